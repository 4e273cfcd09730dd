"""Positions that decide the errors of a sweep, at which reduced sweeps are compared with it.

Changes by another compliance, by other cells or slices vary slowly from one position to the next,
except where a pair enters contact or lies on a corner. A few positions therefore show the largest
changes and their mean: those with the largest pressure off corners, the largest line load, the
largest and the smallest rotation, the least load of a pair, the most load on corners or beside
corners, kinks and ends, and some in the widest gaps between these.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flankload.analysis.load_factors import largest_line_loads
from flankload.contact.status import is_marked, on_corner

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from flankload.contact.sweep import Sweep

#: Number of positions in the plane, and with a width, where slices enter contact in turn: twelve
#: show the same there on random scenes.
DECIDING, DECIDING_OF_SLICES = 12, 8


def n_deciding(*, plane: bool, meshes: int = 1) -> int:
    """Number of deciding positions; with a width, each shows several meshes in different phases."""
    return DECIDING if plane else DECIDING_OF_SLICES // min(meshes, 2)


def deciding_positions(found: Sweep, most: int) -> NDArray[np.int64]:
    """Indices of the deciding positions of a sweep, ascending: `most`, or all if fewer."""
    corner, force = found.slices.corner_off_ends, found.slices.force_N
    which = on_corner(corner), is_marked(corner)
    on_corners, marked = (np.where(loads, force, 0.0).sum(axis=(1, 2)) for loads in which)
    count, forces, rotation = found.status.size, found.site_force_N, found.rotation_rad
    # those on corners first; the sums are sorted with equal ones in their order
    worst = np.lexsort((-marked, -on_corners))[:2]
    least = -np.where(forces > 0, forces, np.inf).min(axis=1)
    peaks = np.where(on_corner(found.site_corner), 0.0, found.site_peak_N_per_mm).max(axis=1)
    largest = (peaks, largest_line_loads(found), rotation, -rotation, least)
    named = dict.fromkeys([*(int(values.argmax()) for values in largest), *map(int, worst)])
    wanted = set(list(named)[:most])
    while len(wanted) < min(most, count):
        there = np.array(sorted(wanted))
        gaps = np.diff(there, append=there[0] + count)
        widest = int(gaps.argmax())
        wanted.add(int(there[widest] + gaps[widest] // 2) % count)
    return np.array(sorted(wanted))
