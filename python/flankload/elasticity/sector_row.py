"""Open rows of condensed sectors, which may differ, by block elimination: exact."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from flankload.elasticity.condensed_sector import turned_cuts
from flankload.elasticity.sector_closure import close_ring

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flankload.base.arrays import Floats
    from flankload.elasticity.condensed_sector import CondensedSector


@dataclass(frozen=True)
class RowCell:
    """A condensed cell of a row; its cuts are in the frames of the neighbouring cells.

    Attributes
    ----------
    local : tuple of (r, p) arrays
        As in `CondensedSector`; the first p readings are the loads.
    carried : tuple of (left, right)
        By kind of reading, forces on both cuts, (m, r) each; not used at the ends of a row.
    stiffness : (left-left, left-right, right-left, right-right)
    """

    local: tuple[Floats, ...]
    carried: tuple[tuple[Floats, Floats], ...]
    stiffness: tuple[Floats, ...]

    @property
    def loads(self) -> int:
        """Number of loads."""
        return self.local[0].shape[1]

    def seen(self, side: int, moved: Floats) -> Floats:
        """All readings of the displacements of the left (side 0) or the right cut (1)."""
        return np.concatenate([both[side].T @ moved for both in self.carried])


def row_response(cells: Sequence[RowCell]) -> Floats:
    """Response (sum of r, sum of p) of all cells of an open row to the loads on each.

    The block-tridiagonal stiffness of the interfaces is eliminated from one end to the other.
    Supports and loads at both ends of the row are part of the first and the last cell. Cells may
    differ in loads and readings.
    """
    loads = [cell.loads for cell in cells]
    ends = np.concatenate([[0], np.cumsum(loads)])
    found: list[tuple[Floats, Floats]] = []
    for k, (one, two) in enumerate(pairwise(cells)):
        # interface k, between cells k and k + 1, under the loads of cells up to k + 1
        pivot = one.stiffness[3] + two.stiffness[0]
        force = np.zeros((len(pivot), ends[k + 2]))
        force[:, ends[k] : ends[k + 1]] = one.carried[0][1][:, : loads[k]]
        force[:, ends[k + 1] :] = two.carried[0][0][:, : loads[k + 1]]
        if k:
            coupled, known = found[-1]
            pivot = pivot - one.stiffness[2] @ coupled
            force[:, : ends[k + 1]] -= one.stiffness[2] @ known
        solved = np.linalg.solve(pivot, np.hstack([two.stiffness[1], force]))
        found.append((solved[:, : -force.shape[1]], solved[:, -force.shape[1] :]))
    parts = [np.zeros((sum(map(len, cell.local)), ends[-1])) for cell in cells]
    moved = np.zeros((0, ends[-1]))
    for k in range(len(cells) - 2, -1, -1):
        coupled, known = found[k]
        after = moved
        moved = np.zeros((len(known), ends[-1]))
        moved[:, : known.shape[1]] = known
        if k < len(cells) - 2:
            moved -= coupled @ after
        parts[k] += cells[k].seen(1, moved)
        parts[k + 1] += cells[k + 1].seen(0, moved)
    for k, cell in enumerate(cells):
        parts[k][:, ends[k] : ends[k + 1]] += np.concatenate(cell.local)
    return np.concatenate(parts)


def open_row(sector: CondensedSector, cells: int, turn_rad: float) -> Floats:
    """Response (n, n, r, p) of the sectors of an open row with fixed ends to the loads on each.

    Each sector is rotated counter-clockwise by `turn_rad` relative to the previous one. [i, j]:
    readings on sector i under the loads on sector j, each in its frame.
    """
    stiffness, carried = turned_cuts(sector, turn_rad)
    cell = RowCell(sector.local, carried, stiffness)
    row = row_response([cell] * cells)
    return row.reshape(cells, -1, cells, cell.loads).transpose(0, 2, 1, 3).copy()


def teeth_response(sector: CondensedSector, teeth: int, sectors: int | None) -> Floats:
    """Response (z, r, p) of all teeth to the loads on tooth 0.

    `sectors`: odd number of elastic sectors of a segment, 1 for a single tooth with fixed cuts,
    None for the whole ring.
    """
    if sectors is None:
        return close_ring(sector, teeth)
    if sectors > 1:
        return segment_response(sector, teeth, sectors)
    own = np.concatenate(sector.local)
    response = np.zeros((teeth, *own.shape))
    response[0] = own
    return response


def segment_response(sector: CondensedSector, teeth: int, cells: int) -> Floats:
    """Response (z, r, p) of a body that is reduced to a segment around each pair of teeth.

    The response between two teeth is that of the two sectors of the segment at the same distance
    that are nearest to its middle, or the mean of two such pairs: symmetric (Betti), and periodic
    with the tooth pitch. Teeth at a greater distance than the length of the segment do not affect
    each other. `cells` is odd and at most the number of teeth.
    """
    row = open_row(sector, cells, 2 * np.pi / teeth)
    response = np.zeros((teeth, *row.shape[2:]))
    for apart in range(min(cells - 1, teeth // 2) + 1):
        spare = cells - 1 - apart
        for first in (spare // 2, spare - spare // 2):
            weight = 0.25 if apart == 0 or 2 * apart == teeth else 0.5
            response[apart] += weight * row[first + apart, first]
            response[-apart % teeth] += weight * row[first, first + apart]
    return response
