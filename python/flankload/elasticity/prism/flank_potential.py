"""Near field of a load on the flank of a prism: half-space, images behind end faces and corners.

An involute helicoid unrolls: places (s, z) on the flank lie so far apart that

    x = (s - s') - (z - z') [c(s) + c(s')]/2,  y = (z - z')/cos(beta_b),  R² = x² + y²

with c = ds/dz along the straight line across the flank (a contact line), which runs along y. A unit
force moves the flank out of the material by

    k [1/R + sum_e psi_e/R_e + sum_w psi_w/R_w],  k = (1 - nu²)/(pi E)
    R_e² = x² + ((z + z' - 2 z_e)/cos(beta_b))²      behind the end face z_e
    R_w² = (d + d')² + y²                            behind a free corner, d = |s - s_w|

In contact lines x = 0. Uniform loads on rectangles have Love's closed form, on segments of a line
its limit.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.polynomial.legendre import leggauss, legvander

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import ArrayLike, NDArray

    Floats = NDArray[np.float64]

#: Gauss points beside those that the degrees of the modes need: in the directions in which 1/R is
#: smooth without being a polynomial. Twice as many change the projections by less than 1e-6.
DIRECTION_POINTS, MIDDLE_POINTS = 16, 4


def love_rectangle(x: ArrayLike, y: ArrayLike, a: float, b: float) -> Floats:
    """Mean of 1/R over the rectangle |x'| <= a, |y'| <= b.

    Parameters
    ----------
    x, y : arrays that broadcast
        Place from the centre, mm.
    a, b : float
        Half sides, mm, above 0.

    Returns
    -------
    array
        1/mm; times k the displacement under a unit load (A. E. H. Love, Phil. Trans. A 228, 1929).
    """
    x, y = np.asarray(x, dtype=float), np.asarray(y, dtype=float)
    corners = (
        _corner(x + a, y + b)
        - _corner(x + a, y - b)
        - _corner(x - a, y + b)
        + _corner(x - a, y - b)
    )
    return np.asarray(corners / (4.0 * a * b))


def _corner(x: Floats, y: Floats) -> Floats:
    """X asinh(Y/|X|) + Y asinh(X/|Y|); a term with a factor 0 is 0."""
    return _term(x, y) + _term(y, x)


def _term(x: Floats, y: Floats) -> Floats:
    magnitude = np.abs(x)
    return x * np.arcsinh(y / np.where(magnitude > 0, magnitude, 1.0))


def line_segment(y: ArrayLike, b: float) -> Floats:
    """Mean of 1/R over the segment |y'| <= b of the same line, |y| > b; 1/mm."""
    distance = np.abs(np.asarray(y, dtype=float))
    return np.asarray(np.log((distance + b) / (distance - b)) / (2.0 * b))


@dataclass(frozen=True, eq=False)
class FlankSurface:
    """Flank of a prism between the ends of its modes, unrolled, and its images.

    Attributes
    ----------
    s_mm, z_mm : (float, float)
        Ranges of arc length and along the axis.
    cos_base_helix : float
        cos(beta_b).
    slope : callable
        Arc lengths to ds/dz along the straight line through the place, of the same shape.
    end : (float, float)
        Strengths psi of the images behind the end faces at low and high z.
    wedge : (float, float)
        The same behind free corners at low and high s.
    """

    s_mm: tuple[float, float]
    z_mm: tuple[float, float]
    cos_base_helix: float
    slope: Callable[[Floats], Floats]
    end: tuple[float, float]
    wedge: tuple[float, float]

    @property
    def length_mm(self) -> float:
        """Along the profile."""
        return self.s_mm[1] - self.s_mm[0]

    @property
    def width_mm(self) -> float:
        """Along the axis."""
        return self.z_mm[1] - self.z_mm[0]

    def potential(self, s: Floats, z: Floats, s_load: Floats, z_load: Floats) -> Floats:
        """Near field of point loads over k; 1/mm, infinite at the load itself.

        Parameters
        ----------
        s, z, s_load, z_load : arrays that broadcast
            Places, mm.
        """
        z_change = z - z_load
        x = s - s_load - 0.5 * (self.slope(s) + self.slope(s_load)) * z_change
        y = z_change / self.cos_base_helix
        with np.errstate(divide="ignore"):
            total = 1.0 / np.hypot(x, y)
        for psi, face in zip(self.end, self.z_mm, strict=True):
            total = total + psi / np.hypot(x, (z + z_load - 2.0 * face) / self.cos_base_helix)
        for psi, corner in zip(self.wedge, self.s_mm, strict=True):
            total = total + psi / np.hypot(np.abs(s - corner) + np.abs(s_load - corner), y)
        return np.asarray(total)


def projected_potential(
    surface: FlankSurface, n_modes: int, degree_z: int, *, finer: int = 1
) -> Floats:
    """<P, potential P> over the flank for modes P_a(xi_s) P_b(xi_z).

    1/R is of degree -1 at R = 0: from there coordinates t, t w, t w' leave a smooth integrand, for
    which Gauss's rule converges like a power.

    Parameters
    ----------
    surface : FlankSurface
    n_modes : int
        a = 0 ... n_modes - 1.
    degree_z : int
        b = 0 ... degree_z.
    finer : int
        So many times as many points.

    Returns
    -------
    (p, p) array, p = n_modes (degree_z + 1), row a (degree_z + 1) + b
        Symmetric; with area elements ds dz/cos(beta_b), mm³.
    """
    rule = _Rule(surface, n_modes, degree_z, finer)
    total = rule.direct()
    for psi, face in zip(surface.end, (0, 1), strict=True):
        if psi:
            total += psi * rule.behind_end(face)
    for psi, corner in zip(surface.wedge, (0, 1), strict=True):
        if psi:
            total += psi * rule.behind_corner(corner)
    size = n_modes * (degree_z + 1)
    result = total.transpose(0, 2, 1, 3).reshape(size, size) / surface.cos_base_helix**2
    return np.asarray(0.5 * (result + result.T))


