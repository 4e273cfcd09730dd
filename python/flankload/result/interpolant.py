"""Interpolation between positions: piecewise cubic polynomials that respect kinks.

A curve over the positions has a kink where a flank pair begins or ceases to carry load, and is
smooth between kinks. So no polynomial crosses a change of the loaded pairs: in an interval with
such a change, the curves from both sides are extended until they intersect.

Every piece has an error estimate: its difference to the polynomial of one degree less through the
nearest of the same points. That is the error of the lower degree, hence conservative.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flankload.base.arrays import Flags, Floats, Numbers


#: Highest degree of a piece.
DEGREE = 3
#: Quadrature nodes on a piece: the product of a cubic and a harmonic is exact to roundoff if the
#: piece is no longer than one and a half waves.
GAUSS_X, GAUSS_W = np.polynomial.legendre.leggauss(16)
#: Parts into which an interval is divided for the intersection of the curves from both sides, and
#: how often: exact to roundoff.
MEETING_PARTS, MEETING_STEPS = 64, 9
#: Places of four values of a cubic, and its coefficients from lower to higher powers by these.
CUBIC_PLACES = np.array([0.0, 0.25, 0.75, 1.0])
CUBIC = np.linalg.inv(np.vander(CUBIC_PLACES, increasing=True)).T


@dataclass(frozen=True)
class PositionCurve:
    """K consecutive polynomials over N intervals between positions.

    Attributes
    ----------
    low, high : (K,) arrays
        Ends of the pieces, rad.
    interval : (K,) array
        Interval of a piece; two pieces that meet at a kink are in the same interval.
    nodes, coefficients : (K, 4) arrays
        Newton's form c0 + (x - n0) (c1 + (x - n1) (c2 + (x - n2) c3)).
    doubts : (K, 4) array
        Coefficients of the difference to the lower degree.
    n_intervals : int
    """

    low: Floats
    high: Floats
    interval: Numbers
    nodes: Floats
    coefficients: Floats
    doubts: Floats
    n_intervals: int

    @property
    def ends(self) -> tuple[float, float]:
        """The first and the last end, rad."""
        return float(self.low[0]), float(self.high[-1])

    @property
    def length(self) -> float:
        """Length from the first to the last end, rad."""
        return self.ends[1] - self.ends[0]

    def values(self, position_rad: Floats) -> Floats:
        """Values at positions between both ends."""
        x = np.asarray(position_rad, dtype=float)
        k = np.clip(np.searchsorted(self.low, x, side="right") - 1, 0, self.low.size - 1)
        return _newton(self.nodes[k], self.coefficients[k], x[:, None])[:, 0]

    def mean(self) -> float:
        """Integral divided by length."""
        x, weight = self._quadrature()
        return float((weight * _newton(self.nodes, self.coefficients, x)).sum() / self.length)

    def amplitudes(self, orders: Sequence[int]) -> Floats:
        """Amplitudes of harmonics with this number of waves between both ends (exact integrals)."""
        x, weight = self._quadrature()
        values = weight * _newton(self.nodes, self.coefficients, x)
        turn = -2j * np.pi * x / self.length
        waves = [(values * np.exp(order * turn)).sum() for order in orders]
        return np.asarray(2.0 / self.length * np.abs(waves))

    def doubt_integrals(self) -> Floats:
        """(N,) Integral of the absolute error estimate over each interval.

        Twice their sum divided by the length bounds the error of every amplitude by this estimate.
        """
        x, weight = self._quadrature()
        size = (weight * np.abs(_newton(self.nodes, self.doubts, x))).sum(axis=1)
        return np.asarray(np.bincount(self.interval, size, self.n_intervals), dtype=float)

    def bounds(self) -> tuple[Floats, Floats]:
        """Two (N,) arrays: bounds of the values on each interval, including the estimate."""
        x = np.column_stack([self.low, self._quadrature()[0], self.high])
        values = _newton(self.nodes, self.coefficients, x)
        size = np.abs(_newton(self.nodes, self.doubts, x))
        least, greatest = np.full((2, self.n_intervals), [[np.inf], [-np.inf]])
        np.minimum.at(least, self.interval, (values - size).min(axis=1))
        np.maximum.at(greatest, self.interval, (values + size).max(axis=1))
        return least, greatest

    def kinks(self) -> Floats:
        """(N,) Positions where both sides intersect, rad; NaN in an interval without a kink."""
        place = np.full(self.n_intervals, np.nan)
        second = np.flatnonzero(np.diff(self.interval) == 0) + 1
        place[self.interval[second]] = self.low[second]
        return place

    def _quadrature(self) -> tuple[Floats, Floats]:
        """Quadrature points and weights (K, nodes)."""
        half = 0.5 * (self.high - self.low)[:, None]
        return 0.5 * (self.high + self.low)[:, None] + half * GAUSS_X, half * GAUSS_W


def curve_through(
    position_rad: Floats, values: Floats, changes: Flags, *, period_rad: float | None = None
) -> PositionCurve:
    """Curve through values at positions.

    Parameters
    ----------
    position_rad, values : (n,) arrays
        Positions ascending; n >= 2, or 1 with a period.
    changes : (n,) array of bool
        Whether the loaded pairs change between a position and the next; the last entry refers to
        the first position one period later, and is ignored without a period.
    period_rad : float, optional
        The curve extends from the first position to the same one a period later; by default to the
        last one.

    Returns
    -------
    PositionCurve
        With n intervals; n - 1 without a period.
    """
    n = len(position_rad)
    x, y, broken = position_rad, values, changes[:-1]
    first = 0
    n_intervals = n - 1
    if period_rad is not None:
        index = np.arange(-DEGREE, n + DEGREE + 1)
        x = position_rad[index % n] + period_rad * (index // n)
        y, broken = values[index % n], changes[index % n][:-1]
        first, n_intervals = DEGREE, n
    # first and last point of the smooth part that contains each point
    stretch = np.concatenate([[0], np.cumsum(broken)])
    start = np.searchsorted(stretch, stretch, side="left")
    end = np.searchsorted(stretch, stretch, side="right") - 1
    left = first + np.arange(n_intervals)
    smooth = left[~broken[left]]
    kinked = left[broken[left]]
    at = np.concatenate([smooth, kinked, kinked + 1])
    middle = 0.5 * (x[smooth] + x[smooth + 1])
    near = _Polynomials.near(x, y, at, start, end, np.append(middle, x[at[smooth.size :]]))
    parts = np.split(np.arange(at.size), [smooth.size, smooth.size + kinked.size])
    whole, before, after = map(near.of, parts)
    meeting, meets = _meeting(before, after, x[kinked], x[kinked + 1])
    chord = _chords(before, after, x, y, kinked)
    met, apart = kinked[meets], kinked[~meets]
    polynomials = (whole, before.of(meets), after.of(meets), chord.of(~meets))
    low = np.concatenate([x[smooth], x[met], meeting[meets], x[apart]])
    high = np.concatenate([x[smooth + 1], meeting[meets], x[met + 1], x[apart + 1]])
    interval = np.concatenate([smooth, met, met, apart])
    order = np.argsort(low, kind="stable")
    nodes, coefficients, doubts = (
        np.vstack([getattr(part, name) for part in polynomials])[order]
        for name in ("nodes", "coefficients", "doubts")
    )
    return PositionCurve(
        low[order], high[order], interval[order] - first, nodes, coefficients, doubts, n_intervals
    )


def loaded_pair_changes(
    loaded: Flags,
    sites: Numbers,
    *,
    pitches: int,
    cyclic: bool = False,
    periods: Numbers | None = None,
) -> Flags:
    """Changes of the loaded pairs between positions.

    Parameters
    ----------
    loaded : (n, S) array of bool
        Positions in the order of the curve.
    sites : (S,) array
        Pair numbers.
    pitches : int
        Pitches in a period: after a period, pair j - pitches takes the place of pair j.
    cyclic : bool
        Whether the sites are all flanks, so that counting restarts after the last (for a cam, the
        only one).
    periods : (n,) array, optional
        Number of periods by which each position has been moved back.

    Returns
    -------
    (n,) array of bool
        As an argument of `curve_through`.
    """
    around = len(sites) if cyclic else 0

    def pairs(p: int, moved: int) -> frozenset[int]:
        numbers = sites[loaded[p]] + moved * pitches
        return frozenset((numbers % around if around else numbers).tolist())

    moved = np.zeros(len(loaded), dtype=int) if periods is None else periods
    there = [pairs(p, int(moved[p])) for p in range(len(loaded))]
    a_period_on = pairs(0, int(moved[0]) - 1)
    following = [*there[1:], a_period_on]
    return np.array([now != then for now, then in zip(there, following, strict=True)])


@dataclass(frozen=True)
class _Polynomials:
    """K polynomials in Newton's form."""

    nodes: Floats
    coefficients: Floats
    doubts: Floats
    degree: Numbers

    @classmethod
    def near(
        cls, x: Floats, y: Floats, at: Numbers, start: Numbers, end: Numbers, reference: Floats
    ) -> _Polynomials:
        """Through up to four points of the same smooth part around the interval after each `at`.

        Points are ordered from the one nearest to the reference, so the term of the last one is the
        difference to the polynomial of one degree less.
        """
        degree = np.minimum(DEGREE, end[at] - start[at])
        lowest = np.clip(at - 1, start[at], end[at] - degree)
        step = np.arange(DEGREE + 1)
        there = step <= degree[:, None]
        index = np.minimum(lowest[:, None] + step, len(x) - 1)
        distance = np.where(there, np.abs(x[index] - reference[:, None]), np.inf)
        order = np.argsort(distance, axis=1, kind="stable")
        index = np.take_along_axis(index, order, axis=1)
        # missing points get distinct places; their coefficients are set to zero below
        nodes = np.where(there, x[index], x[-1] + 1.0 + step)
        table = y[index].astype(float)
        for d in range(1, DEGREE + 1):
            table[:, d:] = (table[:, d:] - table[:, d - 1 : -1]) / (nodes[:, d:] - nodes[:, :-d])
        coefficients = np.where(there, table, 0.0)
        highest = (step == degree[:, None]) & (degree[:, None] > 0)
        return cls(nodes, coefficients, np.where(highest, table, 0.0), degree)

    def of(self, which: Flags | Numbers) -> _Polynomials:
        """Selected polynomials."""
        return _Polynomials(
            self.nodes[which], self.coefficients[which], self.doubts[which], self.degree[which]
        )

    def values(self, x: Floats) -> Floats:
        """One value of each polynomial."""
        return _newton(self.nodes, self.coefficients, x[:, None])[:, 0]


