"""Line loads and load factors of a sweep in slices."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flankload.result.slices import (
    mean_line_loads,
    relative_line_loads,
    relative_mean_line_loads,
)

if TYPE_CHECKING:
    from flankload.base.arrays import Floats
    from flankload.contact.sweep import Sweep


def largest_line_loads(found: Sweep) -> Floats:
    """(P,) Largest mean line load of any flank at each position, N/mm."""
    slices = found.slices
    assert slices is not None
    width = np.diff(slices.edges_mm)
    return mean_line_loads(slices.force_N, width, slices.line_load_mm).max(axis=(1, 2))


def line_load_factors(found: Sweep) -> Floats:
    """(P,) Largest line load of a sweep over its mean at each position."""
    slices = found.slices
    assert slices is not None
    width = np.diff(slices.edges_mm)
    relative = relative_line_loads(
        slices.force_N, width, slices.line_load_mm, each=slices.conforming
    )
    return np.asarray(relative.reshape(len(relative), -1).max(axis=1))


def face_load_factor(found: Sweep, weights: Floats) -> float:
    """K_Hbeta of a sweep; `weights` (P,) are the parts of its positions in the mean load."""
    slices = found.slices
    assert slices is not None
    if slices.conforming:
        return float(line_load_factors(found)[weights > 0].max())
    width = np.diff(slices.edges_mm)
    loads = relative_mean_line_loads(slices.force_N, width, slices.line_load_mm, weights)
    return float(loads.max())
