"""Decisions on quotients that are whole numbers in exact arithmetic.

A flank is three elements long, a position half a pitch on, a strand ends where a land does: on
which side of the whole number such a quotient comes out is a matter of rounding, and no number of
elements, sites or teeth may hang on that.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, overload

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

#: Quotients this near to a whole number are that number: far above what rounding leaves of them,
#: far below what anything could show.
TIE = 1e-9


@overload
def round_down(quotient: float) -> int: ...
@overload
def round_down(quotient: NDArray[np.float64]) -> NDArray[np.int64]: ...
def round_down(quotient: float | NDArray[np.float64]) -> int | NDArray[np.int64]:
    """Floor, where whole numbers that rounding has made a little less are whole.

    Parameters
    ----------
    quotient : float or array

    Returns
    -------
    int or array of int
    """
    whole = np.floor(np.asarray(quotient) + TIE).astype(np.int64)
    return int(whole) if whole.ndim == 0 else whole


@overload
def round_up(quotient: float) -> int: ...
@overload
def round_up(quotient: NDArray[np.float64]) -> NDArray[np.int64]: ...
def round_up(quotient: float | NDArray[np.float64]) -> int | NDArray[np.int64]:
    """Ceiling, where whole numbers that rounding has made a little more are whole.

    Parameters
    ----------
    quotient : float or array

    Returns
    -------
    int or array of int
    """
    return -round_down(-np.asarray(quotient, dtype=np.float64))
