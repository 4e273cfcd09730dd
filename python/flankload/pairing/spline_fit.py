"""Fit of a spline shaft in its hub: equal dimensions, clearances and backlash.

Both have the same base circle. Flanks without errors and backlash therefore coincide between both
tip circles. In three dimensions, the force on a slice of conforming flanks is distributed over
strips of their common height, in the same way in all slices (`contact.conforming`).
"""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, degrees
from typing import TYPE_CHECKING

import numpy as np

from flankload.base.rotation import turned
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


#: Number of strips over the height; twice as many change the rotation of the example by 0.02 %.
STRIPS = 24
#: Number of points of a flank for the interpolation of radii, accurate to 1e-8 of the height.
POINTS = 20001


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
            f"the offset of {1000 * offset:.1f} um: before all teeth carry, coast flanks would "
            "touch, too; only the working flanks are looked at"
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


# --- in three dimensions --------------------------------------------------------------------------
@dataclass(frozen=True, eq=False)
class CommonHeight:
    """The conforming part of both flanks of tooth 0, in N equal strips.

    Attributes
    ----------
    s_mm : two (N,) arrays
        Arc lengths of the middles of the strips on the flanks of shaft and hub.
    strip_mm : float
        Length of a strip along the profile.
    normal : (N, 2) array
        Normals out of the shaft there, in its frame.
    middle_mm, middle_normal, middle_s_mm : (2,) arrays and (float, float)
        Position and normal of the middle of the height, and its arc lengths on both flanks.
    axis_mm, tilt : (2,) arrays
        Position of the hub's axis relative to the shaft's at z = `middle_z_mm`, the middle of the
        common face width, and its displacement per length along z.
    """

    s_mm: tuple[Floats, Floats]
    strip_mm: float
    normal: Floats
    middle_mm: Floats
    middle_normal: Floats
    middle_s_mm: tuple[float, float]
    axis_mm: Floats
    tilt: Floats
    middle_z_mm: float

    @property
    def height_mm(self) -> float:
        """Length of the common height along the profile."""
        return self.strip_mm * self.s_mm[0].size

    def gap_mm(self, turn_rad: Floats, z_mm: Floats, spread: Floats) -> Floats:
        """Gap (S, J) by offset and tilt of the hub's axis, along the normals n of the shaft.

        A rotation vector w of the hub moves the section at z, like its axis, by z (w_y, -w_x); the
        gap is the component along n. `turn_rad` (S,): angles of the teeth of the shaft in space;
        `z_mm` (J,): slices; `spread` (N,): part of the force on each strip.
        """
        axis = self.axis_mm + np.outer(z_mm - self.middle_z_mm, self.tilt)
        return np.asarray(turned(spread @ self.normal, turn_rad) @ axis.T)


def common_height(
    shaft: Body,
    hub: Body,
    *,
    offset_mm: float,
    misalignment_rad: float,
    direction_rad: float,
    middle_z_mm: float,
) -> CommonHeight:
    """Common height of the equal involutes of shaft and hub.

    The axes are `offset_mm` apart along x, with the angle `misalignment_rad` between them: towards
    larger z, the hub's axis tilts in the direction of the polar angle `direction_rad`, about the
    axial position `middle_z_mm`. Raises a SceneError if there is no common height.
    """
    (s_1, r_1), (s_2, r_2) = _radii(shaft), _radii(hub)
    low, high = max(r_1.min(), r_2.min()), min(r_1.max(), r_2.max())
    if not low < high:
        raise SceneError(
            key="body_1.tip_diameter_mm",
            expected=f"more than {2 * low:.4f}, so that the flanks lie on each other between both "
            "fillets and tip roundings",
            found=f"a flank that ends at {2 * high:.4f}",
        )
    start, end = np.interp([low, high], r_1, s_1)
    strip = float(end - start) / STRIPS
    places = start + strip * (np.arange(STRIPS) + 0.5)
    middle = 0.5 * (start + end)
    one = np.append(places, middle)
    two = np.interp(np.interp(one, s_1, r_1), r_2[::-1], s_2[::-1])
    normal, middle_mm = shaft.curve.normal(one), shaft.curve.point([middle])[0]
    direction = np.array([np.cos(direction_rad), np.sin(direction_rad)])
    return CommonHeight(
        s_mm=(places, two[:-1]),
        strip_mm=strip,
        normal=normal[:-1],
        middle_mm=middle_mm,
        middle_normal=normal[-1],
        middle_s_mm=(float(middle), float(two[-1])),
        axis_mm=np.array([offset_mm, 0.0]),
        tilt=misalignment_rad * direction,
        middle_z_mm=middle_z_mm,
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
        "before all teeth carry, coast flanks would touch, too; only the working flanks are looked "
        "at"
    )
    return [said]


def _radii(body: Body) -> tuple[Floats, Floats]:
    """Arc lengths and radii of points on the active flank."""
    s = np.linspace(*body.mode_range_mm, POINTS)
    return s, np.hypot(*body.curve.point(s).T)
