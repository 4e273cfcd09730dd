"""Linear and quadratic shape functions along a line of elements, and Gauss points between them.

A line of nodes is given by coordinates along it; every second node is a mid-side node.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.polynomial.legendre import leggauss

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

#: Gauss points between two breaks: the integrands are cubic, on round flanks approximately.
GAUSS_POINTS = 4


def gauss_points(breaks: Floats) -> tuple[Floats, Floats]:
    """(g,) Gauss points between successive breaks, and their weights."""
    points, weights = leggauss(GAUSS_POINTS)
    steps = 0.5 * np.diff(breaks)[:, None]
    return (breaks[:-1, None] + steps * (1.0 + points)).ravel(), (steps * weights).ravel()


def linear(at: Floats, nodes: Floats) -> Floats:
    """(g, c) Functions at places `at` that are 1 at one of the nodes (c,) and 0 at all others."""
    return np.column_stack([np.interp(at, nodes, own) for own in np.eye(nodes.size)])


def quadratic(at: Floats, nodes: Floats) -> tuple[Floats, Floats]:
    """(g, m) Functions of quadratic elements at places `at`, and their derivatives.

    Parameters
    ----------
    at : (g,) array
    nodes : (m,) array
    """
    ends = nodes[::2]
    element = np.clip(np.searchsorted(ends, at, side="right") - 1, 0, ends.size - 2)
    half = 0.5 * (ends[element + 1] - ends[element])
    x = (at - ends[element]) / half - 1.0
    shapes, slopes = np.zeros((2, at.size, nodes.size))
    rows = np.arange(at.size)
    for k, value in enumerate((x * (x - 1) / 2, 1 - x**2, x * (x + 1) / 2)):
        shapes[rows, 2 * element + k] = value
    for k, slope in enumerate((x - 0.5, -2 * x, x + 0.5)):
        slopes[rows, 2 * element + k] = slope / half
    return shapes, slopes
