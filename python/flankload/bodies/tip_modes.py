"""Modes that go on over a tip rounding or chamfer behind the flank.

On a rounding the normal turns by 50 to 75 degrees towards the axis of the tooth, in which the tooth
hardly yields: within a few tenths of a millimetre the compliance of a gear falls to a quarter. The
Legendre polynomials of the flank cannot follow that. They keep their end values beyond the flank,
and powers of u, which grows from 0 to 1 over the tip, are added to them:

    u, u^2, ... on a rounding, which the flank meets smoothly; 1, u, ... on a chamfer, where it has
    a corner.

There are half as many as modes of the flank, at least two: if only those of the flank become finer,
pressures at the start of the tip are wrong by several percent.

They follow the direction of the force (the core's `mode_values`): where a contact reaches over the
start of a tip, the force is normal to the other flank, not to each place of the profile. On a
rounding u is that of the place with this normal. At the corner of a chamfer, where the normal turns
by T, a force turned by d has the parts sin(T - d)/sin T along the flank's normal and sin d/sin T
along that of the chamfer.

So a mode is the same combination of a polynomial of the flank and of powers of u on the tip,
whatever is projected on it. The near field stays the logarithm of the distance along the profile:
the corner behind the tip is as far away as the tip is long, and the modes carry its image.
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


#: Least number of modes that a tip has of its own.
LEAST_TIP_MODES = 2
#: Gauss's rule on each of the panels that shrink towards the place where two pieces meet, their
#: ratio and number: the logarithm of the sum of both distances is exact to round-off.
POINTS, RATIO, PANELS = 12, 0.2, 16


class Tip(NamedTuple):
    """Where the modes of a tip end, behind those of the flank.

    Attributes
    ----------
    end_mm : float
        Arc length.
    power : int
        The lowest power of u: 1 where the flank meets the tip smoothly, 0 at a corner.
    turn_rad : float
        By how much the normal turns over a rounding, or at the corner of a chamfer.
    """

    end_mm: float
    power: int
    turn_rad: float

    def larger(self, times: float) -> Tip:
        """The same on a curve that is so many times as long."""
        return self._replace(end_mm=times * self.end_mm)

    def behind(self, low_mm: float) -> Tip:
        """The same on a curve that begins at an arc length."""
        return self._replace(end_mm=self.end_mm - low_mm)


def with_tip(flank_modes: int) -> int:
    """Number of modes of a flank and its tip: the tip has half as many, at least two."""
    return flank_modes + max(LEAST_TIP_MODES, flank_modes // 2)


def tip_modes(n_modes: int) -> int:
    """How many of all modes are the tip's own, the last ones: the inverse of `with_tip`."""
    return max(LEAST_TIP_MODES, n_modes // 3)


def tip_values(s: Floats, high: float, tip: Tip, count: int) -> Floats:
    """Values (n, count) of the tip's own modes at arc lengths s (n,), mm; `high` is the flank's."""
    u = np.clip((s - high) / (tip.end_mm - high), 0.0, 1.0)[:, None]
    return np.where(s[:, None] > high, u ** (tip.power + np.arange(count)), 0.0)


def on_tip(n_modes: int, tip: Tip) -> Floats:
    """All modes on the tip (q + 1, n_modes) as Legendre polynomials; q modes are the tip's own."""
    return _on_tip(n_modes, tip.power)


@cache
def _on_tip(n_modes: int, least_power: int) -> Floats:
    """All modes on a tip whose own modes have these powers and higher ones; read-only."""
    own = tip_modes(n_modes)
    parts = np.zeros((own + 1, n_modes))
    parts[0, : n_modes - own] = 1.0
    for k in range(own):
        power = least_power + k
        parts[: power + 1, n_modes - own + k] = poly2leg(polypow([0.5, 0.5], power))
    return frozen(parts)


def joined(
    projected: Callable[[int, float], Floats],
    kernel: Callable[[Floats], Floats],
    n_modes: int,
    mode_range_mm: tuple[float, float],
    tip: Tip,
    *,
    mirror: float = 1.0,
) -> Floats:
    """<P_a, K P_b> over flank and tip from what is known of single pieces.

    Parameters
    ----------
    projected : callable
        Number of Legendre polynomials and length of a piece, mm, to their matrix on it.
    kernel : callable
        K at distances of a place on the flank and one on the tip, mm; smooth but for a logarithm
        at 0.
    n_modes : int
        Those of the tip included.
    mode_range_mm : (float, float)
        Of the flank.
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


def joined_image(
    of_flank: Floats, n_modes: int, mode_range_mm: tuple[float, float], tip: Tip
) -> Floats:
    """<P_a, ln(d + d') P_b> over flank and tip (n_modes, n_modes) from that over the flank (p, p).

    d are the distances from the low end of the flank; the others as in `joined`.
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
    """Distances (k,) from where both meet, and modes times weights (k, n_modes), on each piece."""
    low, high = mode_range_mm
    flank, parts = n_modes - tip_modes(n_modes), on_tip(n_modes, tip)
    (x, weight_x), (y, weight_y) = graded(high - low), graded(tip.end_mm - high)
    before = np.zeros((x.size, n_modes))
    before[:, :flank] = legvander(1.0 - 2.0 * x / (high - low), flank - 1) * weight_x[:, None]
    behind = legvander(2.0 * y / (tip.end_mm - high) - 1.0, len(parts) - 1) * weight_y[:, None]
    return (x, before), (y, behind @ parts)


def graded(length_mm: float) -> tuple[Floats, Floats]:
    """Places from 0 to a length and weights of Gauss's rules on panels that shrink towards 0."""
    ends = np.append(RATIO ** np.arange(PANELS), 0.0)[::-1]
    points, weights = leggauss(POINTS)
    half = 0.5 * np.diff(ends)[:, None]
    places = ends[:-1, None] + half * (1.0 + points)
    return length_mm * places.ravel(), length_mm * (half * weights).ravel()
