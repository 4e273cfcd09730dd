"""Directions and rotations in the plane, counter-clockwise."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]


def directions(angles_rad: Floats) -> Floats:
    """(n, 2) Unit vectors at polar angles (n,)."""
    return np.column_stack([np.cos(angles_rad), np.sin(angles_rad)])


def turned(vectors: Floats, angle_rad: float) -> Floats:
    """Vectors (…, 2), rotated."""
    cosine, sine = np.cos(angle_rad), np.sin(angle_rad)
    return np.asarray(vectors @ np.array([[cosine, sine], [-sine, cosine]]))
