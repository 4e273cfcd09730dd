"""Which keys of a cam and its follower go together."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flankload.scene.refusal import refuse

if TYPE_CHECKING:
    from flankload.scene.cam_tables import Cam, Follower
    from flankload.scene.tables import SceneFile

ROLLER = ("arm_mm", "roller_radius_mm")
FLAT = ("flat_offset_mm", "flat_from_mm", "flat_to_mm")


def check_cam(cam: Cam, key: str) -> None:
    """Check that the table stands in one place.

    Raises
    ------
    SceneError
        If there is no table, or two.
    """
    given = [name for name in ("profile", "profile_file") if getattr(cam, name) is not None]
    if len(given) != 1:
        refuse(
            f"{key}.profile",
            f"a table of angles and radii, here or in {key}.profile_file",
            "both" if given else "nothing",
        )


def check_follower(follower: Follower, key: str) -> None:
    """Check that a follower has a roller or a flat, and that its parts go into each other.

    Raises
    ------
    SceneError
    """
    given = [name for name in (*ROLLER, *FLAT) if getattr(follower, name) is not None]
    wanted = ROLLER if follower.has_roller or "arm_mm" in given else FLAT
    for name in wanted:
        if name not in given:
            refuse(
                f"{key}.{name}",
                "a number: a follower has a roller ("
                + ", ".join(ROLLER)
                + ") or a flat ("
                + ", ".join(FLAT)
                + ")",
                "nothing",
            )
    for name in given:
        if name not in wanted:
            refuse(
                f"{key}.{name}",
                f"nothing beside {key}.{wanted[0]}: a follower has a roller or a flat",
                f"{getattr(follower, name):g}",
            )
    ascending = [("bore_diameter_mm", "hub_diameter_mm")]
    ascending += (
        [("roller_radius_mm", "arm_mm")] if wanted is ROLLER else [("flat_from_mm", "flat_to_mm")]
    )
    for small, large in ascending:
        less, more = getattr(follower, small), getattr(follower, large)
        if more is not None and more <= less:
            refuse(
                f"{key}.{large}",
                f"more than {key}.{small} ({less:g})",
                f"{more:g}",
            )


def check_cam_pair(asked: SceneFile) -> None:
    """Check that a cam has its follower, and that nothing is asked for that both cannot do.

    Raises
    ------
    SceneError
    """
    kind_1, kind_2 = asked.body_1.kind, asked.body_2.kind
    if (kind_1 == "follower") != (kind_2 == "cam"):
        refuse(
            "body_2.kind",
            "'cam' with body_1.kind 'follower': the two go together and with no other",
            f"'{kind_2}' with body_1.kind '{kind_1}'",
        )
    if kind_2 != "cam":
        return
    if asked.effects.root_stress:
        refuse(
            "effects.root_stress",
            "nothing: a cam and its follower have no tooth roots",
            "true",
        )
    if asked.effects.friction_coefficient not in (None, 0.0):
        refuse(
            "effects.friction_coefficient",
            "nothing: this version knows no friction between a cam and its follower",
            "a coefficient",
        )
