"""Root of a function by bisection to machine precision, without importing SciPy."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable


def sign_change(function: Callable[[float], float], low: float, high: float) -> float:
    """Root of a continuous function with opposite signs at both ends, or an end with the value 0.

    Raises
    ------
    ValueError
        If the signs at the ends are equal.
    """
    at_low, at_high = function(low), function(high)
    if at_low == 0.0 or at_high == 0.0:
        return low if at_low == 0.0 else high
    if (at_low > 0.0) == (at_high > 0.0):
        raise ValueError(f"expected opposite signs, found {at_low:g} and {at_high:g}")
    while True:
        middle = 0.5 * (low + high)
        if middle in (low, high):
            return middle
        if (function(middle) > 0.0) == (at_low > 0.0):
            low = middle
        else:
            high = middle
