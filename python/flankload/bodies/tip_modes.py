"""Pressure modes on a tip rounding or chamfer behind the flank.

On a rounding the normal turns by 50 to 75 degrees towards the axis of the tooth, and the compliance
of a gear decreases to a quarter within a few tenths of a millimetre, too steeply for the Legendre
polynomials of the flank. These keep their end values on the tip, and the modes of the tip are added
to them: powers of u, which increases from 0 to 1 over the tip,

    u, u^2, ... on a rounding (smooth transition); 1, u, ... on a chamfer (corner).

Their number is half that of the flank, at least two; with fewer, pressures at the start of the tip
are wrong by several percent.

Where a contact extends over the start of a tip, the force is normal to the other flank, and the
modes are evaluated for its direction (`mode_values` of the core): on a rounding, u is that of the
point with this normal. At the corner of a chamfer, where the normal turns by T, a force rotated by
d has the components sin(T - d)/sin T along the flank's normal and sin d/sin T along that of the
chamfer.

The near field remains the logarithm of the distance along the profile: the modes represent the
image of the corner behind the tip.
"""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.polynomial.legendre import legvander, poly2leg
from numpy.polynomial.polynomial import polypow

from flankload.base.gauss import leggauss
from flankload.base.read_only import frozen

if TYPE_CHECKING:
    from collections.abc import Callable

    from flankload.base.arrays import Floats


#: Least number of modes of a tip.
LEAST_TIP_MODES = 2
#: Gauss points per panel, ratio and number of panels that are graded towards the common end of two
#: pieces: the logarithm of the sum of both distances is integrated to round-off.
POINTS, RATIO, PANELS = 12, 0.2, 16


class Tip(NamedTuple):
    """The tip behind a flank.

    Attributes
    ----------
    end_mm : float
        Arc length at the end of its modes.
    power : int
        The lowest power of u: 1 for a smooth transition from the flank, 0 for a corner.
    turn_rad : float
        Angle by which the normal turns over a rounding, or at the corner of a chamfer.
    """

    end_mm: float
    power: int
    turn_rad: float

    def larger(self, times: float) -> Tip:
        """The tip of a curve that is longer by a factor."""
        return self._replace(end_mm=times * self.end_mm)

    def behind(self, low_mm: float) -> Tip:
        """The tip of a curve that begins at an arc length."""
        return self._replace(end_mm=self.end_mm - low_mm)


def with_tip(flank_modes: int) -> int:
    """Number of modes of a flank and its tip, which has half as many, at least two."""
    return flank_modes + max(LEAST_TIP_MODES, flank_modes // 2)


def tip_modes(n_modes: int) -> int:
    """Number of modes of the tip, the last of all modes: the inverse of `with_tip`."""
    return max(LEAST_TIP_MODES, n_modes // 3)


def tip_values(s: Floats, high: float, tip: Tip, count: int) -> Floats:
    """Values (n, count) of the modes of a tip at s (n,), mm; `high`: end of the flank."""
    u = np.clip((s - high) / (tip.end_mm - high), 0.0, 1.0)[:, None]
    return np.where(s[:, None] > high, u ** (tip.power + np.arange(count)), 0.0)


def on_tip(n_modes: int, tip: Tip) -> Floats:
    """Legendre coefficients (q + 1, n_modes) of all modes on the tip, q of which are its own."""
    return _on_tip(n_modes, tip.power)


@cache
def _on_tip(n_modes: int, least_power: int) -> Floats:
    """Coefficients of all modes on a tip with this least power of its own modes; read-only."""
    own = tip_modes(n_modes)
    parts = np.zeros((own + 1, n_modes))
    parts[0, : n_modes - own] = 1.0
    for k in range(own):
        power = least_power + k
        parts[: power + 1, n_modes - own + k] = poly2leg(polypow([0.5, 0.5], power))
    return frozen(parts)


def projected_with_tip(
    projected: Callable[[int, float], Floats],
    kernel: Callable[[Floats], Floats],
    n_modes: int,
    mode_range_mm: tuple[float, float],
    tip: Tip,
    *,
    mirror: float = 1.0,
) -> Floats:
    """<P_a, K P_b> over flank and tip from the projections on each piece.

    Parameters
    ----------
    projected : callable
        Number of Legendre polynomials and length of a piece, mm -> their matrix on it.
    kernel : callable
        K at distances between points on flank and tip, mm; smooth except for a logarithm at 0.
    n_modes : int
        Including those of the tip.
    mode_range_mm : (float, float)
        Range of the flank.
    tip : Tip
    mirror : float
        K(s', s)/K(s, s'): 1 or -1.

    Returns
    -------
    (n_modes, n_modes) array
    """
    low, high = mode_range_mm
    flank, parts = n_modes - tip_modes(n_modes), on_tip(n_modes, tip)
    result = parts.T @ projected(len(parts), tip.end_mm - high) @ parts
    result[:flank, :flank] += projected(flank, high - low)
    (x, before), (y, behind) = _pieces(n_modes, mode_range_mm, tip)
    across = before.T @ kernel(x[:, None] + y) @ behind
    return np.asarray(result + across + mirror * across.T)


def image_with_tip(
    of_flank: Floats, n_modes: int, mode_range_mm: tuple[float, float], tip: Tip
) -> Floats:
    """<P_a, ln(d + d') P_b> over flank and tip (n_modes, n_modes) from that over the flank (p, p).

    d: distances from the low end of the flank; others as for `projected_with_tip`.
    """
    length = mode_range_mm[1] - mode_range_mm[0]
    (x, before), (y, behind) = _pieces(n_modes, mode_range_mm, tip)
    across = before.T @ np.log(2.0 * length - x[:, None] + y) @ behind
    result = across + across.T + behind.T @ np.log(2.0 * length + y[:, None] + y) @ behind
    result[: len(of_flank), : len(of_flank)] += of_flank
    return np.asarray(result)


def _pieces(
    n_modes: int, mode_range_mm: tuple[float, float], tip: Tip
) -> tuple[tuple[Floats, Floats], tuple[Floats, Floats]]:
    """On each piece: distances (k,) from the common end, and modes times weights (k, n_modes)."""
    low, high = mode_range_mm
    flank, parts = n_modes - tip_modes(n_modes), on_tip(n_modes, tip)
    (x, weight_x), (y, weight_y) = graded(high - low), graded(tip.end_mm - high)
    before = np.zeros((x.size, n_modes))
    before[:, :flank] = legvander(1.0 - 2.0 * x / (high - low), flank - 1) * weight_x[:, None]
    behind = legvander(2.0 * y / (tip.end_mm - high) - 1.0, len(parts) - 1) * weight_y[:, None]
    return (x, before), (y, behind @ parts)


def graded(length_mm: float) -> tuple[Floats, Floats]:
    """Points from 0 to a length and weights of Gauss rules on panels graded towards 0."""
    ends = np.append(RATIO ** np.arange(PANELS), 0.0)[::-1]
    points, weights = leggauss(POINTS)
    half = 0.5 * np.diff(ends)[:, None]
    places = ends[:-1, None] + half * (1.0 + points)
    return length_mm * places.ravel(), length_mm * (half * weights).ravel()
