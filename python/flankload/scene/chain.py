"""Which keys of a sprocket and its chain go together."""

from __future__ import annotations

from collections.abc import Mapping
from math import degrees, pi
from typing import TYPE_CHECKING, Any

from flankload.scene.belt_tables import Belt
from flankload.scene.chain_tables import Chain, Sprocket
from flankload.scene.refusal import refuse, shown

if TYPE_CHECKING:
    from flankload.scene.tables import SceneFile

#: What a chain knows of the tables of all scenes.
KNOWN = {
    "effects": {"large_displacement"},
    "positions": {"count", "angles_deg", "pitches"},
    "accuracy": {"tolerance", "estimate"},
}


def check_chain(asked: SceneFile, given: Mapping[str, Any]) -> None:
    """Check that a chain has its sprocket, and that nothing is asked for that both cannot do.

    Parameters
    ----------
    asked : SceneFile
    given : mapping
        As the user wrote it.

    Raises
    ------
    SceneError
    """
    body_1, body_2 = asked.body_1, asked.body_2
    chains = isinstance(body_1, Sprocket), isinstance(body_2, Chain)
    if chains[0] != chains[1]:
        refuse(
            "body_2.kind",
            "'chain' with body_1.kind 'sprocket': the two go together and with no other",
            f"'{body_2.kind}' with body_1.kind '{body_1.kind}'",
        )
    if not isinstance(body_1, Sprocket) or not isinstance(body_2, Chain):
        _refuse_drive_keys(asked, given)
        return
    for key in ("pitch_mm", "roller_diameter_mm"):
        own, other = getattr(body_1, key), getattr(body_2, key)
        if own != other:
            refuse(
                f"body_2.{key}",
                f"{own:g} as in body_1.{key} (wear goes into body_2.elongation)",
                f"{other:g}",
            )
    most = degrees(2 * pi) * (1 - 1 / body_1.teeth)
    if body_2.wrap_angle_deg > most:
        refuse(
            "body_2.wrap_angle_deg",
            f"at most {most:g}: all teeth of body_1 but one",
            f"{body_2.wrap_angle_deg:g}",
        )
    if asked.load.slack_tension_N is None:
        refuse(
            "load.slack_tension_N",
            "a number > 0: what the slack strand of the chain pulls with",
            "nothing",
        )
    if asked.pair is not None:
        refuse(
            "pair",
            "nothing: a chain lies on its sprocket, and its contacts yield by "
            "body_2.contact_stiffness_N_per_mm",
            "a table",
        )
    for table, known in KNOWN.items():
        for key, value in given.get(table, {}).items():
            if key not in known:
                refuse(
                    f"{table}.{key}",
                    "nothing: a chain and its sprocket do not know it",
                    shown(value),
                )


def _refuse_drive_keys(asked: SceneFile, given: Mapping[str, Any]) -> None:
    """Only drives have a slack strand and rollers that move far."""
    if asked.load.slack_tension_N is not None and not isinstance(asked.body_2, Belt):
        refuse(
            "load.slack_tension_N",
            f"nothing: a {asked.body_2.kind} has no slack strand",
            f"{asked.load.slack_tension_N:g}",
        )
    for key, value in given.get("effects", {}).items():
        if key in KNOWN["effects"]:
            refuse(f"effects.{key}", "nothing, unless body_2.kind is 'chain'", shown(value))
    if asked.pair is None and not isinstance(asked.body_2, Belt):
        refuse("pair", "a table", "nothing")
