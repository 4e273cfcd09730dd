"""Root of a function to machine precision by Chandrupatla's method, without importing SciPy."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable

#: Spacing of floating-point numbers near 1.
EPS = sys.float_info.epsilon


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
    # the sign changes between `here`, the last point, and `there`; `before` is the point left out
    here, at_here, there, at_there, part = high, at_high, low, at_low, 0.5
    while True:
        middle = 0.5 * (here + there)
        if middle in (here, there):
            return middle
        new = here + part * (there - here)
        at_new = function(new)
        if (at_new > 0.0) == (at_here > 0.0):
            before, at_before = here, at_here
        else:
            before, at_before, there, at_there = there, at_there, here, at_here
        here, at_here = new, at_new
        least = 2.0 * EPS * max(abs(here), abs(there)) / abs(there - here)
        part = _next_part((here, before, there), (at_here, at_before, at_there))
        part = min(max(part, least), 1.0 - least) if least < 0.5 else 0.5


def _next_part(points: tuple[float, float, float], values: tuple[float, float, float]) -> float:
    """Next point, as a fraction of the interval from the last point to the other side.

    Inverse quadratic interpolation if it is safe, otherwise bisection (Chandrupatla, Adv. Eng.
    Softw. 28, 1997). Points and values: last, one before, other side.
    """
    (one, two, three), (at_one, at_two, at_three) = points, values
    place = (one - three) / (two - three)
    height = (at_one - at_three) / (at_two - at_three)
    if not (height**2 < place and (1.0 - height) ** 2 < 1.0 - place):
        return 0.5
    along = (two - one) / (three - one) * at_one / (at_two - at_one)
    along *= at_three / (at_two - at_three)
    return at_one / (at_three - at_one) * at_two / (at_three - at_two) + along
