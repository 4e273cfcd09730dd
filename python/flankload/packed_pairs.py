"""Contact pairs of many states in one table, without a row to spare."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

#: Columns of the core's table of pairs: arc lengths on both flanks, radius, place and normal (out
#: of body 1), force, cell, final gap [mm, N], lever of the torque row.
COLUMNS = (
    "s_1",
    "s_2",
    "radius",
    "x",
    "y",
    "normal_x",
    "normal_y",
    "force",
    "cell",
    "gap",
    "lever",
)


@dataclass(frozen=True, eq=False)
class PackedPairs:
    """Pairs of all positions (P) under one torque.

    Attributes
    ----------
    site : (N,) array
        Number of each pair's site in the sweep, from 0; N pairs, of other torques too.
    table : (N, len(COLUMNS)) array
    first, count : (P,) arrays
        Where the pairs of a position begin, and how many there are.
    """

    site: NDArray[np.intc]
    table: NDArray[np.float64]
    first: NDArray[np.int64]
    count: NDArray[np.int64]

    def at(self, p: int) -> tuple[NDArray[np.intc], NDArray[np.float64]]:
        """Sites (n,) and table (n, columns) of the pairs of position p; views."""
        rows = slice(int(self.first[p]), int(self.first[p] + self.count[p]))
        return self.site[rows], self.table[rows]

    def column(self, name: str) -> NDArray[np.float64]:
        """One column of all pairs under this torque, position by position; a copy."""
        return self.table[self._rows(), COLUMNS.index(name)]

    def _rows(self) -> NDArray[np.int64]:
        """Rows of all pairs under this torque."""
        total = int(self.count.sum())
        before = np.cumsum(self.count) - self.count
        return np.arange(total) + np.repeat(self.first - before, self.count)

    @property
    def nbytes(self) -> int:
        """Bytes of the pairs under this torque."""
        each = self.site.itemsize + self.table.itemsize * len(COLUMNS)
        return int(self.count.sum()) * each


def join_pairs(parts: Sequence[PackedPairs], order: NDArray[np.int64]) -> PackedPairs:
    """Pairs of all positions of several, without those of other torques.

    Parameters
    ----------
    parts : sequence of PackedPairs
    order : (P,) array
        Numbers of the positions, as the parts have them one after the other, in their new order.

    Returns
    -------
    PackedPairs
    """
    rows = [part._rows() for part in parts]
    count = np.concatenate([part.count for part in parts])
    first = np.cumsum(count) - count
    return PackedPairs(
        site=np.concatenate([part.site[own] for part, own in zip(parts, rows, strict=True)]),
        table=np.concatenate([part.table[own] for part, own in zip(parts, rows, strict=True)]),
        first=first[order],
        count=count[order],
    )
