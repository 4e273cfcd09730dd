"""Rounding of quotients that are whole numbers in exact arithmetic.

Example: a flank is exactly three elements long. Rounding errors put such a quotient just above or
below the whole number; the number of elements, sites or teeth must not depend on them.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, overload

import numpy as np

if TYPE_CHECKING:
    from flankload.base.arrays import Floats, Numbers

#: A quotient within this distance of a whole number counts as that number, and quantities that
#: differ by less than this part of their scale are equal: far above rounding errors, far below any
#: difference that matters.
TIE = 1e-9


@overload
def round_down(quotient: float) -> int: ...
@overload
def round_down(quotient: Floats) -> Numbers: ...
def round_down(quotient: float | Floats) -> int | Numbers:
    """Floor of a number or an array; a whole number up to `TIE` gives that number."""
    whole = np.floor(np.asarray(quotient) + TIE).astype(np.int64)
    return int(whole) if whole.ndim == 0 else whole


@overload
def round_up(quotient: float) -> int: ...
@overload
def round_up(quotient: Floats) -> Numbers: ...
def round_up(quotient: float | Floats) -> int | Numbers:
    """Ceiling of a number or an array; a whole number up to `TIE` gives that number."""
    return -round_down(-np.asarray(quotient, dtype=np.float64))
