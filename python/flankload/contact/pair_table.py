"""Contact pairs of many states in one table."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

#: Columns of the core's table of pairs: arc lengths on both flanks, radius, position and normal
#: (out of body 1), force, cell width, final gap [mm, N], lever arm of the torque row.
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
#: Further columns with friction: sliding speed [mm per rad of the position], friction coefficient
#: with its sign.
FRICTION_COLUMNS = ("sliding", "friction")


def columns_of(*, friction: bool) -> tuple[str, ...]:
    """Columns of a table of pairs with or without friction."""
    return (*COLUMNS, *FRICTION_COLUMNS) if friction else COLUMNS


@dataclass(frozen=True, eq=False)
class PackedPairs:
    """Pairs of all positions (P) under one torque.

    Attributes
    ----------
    site : (N,) array
        Number of each pair's site in the core, from 0: slice by slice of each site of the flanks.
        N pairs, including those of other torques.
    table : (N, len(COLUMNS)) array; with friction followed by FRICTION_COLUMNS
    first, count : (P,) arrays
        Index of the first pair of a position, and number of its pairs.
    slice_count : int
        Number of slices of each site.
    """

    site: NDArray[np.intc]
    table: NDArray[np.float64]
    first: NDArray[np.int64]
    count: NDArray[np.int64]
    slice_count: int = 1

    def columns_at(self, p: int) -> dict[str, NDArray[np.float64]]:
        """Columns (n,) of the pairs of position p, by name; views."""
        return dict(zip(self.names, self.table[self._rows_of(p)].T, strict=True))

    def at(self, p: int) -> tuple[NDArray[np.intc], NDArray[np.float64]]:
        """Sites (n,) and table (n, columns), a view, of the pairs of position p."""
        rows = self._rows_of(p)
        return self.site[rows] // self.slice_count, self.table[rows]

    def slices_at(self, p: int) -> NDArray[np.intc]:
        """Slices (n,) of the pairs of position p, from 0."""
        return self.site[self._rows_of(p)] % self.slice_count

    def _rows_of(self, p: int) -> slice:
        return slice(int(self.first[p]), int(self.first[p] + self.count[p]))

    def column(self, name: str) -> NDArray[np.float64]:
        """One column of all pairs under this torque, position by position; a copy."""
        return self.table[self._rows(), self.names.index(name)]

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the columns."""
        return (*COLUMNS, *FRICTION_COLUMNS)[: self.table.shape[1]]

    @property
    def position(self) -> NDArray[np.int64]:
        """(n,) Number of the position of all pairs under this torque."""
        return np.repeat(np.arange(self.count.size), self.count)

    @property
    def sites(self) -> NDArray[np.intc]:
        """(n,) Number of the site of all pairs under this torque, from 0; a copy."""
        return self.site[self._rows()] // self.slice_count

    @property
    def slices(self) -> NDArray[np.intc]:
        """(n,) Slice of all pairs under this torque, from 0; a copy."""
        return self.site[self._rows()] % self.slice_count

    def _rows(self) -> NDArray[np.int64]:
        """Rows of all pairs under this torque."""
        total = int(self.count.sum())
        before = np.cumsum(self.count) - self.count
        return np.arange(total) + np.repeat(self.first - before, self.count)

    def split_at(self, site: int) -> tuple[PackedPairs, PackedPairs]:
        """Split the pairs at a site number; site numbers of the second part begin at 0.

        At each position, pairs of smaller site numbers are first. Both parts use the same table.
        """
        above = self.site >= site
        rows = np.concatenate([[0], np.cumsum(above)])
        first = np.maximum(self.first, 0)
        n_above = rows[first + self.count] - rows[first]
        n_below = self.count - n_above
        numbers = self.site - np.where(above, site, 0).astype(self.site.dtype)
        return (
            PackedPairs(numbers, self.table, self.first, n_below, self.slice_count),
            PackedPairs(numbers, self.table, self.first + n_below, n_above, self.slice_count),
        )

    @property
    def nbytes(self) -> int:
        """Bytes of the pairs under this torque."""
        each = self.site.itemsize + self.table.itemsize * self.table.shape[1]
        return int(self.count.sum()) * each


def join_pairs(parts: Sequence[PackedPairs], order: NDArray[np.int64]) -> PackedPairs:
    """Concatenate the pairs of all positions of several tables, without those of other torques.

    `order` (P,) are indices into the concatenated positions of the parts, in their new order.
    """
    rows = [part._rows() for part in parts]
    count = np.concatenate([part.count for part in parts])
    first = np.cumsum(count) - count
    return PackedPairs(
        site=np.concatenate([part.site[own] for part, own in zip(parts, rows, strict=True)]),
        table=np.concatenate([part.table[own] for part, own in zip(parts, rows, strict=True)]),
        first=first[order],
        count=count[order],
        slice_count=parts[0].slice_count,
    )
