"""Refusal of effects that exclude each other or do not apply to the bodies."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from flankload.scene.axial import AxialKeys, three_dimensional_key
from flankload.scene.belt import Belt
from flankload.scene.drive import DriveTable
from flankload.scene.effects.keys import LARGEST_COEFFICIENT
from flankload.scene.effects.records import EFFECTS, STAGE
from flankload.scene.mesh import ComplianceBody, MeshBody
from flankload.scene.refusal import refuse, shown
from flankload.scene.table import has_several_meshes

if TYPE_CHECKING:
    from flankload.scene.effects.record import Effect
    from flankload.scene.scene import BodySpec, SceneFile

RECORDS = {effect.name: effect for effect in EFFECTS}
#: Largest strain for which expansion is taken as linear.
LARGEST_STRAIN = 0.02


def check_effects(asked: SceneFile, given: Mapping[str, Any]) -> None:
    """Refuse impossible combinations of effects and bodies; `given`: scene as in the file."""
    wanted = [effect for effect in EFFECTS if effect.is_asked(asked.effects)]
    _check_known(asked, given.get("effects", {}))
    _check_friction(asked)
    _check_extent(asked)
    _check_teeth(asked, given.get("effects", {}))
    _check_expansion(asked)
    spatial = three_dimensional_key(asked)
    if spatial is not None:
        _check_whole_meshes(asked, spatial)
    for effect in wanted:
        # lumped contact of slices applies to all kinds
        if spatial is None or effect.name != "lumped_contact":
            _check_kinds(effect, asked.body_1.kind, asked.body_2.kind, found=_value(effect, asked))
    _check_contact_models(asked)
    _check_forces(asked)
    for effect in wanted:
        for other, expected in effect.refused_with.items():
            if RECORDS[other] in wanted:
                refuse(f"effects.{effect.key}", expected, _value(effect, asked))


def check_coast_kinds(kind_1: str, kind_2: str) -> None:
    """Check that both flanks of every tooth of both bodies are known."""
    _check_kinds(RECORDS["coast_flanks"], kind_1, kind_2, found="true")


def _value(effect: Effect, asked: SceneFile) -> str:
    return shown(getattr(asked.effects, effect.key or ""))


def _bodies(asked: SceneFile) -> tuple[tuple[str, BodySpec], tuple[str, BodySpec]]:
    return ("body_1", asked.body_1), ("body_2", asked.body_2)


def _check_known(asked: SceneFile, given: Mapping[str, Any]) -> None:
    """Check that a drive has only its own effects, and that other bodies have none of these."""
    kind_1, kind_2 = asked.body_1.kind, asked.body_2.kind
    of_stage = [effect.key for effect in EFFECTS if effect.only_for == STAGE]
    for key, value in given.items():
        if key in of_stage and not has_several_meshes(asked):
            refuse(f"effects.{key}", "nothing, unless there is a table [stage]", shown(value))
    drives = {effect.only_for for effect in EFFECTS} - {None, STAGE}
    for drive in sorted(drive for drive in drives if drive):
        own = [effect.key for effect in EFFECTS if effect.only_for == drive]
        for key, value in given.items():
            if drive == kind_2 and key not in own:
                expected = f"nothing: it does not apply to a {kind_2} and its {kind_1}"
                refuse(f"effects.{key}", expected, shown(value))
            if drive != kind_2 and key in own:
                refuse(f"effects.{key}", f"nothing, unless body_2.kind is '{drive}'", shown(value))


def _check_kinds(effect: Effect, kind_1: str, kind_2: str, *, found: str) -> None:
    for body, kind in (("body_1", kind_1), ("body_2", kind_2)):
        if kind in effect.refused_for:
            refuse(f"effects.{effect.key}", effect.refused_for[kind].format(body=body), found)


def _check_friction(asked: SceneFile) -> None:
    """Check that a list has one number per tooth, or rows of ascending roll position."""
    given, key = asked.effects.friction_coefficient, "effects.friction_coefficient"
    if given and not asked.body_2.has_teeth:
        expected = "nothing: this version has no friction between a cam and its follower"
        refuse(key, expected, "a coefficient")
    if not isinstance(given, tuple):
        return
    rows = [row for row in given if isinstance(row, tuple)]
    if rows and len(rows) < len(given):
        refuse(key, "numbers, one per tooth, or rows of roll position and coefficient", "both")
    for i, (roll, coefficient) in enumerate(rows):
        if not 0.0 <= coefficient <= LARGEST_COEFFICIENT:
            refuse(f"{key}[{i}][1]", f"a number from 0 to {LARGEST_COEFFICIENT:g}", coefficient)
        if i and roll <= rows[i - 1][0]:
            expected = f"more than the roll position of the row before, {rows[i - 1][0]:g}"
            refuse(f"{key}[{i}][0]", expected, roll)


def _check_extent(asked: SceneFile) -> None:
    """Check that a segment has an odd number of sectors, at most as many as the bodies."""
    body, segment_teeth = asked.effects.body, asked.effects.segment_teeth
    key = "effects.segment_teeth"
    if body != "segment" and segment_teeth is not None:
        refuse(key, "nothing, unless effects.body is 'segment'", segment_teeth)
    if body == "whole":
        return
    if body == "segment" and (segment_teeth is None or segment_teeth % 2 == 0):
        refuse(
            key,
            "an odd number from 3, since effects.body is 'segment': as many teeth on both sides "
            "of the one in its middle",
            segment_teeth,
        )
    for name, spec in _bodies(asked):
        if spec.rigid or isinstance(spec, DriveTable):
            continue
        if isinstance(spec, ComplianceBody):
            why = f"{name}.kind is 'compliance': its file determines the elastic part of the body"
        elif not spec.has_teeth:
            why = f"{name}.kind is '{spec.kind}', which has one flank"
        elif spec.has_free_bore:
            own = "rim" if spec.kind == "ring" else "bore"
            why = f"{name}.{own} is 'torque': a segment is held at its cuts"
        elif isinstance(spec, AxialKeys) and spec.shaft is not None and spec.shaft.is_flexible:
            why = f"{name}.shaft.under_teeth is 'flexible': a segment is held at its bore"
        elif isinstance(spec, MeshBody) and spec.flank_sets is not None:
            why = f"{name}.flank_sets names the flanks of a whole body, not of one of its sectors"
        elif segment_teeth is not None and segment_teeth > spec.number_of_teeth:
            teeth = spec.number_of_teeth
            refuse(
                key, f"at most {teeth}, as many teeth as {name} has ({name}.teeth)", segment_teeth
            )
        else:
            continue
        refuse("effects.body", f"'whole', since {why}", shown(body))


def _check_teeth(asked: SceneFile, given: Mapping[str, Any]) -> None:
    """Check tooth coupling and tip contact: a single tooth and a cam have neither."""
    effects, key = asked.effects, "effects.tooth_coupling"
    if effects.body == "tooth" and given.get("tooth_coupling"):
        why = "a single tooth has no coupling"
        refuse(key, f"false or nothing, since effects.body is 'tooth': {why}", True)
    if asked.body_2.has_teeth:
        return
    if not effects.tooth_coupling:
        why = "cam and follower have one flank each"
        refuse(key, f"true, since body_2.kind is 'cam': {why}", False)
    if not effects.tip_contact:
        expected = "true with body_2.kind 'cam', which has neither tips nor fillets"
        refuse("effects.tip_contact", expected, False)


def _check_whole_meshes(asked: SceneFile, spatial: str) -> None:
    """Check that no root stress of a whole mesh over its width is requested."""
    for name, spec in _bodies(asked):
        if asked.effects.root_stress and isinstance(spec, MeshBody) and spec.flank_sets:
            expected = f"false, since {spatial} requires three dimensions, where {name} needs the "
            expected += f"mesh of a sector for it ({name}.flank_sets names the flanks of a whole "
            refuse("effects.root_stress", f"{expected}body)", "true")


def _check_expansion(asked: SceneFile) -> None:
    """Check that expansion has a cause, a small strain, and finite elements where needed."""
    effects = asked.effects
    for key, other in (
        ("thermal_expansion_per_K", "temperature_rise_K"),
        ("support_expansion_per_K", "temperature_rise_K"),
        ("density_kg_m3", "speed_rpm"),
    ):
        if getattr(effects, key) is not None and getattr(effects, other) is None:
            expected = f"nothing, unless there is an effects.{other}"
            refuse(f"effects.{key}", expected, getattr(effects, key))
    for expansion in ("thermal_expansion_per_K", "support_expansion_per_K"):
        rises, per_K = _of_both(effects.temperature_rise_K), _of_both(getattr(effects, expansion))
        for rise, strain_per_K in zip(rises, per_K, strict=True):
            if abs(rise * strain_per_K) > LARGEST_STRAIN:
                refuse(
                    "effects.temperature_rise_K",
                    f"so few K that they stretch the bodies by {LARGEST_STRAIN:g} at most, with "
                    f"effects.{expansion} {strain_per_K:g}",
                    rise,
                )
    for key in ("speed_rpm", "support_expansion_per_K"):
        if getattr(effects, key) is not None:
            _check_elements(asked, key)


def _check_elements(asked: SceneFile, key: str) -> None:
    """Check for finite elements, on which speed and supports of other expansion act as loads."""
    if asked.effects.body == "tooth" and not (asked.body_1.rigid and asked.body_2.rigid):
        why = "effects.body is 'tooth': the expansion of a body depends on all its sectors"
        refuse(f"effects.{key}", f"nothing, since {why}", getattr(asked.effects, key))
    for name, spec in _bodies(asked):
        if isinstance(spec, ComplianceBody) and not spec.rigid:
            why = f"{name}.kind is 'compliance': its file contains no expansion"
            refuse(f"effects.{key}", f"nothing, since {why}", getattr(asked.effects, key))


def _of_both(value: float | tuple[float, ...] | None) -> tuple[float, ...]:
    """One number per body; 0 if there is none."""
    return value if isinstance(value, tuple) else (value or 0.0,) * 2


def _check_contact_models(asked: SceneFile) -> None:
    """Check accuracy keys: lumped contact has no cells, nodal forces have no pressure modes."""
    accuracy = asked.accuracy
    if asked.effects.contact == "lumped":
        for name in ("strips_per_half_width", "corner_strips_per_half_width", "zone_half_widths"):
            if getattr(accuracy, name) is not None:
                expected = "nothing with effects.contact 'lumped', which has no strips"
                refuse(f"accuracy.{name}", expected, getattr(accuracy, name))
    if asked.effects.near_field != "nodes":
        return
    for name, body in _bodies(asked):
        profile = body.profile if isinstance(body, MeshBody) else None
        for rounding in ("tip_radius_mm", "tip_chamfer_mm") if profile is not None else ():
            if getattr(profile, rounding) is not None:
                expected = f"'analytic' with {name}.profile.{rounding}: the carrying edges of a "
                expected += "flank set from a file end at the tip rounding or chamfer"
                refuse("effects.near_field", expected, "'nodes'")
    if accuracy.modes is not None:
        expected = "nothing with effects.near_field 'nodes': nodal forces replace modes"
        refuse("accuracy.modes", expected, accuracy.modes)


def _check_forces(asked: SceneFile) -> None:
    """Check that a lifted belt has prestress, and that coast flanks have an elastic body."""
    belt = asked.body_2
    if asked.effects.land_lift and isinstance(belt, Belt) and belt.prestress_N == 0.0:
        why = "it keeps a belt straight off its pulley"
        refuse("body_2.prestress_N", f"a number > 0 with effects.land_lift: {why}", "0")
    if asked.effects.coast_flank and asked.body_1.rigid and asked.body_2.rigid:
        expected = "false with body_1.rigid and body_2.rigid: flanks that press on each other "
        expected += "across a tooth must be elastic"
        refuse("effects.coast_flank", expected, "true")
