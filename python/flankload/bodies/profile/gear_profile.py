"""The profile of a gear: generated root fillet, involute with its modifications, tip.

The tooth's centre line is the body's +x axis; the working flank is at positive polar angles.
"""

from __future__ import annotations

from dataclasses import replace
from math import atan2, cos, hypot, pi, radians, sqrt, tan
from typing import TYPE_CHECKING, NoReturn

import numpy as np

from flankload.base.involute import involute_function, roll_of_involute_angle
from flankload.bodies.bisection import sign_change
from flankload.bodies.profile.basic_rack import BasicRack, basic_rack
from flankload.bodies.profile.gear_tip import FormPoint, modifications_of
from flankload.bodies.profile.involute import (
    Involute,
    InvoluteFlank,
    Modifications,
)
from flankload.bodies.profile.tooth_profile import ToothProfile, profile_curve
from flankload.errors import SceneError
from flankload.scene.refusal import refuse
from flankload.scene.thickness import generating_shift

if TYPE_CHECKING:
    from flankload.flank import Place
    from flankload.scene import SplineShaft
    from flankload.scene.involute import Geometry


#: Least roll parameter t of an involute, whose curvature is infinite on the base circle. The
#: omitted length is r_b t²/2, below 1e-9 mm for r_b < 200 mm.
LEAST_ROLL = 3e-6
#: Number of points of a fillet for the search of the deepest one below the involute.
FILLET_SAMPLES = 200


def gear_profile(
    spec: Geometry | SplineShaft, key: str, *, teeth: int | None = None
) -> ToothProfile:
    """Profile of a gear from its keys, with the dotted path `key` in the scene.

    `teeth`: number of teeth of a mesh, whose profile may lack this key.

    Raises
    ------
    SceneError
        If the gear is impossible; names the key.
    """
    z = int(teeth if teeth is not None else getattr(spec, "teeth", 0) or 0)
    if z < 3:
        raise SceneError(key=f"{key}.teeth", expected="at least 3 teeth", found=f"{z}")
    shift = generating_shift(spec, z, key)
    rack = basic_rack(spec, z, shift, key)
    base_radius = rack.reference_radius_mm * cos(rack.pressure_angle_rad)
    base_half_angle = (0.5 * pi + 2 * shift * tan(radians(spec.pressure_angle_deg))) / z
    base_half_angle += involute_function(rack.pressure_angle_rad)
    plain = InvoluteFlank(base_radius, base_half_angle, Modifications.none())
    start = _form_point(rack, plain, key)
    involute = Involute(
        base_radius_mm=base_radius,
        reference_radius_mm=rack.reference_radius_mm,
        root_radius_mm=rack.root_radius_mm,
        form_radius_mm=base_radius * hypot(1.0, start.roll),
        tip_radius_mm=0.5 * spec.tip_diameter_mm,
        base_half_angle_rad=base_half_angle,
    )
    _check_tooth(involute, rack, start, spec, key)
    flank = replace(plain, modifications=modifications_of(spec, involute, start.roll, key))
    curve = profile_curve(_fillet(rack, start), flank, involute, start, spec, key)
    return ToothProfile(curve, involute, z, rack.root_half_angle_rad)


