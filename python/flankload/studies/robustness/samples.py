"""Samples of a quantity: percentiles with their sampling error, and the share of failures.

A design without a value is worse than any value, at either end: a percentile below 50 % counts it
below all values, one from 50 % on above them. At most 5 % of all designs then lie beyond the 5 % or
the 95 % percentile or have no value. A percentile among the designs without a value is not known.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from flankload.base.arrays import Floats


#: Probability with which an interval contains the percentile, or the share of failures.
CONFIDENCE = 0.95
#: Percentiles from this one on count designs without a value above all values, others below.
MIDDLE = 50.0


@dataclass(frozen=True)
class Failures:
    """Designs without a solution, among all designs of a simulation."""

    count: int
    designs: int

    @property
    def share(self) -> float:
        """Part of the designs that failed."""
        return self.count / self.designs

    @property
    def interval(self) -> tuple[float, float]:
        """Limits between which the probability of a failure lies, with a probability of 95 %.

        Exact for a binomial distribution (Clopper and Pearson, Biometrika 26, 1934).
        """
        from scipy.stats import beta

        k, n, tail = self.count, self.designs, 0.5 * (1.0 - CONFIDENCE)
        low = float(beta.ppf(tail, k, n - k + 1)) if k else 0.0
        return low, float(beta.ppf(1.0 - tail, k + 1, n - k)) if k < n else 1.0

    def __str__(self) -> str:
        """Return the share with its limits."""
        low, high = (100.0 * limit for limit in self.interval)
        share = f"{self.count} of {self.designs}, {100.0 * self.share:.3g} %"
        return f"{share} (95 % confidence: {low:.3g} to {high:.3g} %)"


@dataclass(frozen=True, eq=False)
class Samples:
    """Independent samples of a quantity.

    `values` (n, ...) has an entry for each design, NaN without a value; n >= 2. Mean and standard
    deviation are those of the designs with a value.
    """

    values: Floats

    def __len__(self) -> int:
        return len(self.values)

    @property
    def known(self) -> Floats:
        """Number of designs with a value, for each entry of the quantity."""
        return np.asarray(np.isfinite(self.values).sum(axis=0, dtype=float))

    @property
    def mean(self) -> Floats:
        """Mean of the samples."""
        return self._mean_of(self.values)

    @property
    def standard_deviation(self) -> Floats:
        """Standard deviation of the distribution, estimated from the samples."""
        variance = self._mean_of((self.values - self.mean) ** 2)
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.asarray(np.sqrt(variance * self.known / (self.known - 1.0)))

    @property
    def mean_error(self) -> Floats:
        """Standard deviation of the mean."""
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.asarray(self.standard_deviation / np.sqrt(self.known))

    @property
    def deviation_error(self) -> Floats:
        """Standard deviation of the standard deviation s: sqrt((m_4 - s⁴) / n) / (2 s)."""
        fourth = self._mean_of((self.values - self.mean) ** 4)
        square = self.standard_deviation**2
        with np.errstate(divide="ignore", invalid="ignore"):
            error = np.sqrt(np.maximum(0.0, fourth - square**2) / self.known / square) / 2.0
        return np.nan_to_num(error)

    def percentile(self, percent: float) -> Floats:
        """Value at a part of all designs in percent, interpolated between two.

        NaN if it lies among the designs without a value.
        """
        ordered = self._ordered(percent)
        below, part = divmod(percent * (len(self) - 1) / 100.0, 1.0)
        found = ordered[int(below)]
        if part:
            found = (1.0 - part) * found + part * ordered[int(below) + 1]
        return np.where(np.isfinite(found), found, np.nan)

    def interval(self, percent: float) -> tuple[Floats, Floats]:
        """Two samples between which the percentile of the distribution lies.

        They include it with a probability of at least 95 %; NaN where the samples are too few for a
        limit, or the limit has no value. The number of samples below the percentile has a binomial
        distribution, for any distribution of the quantity (David and Nagaraja, Order Statistics,
        2003, section 7.1).
        """
        from scipy.stats import binom

        n, tail = len(self), 0.5 * (1.0 - CONFIDENCE)
        ordered = self._ordered(percent)
        below = int(binom.ppf(tail, n, percent / 100.0))
        above = int(binom.ppf(1.0 - tail, n, percent / 100.0)) + 1
        unknown = np.full(ordered.shape[1:], np.nan)
        low = ordered[below - 1] if below >= 1 else unknown
        high = ordered[above - 1] if above <= n else unknown
        return np.where(np.isfinite(low), low, np.nan), np.where(np.isfinite(high), high, np.nan)

    def _ordered(self, percent: float) -> Floats:
        """Each entry of the quantity by itself in ascending order; infinite without a value."""
        worst = -np.inf if percent < MIDDLE else np.inf
        return np.sort(np.where(np.isfinite(self.values), self.values, worst), axis=0)

    def _mean_of(self, values: Floats) -> Floats:
        """Mean over the designs with a value."""
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.asarray(np.nansum(values, axis=0) / self.known)
