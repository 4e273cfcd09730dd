"""Directions, rotations and circles in the plane."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from flankload.base.arrays import Floats
    from flankload.flank import Place


def directions(angles_rad: ArrayLike) -> Floats:
    """Unit vectors (m, 2) at polar angles (m,)."""
    return np.stack([np.cos(angles_rad), np.sin(angles_rad)], axis=1)


def turned(places: Floats, angle_rad: float) -> Floats:
    """Places (m, 2) rotated counter-clockwise about the origin."""
    c, s = np.cos(angle_rad), np.sin(angle_rad)
    return np.asarray(places @ np.array([[c, s], [-s, c]]))


def across(vectors: Floats) -> Floats:
    """Vectors (m, 2) rotated by a quarter turn counter-clockwise."""
    return np.stack([-vectors[:, 1], vectors[:, 0]], axis=1)


def line(start: Floats, direction: Floats) -> Place:
    """A straight line by the distance from its start."""

    def place(u: Floats) -> tuple[Floats, Floats, Floats]:
        ones = np.ones((u.size, 1))
        return start + u[:, None] * direction, ones * direction, 0.0 * ones * direction

    return place


def circle(center: Floats, radius: float) -> Place:
    """A circle by the polar angle about its centre; a negative radius: its opposite points."""

    def place(angle: Floats) -> tuple[Floats, Floats, Floats]:
        out = directions(angle)
        return center + radius * out, radius * across(out), -radius * out

    return place
