"""Interpolating splines.

Importing scipy for them would take a third of the time of a run.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flankload.base.arrays import Floats


@dataclass(frozen=True)
class Spline:
    """A piecewise polynomial as a sum of B-splines; its end pieces continue beyond the ends.

    Attributes
    ----------
    knots : (n + degree + 1,) array
        Ascending, the first and the last degree + 1 equal.
    coefficients : (n, d) array
        Of the B-splines, for d functions.
    """

    knots: Floats
    coefficients: Floats

    @property
    def degree(self) -> int:
        """Degree of the pieces."""
        return self.knots.size - len(self.coefficients) - 1

    def __call__(self, u: Floats) -> Floats:
        """Values (m, d) at places u (m,)."""
        first, parts = _b_splines(self.knots, self.degree, u)
        used = self.coefficients[first[:, None] + np.arange(self.degree + 1)]
        return np.asarray((parts[:, :, None] * used).sum(axis=1))

    def derivative(self) -> Spline:
        """Return the first derivative."""
        p, t = self.degree, self.knots[1:-1]
        rise = np.diff(self.coefficients, axis=0)
        return Spline(t, p * rise / (t[p:] - t[:-p])[:, None])

    def derivatives(self, u: Floats) -> tuple[Floats, Floats, Floats]:
        """Values and two derivatives, each (m, d), at places u (m,)."""
        if self.degree < 2:
            return self(u), self.derivative()(u), np.zeros((u.size, self.coefficients.shape[1]))
        slope = self.derivative()
        return self(u), slope(u), slope.derivative()(u)


def interpolating_spline(places: Floats, values: Floats, degree: int = 3) -> Spline:
    """Spline of odd degree through values (n, d) at ascending places (n,), n >= 2.

    Its end conditions are not-a-knot; fewer than degree + 1 places have one polynomial.
    """
    n, p = len(places), min(degree, len(places) - 1)
    inside = places[p // 2 + 1 : n - (p + 1) // 2]
    knots = np.concatenate([[places[0]] * (p + 1), inside, [places[-1]] * (p + 1)])
    first, parts = _b_splines(knots, p, places)
    # row i holds columns i - p to i + p of the matrix of the B-splines at the places
    band = np.zeros((n, 2 * p + 1))
    column = (first - np.arange(n) + p)[:, None] + np.arange(p + 1)
    np.put_along_axis(band, column, parts, axis=1)
    return Spline(knots, _solve_band(band, values))


def _b_splines(knots: Floats, degree: int, u: Floats) -> tuple[np.ndarray, Floats]:
    """Number (m,) of the first B-spline that is not 0 at places u; values (m, degree + 1) from it.

    The recursion of de Boor and Cox.
    """
    k = np.searchsorted(knots[degree + 1 : -degree - 1], u, side="right")[:, None]
    u, values = u[:, None], np.ones((u.size, 1))
    for p in range(1, degree + 1):
        right = knots[k + degree + 1 + np.arange(p)]
        left = knots[k + degree + 1 - p + np.arange(p)]
        part = values / (right - left)
        values = np.pad(part * (right - u), ((0, 0), (0, 1)))
        values[:, 1:] += part * (u - left)
    return k[:, 0], values


def _solve_band(band: Floats, values: Floats) -> Floats:
    """Solve a system whose row i has columns i - p to i + p in the band (n, 2 p + 1).

    Its matrix, that of B-splines, is totally positive: elimination needs no pivots.
    """
    n, p = len(band), band.shape[1] // 2
    upper, x = band.copy(), values.copy()
    for i in range(n):
        for j in range(i + 1, min(i + p + 1, n)):
            at = p + i - j
            factor = upper[j, at] / upper[i, p]
            upper[j, at : at + p + 1] -= factor * upper[i, p:]
            x[j] -= factor * x[i]
    for i in range(n - 1, -1, -1):
        known = x[i + 1 : i + p + 1]
        x[i] = (x[i] - upper[i, p + 1 : p + 1 + len(known)] @ known) / upper[i, p]
    return x
