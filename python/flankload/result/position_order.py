"""Arrangement of positions in their period, and their weights in means."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flankload.base.rounding import TIE, round_down

if TYPE_CHECKING:
    from flankload.base.arrays import Floats, Numbers

#: A larger distance between positions, in pitches, is a gap.
WIDEST = 0.25


@dataclass(frozen=True)
class PositionOrder:
    """Arrangement of positions in their period.

    Attributes
    ----------
    position_rad : (n,) array
        Distinct positions, moved into one period, ascending.
    index : (n,) array
        Their indices among the given positions.
    periods : (n,) array
        Number of periods by which each has been moved back.
    weights : (P,) array
        Parts of the given positions in means over the period, or over their range if it has no
        gaps; their sum is 1. Equal for even positions, and for single ones.
    covers_period : bool
        Whether there is no gap in the period.
    contiguous : bool
        Whether there is no gap between the first and the last position.
    even : bool
        Whether the given positions divide the period evenly.
    regular : bool
        Whether they have equal distances.
    """

    position_rad: Floats
    index: Numbers
    periods: Numbers
    weights: Floats
    covers_period: bool
    contiguous: bool
    even: bool
    regular: bool


def order_of(
    position_rad: Floats, *, pitch_rad: float, period_rad: float, closed: bool
) -> PositionOrder:
    """Arrange positions (P,).

    If they are `closed`, they ascend and cover the period once.
    """
    steps = np.diff(position_rad)
    even = bool(
        closed and np.allclose(steps, period_rad / position_rad.size, rtol=0, atol=TIE * pitch_rad)
    )
    low = position_rad.min()
    periods = round_down((position_rad - low) / period_rad)
    inside = position_rad - periods * period_rad
    index = np.argsort(inside, kind="stable")
    index = index[np.diff(inside[index], prepend=-np.inf) > TIE * pitch_rad]
    gaps = np.diff(inside[index], append=inside[index[0]] + period_rad)
    widest = WIDEST * pitch_rad * (1.0 + TIE)
    span, covered = np.ptp(position_rad), bool(gaps.max() <= widest)
    # single isolated positions are no period, however many turns they are apart
    covers = bool(closed or (covered and span + gaps.max() >= period_rad * (1.0 - TIE)))
    within = bool(span < period_rad and np.max(gaps[:-1], initial=0.0) <= widest)
    weights = np.full(position_rad.size, 1.0 / position_rad.size)
    if not even and (covers or (within and index.size > 1)):
        weights = np.zeros(position_rad.size)
        weights[index] = _parts(gaps, closed=covers)
    return PositionOrder(
        position_rad=inside[index],
        index=index,
        periods=periods[index],
        weights=weights,
        covers_period=covers,
        contiguous=not covers and within,
        even=even,
        regular=bool(np.ptp(steps) <= TIE * pitch_rad) if steps.size else True,
    )


def _parts(gaps: Floats, *, closed: bool) -> Floats:
    """Half of the distances of each position from the previous and to the next one, relative.

    Beyond the ends of a range that is not closed, positions go on as at these ends.
    """
    after = gaps if closed else np.append(gaps[:-1], gaps[-2])
    before = np.roll(after, 1)
    if not closed:
        before[0] = after[0]
    return np.asarray((before + after) / (before + after).sum())