def _form_point(rack: BasicRack, flank: InvoluteFlank, key: str) -> FormPoint:
    """End of the fillet, where it touches the involute or cuts it (undercut, protuberance)."""
    angle, low = rack.end_angle_rad, 0.5 * pi
    free = rack.protuberance_angle_rad is not None
    roll = rack.roll_of_form_point(flank.base_half_angle_rad)
    if roll > -LEAST_ROLL and not free:
        return FormPoint(max(roll, LEAST_ROLL), angle, False)

    def place(beta: float) -> tuple[float, float]:
        x, y = rack.fillet(np.array([beta]))[0][0]
        return hypot(x, y), atan2(y, x)

    def metal_left(beta: float) -> float:
        radius, polar = place(beta)
        return polar - flank.polar_angle_at(radius)

    if free and metal_left(angle) < 0.0:
        return _on_protuberance(rack, flank, place(angle)[0], key)
    # the radius grows as beta decreases; the involute begins at the base circle
    if place(low)[0] < flank.base_radius_mm:
        low = sign_change(lambda beta: place(beta)[0] - flank.base_radius_mm, angle, low)
    if free:
        # the fillet cuts the involute above its deepest point
        between = [rack.flank_angle_rad, *np.linspace(angle, low, FILLET_SAMPLES)[1:-1]]
        low = float(min((beta for beta in between if beta < low), key=metal_left))
        if metal_left(low) >= 0.0:
            _refuse_protuberance(key, "a protuberance that cuts into the involute")
    beta = sign_change(metal_left, angle, low)
    return FormPoint(max(flank.roll_at(place(beta)[0]), LEAST_ROLL), beta, True)


def _on_protuberance(rack: BasicRack, flank: InvoluteFlank, low: float, key: str) -> FormPoint:
    """End of the fillet on the involute of the protuberance flank, above a radius."""
    free = InvoluteFlank(*rack.protuberance_flank(), Modifications.none())

    def metal_left(radius: float) -> float:
        return free.polar_angle_at(radius) - flank.polar_angle_at(radius)

    high = 2.0 * rack.reference_radius_mm
    if low < free.base_radius_mm or metal_left(high) <= 0.0:
        _refuse_protuberance(key, "a protuberance whose flank ends on the involute")
    radius = sign_change(metal_left, low, high)
    return FormPoint(flank.roll_at(radius), free.roll_at(radius), True, free)


def _refuse_protuberance(key: str, expected: str) -> NoReturn:
    refuse(f"{key}.protuberance_mm", expected, "one that does not, with this angle and tip radius")


def _fillet(rack: BasicRack, start: FormPoint) -> list[tuple[Place, float, float]]:
    """Parts of the fillet from the root circle to the flank, with their parameters."""
    if start.free is None:
        return [(rack.fillet, 0.5 * pi, start.beta)]
    end = rack.end_angle_rad
    x, y = rack.fillet(np.array([end]))[0][0]
    on_free = (start.free.place, start.free.roll_at(hypot(x, y)), start.beta)
    return [(rack.fillet, 0.5 * pi, end), on_free]


def _check_tooth(
    involute: Involute, rack: BasicRack, start: FormPoint, spec: Geometry | SplineShaft, key: str
) -> None:
    """Check that the tooth has a flank and a foot, and is not pointed."""
    if involute.base_half_angle_rad <= 0.0:
        expected = "a profile shift that leaves the tooth some thickness at its base circle"
        refuse(f"{key}.profile_shift", expected, f"{spec.profile_shift:g}")
    end = start.beta if start.free is None else rack.end_angle_rad
    foot = rack.fillet(np.linspace(0.5 * pi, end, 200))[0]
    if foot[:, 1].min() <= 0.0:
        expected = "a profile shift at which the rack does not cut off the tooth at its foot"
        refuse(f"{key}.profile_shift", expected, f"{spec.profile_shift:g}")
    if involute.tip_radius_mm <= involute.form_radius_mm:
        expected = f"more than the form diameter {2 * involute.form_radius_mm:.4f}, where the "
        expected += "involute begins"
        refuse(f"{key}.tip_diameter_mm", expected, f"{spec.tip_diameter_mm:g}")
    if involute.half_angle_at(involute.tip_radius_mm) <= 0.0:
        roll = roll_of_involute_angle(involute.base_half_angle_rad)
        largest = 2 * involute.base_radius_mm * sqrt(1.0 + roll**2)
        expected = f"less than {largest:.4f}, where the teeth are pointed"
        refuse(f"{key}.tip_diameter_mm", expected, f"{spec.tip_diameter_mm:g}")
