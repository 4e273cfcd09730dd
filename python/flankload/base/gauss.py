"""Gauss-Legendre rules, each computed once."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING

from numpy.polynomial import legendre

from flankload.base.read_only import frozen

if TYPE_CHECKING:
    from flankload.base.arrays import Floats


@cache
def leggauss(count: int) -> tuple[Floats, Floats]:
    """Points and weights (count,) of the Gauss rule on [-1, 1]; the arrays are read-only."""
    points, weights = legendre.leggauss(count)
    return frozen(points), frozen(weights)
