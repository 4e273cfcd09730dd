"""Effects that do not go together, or not with these bodies: one refusal at a time, both keys."""

from collections.abc import Mapping
from typing import Any

from flankload.scene.belt_tables import Belt, Pulley
from flankload.scene.cam_tables import Cam, Follower
from flankload.scene.chain_tables import Chain, Sprocket
from flankload.scene.effect_tables import LARGEST_COEFFICIENT
from flankload.scene.gear_tables import SplineShaft
from flankload.scene.growth_rules import check_growth
from flankload.scene.mesh_tables import ComplianceBody, MeshBody
from flankload.scene.refusal import refuse, shown
from flankload.scene.tables import SceneFile

#: Kinds of bodies whose coast flanks are not known, and why.
ONE_FLANK = {
    "mesh": "of whose teeth a file names one flank",
    "compliance": "of whose teeth a file names one flank",
    "cam": "which has one flank",
    "follower": "which has one flank",
    "sprocket": "whose pockets hold rollers",
    "chain": "which has no teeth",
}


def check_effects(asked: SceneFile, given: Mapping[str, Any]) -> None:
    """Refuse combinations of effects and bodies that have no meaning.

    Parameters
    ----------
    asked : SceneFile
    given : mapping
        The scene as it stands in the file.

    Raises
    ------
    SceneError
        Names the key, and in what it expects the other one.
    """
    effects = given.get("effects", {})
    _check_friction(asked)
    _check_lumped(asked)
    _check_extent(asked)
    _check_coupling(asked, effects)
    check_growth(asked)
    _check_nodes(asked)
    _check_places(asked)
    _check_tip_contact(asked)
    _check_coast_flank(asked)


def check_coast_kinds(*kinds: str) -> None:
    """Check that both flanks of every tooth of body 1, of body 2 are known.

    Raises
    ------
    SceneError
    """
    for key, kind in zip(("body_1", "body_2"), kinds, strict=True):
        if kind in ONE_FLANK:
            refuse(
                "effects.coast_flank",
                f"false with {key}.kind '{kind}', {ONE_FLANK[kind]}",
                "true",
            )


def _check_friction(asked: SceneFile) -> None:
    """A list has one number per tooth, or rows of ascending roll position and coefficient."""
    given = asked.effects.friction_coefficient
    if not isinstance(given, tuple):
        return
    key = "effects.friction_coefficient"
    rows = [row for row in given if isinstance(row, tuple)]
    if rows and len(rows) < len(given):
        refuse(key, "numbers, one per tooth, or rows of roll position and coefficient", "both")
    for i, (roll, coefficient) in enumerate(rows):
        if not 0.0 <= coefficient <= LARGEST_COEFFICIENT:
            refuse(f"{key}[{i}][1]", f"a number from 0 to {LARGEST_COEFFICIENT:g}", coefficient)
        if i and roll <= rows[i - 1][0]:
            refuse(
                f"{key}[{i}][0]",
                f"more than the roll position of the row before, {rows[i - 1][0]:g}",
                roll,
            )


def _check_lumped(asked: SceneFile) -> None:
    """Lumped contact has no strips, and conforming flanks have no place to lump it in."""
    if asked.effects.contact != "lumped":
        return
    key = "effects.contact"
    if isinstance(asked.body_1, SplineShaft):
        refuse(
            key,
            "'pairs' with body_1.kind 'spline_shaft': its flanks conform, and touch over a length "
            "instead of at a place",
            "'lumped'",
        )
    for name in ("strips_per_half_width", "corner_strips_per_half_width", "zone_half_widths"):
        if getattr(asked.accuracy, name) is not None:
            refuse(
                f"accuracy.{name}",
                f"nothing with {key} 'lumped', which lays no strips",
                getattr(asked.accuracy, name),
            )


