"""Limit of a sequence of refinements: Richardson extrapolation with a fitted order.

Three steps of sizes h0 < h1 < h2 with values v0, v1, v2 of the form v + a h^p determine the order p
by (h2^p − h1^p) / (h1^p − h0^p) = |v1 − v2| / |v0 − v1|, and the limit is v0 + c (v0 − v1) with
c = h0^p / (h1^p − h0^p).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flankload.base.arrays import Floats


#: Orders outside this range are not asymptotic: kinks and rounded numbers of elements cause them.
LEAST_ORDER, LARGEST_ORDER = 0.5, 8.0
#: An extrapolation by more than this multiple of the last change is unreliable.
FURTHEST = 1.0
#: Uncertainty of an extrapolated limit, relative to its distance from the finest value: the effect
#: of an order wrong by a half for second order.
IN_DOUBT = 0.5
#: Upper bound of the remaining error of slow convergence, relative to the last change: low orders
#: fitted to almost equal steps would give more, but are not reliable.
MOST_LEFT = 2.0
#: Changes below this part of the value are roundoff.
LEAST_CHANGE = 1e-8


@dataclass(frozen=True)
class Limit:
    """Limit of a sequence of refinements.

    `value` is extrapolated, with the fitted `order`, or the finest value if the sequence does not
    converge monotonically. `monotone`: whether the changes keep their sign and decrease, or are
    roundoff. `doubt` is the largest difference of finest value and limit, without an order the last
    change. `slow`: whether convergence is too slow for a reliable limit. `left` is the possible
    error of `value` itself: a part of the extrapolation, or the last change, or for slow
    convergence the correction from the fitted order, up to twice the last change.
    """

    value: Floats
    order: float | None
    monotone: bool
    doubt: float
    left: Floats
    slow: bool = False


def limit_of(sizes: Sequence[float], values: Sequence[Floats]) -> Limit:
    """Limit of a sequence of refinements, from its values at ascending sizes: the finest first.

    The values are arrays of one shape, NaN if missing. The first three count; fewer than three are
    not extrapolated.
    """
    finest = np.asarray(values[0], dtype=float)
    if len(values) < 2:
        return Limit(finest, None, False, float("nan"), np.full_like(finest, np.nan))
    last = finest - np.asarray(values[1], dtype=float)
    doubt = largest_of(last)
    if doubt <= LEAST_CHANGE * largest_of(finest):
        return Limit(finest, None, True, doubt, last)
    if len(values) < 3:
        return Limit(finest, None, False, doubt, last)
    before = np.asarray(values[1], dtype=float) - np.asarray(values[2], dtype=float)
    along = float(np.nansum(last * before))
    sizes_of_changes = (float(np.sqrt(np.nansum(change**2))) for change in (before, last))
    order = _fitted_order(sizes, *sizes_of_changes) if along > 0 else None
    if order is None:
        return Limit(finest, None, False, doubt, last)
    part = sizes[0] ** order / (sizes[1] ** order - sizes[0] ** order)
    if part > FURTHEST:
        return Limit(finest, None, True, part * doubt, min(part, MOST_LEFT) * last, slow=True)
    return Limit(finest + part * last, order, True, part * doubt, IN_DOUBT * part * last)


def _fitted_order(sizes: Sequence[float], before: float, last: float) -> float | None:
    """Order of convergence from the changes to the middle and to the finest of three sizes.

    None if no order from 0.5 to 8 fits.
    """
    from scipy.optimize import brentq

    fine, middle, coarse = sizes[:3]
    wanted = before / last if last > 0 else np.inf

    def beyond(order: float) -> float:  # increases with the order
        step: float = middle**order
        return float((coarse**order - step) / (step - fine**order)) - wanted

    if not beyond(LEAST_ORDER) <= 0.0 <= beyond(LARGEST_ORDER):
        return None
    return float(brentq(beyond, LEAST_ORDER, LARGEST_ORDER, xtol=1e-15, rtol=1e-15))


def largest_of(values: Floats) -> float:
    """Largest magnitude of the finite numbers."""
    return float(np.abs(values[np.isfinite(values)]).max(initial=0.0))
