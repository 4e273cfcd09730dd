"""Which keys of a pulley and its belt go together."""

from __future__ import annotations

from collections.abc import Mapping
from math import pi, radians, sqrt, tan
from typing import TYPE_CHECKING, Any

from flankload.errors import SceneError
from flankload.scene.belt_tables import Belt, Pulley
from flankload.scene.refusal import shown

if TYPE_CHECKING:
    from flankload.scene.tables import SceneFile

#: What a belt knows of the tables of all scenes.
KNOWN = {
    "effects": {"land_friction", "land_lift"},
    "positions": {"count", "angles_deg", "pitches"},
    "accuracy": {"tolerance", "estimate", "flank_element_mm"},
}
#: Beyond this the belt is none for the pulley.
LARGEST_PITCH_DIFFERENCE = 0.02
#: A tooth of the belt is no wider than this part of the pitch: there must be a land.
WIDEST_TOOTH = 0.9
#: A groove of an elastic pulley keeps this part of its width at its bottom.
LEAST_BOTTOM = 0.1
#: What the scene of an elastic pulley may name beside.
ELASTIC = ("bore_diameter_mm", "young_modulus_MPa", "poisson_ratio")


def check_belt(asked: SceneFile, given: Mapping[str, Any]) -> None:
    """Check that a belt has its pulley, and that nothing is asked for that both cannot do.

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
    if isinstance(body_1, Pulley) != isinstance(body_2, Belt):
        _refuse(
            "body_2.kind",
            "'belt' with body_1.kind 'pulley': the two go together and with no other",
            f"'{body_2.kind}' with body_1.kind '{body_1.kind}'",
        )
    if not isinstance(body_1, Pulley) or not isinstance(body_2, Belt):
        for key, value in given.get("effects", {}).items():
            if key in KNOWN["effects"]:
                _refuse(f"effects.{key}", "nothing, unless body_2.kind is 'belt'", shown(value))
        return
    _check_pitch(body_1, body_2)
    _check_tooth(body_1, body_2)
    _check_elastic(body_1, body_2, given.get("body_1", {}))
    _check_load(asked, body_2)
    for table, known in KNOWN.items():
        for key, value in given.get(table, {}).items():
            if key == "plane" and not body_1.rigid:
                continue  # of the pulley
            if key not in known:
                _refuse(
                    f"{table}.{key}",
                    "nothing: a belt and its pulley do not know it",
                    shown(value),
                )


def _check_pitch(pulley: Pulley, belt: Belt) -> None:
    if belt.wrapped_teeth >= pulley.teeth:
        _refuse(
            "body_2.wrapped_teeth",
            f"less than body_1.teeth ({pulley.teeth})",
            f"{belt.wrapped_teeth}",
        )
    difference = belt.pitch_mm - pulley.pitch_mm
    part = 100 * LARGEST_PITCH_DIFFERENCE
    if abs(difference) > LARGEST_PITCH_DIFFERENCE * pulley.pitch_mm:
        _refuse(
            "body_2.pitch_mm",
            f"body_1.pitch_mm ({pulley.pitch_mm:g}) to {part:g} %",
            f"{belt.pitch_mm:g}",
        )
    whole = difference + belt.pitch_difference_um / 1000.0
    if abs(whole) > LARGEST_PITCH_DIFFERENCE * pulley.pitch_mm:
        _refuse(
            "body_2.pitch_difference_um",
            f"at most {part:g} % of body_1.pitch_mm ({pulley.pitch_mm:g})",
            f"{belt.pitch_difference_um:g}",
        )
    land = pulley.teeth * pulley.pitch_mm / (2 * pi) - belt.land_distance_mm
    if belt.land_distance_mm >= belt.back_mm:
        _refuse(
            "body_2.land_distance_mm",
            f"less than body_2.back_mm ({belt.back_mm:g}): the cord lies in the belt",
            f"{belt.land_distance_mm:g}",
        )
    if belt.tooth_height_mm >= 0.5 * land:
        _refuse(
            "body_2.tooth_height_mm",
            f"less than half of the pulley's radius ({0.5 * land:.4g})",
            f"{belt.tooth_height_mm:g}",
        )
    widest = WIDEST_TOOTH * 2 * pi * land / pulley.teeth
    if belt.tooth_width_mm > widest:
        _refuse(
            "body_2.tooth_width_mm",
            f"at most {widest:.4g}: lands between the teeth",
            f"{belt.tooth_width_mm:g}",
        )


def _check_tooth(pulley: Pulley, belt: Belt) -> None:
    trapezoid = pulley.profile == "T"
    for key, value in (
        ("body_1.groove_angle_deg", pulley.groove_angle_deg),
        ("body_2.flank_angle_deg", belt.flank_angle_deg),
    ):
        if not trapezoid and value is not None:
            _refuse(key, "nothing with body_1.profile 'HTD'", f"{value:g}")
    if trapezoid:
        if belt.flank_angle_deg is None:
            _refuse("body_2.flank_angle_deg", "a number with body_1.profile 'T'", "nothing")
        assert belt.flank_angle_deg is not None
        tip = belt.tooth_width_mm - 2 * belt.tooth_height_mm * tan(radians(belt.flank_angle_deg))
        if tip < 0.1 * belt.tooth_width_mm:
            _refuse(
                "body_2.flank_angle_deg",
                "so small that a tooth keeps a tenth of its width at the tip",
                f"{belt.flank_angle_deg:g}",
            )
    elif belt.tooth_height_mm < 0.4 * belt.tooth_width_mm:
        _refuse(
            "body_2.tooth_height_mm",
            f"at least 0.4 of body_2.tooth_width_mm ({belt.tooth_width_mm:g}) with body_1.profile "
            "'HTD'",
            f"{belt.tooth_height_mm:g}",
        )
    for key, groove, tooth in (
        ("groove_width_mm", pulley.groove_width_mm, "tooth_width_mm"),
        ("groove_depth_mm", pulley.groove_depth_mm, "tooth_height_mm"),
    ):
        least = getattr(belt, tooth)
        if groove is not None and groove < least:
            _refuse(f"body_1.{key}", f"at least body_2.{tooth} ({least:g})", f"{groove:g}")


def _check_elastic(pulley: Pulley, belt: Belt, given: Mapping[str, Any]) -> None:
    """A pulley that yields has a bore, and teeth between its grooves."""
    named = [key for key in ELASTIC if key in given]
    if named and "rigid" not in given:
        _refuse("body_1.rigid", f"true or false beside body_1.{named[0]}", "nothing")
    if pulley.rigid:
        return
    if pulley.bore_diameter_mm is None:
        _refuse("body_1.bore_diameter_mm", "a number with body_1.rigid = false", "nothing")
    assert pulley.bore_diameter_mm is not None
    land = pulley.teeth * pulley.pitch_mm / (2 * pi) - belt.land_distance_mm
    width = pulley.groove_width_mm or belt.tooth_width_mm
    widest = WIDEST_TOOTH * 2 * pi * land / pulley.teeth
    if width > widest:
        _refuse("body_1.groove_width_mm", f"at most {widest:.4g}: teeth between", f"{width:g}")
    deeper = 0.5 * (width - belt.tooth_width_mm) if pulley.profile == "HTD" else 0.0
    depth = max(pulley.groove_depth_mm or 0.0, belt.tooth_height_mm + deeper)
    if pulley.profile == "T":
        angle = pulley.groove_angle_deg
        angle = angle if angle is not None else belt.flank_angle_deg
        assert angle is not None
        if width - 2 * depth * tan(radians(angle)) < LEAST_BOTTOM * width:
            _refuse(
                "body_1.groove_depth_mm",
                "so small that a groove keeps a tenth of its width at the bottom",
                f"{depth:g}",
            )
    bottom = 2 * (sqrt(land**2 - (0.5 * width) ** 2) - depth)
    if pulley.bore_diameter_mm >= bottom:
        _refuse(
            "body_1.bore_diameter_mm",
            f"less than the diameter below the grooves ({bottom:.4g})",
            f"{pulley.bore_diameter_mm:g}",
        )


def _check_load(asked: SceneFile, belt: Belt) -> None:
    if asked.load.slack_tension_N is None:
        _refuse(
            "load.slack_tension_N",
            "a number > 0: what the slack strand of the belt pulls with",
            "nothing",
        )
    if asked.pair is not None:
        _refuse("pair", "nothing: a belt has body_2.width_mm and lies on its pulley", "a table")
    if asked.effects.land_lift and asked.effects.land_friction:
        _refuse(
            "effects.land_lift",
            "false with effects.land_friction: lands that lift do not rub as all others do",
            "true",
        )
    if asked.effects.land_lift and belt.prestress_N == 0.0:
        _refuse(
            "body_2.prestress_N",
            "a number > 0 with effects.land_lift: what holds a belt straight off its pulley",
            "0",
        )


def _refuse(key: str, expected: str, found: str) -> None:
    raise SceneError(key=key, expected=expected, found=found)
