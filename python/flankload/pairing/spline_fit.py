"""Fit of a spline shaft in its hub: equal dimensions, clearances and backlash.

Both have the same base circle. Flanks without errors and backlash therefore coincide between both
tip circles.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, degrees
from typing import TYPE_CHECKING

import numpy as np

from flankload.base.rounding import TIE
from flankload.errors import SceneError
from flankload.pairing.interference import LEAST_OVERLAP, along

if TYPE_CHECKING:
    from flankload.base.arrays import Floats
    from flankload.bodies.body import Body
    from flankload.bodies.profile.involute import Involute
    from flankload.pairing.slices import Slices


#: Largest interference of tooth and space for a press fit, in base pitches.
LARGEST_OVERLAP = 0.01


#: Number of points in each interval of a flank's curve.
POINTS_PER_INTERVAL = 12


@dataclass(frozen=True)
class SplineFit:
    """Fit of shaft and hub, with offset axes.

    `active_radii_mm`: tip radii of hub and shaft, between which the flanks coincide; `turn_rad`:
    angle of the hub at which flanks without errors touch on a common axis. Pressure angle and
    backlash are those on the pitch circle.
    """

    pressure_angle_rad: float
    pitch_radius_mm: float
    base_radius_mm: float
    active_radii_mm: tuple[float, float]
    turn_rad: float
    backlash_mm: float
    offset_mm: float

    @property
    def normal_backlash_mm(self) -> float:
        """Backlash along the base tangent, mm."""
        return self.backlash_mm * cos(self.pressure_angle_rad)


def spline_fit(
    shaft: Body, hub: Body, offset: float, warnings: list[str], *, coast_flanks: bool = False
) -> SplineFit:
    """Geometry of a shaft in its hub with axes `offset` mm apart, checked.

    Warnings for the user are appended. If coast flanks can carry load, a tooth may be wider than
    its space by `LARGEST_OVERLAP`.
    """
    assert shaft.involute is not None
    assert hub.involute is not None
    one, two = shaft.involute, hub.involute
    _check_teeth(shaft, hub)
    _check_circles(one, two, offset)
    clearance = _angular_clearance(one, two, shaft.teeth, coast_flanks=coast_flanks)
    fit = SplineFit(
        pressure_angle_rad=float(np.arccos(one.base_radius_mm / one.reference_radius_mm)),
        pitch_radius_mm=one.reference_radius_mm,
        base_radius_mm=one.base_radius_mm,
        active_radii_mm=(two.tip_radius_mm, one.tip_radius_mm),
        turn_rad=-clearance,
        backlash_mm=2 * clearance * one.reference_radius_mm,
        offset_mm=offset,
    )
    _check_roots(shaft, hub, fit)
    if 2 * offset > fit.normal_backlash_mm and not coast_flanks:
        warnings.append(
            f"the normal backlash of {1000 * fit.normal_backlash_mm:.1f} um is less than twice "
            f"the offset of {1000 * offset:.1f} um: coast flanks would touch before all "
            "teeth carry load, which this run ignores (effects.coast_flank = true includes them)"
        )
    return fit


def _check_teeth(shaft: Body, hub: Body) -> None:
    """Check for equal number of teeth, module and pressure angle."""
    (module_1, angle_1), (module_2, angle_2) = (
        _module_and_angle(body.involute, body.teeth) for body in (shaft, hub)
    )
    for key, one, two, tolerance in (
        ("teeth", shaft.teeth, hub.teeth, 0.0),
        ("module_mm", module_1, module_2, TIE * module_1),
        ("pressure_angle_deg", angle_1, angle_2, TIE),
    ):
        if abs(two - one) > tolerance:
            raise SceneError(
                key=f"body_2.{key}",
                expected=f"{one:g}, as in body_1.{key}",
                found=f"{two:g}",
            )


def _angular_clearance(one: Involute, two: Involute, teeth: int, *, coast_flanks: bool) -> float:
    """Half the difference of the angular widths of space and tooth, rad, checked."""
    clearance = two.base_half_angle_rad - one.base_half_angle_rad
    wider = -2 * clearance * one.reference_radius_mm
    widest = LARGEST_OVERLAP * 2 * np.pi * one.base_radius_mm / teeth
    if coast_flanks and wider > widest:
        raise SceneError(
            key="body_1.profile_shift",
            expected=f"a tooth wider than its space by at most {widest:.4f} mm on the pitch circle "
            f"({LARGEST_OVERLAP:g} of the base pitch), even with effects.coast_flank",
            found=f"{wider:.4f} mm",
        )
    if clearance < -TIE and not coast_flanks:
        raise SceneError(
            key="body_1.profile_shift",
            expected="at most that of body_2, so that the tooth is no wider than the space (or "
            "effects.coast_flank = true)",
            found=f"a tooth that is {wider:.4f} mm wider on the pitch circle",
        )
    return clearance


def _module_and_angle(involute: Involute | None, teeth: int) -> tuple[float, float]:
    """Module (mm) and pressure angle (deg)."""
    assert involute is not None
    radius = involute.reference_radius_mm
    return 2 * radius / teeth, degrees(np.arccos(involute.base_radius_mm / radius))


def _check_circles(one: Involute, two: Involute, offset: float) -> None:
    """Check that the tips overlap and clear the roots, including the offset."""
    if one.tip_radius_mm - offset <= two.tip_radius_mm:
        raise SceneError(
            key="body_1.tip_diameter_mm",
            expected=f"more than {2 * (two.tip_radius_mm + offset):g}, body_2.tip_diameter_mm "
            "(and twice the offset), so that flanks lie on each other",
            found=f"{2 * one.tip_radius_mm:g}",
        )
    for key, tip, mate, root, side in (
        ("body_1", one.tip_radius_mm, "body_2", two.root_radius_mm, 1),
        ("body_2", two.tip_radius_mm, "body_1", one.root_radius_mm, -1),
    ):
        if side * (root - tip) <= offset:
            word = "less" if side > 0 else "more"
            raise SceneError(
                key=f"{key}.tip_diameter_mm",
                expected=f"{word} than {2 * (root - side * offset):.4f}, where the tip clears the "
                f"root circle of {mate}" + (f" on an offset of {offset:g} mm" if offset else ""),
                found=f"{2 * tip:g}",
            )


def _check_roots(shaft: Body, hub: Body, fit: SplineFit) -> None:
    """Check that no tip overlaps the mate's root fillet when the flanks touch."""
    (r_1, angle_1), (r_2, angle_2) = (_places(body) for body in (shaft, hub))
    low, high = fit.active_radii_mm
    radius = np.unique(np.concatenate([r_1, r_2]))
    radius = radius[(radius >= low) & (radius <= high)]
    gap = np.interp(radius, r_2, angle_2) + fit.turn_rad - np.interp(radius, r_1, angle_1)
    depth = -gap * radius
    worst = int(np.argmax(depth))
    if depth[worst] <= LEAST_OVERLAP * shaft.curve.length_mm:
        return
    at_hub_tip = radius[worst] < 0.5 * (low + high)
    (key, tip), mate = (("body_2", low), shaft) if at_hub_tip else (("body_1", high), hub)
    form = 2 * (mate.involute.form_radius_mm if mate.involute else 0.0)
    raise SceneError(
        key=f"{key}.tip_diameter_mm",
        expected=f"a tip that clears the root fillet of {'body_1' if at_hub_tip else 'body_2'}, "
        f"which begins at the diameter {form:.4f}",
        found=f"{2 * tip:g}, where they overlap by {depth[worst]:.4f} mm",
    )


