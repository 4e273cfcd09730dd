"""Rotation of a flank about the axis of its body by an angle that varies along the flank."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from flankload.flank.curve import FlankCurve
from flankload.flank.fit import hermite_quintics

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from flankload.base.arrays import Floats

    #: Arc lengths (m,) -> angles and their first two derivatives.
    Turn = Callable[[Floats], tuple[Floats, Floats, Floats]]

#: Least distance of two breaks, relative to the length of the curve.
LEAST_BREAK_DISTANCE = 1e-6


def turned_along(curve: FlankCurve, turn: Turn, knots: Floats) -> FlankCurve:
    """Rotate each point of a curve about the origin by an angle that depends on its arc length s.

    Points keep their distance from the origin and their s; the arc length of the new curve differs
    from s by a part of the order of the angle.

    Parameters
    ----------
    curve : FlankCurve
    turn : callable
        Angle in rad, counter-clockwise, and its first two derivatives, at s (m,).
    knots : (k,) array
        Arc lengths at which a higher derivative of the angle jumps; they become breaks.

    Returns
    -------
    FlankCurve
    """
    inside = knots[(knots > curve.breaks[0]) & (knots < curve.breaks[-1])]
    apart = np.abs(inside[:, None] - curve.breaks).min(axis=1, initial=np.inf)
    breaks = np.union1d(curve.breaks, inside[apart > LEAST_BREAK_DISTANCE * curve.length_mm])
    of = np.searchsorted(curve.breaks, 0.5 * (breaks[1:] + breaks[:-1])) - 1
    corners = np.zeros(breaks.size, dtype=bool)
    corners[np.searchsorted(breaks, curve.breaks)] = curve.corners
    near, far = (_turned_ends(curve, of, ends, turn) for ends in (breaks[:-1], breaks[1:]))
    return FlankCurve(
        breaks=breaks,
        coefficients=hermite_quintics(near, far, np.diff(breaks)),
        labels=tuple(curve.labels[k] for k in of),
        corners=corners,
    )


def _turned_ends(
    curve: FlankCurve, of: NDArray[np.int64], s: Floats, turn: Turn
) -> tuple[Floats, Floats, Floats]:
    """Rotated points (n, 2) of the intervals `of`, and their first two derivatives."""
    x = (s - curve.breaks[of])[:, None] ** np.arange(curve.coefficients.shape[2])
    c = curve.coefficients[of, 0] + 1j * curve.coefficients[of, 1]
    powers = np.arange(1, c.shape[1])
    c_1 = c[:, 1:] * powers
    c_2 = c_1[:, 1:] * powers[:-1]
    point = (c * x).sum(axis=1)
    first, second = (c_1 * x[:, :-1]).sum(axis=1), (c_2 * x[:, :-2]).sum(axis=1)
    angle, rate, change = turn(s)
    phase = np.exp(1j * angle)
    turned = (
        point * phase,
        (first + 1j * rate * point) * phase,
        (second + 2j * rate * first + (1j * change - rate**2) * point) * phase,
    )
    one, two, three = (np.stack([part.real, part.imag], axis=1) for part in turned)
    return one, two, three
