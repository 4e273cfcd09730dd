"""Mean and harmonics of the transmission error over the period, for even and uneven positions.

Even positions that divide the period are summed (discrete Fourier transform). For other positions
the curve through them (`curve_through`) is integrated exactly.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from flankload.result.interpolant import curve_through, loaded_pair_changes
from flankload.result.position_order import PositionOrder, order_of

if TYPE_CHECKING:
    from flankload.base.arrays import Flags, Floats, Numbers
    from flankload.result.interpolant import PositionCurve
    from flankload.result.result import Result

#: Number of harmonics of the transmission error in the summary.
N_HARMONICS = 5


@dataclass(frozen=True)
class OverPositions(PositionOrder):
    """Integral quantities of a curve over the positions of a result."""

    result: Result

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
    order = order_of(
        result.position_rad,
        pitch_rad=result.pitch_rad,
        period_rad=result.period_rad,
        closed=result.closed,
    )
    return OverPositions(**vars(order), result=result)
