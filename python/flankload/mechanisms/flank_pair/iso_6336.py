"""Face load factor by the formulas of ISO 6336-1 (method C), for comparison with the computed one.

    K = 1 + c b F_y/(2 F_m) while c b F_y/(2 F_m) < 1, else sqrt(2 c b F_y/F_m)
    F_y = 1.33 f_sh + f_ma
    f_sh = 0.023 F_m/b (|1 + K' l s/d_1² (d_1/d_sh)⁴ - 0.3| + 0.3) (b/d_1)²   um, N/mm
    c = 0.85 c' (0.75 eps_alpha + 0.25)

with c' of the same standard for solid gears of steel, reduced below 100 N/mm. Assumed: application
and dynamic factor 1 (F_m is the tangential force on the reference circle of the pinion), no running
in, no least deviation, one mesh that carries all the torque of the pinion; f_ma is the misalignment
of the axes of the scene, in the plane of action. Flank modifications do not enter.
"""

from __future__ import annotations

from dataclasses import replace
from math import cos, sin, sqrt
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from flankload.pairing.body_pair import BodyPair
    from flankload.result.result import Result
    from flankload.scene import Scene
    from flankload.scene.gear import Gear
    from flankload.scene.shaft import Shaft

#: K' of a pinion between two bearings, offset from their middle towards the torque input (negative
#: away from it): of a pinion that stiffens the shaft, and of one that does not.
K_STIFFENING, K_PLAIN = 0.48, 0.8
#: Least ratio of pinion and shaft diameter at which the pinion stiffens the shaft.
STIFFENING_RATIO = 1.15
#: Largest distance from the middle between the bearings, relative to the bearing span.
LARGEST_OFFSET = 0.3
#: Young's modulus of steel in the standard, MPa.
STEEL = 206000.0
#: Line load below which c' is proportional to it, N/mm.
LOW_LOAD = 100.0


def with_iso_factor(result: Result, scene: Scene, pair: BodyPair) -> Result:
    """A result with the factor of the standard, or with a note on why it is absent.

    Unchanged without torque, or without a shaft that bends and twists under the teeth.
    """
    flexible = any(body.axial.flexible for body in pair.bodies)
    if result.shafts is None or not flexible or not result.torque_Nm:
        return result
    factor = k_h_beta_iso(scene, pair, result.torque_Nm)
    if isinstance(factor, str):
        note = f"k_h_beta_iso is absent, since {factor}"
        return replace(result, warnings=(*result.warnings, note))
    return replace(result, shafts=replace(result.shafts, k_h_beta_iso=factor))


def k_h_beta_iso(scene: Scene, pair: BodyPair, torque_Nm: float) -> float | str:
    """K_H-beta by ISO 6336-1, method C, for a torque on body 1, or why it does not apply."""
    from flankload.scene.gear import Gear

    one, two = scene.body_1, scene.body_2
    mesh = pair.pairing.gear_geometry
    if not (isinstance(one, Gear) and isinstance(two, Gear)) or mesh is None:
        return "the formula is for two external gears"
    number = 0 if one.teeth <= two.teeth else 1
    pinion, wheel = (one, two) if number == 0 else (two, one)
    shaft = pinion.shaft
    if shaft is None or not shaft.is_flexible:
        return f"the pinion, body_{number + 1}, has no shaft with under_teeth = 'flexible'"
    arrangement = _bending(shaft, _reference_diameter(pinion))
    if isinstance(arrangement, str):
        return f"body_{number + 1}.shaft: {arrangement}"
    width, diameter = pair.face_width_mm, _reference_diameter(pinion)
    torque = torque_Nm * pinion.teeth / one.teeth
    line_load = 2000.0 * torque / (diameter * width)
    f_sh = 0.023 * line_load * (abs(1.0 + arrangement - 0.3) + 0.3) * (width / diameter) ** 2
    angle = mesh.pressure_angle_rad
    slope = scene.pair.inclination_um_per_mm * sin(angle)
    slope += scene.pair.deviation_um_per_mm * cos(angle)
    deviation = 1.33 * f_sh + abs(slope) * width
    stiffness = 0.85 * _tooth_stiffness(pinion, wheel, line_load)
    stiffness *= 0.75 * mesh.contact_ratio + 0.25
    half = 0.5 * stiffness * deviation / line_load
    return 1.0 + half if half < 1.0 else 2.0 * sqrt(half)


def _reference_diameter(gear: Gear) -> float:
    return gear.teeth * gear.module_mm / cos(gear.helix_rad)


def _bending(shaft: Shaft, diameter: float) -> float | str:
    """K' l s/d_1² (d_1/d_sh)⁴, or why the formula does not apply."""
    assert shaft.bearing_positions_mm is not None
    assert shaft.radial_stiffness_N_per_um is not None
    assert shaft.gear_position_mm is not None
    stiff = zip(shaft.bearing_positions_mm, shaft.radial_stiffness_N_per_um, strict=True)
    places = sorted({place for place, radial in stiff if radial > 0.0})
    if len(places) != 2:
        return f"the formula is for two radial bearings, not for {len(places)}"
    if shaft.torque_end == "even":
        return "the formula is for torque that enters at one end"
    one, two = places
    span, offset = two - one, shaft.gear_position_mm - 0.5 * (one + two)
    if abs(offset) >= LARGEST_OFFSET * span:
        return (
            "the formula is for pinions within "
            f"{LARGEST_OFFSET:g} of the bearing distance from its middle"
        )
    of_shaft = _equal_diameter(shaft, one, two)
    factor = K_STIFFENING if diameter >= STIFFENING_RATIO * of_shaft else K_PLAIN
    towards = offset if shaft.torque_end == "II" else -offset
    return factor * span * towards / diameter**2 * (diameter / of_shaft) ** 4


def _equal_diameter(shaft: Shaft, one: float, two: float) -> float:
    """Diameter of a uniform shaft with the mean 1/I of the stepped shaft between two points."""
    assert shaft.lengths_mm is not None
    assert shaft.diameters_mm is not None
    ends = np.concatenate([[0.0], np.cumsum(shaft.lengths_mm)])
    parts = np.diff(np.clip(ends, one, two))
    inner = shaft.bore_diameter_mm or 0.0
    fourth = np.array(shaft.diameters_mm) ** 4 - inner**4
    return float((parts.sum() / (parts / fourth).sum()) ** 0.25)


def _tooth_stiffness(pinion: Gear, wheel: Gear, line_load: float) -> float:
    """c' of ISO 6336-1 in N/(mm um): solid gears, C_M = 0.8, C_R = 1."""
    q = 0.04723
    for gear, by_teeth, linear, mixed, square in (
        (pinion, 0.15551, -0.00635, -0.11654, 0.00529),
        (wheel, 0.25791, -0.00193, -0.24188, 0.00182),
    ):
        teeth, x = gear.teeth / cos(gear.helix_rad) ** 3, gear.profile_shift
        q += by_teeth / teeth + linear * x + mixed * x / teeth + square * x**2
    rack = 1.0 + 0.5 * (1.2 - 0.5 * (pinion.dedendum_factor + wheel.dedendum_factor))
    rack *= 1.0 - 0.02 * (20.0 - pinion.pressure_angle_deg)
    modulus = 2.0 / (1.0 / pinion.young_modulus_MPa + 1.0 / wheel.young_modulus_MPa)
    stiffness = 0.8 / q * rack * cos(pinion.helix_rad) * modulus / STEEL
    return stiffness * min(1.0, line_load / LOW_LOAD)
