"""Samples of a quantity: percentiles with their sampling error."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from flankload.base.arrays import Floats


#: Probability with which an interval contains the percentile.
CONFIDENCE = 0.95


@dataclass(frozen=True, eq=False)
class Samples:
    """Independent samples of a quantity.

    `ascending` (n, ...) has each entry of the quantity by itself in ascending order; n >= 2.
    """

    ascending: Floats

    def __len__(self) -> int:
        return len(self.ascending)

    @property
    def mean(self) -> Floats:
        """Mean of the samples."""
        return np.asarray(self.ascending.mean(axis=0))

    @property
    def standard_deviation(self) -> Floats:
        """Standard deviation of the distribution, estimated from the samples."""
        return np.asarray(self.ascending.std(axis=0, ddof=1))

    @property
    def mean_error(self) -> Floats:
        """Standard deviation of the mean."""
        return self.standard_deviation / np.sqrt(len(self))

    @property
    def deviation_error(self) -> Floats:
        """Standard deviation of the standard deviation s: sqrt((m_4 - s⁴) / n) / (2 s)."""
        fourth = ((self.ascending - self.mean) ** 4).mean(axis=0)
        square = self.standard_deviation**2
        with np.errstate(divide="ignore", invalid="ignore"):
            error = np.sqrt(np.maximum(0.0, fourth - square**2) / len(self) / square) / 2.0
        return np.nan_to_num(error)

    def percentile(self, percent: float) -> Floats:
        """Value below which a part of the samples in percent lies, interpolated between two."""
        return np.asarray(np.quantile(self.ascending, percent / 100.0, axis=0))

    def interval(self, percent: float) -> tuple[Floats, Floats]:
        """Two samples between which the percentile of the distribution lies.

        They include it with a probability of at least 95 %; NaN where the samples are too few for a
        limit. The number of samples below the percentile has a binomial distribution, for any
        distribution of the quantity (David and Nagaraja, Order Statistics, 2003, section 7.1).
        """
        from scipy.stats import binom

        n, tail = len(self), 0.5 * (1.0 - CONFIDENCE)
        below = int(binom.ppf(tail, n, percent / 100.0))
        above = int(binom.ppf(1.0 - tail, n, percent / 100.0)) + 1
        unknown = np.full(self.ascending.shape[1:], np.nan)
        return (
            self.ascending[below - 1] if below >= 1 else unknown,
            self.ascending[above - 1] if above <= n else unknown,
        )
