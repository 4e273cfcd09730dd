"""Line loads of a sweep in slices, whose largest ones are the load factors."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flankload.result.slices import mean_line_loads, relative_line_loads, relative_mean_line_loads

if TYPE_CHECKING:
    from flankload.base.arrays import Floats
    from flankload.contact.sweep import Sweep


def line_loads(found: Sweep) -> Floats:
    """(P, S, J) Mean line load of each flank at each position, N/mm."""
    slices = found.slices
    width = np.diff(slices.edges_mm)
    return mean_line_loads(slices.force_N, width, slices.line_load_mm)


def largest_line_loads(found: Sweep) -> Floats:
    """(P,) The largest of them at each position."""
    return np.asarray(line_loads(found).max(axis=(1, 2)))


def relative_loads(found: Sweep) -> Floats:
    """(P, J), of flanks that conform (P, S, J), line load over its mean at each position."""
    slices = found.slices
    width = np.diff(slices.edges_mm)
    return relative_line_loads(slices.force_N, width, slices.line_load_mm, each=slices.conforming)


def line_load_factors(found: Sweep) -> Floats:
    """(P,) Largest line load of a sweep over its mean at each position."""
    relative = relative_loads(found)
    return np.asarray(relative.reshape(len(relative), -1).max(axis=1))


def loads_over_period(found: Sweep, weights: Floats) -> Floats:
    """(J,) Line load over its mean, both means over the period, whose largest is K_Hbeta.

    `weights` (P,) are the parts of the positions. Of flanks that conform as `relative_loads`.
    """
    slices = found.slices
    if slices.conforming:
        return relative_loads(found)[weights > 0]
    width = np.diff(slices.edges_mm)
    return relative_mean_line_loads(slices.force_N, width, slices.line_load_mm, weights)


def face_load_factor(found: Sweep, weights: Floats) -> float:
    """K_Hbeta of a sweep."""
    return float(loads_over_period(found, weights).max())