def _check_extent(asked: SceneFile) -> None:
    """A segment has an odd number of sectors, and the bodies have as many."""
    body, segment_teeth = asked.effects.body, asked.effects.segment_teeth
    if body != "segment" and segment_teeth is not None:
        refuse(
            "effects.segment_teeth",
            "nothing, unless effects.body is 'segment'",
            segment_teeth,
        )
    if body == "whole":
        return
    if body == "segment" and (segment_teeth is None or segment_teeth % 2 == 0):
        refuse(
            "effects.segment_teeth",
            "an odd number from 3, since effects.body is 'segment': as many teeth on both sides "
            "of the one in its middle",
            segment_teeth,
        )
    for key, spec in (("body_1", asked.body_1), ("body_2", asked.body_2)):
        if spec.rigid:
            continue
        if isinstance(spec, Sprocket | Chain | Pulley | Belt):
            continue  # these know no effects of elastic flanks at all
        if isinstance(spec, ComplianceBody):
            why = f"{key}.kind is 'compliance': its file says how much of the body it is"
        elif isinstance(spec, Cam | Follower):
            why = f"{key}.kind is '{spec.kind}', which has one flank"
        elif isinstance(spec, MeshBody) and spec.flank_sets is not None:
            why = f"{key}.flank_sets names the flanks of a whole body, not of one of its sectors"
        else:
            if segment_teeth is not None and segment_teeth > spec.number_of_teeth:
                refuse(
                    "effects.segment_teeth",
                    f"at most {spec.number_of_teeth}, as many teeth as {key} has ({key}.teeth)",
                    segment_teeth,
                )
            continue
        refuse("effects.body", f"'whole', since {why}", shown(body))


def _check_coupling(asked: SceneFile, given: Mapping[str, Any]) -> None:
    """One tooth alone has no neighbours to move, nor has a flank all around."""
    if asked.effects.body == "tooth" and given.get("tooth_coupling"):
        refuse(
            "effects.tooth_coupling",
            "false or nothing, since effects.body is 'tooth': of a tooth by itself no other moves",
            True,
        )
    if not asked.effects.tooth_coupling and isinstance(asked.body_2, Cam):
        refuse(
            "effects.tooth_coupling",
            "true, since body_2.kind is 'cam': cam and follower have one flank each",
            "false",
        )


def _check_tip_contact(asked: SceneFile) -> None:
    """Cams and followers have no tips that could be left out."""
    if not asked.effects.tip_contact and isinstance(asked.body_2, Cam):
        refuse(
            "effects.tip_contact",
            "true with body_2.kind 'cam', which has neither tips nor fillets",
            False,
        )


def _check_places(asked: SceneFile) -> None:
    """A lumped contact has one place for its forces."""
    if asked.effects.contact != "lumped":
        return
    for key, value in (("near_field", "nodes"), ("influence", "finite")):
        if getattr(asked.effects, key) == value:
            refuse(
                "effects.contact",
                f"'pairs' with effects.{key} '{value}': forces there have places",
                "'lumped'",
            )


def _check_nodes(asked: SceneFile) -> None:
    """Both flanks have nodes for forces, and nothing stands in modes."""
    if asked.effects.near_field != "nodes":
        return
    key = "effects.near_field"
    if isinstance(asked.body_2, Cam):
        refuse(
            key,
            "'analytic' with body_2.kind 'cam': a closed flank has no first and last node",
            "'nodes'",
        )
    for name, body in (("body_1", asked.body_1), ("body_2", asked.body_2)):
        profile = body.profile if isinstance(body, MeshBody) else None
        for rounding in ("tip_radius_mm", "tip_chamfer_mm") if profile is not None else ():
            if getattr(profile, rounding) is not None:
                refuse(
                    key,
                    f"'analytic' with {name}.profile.{rounding}: the edges of a file's flank set "
                    "that carry end where the tip turns",
                    "'nodes'",
                )
    for growth in ("temperature_rise_K", "speed_rpm"):
        if getattr(asked.effects, growth):
            refuse(
                key, f"'analytic' with effects.{growth}: growth is known in modes alone", "'nodes'"
            )
    if asked.accuracy.modes is not None:
        refuse(
            "accuracy.modes",
            f"nothing with {key} 'nodes': forces at nodes stand in place of modes",
            asked.accuracy.modes,
        )


def _check_coast_flank(asked: SceneFile) -> None:
    """Both flanks of every tooth are known, and something yields between them."""
    effects = asked.effects
    if not effects.coast_flank:
        return
    check_coast_kinds(asked.body_1.kind, asked.body_2.kind)
    if asked.body_1.rigid and asked.body_2.rigid:
        refuse(
            "effects.coast_flank",
            "false with body_1.rigid and body_2.rigid: flanks that press on each other "
            "across a tooth must yield",
            "true",
        )
    if effects.contact == "lumped":
        refuse(
            "effects.contact",
            "'pairs' with effects.coast_flank: lumped contact has working flanks only",
            "'lumped'",
        )
    for key, value in (("near_field", "nodes"), ("influence", "finite")):
        if getattr(effects, key) == value:
            refuse(
                f"effects.{key}",
                "no such level with effects.coast_flank, whose flanks cross the teeth in modes, by "
                "small forces",
                shown(value),
            )
    if effects.root_stress:
        refuse(
            "effects.root_stress",
            "false with effects.coast_flank: stress is known of forces on the working flanks only",
            "true",
        )
