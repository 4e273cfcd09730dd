"""Condensation of a sector of a prism to its loads and cuts by a multifrontal method on LAPACK.

Each node of the plane mesh has 3 (p + 1) unknowns, by axial function, then component. Cuts have the
axial degrees up to q, i.e. the first 3 (q + 1) unknowns of each node. Kept unknowns and loads
remain in the fronts to the end: the remainder of

    [[K_ii, K_ic, F_i], [K_ci, K_cc, F_c], [F_i', F_c', 0]]

is [[S, G], [G', -C_loc]], the input of the ring closure. The eliminated part is positive definite,
so that no pivoting is needed.

Without twist, displacements in the section of even (odd) axial degree are coupled to axial ones of
odd (even) degree only: two problems of half the size. This includes regions of different widths
with a common middle plane.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.linalg.blas import dsyrk, dtrsm
from scipy.linalg.lapack import dpotrf

from flankload.cost import Account
from flankload.elasticity.condensed_sector import CondensedSector
from flankload.elasticity.prism.dissection import Front, dissect

if TYPE_CHECKING:
    from collections.abc import Iterator

    from flankload.base.arrays import Flags, Floats, Numbers
    from flankload.bodies.body import SectorMesh
    from flankload.elasticity.prism.axial_basis import AxialFunctions
    from flankload.elasticity.prism.recovery import Independent, Recovery
    from flankload.elasticity.prism.section_stiffness import SectionStiffness

#: Components of a displacement.
COMPONENTS = 3


def condense_prism(
    section: SectionStiffness,
    axial: AxialFunctions,
    mesh: SectorMesh,
    loads: Floats,
    *,
    cut_degree: int,
    twisted: bool,
    account: Account | None = None,
    recovery: Recovery | None = None,
) -> CondensedSector:
    """Condense a sector to its loads and cuts, with nodes that are fixed over their whole width.

    Parameters
    ----------
    loads : (N, 3 (p + 1), r) array
        Columns by node and unknown, which are also readings.
    cut_degree : int
        Degree q <= p of the displacements of the cuts in z. Their unknowns are by node, axial
        function, component.
    twisted : bool
        False: two problems of half the size if the functions of z are even or odd.
    recovery : Recovery, optional
        Stores the fronts for displacements inside the sector.
    """
    account = Account() if account is None else account
    cut = np.concatenate([mesh.left_nodes, mesh.right_nodes])
    inner = np.ones(section.nodes, dtype=bool)
    inner[cut] = inner[mesh.fixed_nodes] = False
    fronts, position = dissect(
        mesh.nodes,
        [connectivity for _, connectivity in mesh.cells],
        inner=inner,
        kept=cut,
        loaded=np.asarray(loads.any(axis=(1, 2))),
    )
    per_cut = COMPONENTS * (cut_degree + 1)
    count, size = loads.shape[2], cut.size * per_cut
    whole = np.zeros((size + count, size + count))
    products = axial.products(section)
    if recovery is not None:
        recovery.begin(cut, COMPONENTS * axial.count, per_cut)
    problems = _independent(axial.count, coupled=twisted or not axial.symmetric)
    for number, unknowns in enumerate(problems):
        of_cut = unknowns[unknowns < per_cut]
        columns = np.flatnonzero(loads[:, unknowns].any(axis=(0, 1)))
        pair_blocks = _PairBlocks(section, products, unknowns, of_cut, position)
        at = (np.arange(cut.size)[:, None] * per_cut + of_cut).ravel()
        at = np.append(at, size + columns)
        own = loads[:, unknowns][:, :, columns]
        kept = None if recovery is None else recovery.part(fronts, unknowns, of_cut, columns)
        parts = number / len(problems), (number + 1) / len(problems)
        whole[np.ix_(at, at)] += _eliminated(
            fronts, pair_blocks, own, cut.size, account, kept, parts=parts
        )
    if recovery is not None:
        account.workspace_bytes += recovery.bytes
    on_cut = loads[cut][:, :per_cut].reshape(size, count)
    return CondensedSector(
        local=(-whole[size:, size:],),
        carried=(whole[:size, size:] + on_cut,),
        stiffness=whole[:size, :size],
        components=COMPONENTS,
    )


def _independent(functions: int, *, coupled: bool) -> list[Numbers]:
    """Sets of unknowns of a node that are not coupled to each other."""
    unknowns = np.arange(COMPONENTS * functions)
    if coupled:
        return [unknowns]
    function, component = np.divmod(unknowns, COMPONENTS)
    odd = (function + (component == COMPONENTS - 1)) % 2
    return [unknowns[odd == part] for part in (0, 1)]


class _PairBlocks:
    """Blocks of the stiffness between pairs of nodes, expanded from those of the section."""

    def __init__(
        self,
        section: SectionStiffness,
        products: tuple[Numbers, Floats],
        unknowns: Numbers,
        of_cut: Numbers,
        position: Numbers,
    ) -> None:
        self.unknowns, self.of_cut, self.position = unknowns, of_cut, position
        self._section, (self._number, self._terms) = section, products
        row, column = position[section.rows], position[section.columns]
        lower = np.flatnonzero((column >= 0) & (row >= column))
        self._pairs = lower[np.argsort(column[lower], kind="stable")]
        self._first = np.searchsorted(column[self._pairs], np.arange(position.max() + 2))

    def pairs(self, first: int, last: int) -> Numbers:
        """Pairs of nodes in the lower triangle whose columns are in a range of positions."""
        return self._pairs[self._first[first] : self._first[last]]

    def of_one_kind(self, pairs: Numbers) -> Iterator[Flags]:
        """Groups of pairs with the same axial matrices."""
        number = self._number[pairs]
        for one in np.unique(number):
            yield number == one

    def ends(self, pairs: Numbers) -> tuple[Numbers, Numbers]:
        """Rows and columns of pairs."""
        return self._section.rows[pairs], self._section.columns[pairs]

    def blocks(self, pairs: Numbers, rows: Numbers, columns: Numbers) -> Floats:
        """Stiffness (n, rows, columns) between unknowns of pairs with the same axial matrices."""
        (a, c), (b, d) = (np.divmod(part, COMPONENTS) for part in (rows, columns))
        of_section = self._section.blocks[pairs]
        weights = self._terms[self._number[pairs[0]]][:, a[:, None], b]
        total = np.zeros((pairs.size, rows.size, columns.size))
        for term in range(4):
            total += of_section[:, term, c[:, None], d] * weights[term]
        return total


@dataclass(frozen=True, eq=False)
class _Remainder:
    """Remainder of a front: lower triangle of the matrix of its boundary nodes, then loads."""

    front: Front
    sizes: Numbers
    matrix: Floats


def _eliminated(
    fronts: list[Front],
    pair_blocks: _PairBlocks,
    loads: Floats,
    cuts: int,
    account: Account,
    kept: Independent | None,
    *,
    parts: tuple[float, float],
) -> Floats:
    """Symmetric matrix (m, m) of `cuts` kept nodes, in their order, and loads after elimination.

    `parts` of the work of a body are done before and after it.
    """
    left: dict[int, _Remainder] = {}
    bytes_held = most = 0
    work = np.cumsum([front.own.size * (front.own.size + front.rest.size) ** 2 for front in fronts])
    done = parts[0] + (parts[1] - parts[0]) * work / work[-1]
    for number, front in enumerate(fronts):
        joined = [left.pop(part) for part in front.parts]
        left[number], factor, below = _front_remainder(front, joined, pair_blocks, loads)
        account.report(float(done[number]))
        if kept is not None:
            kept.keep(number, front, factor, below)
        bytes_held += left[number].matrix.nbytes
        most = max(most, bytes_held)
        bytes_held -= sum(part.matrix.nbytes for part in joined)
    account.count(fe_factorisations=1)
    account.workspace_bytes += most
    (last,) = left.values()
    n, first = pair_blocks.of_cut.size, int(pair_blocks.position.max()) + 1 - cuts
    matrix = np.zeros((cuts * n + loads.shape[2],) * 2)
    place = (pair_blocks.position[last.front.rest] - first)[:, None] * n + np.arange(n)
    at = np.append(place.ravel(), cuts * n + np.arange(loads.shape[2]))
    matrix[np.ix_(at, at)] = last.matrix
    pairs = pair_blocks.pairs(first, first + cuts)
    row, column = (pair_blocks.position[part] - first for part in pair_blocks.ends(pairs))
    between = matrix[: cuts * n, : cuts * n].reshape(cuts, n, cuts, n)
    for some in pair_blocks.of_one_kind(pairs):
        blocks = pair_blocks.blocks(pairs[some], pair_blocks.of_cut, pair_blocks.of_cut)
        between[row[some], :, column[some]] += blocks
    return np.tril(matrix) + np.tril(matrix, -1).T


def _front_remainder(
    front: Front, parts: list[_Remainder], pair_blocks: _PairBlocks, loads: Floats
) -> tuple[_Remainder, Floats, Floats]:
    """Assemble a front and eliminate its nodes: remainder, factor, rows below the factor."""
    n, m = pair_blocks.unknowns.size, pair_blocks.of_cut.size
    width = loads.shape[2] if front.loaded else 0
    own = front.own.size * n
    sizes = np.where(np.arange(front.rest.size) < front.inner, n, m)
    rest = int(sizes.sum()) + width
    pivot = np.zeros((own, own), order="F")
    below = np.zeros((rest, own), order="F")
    remainder = np.zeros((rest, rest), order="F")
    if front.own.size:
        _assemble(front, pair_blocks, pivot, below)
        if front.loaded:
            below[rest - width :] = loads[front.own].reshape(own, width).T
    for part in parts:
        _extend(front, sizes, n, part, (pivot, below, remainder))
    if front.own.size:
        pivot, failed = dpotrf(pivot, lower=1, clean=0, overwrite_a=1)
        assert not failed, "stiffness of a sector: expected positive definite"
        if rest:
            below = dtrsm(1.0, pivot, below, side=1, lower=1, trans_a=1, overwrite_b=1)
            remainder = dsyrk(-1.0, below, beta=1.0, c=remainder, lower=1, overwrite_c=1)
    sizes = np.append(sizes, width) if width else sizes
    return _Remainder(front, sizes, remainder), pivot, below


def _assemble(front: Front, pair_blocks: _PairBlocks, pivot: Floats, below: Floats) -> None:
    """Stiffness of the nodes of a front, and between them and its boundary."""
    n, m, count = pair_blocks.unknowns.size, pair_blocks.of_cut.size, front.own.size
    first = int(pair_blocks.position[front.own[0]])
    pairs = pair_blocks.pairs(first, first + count)
    rows, columns = pair_blocks.ends(pairs)
    column = pair_blocks.position[columns] - first
    row = pair_blocks.position[rows] - first
    place = np.full(pair_blocks.position.size, -1)
    place[front.rest] = np.arange(front.rest.size)
    at, inner = place[rows], front.inner
    own = pivot.reshape((n, count, n, count), order="F")
    later = below[: inner * n].reshape((n, inner, n, count), order="F")
    cuts = front.rest.size - inner
    kept = below[inner * n : inner * n + cuts * m].reshape((m, cuts, n, count), order="F")
    of_one_kind = list(pair_blocks.of_one_kind(pairs))
    for target, goal, chosen, unknowns in (
        (own, row, row < count, pair_blocks.unknowns),
        (later, at, (row >= count) & (at < inner), pair_blocks.unknowns),
        (kept, at - inner, (row >= count) & (at >= inner), pair_blocks.of_cut),
    ):
        for some in of_one_kind:
            both = some & chosen
            if both.any():
                blocks = pair_blocks.blocks(pairs[both], unknowns, pair_blocks.unknowns)
                target[:, goal[both], :, column[both]] += blocks


def _extend(
    front: Front, sizes: Numbers, n: int, part: _Remainder, target: tuple[Floats, Floats, Floats]
) -> None:
    """Add the remainder of a part, in blocks of unknowns that are adjacent in both."""
    pivot, below, remainder = target
    nodes = part.front.rest
    own = len(pivot)
    start = own + np.concatenate([[0], np.cumsum(sizes)])
    at = dict(zip(front.own.tolist(), range(0, own, n), strict=True))
    at |= dict(zip(front.rest.tolist(), start[:-1].tolist(), strict=True))
    ends = np.cumsum(part.sizes)
    runs: list[list[int]] = []  # first in the part, first in the front, length
    goal = [at[node] for node in nodes.tolist()]
    if part.sizes.size > nodes.size:  # loads are last
        goal.append(int(start[-1]))
    for first, last, place in zip(ends - part.sizes, ends, goal, strict=True):
        if runs and runs[-1][1] + runs[-1][2] == place and (place != own):
            runs[-1][2] += last - first
        else:
            runs.append([first, place, last - first])
    for j, (from_j, to_j, long_j) in enumerate(runs):
        for from_i, to_i, long_i in runs[j:]:
            block = part.matrix[from_i : from_i + long_i, from_j : from_j + long_j]
            if to_j >= own:
                goal_block = remainder[to_i - own :, to_j - own :]
            elif to_i >= own:
                goal_block = below[to_i - own :, to_j:]
            else:
                goal_block = pivot[to_i:, to_j:]
            goal_block[:long_i, :long_j] += block
