"""Where a ladder leads to: Richardson's limit with the order that the ladder itself shows.

Three steps of sizes h0 < h1 < h2 with values v0, v1, v2 of the form v + a h^p fix the order p by
(h2^p − h1^p) / (h1^p − h0^p) = |v1 − v2| / |v0 − v1|, and the limit is v0 + c (v0 − v1) with
c = h0^p / (h1^p − h0^p).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

#: Orders beyond are no asymptotics: kinks and rounded numbers of elements make them.
LEAST_ORDER, LARGEST_ORDER = 0.5, 8.0
#: A limit further off than this many times the last change is no longer told by it.
FURTHEST = 1.0
#: Part of the way from the finest value to an extrapolated limit that this is in doubt by: what an
#: order off by a half makes of second order.
IN_DOUBT = 0.5
#: What is left by a ladder that converges slowly, over its last change, at the most: low orders on
#: steps that hardly differ would add more, but are no orders.
MOST_LEFT = 2.0
#: Changes below this part of the value are rounding.
ROUNDING = 1e-8


@dataclass(frozen=True)
class Limit:
    """Where the values of a ladder lead to.

    Attributes
    ----------
    value : array
        Extrapolated; the finest value where the ladder does not converge monotonically.
    order : float or None
        Fitted order; None where nothing is extrapolated.
    monotone : bool
        The changes keep their sense and shrink, or are rounding.
    doubt : float
        Largest distance of finest value and limit; without an order the last change.
    slow : bool
        It converges, but so slowly that the limit is out of sight.
    left : array
        What the value itself may be off: a part of what was extrapolated, or the last change, or
        where it converges slowly what an order would add to it, up to twice that.
    """

    value: Floats
    order: float | None
    monotone: bool
    doubt: float
    left: Floats
    slow: bool = False


def limit_of(sizes: Sequence[float], values: Sequence[Floats]) -> Limit:
    """Limit of a ladder.

    Parameters
    ----------
    sizes : sequence of float
        Ascending: the finest first.
    values : sequence of arrays of one shape
        In the same order; NaN where there is none.

    Returns
    -------
    Limit
        The first three count; of fewer than three nothing is extrapolated.
    """
    finest = np.asarray(values[0], dtype=float)
    if len(values) < 2:
        return Limit(finest, None, False, float("nan"), np.full_like(finest, np.nan))
    last = finest - np.asarray(values[1], dtype=float)
    scale = _largest(finest)
    doubt = _largest(last)
    if doubt <= ROUNDING * scale:
        return Limit(finest, None, True, doubt, last)
    if len(values) < 3:
        return Limit(finest, None, False, doubt, last)
    before = np.asarray(values[1], dtype=float) - np.asarray(values[2], dtype=float)
    along = float(np.nansum(last * before))
    order = fitted_order(sizes, _norm(before), _norm(last)) if along > 0 else None
    if order is None:
        return Limit(finest, None, False, doubt, last)
    part = sizes[0] ** order / (sizes[1] ** order - sizes[0] ** order)
    if part > FURTHEST:
        return Limit(finest, None, True, part * doubt, min(part, MOST_LEFT) * last, slow=True)
    return Limit(finest + part * last, order, True, part * doubt, IN_DOUBT * part * last)


def fitted_order(sizes: Sequence[float], before: float, last: float) -> float | None:
    """Order at which two changes of a ladder follow each other.

    Parameters
    ----------
    sizes : sequence of three floats, ascending
    before, last : float
        Sizes of the change from the coarsest to the middle step, and from there to the finest.

    Returns
    -------
    float or None
        None where no order from 0.5 to 8 does.
    """
    fine, middle, coarse = sizes[:3]

    def ratio(order: float) -> float:
        step: float = middle**order
        return float((coarse**order - step) / (step - fine**order))

    wanted = before / last if last > 0 else np.inf
    low, high = LEAST_ORDER, LARGEST_ORDER
    if not ratio(low) <= wanted <= ratio(high):
        return None
    for _ in range(60):  # the ratio grows with the order
        order = 0.5 * (low + high)
        low, high = (order, high) if ratio(order) < wanted else (low, order)
    return 0.5 * (low + high)


def _norm(change: Floats) -> float:
    return float(np.sqrt(np.nansum(change**2)))


def _largest(values: Floats) -> float:
    known = np.abs(values[np.isfinite(values)])
    return float(known.max(initial=0.0))
