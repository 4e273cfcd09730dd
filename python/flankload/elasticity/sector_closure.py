"""Static condensation of one sector to its loads and cuts, and assembly of equal sectors.

A condensed sector consists of the response to its loads with fixed cuts, the forces G of these
loads on the cuts, and the stiffness S of the cuts. A ring of equal sectors is block-circulant and
solved by sector harmonics; an open row is solved by block elimination. Both are exact. Each kind of
reading (displacements under the loads, coast flank, stress, …) has a separate product, so that its
bits do not depend on other readings.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from flankload.base.rotation import turned
from flankload.elasticity.finite_elements import condensed, degrees_of, factored
from flankload.elasticity.job_log import JobLog

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from scipy.sparse import csc_array

    from flankload.base.arrays import Floats, Numbers
    from flankload.bodies.body import SectorMesh


@dataclass(frozen=True)
class CondensedSector:
    """One condensed sector with free cuts, with the unknowns of the cuts in its frame.

    Attributes
    ----------
    local : tuple of (r, p) arrays
        By kind of reading, the loads first: response of its r readings to the p loads with fixed
        cuts.
    carried : tuple of (2 m, r) arrays
        By kind of reading: forces on the left and the right cut if the readings act as loads.
    stiffness : (2 m, 2 m) array
        Stiffness of the cuts.
    components : int
        Components of a displacement: 2, or 3 with the axial one last. The unknowns of a point of a
        cut are consecutive.
    """

    local: tuple[Floats, ...]
    carried: tuple[Floats, ...]
    stiffness: Floats
    components: int = 2


def condense(
    matrix: csc_array,
    loads: Floats,
    mesh: SectorMesh,
    readings: Mapping[str, Floats] | None = None,
    log: JobLog | None = None,
) -> tuple[CondensedSector, int]:
    """Condense a sector to its loads and cuts.

    Parameters
    ----------
    matrix : csc_array, (2N, 2N)
        Stiffness of the sector.
    loads : (2N, p) array
        Loads, which are also readings of the displacements.
    readings : mapping of str to (2N, q) array, optional
        Further readings of the displacements, by the counter of their solutions (`cost.COUNTERS`).
        Body loads are readings, too: by reciprocity (Betti), they read the displacements that they
        cause.

    Returns
    -------
    sector : CondensedSector
        Its kinds of readings are the loads, then `readings` in their order.
    degrees_of_freedom : int
        Number of unknowns.
    """

    log = JobLog() if log is None else log
    cut = degrees_of(np.concatenate([mesh.left_nodes, mesh.right_nodes]))
    inside = np.setdiff1d(
        np.arange(matrix.shape[0]), np.concatenate([cut, degrees_of(mesh.fixed_nodes)])
    )
    solve, complement = condensed(matrix, inside, cut, log.account)
    log.end_step("factorisation")
    kinds, solved = [loads], [solve(loads[inside])]
    log.solution(inside, solved[0], matrix.shape[0])
    for name, columns in (readings or {}).items():
        log.account.count(**{name: columns.shape[1]})
        kinds.append(columns)
        solved.append(solve(columns[inside]))
    log.account.workspace_bytes += sum(part.nbytes for part in (*kinds, *solved))
    coupling = matrix[cut][:, inside]
    sector = CondensedSector(
        local=tuple(columns[inside].T @ solved[0] for columns in kinds),
        carried=tuple(
            columns[cut] - coupling @ moved for columns, moved in zip(kinds, solved, strict=True)
        ),
        stiffness=complement,
    )
    log.end_step("solution")
    return sector, inside.size + cut.size // 2


def sector_unknowns(mesh: SectorMesh, *, held: bool = False) -> int:
    """Number of unknowns of a sector with one of its cuts, or with both of them fixed."""
    fixed = np.concatenate([mesh.fixed_nodes, mesh.left_nodes, mesh.right_nodes])
    inside = len(mesh.nodes) - np.unique(fixed).size
    return 2 * (inside if held else inside + mesh.left_nodes.size)


def close_ring(sector: CondensedSector, teeth: int) -> Floats:
    """Response (z, r, p) of all teeth of a closed ring to the loads on tooth 0.

    The unknowns of the common cut of sectors k - 1 and k are in the frame of sector k. A Fourier
    transform over the sectors decouples the block-circulant system. [t]: readings on tooth t, in
    its frame; the first p are those of the loads.
    """
    pitch = 2 * np.pi / teeth
    (left_left, left_right, right_left, right_right), carried = turned_cuts(sector, pitch)
    response = [np.zeros((teeth, *local.shape)) for local in sector.local]
    offsets = np.arange(teeth)
    for k in range(teeth // 2 + 1):
        weight = 1.0 if k == 0 or 2 * k == teeth else 2.0
        shift = np.exp(1j * pitch * k)
        # w_t = w exp(i k pitch t); loads on the left (t = 0) and the right cut (t = 1) of sector 0
        load_left, load_right = carried[0]
        unknown = np.linalg.solve(
            left_left + right_right + left_right * shift + right_left / shift,
            load_left + load_right / shift,
        )
        waves = np.exp(1j * pitch * k * offsets)[:, None, None]
        for part, (read_left, read_right) in zip(response, carried, strict=True):
            seen = read_left.T @ unknown + (read_right.T @ unknown) * shift
            part += (weight / teeth) * np.real(seen[None] * waves)
    for part, local in zip(response, sector.local, strict=True):
        part[0] += local
    return np.concatenate(response, axis=1)


def ring_displacements(sector: CondensedSector, teeth: int) -> Floats:
    """Displacements (2 m, z) of the cuts of all sectors of a closed ring, in the sectors' frames.

    `sector.carried` contains the forces on the cuts of each sector, (2 m, z).
    """
    pitch = 2 * np.pi / teeth
    (left_left, left_right, right_left, right_right), ((one, two),) = turned_cuts(sector, pitch)
    load = np.fft.rfft(one + np.roll(two, 1, axis=1), axis=1).T
    waved = np.empty_like(load)
    for k, wave in enumerate(np.exp(1j * pitch * np.arange(len(load)))):
        system = left_left + right_right + left_right * wave + right_left / wave
        waved[k] = np.linalg.solve(system, load[k])
    left = np.fft.irfft(waved, n=teeth, axis=0)
    right = np.roll(left, -1, axis=0).reshape(teeth, -1, sector.components).copy()
    right[..., :2] = turned(right[..., :2], pitch)
    return np.concatenate([left.T, right.reshape(teeth, -1).T])


def uniform_response(sector: CondensedSector, teeth: int) -> Floats:
    """Response (r, p) of a ring under equal loads on all teeth: the sum over `close_ring`."""
    stiffness, carried = turned_cuts(sector, 2 * np.pi / teeth)
    reads = [left + right for left, right in carried]
    unknown = np.linalg.solve(sum(stiffness), reads[0])
    return np.concatenate(
        [local + read.T @ unknown for local, read in zip(sector.local, reads, strict=True)]
    )


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


def tooth_response(
    matrix: csc_array,
    loads: Floats,
    mesh: SectorMesh,
    readings: Sequence[Floats] = (),
    log: JobLog | None = None,
) -> tuple[Floats, int]:
    """Response (z, r, p) of a single tooth with fixed cuts, and the number of unknowns.

    Arguments as of `condense`; `readings`: columns (2N, q) by kind, without solutions. The response
    is 0 for all other teeth.
    """
    log = JobLog() if log is None else log
    held = degrees_of(np.concatenate([mesh.left_nodes, mesh.right_nodes, mesh.fixed_nodes]))
    inside = np.setdiff1d(np.arange(matrix.shape[0]), held)
    solve = factored(matrix[inside][:, inside].tocsc(), log.account)
    log.end_step("factorisation")
    solved = solve(loads[inside])
    own = np.concatenate([columns[inside].T @ solved for columns in (loads, *readings)])
    response = np.zeros((mesh.teeth, *own.shape))
    response[0] = own
    log.end_step("solution")
    log.solution(inside, solved, matrix.shape[0])
    return response, inside.size


def made_symmetric(response: Floats, across: Numbers) -> tuple[Floats, float]:
    """Mean of responses (k, p, p) and their transposes, which differ by rounding only (Betti).

    Also the largest difference over the largest response. `across` (k,): blocks with load and
    reading exchanged.
    """
    mirrored = response[across].transpose(0, 2, 1)
    asymmetry = float(np.abs(response - mirrored).max() / np.abs(response).max())
    return 0.5 * (response + mirrored), asymmetry


def turned_cuts(
    sector: CondensedSector, turn_rad: float
) -> tuple[tuple[Floats, ...], tuple[tuple[Floats, Floats], ...]]:
    """Stiffness of the cuts and forces on them, with the right cut in the frame of the next sector.

    Returns
    -------
    stiffness : left-left, left-right, right-left, right-right, each (m, m)
    carried : by kind of reading left, right, each (m, r)
    """
    m = len(sector.stiffness) // 2
    cosine, sine = np.cos(turn_rad), np.sin(turn_rad)
    block = np.eye(sector.components)
    block[:2, :2] = [[cosine, -sine], [sine, cosine]]
    turn = np.kron(np.eye(m // sector.components), block)
    # right unknowns of sector k, in its frame = turn @ left unknowns of sector k + 1, in its frame
    return (
        sector.stiffness[:m, :m],
        sector.stiffness[:m, m:] @ turn,
        turn.T @ sector.stiffness[m:, :m],
        turn.T @ sector.stiffness[m:, m:] @ turn,
    ), tuple((forces[:m], turn.T @ forces[m:]) for forces in sector.carried)
