"""Mean and harmonics of the transmission error over the period, for even and uneven positions.

Even positions that divide the period are summed (discrete Fourier transform). For other positions
the curve through them (`curve_through`) is integrated exactly.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from flankload.base.rounding import TIE, round_down
from flankload.result.interpolant import curve_through, loaded_pair_changes

if TYPE_CHECKING:
    from flankload.base.arrays import Flags, Floats, Numbers
    from flankload.result.interpolant import PositionCurve
    from flankload.result.result import Result

#: Number of harmonics of the transmission error in the summary.
N_HARMONICS = 5
#: A larger distance between positions, in pitches, is a gap.
WIDEST = 0.25


@dataclass(frozen=True)
class OverPositions:
    """Integral quantities of a curve over the positions.

    Attributes
    ----------
    position_rad : (n,) array
        Positions of the curve, ascending and distinct.
    index : (n,) array
        Indices of these positions in the result.
    periods : (n,) array
        Number of periods by which each has been moved back.
    covers_period : bool
        Whether there is no gap in the period.
    contiguous : bool
        Whether there is no gap between the first and the last position.
    even : bool
        Whether the original positions divide the period evenly.
    regular : bool
        Whether they have equal distances.
    """

    result: Result
    position_rad: Floats
    index: Numbers
    periods: Numbers
    covers_period: bool
    contiguous: bool
    even: bool
    regular: bool

    def mean(self, values: Floats) -> float:
        """Mean of a smooth quantity over the period, or over the range of the positions.

        Single positions, between which nothing is known, have equal weights.
        """
        curve = self.curve(values)
        return float(values.mean()) if curve is None else curve.mean()

    def mean_of_steps(self, values: Floats | Numbers) -> float:
        """Mean of a number that changes where the set of loaded pairs changes.

        Between two positions this is at the kink of the transmission error, or half-way.
        """
        curve = self.curve(self.result.transmission_error_um)
        if curve is None or not self.covers_period:
            return float(values.mean())
        before = values[self.index]
        after = np.roll(before, -1)
        ends = np.append(self.position_rad, self.position_rad[0] + self.result.period_rad)
        kink = curve.kinks()
        kink = np.where(np.isnan(kink), 0.5 * (ends[:-1] + ends[1:]), kink)
        parts = before * (kink - ends[:-1]) + after * (ends[1:] - kink)
        return float(parts.sum() / self.result.period_rad)

    def harmonics(
        self, values: Floats, *, every: int = 1, count: int = N_HARMONICS
    ) -> list[float | None] | None:
        """Amplitudes of the first `count` harmonics of the period, or of every n-th one.

        None for a harmonic with too few positions; None as a whole if there is a gap in the period.
        """
        if not self.covers_period:
            return None
        n = self.position_rad.size
        orders = [every * k for k in range(1, count + 1)]
        if self.even:
            amplitudes = 2.0 / n * np.abs(np.fft.rfft(values))
            return [float(amplitudes[k]) if 2 * k < n else None for k in orders]
        curve = self.curve(values)
        assert curve is not None
        found = curve.amplitudes(orders)
        return [float(a) if 2 * k < n else None for a, k in zip(found, orders, strict=True)]

    def curve(self, values: Floats) -> PositionCurve | None:
        """Curve through the values of uneven positions without a gap, else None."""
        if self.even or self.position_rad.size < 2:
            return None
        if not (self.covers_period or self.contiguous):
            return None
        period = self.result.period_rad if self.covers_period else None
        return curve_through(
            self.position_rad, values[self.index], self._changes, period_rad=period
        )

    @cached_property
    def _changes(self) -> Flags:
        result = self.result
        return loaded_pair_changes(
            result.site_force_N[self.index] > 0,
            result.sites,
            pitches=result.period_pitches,
            cyclic=result.engagement.cyclic_sites,
            periods=self.periods,
        )


def over_positions(result: Result) -> OverPositions:
    """Arrangement of the positions of a result in its period."""
    position, period, pitch = result.position_rad, result.period_rad, result.pitch_rad
    steps = np.diff(position)
    even = bool(
        result.closed and np.allclose(steps, period / position.size, rtol=0, atol=TIE * pitch)
    )
    low = position.min()
    periods = round_down((position - low) / period)
    inside = position - periods * period
    index = np.argsort(inside, kind="stable")
    index = index[np.diff(inside[index], prepend=-np.inf) > TIE * pitch]
    gaps = np.diff(inside[index], append=inside[index[0]] + period)
    widest = WIDEST * pitch * (1.0 + TIE)
    span, covered = np.ptp(position), bool(gaps.max() <= widest)
    # single isolated positions are no period, however many turns they are apart
    covers = bool(result.closed or (covered and span + gaps.max() >= period * (1.0 - TIE)))
    contiguous = bool(not covers and span < period and np.max(gaps[:-1], initial=0.0) <= widest)
    return OverPositions(
        result,
        position_rad=inside[index],
        index=index,
        periods=periods[index],
        covers_period=covers,
        contiguous=contiguous,
        even=even,
        regular=bool(np.ptp(steps) <= TIE * pitch) if steps.size else True,
    )
