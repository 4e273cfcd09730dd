"""Contours for pictures of bodies of which only the flank is known."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from flankload.base.arrays import Floats


def sketched_tooth(flank: Floats, teeth: int) -> Floats:
    """Contour (2 n, 2) of a tooth, counter-clockwise: the flank and its mirror image.

    They are a quarter pitch apart from the centre. The points (n, 2) of the flank are from root to
    tip, mm; the teeth are internal if the radius decreases.
    """
    root, tip = np.linalg.norm(flank[[0, -1]], axis=1)
    outward = 1 if tip > root else -1
    middle = flank[len(flank) // 2]
    angle = float(np.arctan2(middle[1], middle[0])) - outward * np.pi / (2 * teeth)
    c, s = np.cos(2 * angle), np.sin(2 * angle)
    other = flank @ np.array([[c, s], [s, -c]])
    return np.concatenate([other, flank[::-1]] if outward > 0 else [flank, other[::-1]])