def _newton(nodes: Floats, coefficients: Floats, x: Floats) -> Floats:
    """Values (…, m) at places (…, m) of polynomials (…, 4)."""
    values = coefficients[..., DEGREE, None]
    for d in range(DEGREE - 1, -1, -1):
        values = values * (x - nodes[..., d, None]) + coefficients[..., d, None]
    return values


def _meeting(
    before: _Polynomials, after: _Polynomials, low: Floats, high: Floats
) -> tuple[Floats, Flags]:
    """Intersection of the curves from both sides inside an interval, and whether it exists.

    A single point between two kinks does not determine a curve and is excluded.
    """
    places = low[:, None] + (high - low)[:, None] * CUBIC_PLACES
    one, two = (_newton(side.nodes, side.coefficients, places) for side in (before, after))
    apart = one - two
    meets = (apart[:, 0] * apart[:, -1] <= 0) & (before.degree > 0) & (after.degree > 0)
    if not meets.any():
        return low, meets
    power = (apart @ CUBIC * np.sign(apart[:, :1])).T[..., None]
    begin, step = np.zeros((low.size, 1)), 1.0
    for _ in range(MEETING_STEPS):
        step /= MEETING_PARTS
        part = begin + step * np.arange(1, MEETING_PARTS)
        values = ((power[3] * part + power[2]) * part + power[1]) * part + power[0]
        begin += step * np.cumprod(values > 0, axis=1).sum(axis=1, keepdims=True)
    return low + (high - low) * (begin[:, 0] + 0.5 * step), meets


def _chords(
    before: _Polynomials, after: _Polynomials, x: Floats, y: Floats, at: Numbers
) -> _Polynomials:
    """Lines over intervals, with an error estimate from the misfit of both curves at the ends."""
    nodes, coefficients, doubts = np.zeros((3, at.size, DEGREE + 1))
    nodes[:, 0], nodes[:, 1] = x[at], x[at + 1]
    coefficients[:, 0] = y[at]
    coefficients[:, 1] = (y[at + 1] - y[at]) / (x[at + 1] - x[at])
    missed = before.values(x[at + 1]) - y[at + 1], after.values(x[at]) - y[at]
    doubts[:, 0] = np.abs(missed).max(axis=0)
    return _Polynomials(nodes, coefficients, doubts, np.ones(at.size, dtype=int))
