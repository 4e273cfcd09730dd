"""Transmission error over the period: mean and harmonics, from even and from uneven positions.

Even positions that divide the period give sums over them (the discrete Fourier transform). Others
give integrals over the curve through them (`position_curve`), exactly.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from flankload.base.rounding import round_down
from flankload.result.interpolant import curve_through, loaded_pair_changes

if TYPE_CHECKING:
    from flankload.result.interpolant import Flags, Floats, Integers, PositionCurve
    from flankload.result.result import Result

#: Harmonics of the transmission error that the summary names.
N_HARMONICS = 5
#: Positions further apart, in pitches, leave what is between them open.
WIDEST = 0.25
#: Positions closer than this part of a pitch are one.
SAME = 1e-9


@dataclass(frozen=True)
class OverPositions:
    """What a curve over the positions says on the whole.

    Attributes
    ----------
    position_rad : (n,) array
        Positions of the curve, ascending, none twice.
    index : (n,) array
        Which of the result's positions they are.
    periods : (n,) array
        Periods by which each has been moved back.
    covers_period : bool
        They leave no part of the period open.
    contiguous : bool
        They leave no part open between the first and the last.
    even : bool
        They divide the period evenly, as they stand.
    regular : bool
        They have equal distances.
    """

    result: Result
    position_rad: Floats
    index: Integers
    periods: Integers
    covers_period: bool
    contiguous: bool
    even: bool
    regular: bool

    def mean(self, values: Floats) -> float:
        """Mean of a smooth quantity: over the period, or over what the positions span.

        Single positions, of which nothing is known between them, count alike.
        """
        curve = self.curve(values)
        return float(values.mean()) if curve is None else curve.mean()

    def mean_of_steps(self, values: Floats | Integers) -> float:
        """Mean of a number that changes where the loaded pairs do.

        Between two positions that is where the transmission error has its kink, or half-way.
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

    def harmonics(self, values: Floats, *, every: int = 1) -> list[float | None] | None:
        """Amplitudes of the first waves of the period, or of every so-manieth.

        None in place of one for which the positions are too few; None at all where the positions
        leave a part of the period open.
        """
        if not self.covers_period:
            return None
        n = self.position_rad.size
        orders = [every * k for k in range(1, N_HARMONICS + 1)]
        if self.even:
            amplitudes = 2.0 / n * np.abs(np.fft.rfft(values))
            return [float(amplitudes[k]) if 2 * k < n else None for k in orders]
        curve = self.curve(values)
        assert curve is not None
        found = curve.amplitudes(orders)
        return [float(a) if 2 * k < n else None for a, k in zip(found, orders, strict=True)]

    def curve(self, values: Floats) -> PositionCurve | None:
        """Curve through the values of uneven positions that leave nothing open, else None."""
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
            whole_circle=result.whole_circle or result.has_cam,
            periods=self.periods,
        )


def over_positions(result: Result) -> OverPositions:
    """How a result's positions lie in its period.

    Parameters
    ----------
    result : Result

    Returns
    -------
    OverPositions
    """
    position, period, pitch = result.position_rad, result.period_rad, result.pitch_rad
    steps = np.diff(position)
    even = bool(
        result.closed and np.allclose(steps, period / position.size, rtol=0, atol=SAME * pitch)
    )
    low = position.min()
    periods = round_down((position - low) / period)
    inside = position - periods * period
    index = np.argsort(inside, kind="stable")
    index = index[np.diff(inside[index], prepend=-np.inf) > SAME * pitch]
    gaps = np.diff(inside[index], append=inside[index[0]] + period)
    widest = WIDEST * pitch * (1.0 + SAME)
    span, covered = np.ptp(position), bool(gaps.max() <= widest)
    # single positions here and there are no period, however many turns they are apart
    covers = result.closed or (covered and span + gaps.max() >= period * (1.0 - SAME))
    contiguous = not covers and span < period and bool(np.max(gaps[:-1], initial=0.0) <= widest)
    return OverPositions(
        result,
        position_rad=inside[index],
        index=index,
        periods=periods[index],
        covers_period=bool(covers),
        contiguous=bool(contiguous),
        even=even,
        regular=bool(np.ptp(steps) <= SAME * pitch) if steps.size else True,
    )
