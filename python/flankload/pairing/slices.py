"""Slices of the common face width of two bodies.

The transverse section of a body at the axial position z is that at z = 0, rotated by twist times z.
The pairs of flanks of a slice are those of the plane pair with teeth at these angles.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from math import cos, pi, sin
from typing import TYPE_CHECKING

import numpy as np

from flankload.base.gauss import leggauss
from flankload.base.rounding import TIE

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from flankload.base.arrays import Floats
    from flankload.bodies.axial_shape import AxialShape
    from flankload.bodies.body import Body
    from flankload.pairing.common_height import CommonHeight


#: Default number of slices over the common face width.
SLICES = 28
#: Part of the common face width over which line loads are means by default: one default slice. At
#: the end of a narrower body the mean over a longer part converges earlier, but where the load
#: increases towards an end it is smaller than the load there.
LINE_LOAD_PART = 1 / SLICES
#: Gauss points for the mean gap of a slice, exact for parabolas.
GAP_POINTS = 3
#: Width of the slices of cells at the ends, over that in the middle, and growth from the ends.
END_SLICE, SLICE_GROWTH = 0.3, 1.5


@dataclass(frozen=True)
class Slices:
    """J slices of the common face width.

    Attributes
    ----------
    edges_mm : (J + 1,) array
        Ends of the slices, ascending, within both bodies.
    turns_rad : two (J,) arrays
        Angle of each body's section in each slice relative to that at z = 0.
    removed_mm : two (J,) arrays
        Metal removed from the flanks of each body, along the base tangent, mean over each slice.
    of_teeth_mm : two (T, J) arrays or None
        Further metal removed from each tooth, in the order of pitch errors; None if all are equal.
    surfaces_mm : two (J, m) arrays or None
        Further metal removed at the places of a surface over the height of the flanks; None
        without.
    line_load_mm : float
        Length over which line loads are means.
    plane : bool
        Whether this is the only slice of a plane mesh, whose compliances are per width.
    sharp_ends : (int, int)
        Number of the body whose flanks end within those of the other one, at smaller and larger z;
        0 where both end together. Such an end is a sharp corner.
    conforming : CommonHeight or None
        Common height of conforming flanks (splines); None for line contact.
    coast_gap_mm : (J,) array or None
        Gap of coast flanks beyond that of working flanks, by misalignment; None if it is 0. Metal
        is removed from coast flanks as from working flanks, but for that of single teeth.
    laid_on : callable or None
        laid_on(edges_mm): slices of the same bodies between other edges; None in the plane.
    """

    edges_mm: Floats
    turns_rad: tuple[Floats, Floats]
    removed_mm: tuple[Floats, Floats]
    line_load_mm: float
    plane: bool = False
    sharp_ends: tuple[int, int] = (0, 0)
    of_teeth_mm: tuple[Floats | None, Floats | None] = (None, None)
    surfaces_mm: tuple[Floats | None, Floats | None] = (None, None)
    conforming: CommonHeight | None = None
    coast_gap_mm: Floats | None = None
    laid_on: Callable[[Floats], Slices] | None = None

    @property
    def count(self) -> int:
        """Number of slices."""
        return self.edges_mm.size - 1

    @property
    def z_mm(self) -> Floats:
        """(J,) Middle of each slice."""
        return np.asarray(0.5 * (self.edges_mm[1:] + self.edges_mm[:-1]))

    @property
    def from_middle_mm(self) -> Floats:
        """(J,) Middle of each slice from the middle of the width."""
        return self.z_mm - 0.5 * (self.edges_mm[0] + self.edges_mm[-1])

    @property
    def width_mm(self) -> Floats:
        """(J,) Width of each slice."""
        return np.diff(self.edges_mm)

    @property
    def compliance_width_mm(self) -> float:
        """Width by which compliances and peaks of forces per length are divided."""
        return float(self.width_mm[0]) if self.plane else 1.0

    def compared(self) -> Slices:
        """Slices that show the error of these: twice as many, both halves of each.

        Half as many if these are more than the default, or of conforming flanks, which all carry
        load, since a state costs the square of their number. The same in the plane.
        """
        if self.laid_on is None:
            return self
        if self.count > SLICES or (self.conforming is not None and self.count > 1):
            edges = np.append(self.edges_mm[:-1:2], self.edges_mm[-1])
        else:
            edges = np.sort(np.append(self.edges_mm, self.z_mm))
        return replace(self.laid_on(edges), conforming=self.conforming)

    def site_angles(self, angles_rad: Floats, body: int, *, coast: bool = False) -> Floats:
        """Angles (S * J,) of the teeth (S,) of a body in all slices, slice by slice per site.

        For coast flanks: angles of the mirror image, whose helix has the other hand.
        """
        turns = self.turns_rad[body]
        return np.asarray(np.add.outer(angles_rad, -turns if coast else turns).ravel())

    def site_deviations(self, deviations_mm: Floats, body: int, *, coast: bool = False) -> Floats:
        """Excess metal (S * J,) in all slices from that of the sites (S,) or (S, J), mm."""
        each, removed = deviations_mm.reshape(len(deviations_mm), -1), self.removed_mm[body]
        if coast and body == 1 and self.coast_gap_mm is not None:
            removed = removed + self.coast_gap_mm
        return np.asarray((each - removed).ravel())

    def tooth_deviations(self, sites: NDArray[np.int64], body: int) -> Floats:
        """Excess metal on the teeth of a body at sites (S,): (S, 1) or (S, J), mm."""
        removed = self.of_teeth_mm[body]
        if removed is None:
            return np.zeros((sites.size, 1))
        # the tooth after that of pair 0 comes into contact as pair -1; on a spline it is pair 1
        entries = -sites if self.conforming is None else sites
        return np.asarray(-removed[entries % len(removed)])


def plane_slice(face_width_mm: float) -> Slices:
    """The only slice of a plane mesh, the same for both bodies."""
    ends, none = 0.5 * face_width_mm * np.array([-1.0, 1.0]), np.zeros(1)
    return Slices(ends, (none, none), (none, none), line_load_mm=face_width_mm, plane=True)


def slices_of(
    shapes: tuple[AxialShape, AxialShape],
    count: int | None,
    misalignment_per_mm: tuple[float, float] = (0.0, 0.0),
    *,
    graded: bool = False,
    line_load_mm: float | None = None,
) -> Slices:
    """Slices of the common face width.

    Parameters
    ----------
    count : int or None
        Number of slices, `SLICES` by default.
    misalignment_per_mm : (float, float)
        Gap per length along z by the misalignment of the axes, of working and of coast flanks.
    graded : bool
        Narrower slices at both ends, which resolve the pressure there, instead of equal ones.
    line_load_mm : float or None
        Length over which line loads are means, a part `LINE_LOAD_PART` of the width by default.
    """
    one, two = shapes
    low = max(one.range_mm[0], two.range_mm[0])
    high = min(one.range_mm[1], two.range_mm[1])
    edges = _ends_of_slices(low, high, count or SLICES, graded=graded)
    line_load_mm = line_load_mm or LINE_LOAD_PART * (high - low)
    return _laid_on(shapes, misalignment_per_mm, line_load_mm, edges)


def _laid_on(
    shapes: tuple[AxialShape, AxialShape],
    misalignment_per_mm: tuple[float, float],
    line_load_mm: float,
    ends: Floats,
) -> Slices:
    """Slices between these ends (J + 1,)."""
    one, two = shapes
    z, half = 0.5 * (ends[1:] + ends[:-1]), 0.5 * np.diff(ends)
    (gap, coast_gap), (places, weights) = misalignment_per_mm, leggauss(GAP_POINTS)
    inside = z[:, np.newaxis] + np.outer(half, places)

    def of_teeth(shape: AxialShape) -> Floats | None:
        return shape.tooth_gaps_mm(inside) @ weights / 2.0 if shape.tooth_slopes_mm else None

    def surface(shape: AxialShape) -> Floats | None:
        if shape.surface is None:
            return None
        removed = shape.surface.at(shape.zeta(inside.ravel()), shape.width_mm)
        return np.einsum("jkm,k->jm", removed.reshape(*inside.shape, -1), weights / 2.0)

    return Slices(
        edges_mm=ends,
        turns_rad=(one.twist_rad_per_mm * z, two.twist_rad_per_mm * z),
        removed_mm=(
            one.gap_mm(inside) @ weights / 2.0,
            two.gap_mm(inside) @ weights / 2.0 + gap * z,
        ),
        line_load_mm=line_load_mm,
        sharp_ends=_sharp_ends(one.range_mm, two.range_mm),
        of_teeth_mm=(of_teeth(one), of_teeth(two)),
        surfaces_mm=(surface(one), surface(two)),
        coast_gap_mm=None if coast_gap == gap else (coast_gap - gap) * z,
        laid_on=partial(_laid_on, shapes, misalignment_per_mm, line_load_mm),
    )


def _sharp_ends(one: tuple[float, float], two: tuple[float, float]) -> tuple[int, int]:
    """Body whose end is inside the range of the other one, at both ends; 0 without one."""
    least = TIE * (one[1] - one[0])
    low, high = one[0] - two[0], two[1] - one[1]

    def body(inside: float) -> int:
        return 0 if abs(inside) <= least else 1 if inside > 0 else 2

    return body(low), body(high)


def _ends_of_slices(low: float, high: float, count: int, *, graded: bool) -> Floats:
    """Ends (count + 1,) of slices, symmetric about the middle of the width."""
    if not graded:
        return np.linspace(low, high, count + 1)
    from_end = np.minimum(np.arange(count), np.arange(count)[::-1])
    widths = np.minimum(1.0, END_SLICE * SLICE_GROWTH**from_end)
    before = np.cumsum(np.append(0.0, widths))
    # exact at both ends, and bitwise symmetric
    part = (before - before[::-1] + before[-1]) / (2.0 * before[-1])
    return np.asarray((1.0 - part) * low + part * high)


def gap_by_misalignment(
    inclination_um_per_mm: float, deviation_um_per_mm: float, pressure_angle_rad: float
) -> float:
    """Gap per length along z by a misalignment of the axes, along the base tangent (ISO 6336-1).

    The inclination is in the plane of both axes, the deviation across it; the angle is the working
    transverse pressure angle.
    """
    gap = inclination_um_per_mm * sin(pressure_angle_rad)
    gap += deviation_um_per_mm * cos(pressure_angle_rad)
    return gap / 1000.0


def reached_positions(position_rad: Floats, body_1: Body) -> Floats:
    """Angles (n,) of all sections of body 1 over its width, at angles (P,) of that at z = 0."""
    if not body_1.axial.twist_rad_per_mm:
        return position_rad
    low, high = (body_1.axial.twist_rad_per_mm * z for z in body_1.axial.range_mm)
    # steps below half a pitch, so that no pair is missed
    steps = 2 + int(abs(high - low) * body_1.teeth / pi)
    return np.unique(np.add.outer(position_rad, np.linspace(low, high, steps)))
