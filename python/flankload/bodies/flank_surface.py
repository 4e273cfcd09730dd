"""Metal removed from a flank over its height and its width: twist, measured topography.

The point of each diameter is turned about the axis by the metal removed there over the base radius:
so the modified flank deviates from the other one by that amount along the base tangent, as in a
profile diagram, and tip and root keep their circles.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from flankload.bodies.topography import Topography, read_topography
from flankload.flank import FlankCurve, turned_along

if TYPE_CHECKING:
    from pathlib import Path

    from scipy.interpolate import CubicSpline

    from flankload.base.arrays import Floats
    from flankload.bodies.body import Body
    from flankload.scene.axial import AxialKeys


@dataclass(frozen=True)
class FlankSurface:
    """Metal removed as a function of the place on a flank, in the direction of the base tangent.

    Attributes
    ----------
    range_mm : (float, float)
        Arc lengths at the ends of the active flank: between root fillet and tip rounding or tip.
    twist_mm : float
        Half of it is removed at the root at the end of smaller z and at the tip at the other end,
        half is added at the two other corners.
    topography : Topography or None
        Measured deviations.
    """

    range_mm: tuple[float, float]
    twist_mm: float = 0.0
    topography: Topography | None = None

    @property
    def places_mm(self) -> Floats:
        """(m,) Arc lengths at which the metal removed is known, ascending; between: a spline."""
        return np.array(self.range_mm) if self.topography is None else self.topography.s_mm

    def at(self, zeta: Floats, width_mm: float) -> Floats:
        """Metal removed (n, m) at all places of n sections, mm; negative where metal is added.

        `zeta` (n,): places along the face width, 0 at the end of smaller z, 1 at the other.
        """
        low, high = self.range_mm
        xi = (self.places_mm - low) / (high - low)
        removed = 0.5 * self.twist_mm * np.multiply.outer(2.0 * zeta - 1.0, 2.0 * xi - 1.0)
        if self.topography is not None:
            removed += self.topography.at(zeta * width_mm)
        return np.asarray(removed)

    @property
    def most_added_mm(self) -> float:
        """Upper bound of the metal added, mm."""
        most = 0.5 * abs(self.twist_mm)
        if self.topography is not None:
            most += max(0.0, -float(self.topography.removed_mm.min()))
        return most


def flank_surface(
    keys: AxialKeys, key: str, body: Body, *, folder: Path, width_mm: float
) -> FlankSurface | None:
    """Twist and topography from the keys of a body; None without these keys.

    The file of the topography is relative to the folder; the width is that of the body.

    Raises
    ------
    SceneError
        If the file is missing or faulty, or does not cover the flank.
    """
    if not keys.profile_twist_um and keys.topography_file is None:
        return None
    grid = None
    if keys.topography_file is not None:
        path, name = folder / keys.topography_file, f"{key}.topography_file"
        grid = read_topography(path, name, body.curve, body.mode_range_mm, width_mm)
    return FlankSurface(body.mode_range_mm, (keys.profile_twist_um or 0.0) / 1000.0, grid)


def section_curves(body: Body, removed_mm: Floats) -> list[FlankCurve]:
    """Flanks of a body with a surface in n sections, all with the same breaks.

    `removed_mm`: metal removed (n, m) at the places of the surface in these sections.
    """
    from scipy.interpolate import CubicSpline

    assert body.axial is not None
    assert body.axial.surface is not None
    surface = body.axial.surface
    radius = body.base_radius_mm or abs(body.normal_lever_mm)
    ends = (body.curve.breaks[0], *surface.range_mm, body.curve.length_mm)
    splines = [
        CubicSpline(surface.places_mm, -body.outward * removed / radius) for removed in removed_mm
    ]
    knots = np.append(surface.places_mm, surface.range_mm)
    return [turned_along(body.curve, partial(_faded, spline, ends), knots) for spline in splines]


def _faded(
    spline: CubicSpline, ends: tuple[float, float, float, float], s: Floats
) -> tuple[Floats, Floats, Floats]:
    """Values of a spline and two derivatives; beside the active flank they become constant.

    The slope fades over root fillet and tip rounding by a quintic, so that the curvature has no
    jump.
    """
    low, high = ends[1], ends[2]
    inside = np.clip(s, low, high)
    value, first, second = spline(inside), spline(inside, 1), spline(inside, 2)
    for end, far, side in ((low, ends[0], s < low), (high, ends[3], s > high)):
        if not side.any():
            continue
        h = far - end
        x = (s[side] - end) / h
        slope, bend = h * float(spline(end, 1)), h**2 * float(spline(end, 2))
        # value, slope and bend of the end at x = 0; constant from x = 1 on, at the same value
        c = np.array([0.0, slope, 0.5 * bend, *_closing(slope, bend)])
        polynomial = np.polynomial.Polynomial(c)
        value[side] = float(spline(end)) + polynomial(x)
        first[side] = polynomial.deriv(1)(x) / h
        second[side] = polynomial.deriv(2)(x) / h**2
    return value, first, second


def _closing(slope: float, bend: float) -> tuple[float, float, float]:
    """Coefficients of x^3 to x^5 with which slope x + bend x^2/2 + ... ends in 0, flat."""
    return -6.0 * slope - 1.5 * bend, 8.0 * slope + 1.5 * bend, -3.0 * slope - 0.5 * bend