def _places(body: Body) -> tuple[Floats, Floats]:
    """Radii, ascending, and polar angles of points on a flank."""
    x, y = body.curve.point(along(body.curve, POINTS_PER_INTERVAL)).T
    radius, angle = np.hypot(x, y), np.arctan2(y, x)
    order = np.argsort(radius, kind="stable")
    return radius[order], angle[order]


def describe_fit(fit: SplineFit) -> tuple[tuple[str, str], ...]:
    """Main geometry of a spline: rows of name and value with unit."""
    low, high = fit.active_radii_mm
    return (
        ("pressure angle", f"{degrees(fit.pressure_angle_rad):.4f} deg"),
        ("pitch diameter", f"{2 * fit.pitch_radius_mm:.4f} mm"),
        ("active flank between", f"{2 * low:.4f} and {2 * high:.4f} mm"),
        ("backlash on the pitch circle", f"{fit.backlash_mm:.4f} mm"),
        ("backlash, normal", f"{fit.normal_backlash_mm:.4f} mm"),
    )


def tilt_notes(fit: SplineFit | None, slices: Slices) -> list[str]:
    """Note on coast flanks of a misaligned spline that would touch before all teeth carry."""
    height = slices.conforming
    if fit is None or height is None or not height.tilt.any():
        return []
    width_mm = float(slices.width_mm.sum())
    moved = fit.offset_mm + 0.5 * width_mm * float(np.hypot(*height.tilt))
    if 2.0 * moved <= fit.normal_backlash_mm:
        return []
    said = (
        f"the normal backlash of {1000 * fit.normal_backlash_mm:.1f} um is less than twice the "
        f"{1000 * moved:.1f} um by which misalignment and offset move the ends of the flanks: "
        "coast flanks would touch before all teeth carry load, which this run ignores"
    )
    return [said]
