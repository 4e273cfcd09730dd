"""Near field of a load on the flank of a prism: half-space, images behind end faces and corners.

On the developed involute helicoid, the distance R of points (s, z) and (s', z') follows from

    x = (s - s') - (z - z') [c(s) + c(s')]/2,  y = (z - z')/cos(beta_b),  R² = x² + y²

with c = ds/dz along the straight line across the flank (a contact line, x = 0), parallel to y. The
normal displacement of the flank under a normal unit force is

    k [1/R + sum_e psi_e/R_e + sum_w psi_w/R_w],  k = (1 - nu²)/(pi E)
    R_e² = x² + ((z + z' - 2 z_e)/cos(beta_b))²      behind the end face z_e
    R_w² = (d + d')² + y²                            behind a free corner, d = |s - s_w|

The normal displacement under a unit force along the profile, towards increasing arc length, is

    -j/pi x/R² + k sum_w psi_nt/R_w,  j = (1 - 2 nu)(1 + nu)/(2 E)

(Cerruti; K. L. Johnson, Contact Mechanics, (3.75)): inwards in front of the force.

On a tip rounding or chamfer, beta_b varies with s, and the mean of both points is used in R.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise, product
from typing import TYPE_CHECKING

import numpy as np
from numpy.polynomial.legendre import legvander

from flankload.elasticity.prism.flank_surface import DIRECTION_POINTS, FlankSurface, unit_gauss

if TYPE_CHECKING:
    from collections.abc import Iterator

    from flankload.base.arrays import Floats, Numbers

#: Gauss points along the profile, besides those for the degrees of the modes.
MIDDLE_POINTS = 4
#: With a tip, which is short: growth of panels away from R = 0, and points besides those for the
#: modes.
GROWTH, PANEL_POINTS = 4.0, 4


def projected_potential(
    surface: FlankSurface, n_modes: int, degree_z: int, *, finer: int = 1
) -> Floats:
    """<P, potential P> over the flank for modes P_a(xi_s) P_b(xi_z).

    Coordinates t, t w, t w' from R = 0 cancel the singularity of 1/R, so that the Gauss rule
    converges exponentially.

    Parameters
    ----------
    n_modes : int
        a = 0 ... n_modes - 1, including those of a tip.
    degree_z : int
        b = 0 ... degree_z.
    finer : int
        Factor on the number of points.

    Returns
    -------
    (p, p) array, p = n_modes (degree_z + 1), row a (degree_z + 1) + b
        Symmetric; with area elements ds dz/cos(beta), mm³.
    """
    rule = _Rule(surface, n_modes, degree_z, finer)
    total = rule.direct()
    for psi, face in zip(surface.end, (0, 1), strict=True):
        if psi:
            total += psi * rule.behind_end(face)
    for psi, corner in zip(surface.wedge, (0, 1), strict=True):
        if psi:
            total += psi * rule.behind_corner(corner)
    result = _by_mode(total)
    return np.asarray(0.5 * (result + result.T))


def projected_tangential(
    surface: FlankSurface,
    n_modes: int,
    degree_z: int,
    *,
    kernel: float,
    jump: float,
    finer: int = 1,
) -> Floats:
    """<P, near field P> for normal displacements (rows) under loads along the profile, (p, p).

    Arguments as for `projected_potential`, with `kernel` c0 = 2 k and `jump` j, mm²/N. With area
    elements ds dz/cos(beta), mm⁵/N.
    """
    rule = _Rule(surface, n_modes, degree_z, finer)
    direct, images = rule.direct(turned=True), np.zeros([n_modes] * 2 + [degree_z + 1] * 2)
    for psi, corner in zip(surface.wedge_along, (0, 1), strict=True):
        if psi:
            images += 0.5 * kernel * psi * rule.behind_corner(corner)
    behind = _by_mode(images)
    return np.asarray(-jump / np.pi * _by_mode(direct) + 0.5 * (behind + behind.T))


def _by_mode(total: Floats) -> Floats:
    """Integrals [a, c, b, d] of P_a P_b times P_c P_d as a matrix."""
    n_modes, _, count, _ = total.shape
    return total.transpose(0, 2, 1, 3).reshape(n_modes * count, n_modes * count)


@dataclass(frozen=True, eq=False)
class _Lines:
    """Pairs of points (s, s') of two pieces of the profile at m distances s - s', g for each.

    Many points of a rule have the same distance s - s' and differ along the axis only.

    Attributes
    ----------
    index : (k,) array
        Index of each distance among the m that occur between the pieces; -1 if it does not.
    spare : (m,) array
        Length over which the pairs extend, mm.
    slope, secant : (m, g) array
        Means of both points.
    secants : two (m, g) arrays
    modes : two (m, g, n) arrays
    """

    index: Numbers
    spare: Floats
    slope: Floats
    secant: Floats
    secants: tuple[Floats, ...]
    modes: tuple[Floats, ...]


class _Rule:
    """Integrals [a, c, b, d] of P_a(s) P_c(s') P_b(z) P_d(z') over the distance."""

    def __init__(self, surface: FlankSurface, n_modes: int, degree_z: int, finer: int) -> None:
        self._surface = surface
        self._n, self._m = n_modes, degree_z + 1
        self._radial = unit_gauss(finer * (n_modes + degree_z + 4))
        self._sideways = unit_gauss(finer * DIRECTION_POINTS)
        self._along = unit_gauss(finer * (n_modes + MIDDLE_POINTS))
        self._across = unit_gauss(self._m)
        self._panel = unit_gauss(finer * (max(n_modes, degree_z) // 2 + PANEL_POINTS))
        lengths = np.diff(surface.pieces_mm)
        shortest = float(lengths.min())
        self._ahead = _panels(surface.length_mm, shortest, lengths)
        self._apart = _panels(surface.width_mm, shortest, np.full(lengths.size - 1, shortest))
        self._known: dict[bytes, list[_Lines]] = {}

    def direct(self, *, turned: bool = False) -> Floats:
        """Integral without an image; if turned, that of x/R², which is antisymmetric."""
        total = np.zeros((self._n, self._n, self._m, self._m))
        for (ahead, apart), weight in self._points(self._ahead, self._apart):
            for z_change in (apart, -apart):
                part = self._profile(ahead, z_change, z_change, weight, turned=turned)
                total += np.tensordot(part, self._overlap(z_change), axes=(0, 0))
        exchanged = total.transpose(1, 0, 3, 2)
        return np.asarray(total - exchanged if turned else total + exchanged)

    def behind_end(self, face: int) -> Floats:
        """Integral for the image behind the low (0) or the high end face (1)."""
        surface, outward = self._surface, 1.0 if face else -1.0
        total = np.zeros((self._n, self._n, self._m, self._m))
        for (ahead, one, two), weight in self._points(self._ahead, self._apart, self._apart):
            part = self._profile(ahead, outward * (two - one), one + two, weight)
            values = [
                legvander(outward * (1.0 - 2.0 * eta / surface.width_mm), self._m - 1)
                for eta in (one, two)
            ]
            across = values[0][:, :, None] * values[1][:, None, :]
            total += np.tensordot(part, across, axes=(0, 0))
        return np.asarray(total + total.transpose(1, 0, 3, 2))

    def behind_corner(self, corner: int) -> Floats:
        """Integral for the image behind the corner at low (0) or high (1) arc length."""
        surface = self._surface
        inwards = -1.0 if corner else 1.0
        total = np.zeros((self._n, self._n, self._m, self._m))
        places = np.abs(np.subtract(surface.pieces_mm, surface.s_mm[corner]))
        profile, whole = np.unique(places), np.array([0.0, surface.width_mm])
        for (one, two, apart), weight in self._points(profile, profile, whole):
            s = [surface.s_mm[corner] + inwards * distance for distance in (one, two)]
            secants = [surface.secant(place) for place in s]
            factor = weight * secants[0] * secants[1]
            factor = factor / np.hypot(one + two, apart * 0.5 * sum(secants))
            values = [surface.modes(place, self._n) for place in s]
            part = factor[:, None, None] * values[0][:, :, None] * values[1][:, None, :]
            # z - z' < 0 is the transpose, and the sum is made symmetric
            total += np.tensordot(part, 2.0 * self._overlap(apart), axes=(0, 0))
        return total

    def _points(self, *edges: Floats) -> Iterator[tuple[list[Floats], Floats]]:
        """Points (by coordinate) and weights of the boxes between edges, which begin at 0."""
        for box in product(*(list(pairwise(each)) for each in edges)):
            sizes = [high - low for low, high in box]
            if any(low > 0.0 for low, _ in box):
                points, weight = _tensor([self._panel] * len(box))
            else:
                points, weight = _cone(len(box), self._radial, self._sideways)
            places = [
                low + size * part for (low, _), size, part in zip(box, sizes, points, strict=True)
            ]
            yield places, weight * np.prod(sizes)

    def _profile(
        self,
        ahead: Floats,
        z_change: Floats,
        y_change: Floats,
        weight: Floats,
        *,
        turned: bool = False,
    ) -> Floats:
        """Integrals (k, a, c) of P_a(s) P_c(s')/R over s - s' = ahead (k,); x/R² if turned."""
        gauss = self._along[1]
        total = np.zeros((ahead.size, self._n, self._n))
        distinct, number = np.unique(ahead, return_inverse=True)
        for lines in self._lines(distinct):
            some = np.flatnonzero(lines.index[number] >= 0)
            at = lines.index[number[some]]
            x = ahead[some, None] - lines.slope[at] * z_change[some, None]
            factor = (weight[some] * lines.spare[at])[:, None] * gauss
            factor = factor * lines.secants[0][at] * lines.secants[1][at]
            distance = np.hypot(x, lines.secant[at] * y_change[some, None])
            factor = factor / distance
            if turned:
                factor = factor * (x / distance)
            one, two = (values[at] for values in lines.modes)
            total[some] += (factor[..., None] * one).transpose(0, 2, 1) @ two
        return total

    def _lines(self, ahead: Floats) -> list[_Lines]:
        """Points with s - s' = ahead (m,), for each pair of pieces of the profile."""
        surface, (at, _) = self._surface, self._along
        key = ahead.tobytes()
        if key in self._known:
            return self._known[key]
        found = self._known[key] = []
        pieces = list(pairwise(surface.pieces_mm))
        for (low, high), (low_ahead, high_ahead) in product(pieces, pieces):
            first = np.maximum(low, low_ahead - ahead)
            spare = np.minimum(high, high_ahead - ahead) - first
            some = np.flatnonzero(spare > 0.0)
            if not some.size:
                continue
            index = np.full(ahead.size, -1)
            index[some] = np.arange(some.size)
            behind = first[some, None] + spare[some, None] * at  # s'
            places = behind + ahead[some, None], behind
            secants = tuple(surface.secant(s) for s in places)
            found.append(
                _Lines(
                    index=index,
                    spare=spare[some],
                    slope=0.5 * (surface.slope(places[0]) + surface.slope(places[1])),
                    secants=secants,
                    secant=0.5 * (secants[0] + secants[1]),
                    modes=tuple(surface.modes(s, self._n) for s in places),
                )
            )
        return found

    def _overlap(self, z_change: Floats) -> Floats:
        """Integrals (k, b, d) of P_b(z) P_d(z') over z - z' = z_change (k,)."""
        width, (at, gauss) = self._surface.width_mm, self._across
        spare = width - np.abs(z_change)
        first = np.maximum(z_change, 0.0)
        z = (first[:, None] + spare[:, None] * at) / width
        one = legvander(2.0 * z - 1.0, self._m - 1)
        two = legvander(2.0 * (z - (z_change / width)[:, None]) - 1.0, self._m - 1)
        return np.asarray((one * (spare[:, None] * gauss)[..., None]).transpose(0, 2, 1) @ two)


def _panels(length_mm: float, shortest_mm: float, breaks_mm: Floats) -> Floats:
    """Edges of panels from 0 to a length: breaks, and panels that grow from a shortest one."""
    if not breaks_mm.size or shortest_mm >= length_mm:
        return np.array([0.0, length_mm])
    steps = int(np.log(length_mm / shortest_mm) / np.log(GROWTH))
    grown = shortest_mm * GROWTH ** np.arange(steps + 1)
    apart = np.abs(np.log(grown[:, None] / np.append(breaks_mm, length_mm))).min(axis=1)
    edges = np.concatenate([[0.0, length_mm], breaks_mm, grown[apart > np.log(1.5)]])
    return np.unique(edges[edges <= length_mm])


def _tensor(rules: list[tuple[Floats, Floats]]) -> tuple[list[Floats], Floats]:
    """Points in the unit cube (by coordinate) and weights of a product of rules."""
    points = np.meshgrid(*(at for at, _ in rules), indexing="ij")
    weights = np.meshgrid(*(weight for _, weight in rules), indexing="ij")
    return [part.ravel() for part in points], np.prod([part.ravel() for part in weights], axis=0)


def _cone(
    dimension: int, radial: tuple[Floats, Floats], sideways: tuple[Floats, Floats]
) -> tuple[list[Floats], Floats]:
    """Points (by coordinate) and weights of the unit cube, divided into cones from its corner 0."""
    (t, *others), weight = _tensor([radial, *[sideways] * (dimension - 1)])
    weight = weight * t ** (dimension - 1)
    edges = [t, *(t * other for other in others)]
    cones = [np.roll(np.arange(dimension), turn) for turn in range(dimension)]
    points = [np.concatenate([edges[cone[axis]] for cone in cones]) for axis in range(dimension)]
    return points, np.tile(weight, dimension)
