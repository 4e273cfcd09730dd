"""The profile of a ring (internal gear): root fillet, involute of its space, tip.

The centre line of a space is the body's +x axis. The working flank is at positive polar angles and
belongs to the tooth that is centred at half a pitch.
"""

from __future__ import annotations

from dataclasses import replace
from math import atan2, cos, hypot, pi, radians, sqrt, tan
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from flankload.base.involute import involute_function, roll_of_involute_angle
from flankload.base.rotation import directions
from flankload.bodies.bisection import sign_change
from flankload.bodies.plane import circle
from flankload.bodies.profile.gear_tip import FormPoint, modifications_of
from flankload.bodies.profile.involute import (
    Involute,
    InvoluteFlank,
)
from flankload.bodies.profile.tooth_profile import ToothProfile, profile_curve
from flankload.errors import SceneError
from flankload.scene.refusal import refuse
from flankload.scene.thickness import generating_shift

if TYPE_CHECKING:
    from flankload.base.arrays import Floats
    from flankload.scene import Ring, SplineHub


#: Factor on the largest fillet radius, so that the arc does not cross the centre line by rounding.
FULL_ARC = 1.0 - 1e-12


class RootArc(NamedTuple):
    """The root fillet: an arc in the space that is tangent to flank and root circle.

    Attributes
    ----------
    radius_mm : float
    roll : float
        Roll parameter of the involute at the point of tangency.
    center_mm : (2,) array
    center_angle_rad : float
        Polar angle of the arc's centre, and of its point on the root circle.
    """

    radius_mm: float
    roll: float
    center_mm: Floats
    center_angle_rad: float


def ring_profile(spec: Ring | SplineHub, key: str) -> ToothProfile:
    """Profile of a ring or hub from its keys, with the dotted path `key` in the scene.

    Raises
    ------
    SceneError
        If the ring is impossible; names the key.
    """
    z, normal_angle = spec.teeth, radians(spec.pressure_angle_deg)
    pressure_angle = spec.transverse_angle_rad
    reference_radius = 0.5 * z * spec.module_mm / cos(spec.helix_rad)
    shift = generating_shift(spec, z, key, outward=-1)
    base_half_angle = (0.5 * pi + 2 * shift * tan(normal_angle)) / z
    involute = Involute(
        base_radius_mm=reference_radius * cos(pressure_angle),
        reference_radius_mm=reference_radius,
        root_radius_mm=0.5 * spec.root_diameter_mm,
        form_radius_mm=0.5 * spec.root_diameter_mm,
        tip_radius_mm=0.5 * spec.tip_diameter_mm,
        base_half_angle_rad=base_half_angle + involute_function(pressure_angle),
        outward=-1,
        tooth_center_rad=pi / z,
    )
    _check_circles(involute, spec, key)
    arc = _root_arc(involute, spec, key)
    involute = replace(involute, form_radius_mm=involute.base_radius_mm * hypot(1.0, arc.roll))
    _check_fillet(involute, arc, spec, key)
    flank = InvoluteFlank(
        involute.base_radius_mm,
        involute.base_half_angle_rad,
        modifications_of(spec, involute, arc.roll, key),
    )
    end = involute.base_half_angle_rad - arc.roll + 0.5 * pi
    fillet = [(circle(arc.center_mm, arc.radius_mm), arc.center_angle_rad, end)]
    curve = profile_curve(fillet, flank, involute, FormPoint(arc.roll, end, False), spec, key)
    return ToothProfile(curve, involute, z, arc.center_angle_rad)


def _check_fillet(involute: Involute, arc: RootArc, spec: Ring | SplineHub, key: str) -> None:
    """Check that a flank remains outside the fillet."""
    if involute.form_radius_mm > involute.tip_radius_mm:
        return
    default = "nothing: the largest arc, " if spec.root_fillet_radius_mm is None else ""
    raise SceneError(
        key=f"{key}.root_fillet_radius_mm",
        expected="a fillet that leaves some flank outside the tip diameter "
        f"{2 * involute.tip_radius_mm:g}",
        found=f"{default}{arc.radius_mm:.6g}, reaches in to the diameter "
        f"{2 * involute.form_radius_mm:.4f}",
    )


def _check_circles(involute: Involute, spec: Ring | SplineHub, key: str) -> None:
    """Check that the involute extends from tip to root circle, with no pointed space or tooth."""
    base, pitch = involute.base_radius_mm, 2 * pi / spec.teeth
    if involute.tip_radius_mm <= base:
        expected = f"more than the base diameter {2 * base:.4f}, inside which there is no "
        expected += "involute"
        refuse(f"{key}.tip_diameter_mm", expected, f"{spec.tip_diameter_mm:g}")
    if not involute.base_half_angle_rad > 0.0:
        expected = "a profile shift that leaves the space some width at the base circle"
        refuse(f"{key}.profile_shift", expected, f"{spec.profile_shift:g}")
    if involute.half_angle_at(involute.root_radius_mm) <= 0.0:
        largest = _diameter_at(involute, involute.base_half_angle_rad)
        expected = f"less than {largest:.4f}, where the spaces are pointed"
        refuse(f"{key}.root_diameter_mm", expected, f"{spec.root_diameter_mm:g}")
    if involute.tooth_half_angle_at(involute.tip_radius_mm) <= 0.0:
        least = _diameter_at(involute, involute.base_half_angle_rad - 0.5 * pitch)
        expected = f"more than {least:.4f}, where the teeth are pointed"
        refuse(f"{key}.tip_diameter_mm", expected, f"{spec.tip_diameter_mm:g}")


def _diameter_at(involute: Involute, involute_angle: float) -> float:
    """Diameter at which the polar angle of the involute is smaller by an angle than at its base."""
    return 2 * involute.base_radius_mm * hypot(1.0, roll_of_involute_angle(involute_angle))


def _touching_arc(involute: Involute, radius: float) -> RootArc:
    """Arc with a radius; its centre is at r_b t - radius along the normal of the involute."""
    base = involute.base_radius_mm
    along = sqrt((involute.root_radius_mm - radius) ** 2 - base**2)
    roll = (along + radius) / base
    normal = involute.base_half_angle_rad - roll
    radial, tangential = directions(np.array([normal, normal + 0.5 * pi]))
    center = base * radial + along * tangential
    return RootArc(radius, roll, center, atan2(center[1], center[0]))


def _root_arc(involute: Involute, spec: Ring | SplineHub, key: str) -> RootArc:
    """The arc with the radius of the scene, or the largest arc, centred in the space."""
    limit = (involute.root_radius_mm - involute.base_radius_mm) * FULL_ARC
    largest = limit

    def beside(radius: float) -> float:
        return _touching_arc(involute, radius).center_angle_rad

    if beside(limit) < 0.0:
        largest = sign_change(beside, 0.0, limit) * FULL_ARC
    radius = spec.root_fillet_radius_mm
    if radius is None:
        return _touching_arc(involute, largest)
    if radius > largest:
        expected = f"at most {largest:.6f}, the largest arc that touches flank and root circle"
        refuse(f"{key}.root_fillet_radius_mm", expected, f"{radius:g}")
    return _touching_arc(involute, radius)