class _Rule:
    """Integrals [a, c, b, d] of P_a(s) P_c(s') P_b(z) P_d(z') over the distance."""

    def __init__(self, surface: FlankSurface, n_modes: int, degree_z: int, finer: int) -> None:
        self._surface = surface
        self._n, self._m = n_modes, degree_z + 1
        self._radial = _unit_gauss(finer * (n_modes + degree_z + 4))
        self._sideways = _unit_gauss(finer * DIRECTION_POINTS)
        self._along = _unit_gauss(finer * (n_modes + MIDDLE_POINTS))
        self._across = _unit_gauss(self._m)

    def direct(self) -> Floats:
        """Without an image: over s - s' > 0, and its transpose."""
        surface = self._surface
        (p, q), weight = _cone(2, self._radial, self._sideways)
        ahead, apart = p * surface.length_mm, q * surface.width_mm
        weight = weight * surface.length_mm * surface.width_mm
        total = np.zeros((self._n, self._n, self._m, self._m))
        for z_change in (apart, -apart):
            part = self._profile(ahead, z_change, z_change, weight)
            total += np.tensordot(part, self._overlap(z_change), axes=(0, 0))
        return total + total.transpose(1, 0, 3, 2)

    def behind_end(self, face: int) -> Floats:
        """Behind the low end face (0) or the high one (1)."""
        surface, width = self._surface, self._surface.width_mm
        (p, one, two), weight = _cone(3, self._radial, self._sideways)
        outward = 1.0 if face else -1.0
        z_change = outward * (two - one) * width
        weight = weight * surface.length_mm * width**2
        part = self._profile(p * surface.length_mm, z_change, (one + two) * width, weight)
        values = [legvander(outward * (1.0 - 2.0 * eta), self._m - 1) for eta in (one, two)]
        across = values[0][:, :, None] * values[1][:, None, :]
        total = np.tensordot(part, across, axes=(0, 0))
        return np.asarray(total + total.transpose(1, 0, 3, 2))

    def behind_corner(self, corner: int) -> Floats:
        """Behind the corner at the low end of the arc length (0) or the high one (1)."""
        surface, length = self._surface, self._surface.length_mm
        (one, two, q), weight = _cone(3, self._radial, self._sideways)
        outward = 1.0 if corner else -1.0
        apart = q * surface.width_mm
        distance = np.hypot((one + two) * length, apart / surface.cos_base_helix)
        weight = weight * length**2 * surface.width_mm / distance
        values = [legvander(outward * (1.0 - 2.0 * d), self._n - 1) for d in (one, two)]
        part = weight[:, None, None] * values[0][:, :, None] * values[1][:, None, :]
        # z - z' < 0 is the transpose, and the sum is made symmetric
        return np.asarray(np.tensordot(part, 2.0 * self._overlap(apart), axes=(0, 0)))

    def _profile(self, ahead: Floats, z_change: Floats, y_change: Floats, weight: Floats) -> Floats:
        """Integrals (k, a, c) of P_a(s) P_c(s')/R over all places with s - s' = ahead (k,)."""
        surface = self._surface
        (low, high), (at, gauss) = surface.s_mm, self._along
        spare = surface.length_mm - ahead
        behind = low + spare[:, None] * at  # s'
        places = behind + ahead[:, None], behind
        slope = 0.5 * sum(surface.slope(s) for s in places)
        x = ahead[:, None] - slope * z_change[:, None]
        factor = (weight * spare)[:, None] * gauss
        factor = factor / np.hypot(x, (y_change / surface.cos_base_helix)[:, None])
        one, two = (legvander((2.0 * s - low - high) / (high - low), self._n - 1) for s in places)
        return np.asarray((factor[..., None] * one).transpose(0, 2, 1) @ two)

    def _overlap(self, z_change: Floats) -> Floats:
        """Integrals (k, b, d) of P_b(z) P_d(z') over all places with z - z' = z_change (k,)."""
        width, (at, gauss) = self._surface.width_mm, self._across
        spare = width - np.abs(z_change)
        first = np.maximum(z_change, 0.0)
        z = (first[:, None] + spare[:, None] * at) / width
        one = legvander(2.0 * z - 1.0, self._m - 1)
        two = legvander(2.0 * (z - (z_change / width)[:, None]) - 1.0, self._m - 1)
        return np.asarray((one * (spare[:, None] * gauss)[..., None]).transpose(0, 2, 1) @ two)


def _unit_gauss(points: int) -> tuple[Floats, Floats]:
    """Gauss's rule on [0, 1]."""
    at, weights = leggauss(points)
    return 0.5 + 0.5 * at, 0.5 * weights


def _cone(
    dimension: int, radial: tuple[Floats, Floats], sideways: tuple[Floats, Floats]
) -> tuple[list[Floats], Floats]:
    """Points of the unit cube (by coordinate) and weights, cut into cones from its corner 0."""
    rules = [radial, *[sideways] * (dimension - 1)]
    t, *others = (part.ravel() for part in np.meshgrid(*(at for at, _ in rules), indexing="ij"))
    weights = np.meshgrid(*(weight for _, weight in rules), indexing="ij")
    weight = np.prod([part.ravel() for part in weights], axis=0) * t ** (dimension - 1)
    edges = [t, *(t * other for other in others)]
    cones = [np.roll(np.arange(dimension), turn) for turn in range(dimension)]
    points = [np.concatenate([edges[cone[axis]] for cone in cones]) for axis in range(dimension)]
    return points, np.tile(weight, dimension)
