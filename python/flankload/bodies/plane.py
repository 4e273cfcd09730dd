"""Mirror images, lines and circles in the plane, and the contour of a tooth for pictures."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flankload.base.rotation import directions

if TYPE_CHECKING:
    from flankload.base.arrays import Floats
    from flankload.flank import Place


def mirrored(places: Floats, axis_rad: float) -> Floats:
    """Mirror images of places (m, 2) about a line through the origin."""
    c, s = np.cos(2 * axis_rad), np.sin(2 * axis_rad)
    return np.asarray(places @ np.array([[c, s], [s, -c]]))


def across(vectors: Floats) -> Floats:
    """Vectors (m, 2) rotated by a quarter turn counter-clockwise."""
    found = np.empty_like(vectors)
    found[:, 0], found[:, 1] = -vectors[:, 1], vectors[:, 0]
    return found


def line(start: Floats, direction: Floats) -> Place:
    """A straight line, parametrised by the distance from its start."""

    def place(u: Floats) -> tuple[Floats, Floats, Floats]:
        ones = np.ones((u.size, 1))
        return start + u[:, None] * direction, ones * direction, 0.0 * ones * direction

    return place


@dataclass(frozen=True)
class Circle:
    """A circle; a dataclass, so that bodies with the same circle share cached fits."""

    center_mm: tuple[float, float]
    radius_mm: float

    def place(self, angle: Floats) -> tuple[Floats, Floats, Floats]:
        """Points at polar angles (m,) about the centre, with two derivatives: (m, 2) each."""
        out, radius = directions(angle), self.radius_mm
        return self.center_mm + radius * out, radius * across(out), -radius * out


def circle(center: Floats, radius: float) -> Place:
    """A circle, parametrised by its polar angle; with a negative radius, by that angle plus pi."""
    x, y = center.tolist()
    return Circle((x, y), radius).place


def sketched_tooth(flank: Floats, teeth: int) -> Floats:
    """Contour (2 n, 2) of a tooth, counter-clockwise: the flank and its mirror image.

    Both are a quarter pitch from the centre line. The points (n, 2) of the flank are from root to
    tip, mm; the teeth are internal if the radius decreases.
    """
    root, tip = np.linalg.norm(flank[[0, -1]], axis=1)
    outward = 1 if tip > root else -1
    middle = flank[len(flank) // 2]
    angle = float(np.arctan2(middle[1], middle[0])) - outward * np.pi / (2 * teeth)
    other = mirrored(flank, angle)
    return np.concatenate([other, flank[::-1]] if outward > 0 else [flank, other[::-1]])
