"""Means of 1/R over uniformly loaded rectangles and segments of a line, in closed form."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    Floats = NDArray[np.float64]


def love_rectangle(x: ArrayLike, y: ArrayLike, a: float, b: float) -> Floats:
    """Mean of 1/R over the rectangle |x'| <= a, |y'| <= b.

    Parameters
    ----------
    x, y : arrays that broadcast
        Place from the centre, mm.
    a, b : float
        Half sides, mm, above 0.

    Returns
    -------
    array
        1/mm; times k the displacement under a unit load (A. E. H. Love, Phil. Trans. A 228, 1929).
    """
    x, y = np.asarray(x, dtype=float), np.asarray(y, dtype=float)
    corners = (
        _corner(x + a, y + b)
        - _corner(x + a, y - b)
        - _corner(x - a, y + b)
        + _corner(x - a, y - b)
    )
    return np.asarray(corners / (4.0 * a * b))


def _corner(x: Floats, y: Floats) -> Floats:
    """X asinh(Y/|X|) + Y asinh(X/|Y|); a term with a factor 0 is 0."""
    return _term(x, y) + _term(y, x)


def _term(x: Floats, y: Floats) -> Floats:
    magnitude = np.abs(x)
    return x * np.arcsinh(y / np.where(magnitude > 0, magnitude, 1.0))


def line_segment(y: ArrayLike, b: float) -> Floats:
    """Mean of 1/R over the segment |y'| <= b of the same line, |y| > b; 1/mm."""
    distance = np.abs(np.asarray(y, dtype=float))
    return np.asarray(np.log((distance + b) / (distance - b)) / (2.0 * b))
