"""Displacements inside a condensed mesh by back substitution in stored fronts.

A front with the factor L of its unknowns and the rows B L'⁻¹ below it, with B for its boundary x_b
and the load columns, gives

    x = L'⁻¹ (y - (B L'⁻¹)' [x_b, -c]),   y = L⁻¹ f                                        (R5)

for loads with the factors c and forces f on its nodes, reduced by the previous fronts.
Displacements of a few nodes require their fronts and all later ones on the way to the cuts. Those
of the second half of a symmetric mesh are those of the first half under reflected forces and
boundary displacements, in further columns.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from flankload import _core
from flankload.base.blas_threads import one_blas_thread

if TYPE_CHECKING:
    from collections.abc import Iterator

    from flankload.base.arrays import Floats, Numbers
    from flankload.elasticity.condensed_sector import CondensedSector
    from flankload.elasticity.fronts.dissection import Dissection
    from flankload.elasticity.fronts.elimination import EliminatedFront, Elimination
    from flankload.elasticity.fronts.problem import Problem


class Recovery:
    """Stored fronts of a condensation, and displacements from them.

    Parameters
    ----------
    nodes : (k,) array, optional
        Nodes whose displacements are needed; default: all.
    """

    def __init__(self, nodes: Numbers | None = None) -> None:
        self._nodes = nodes
        self._parts: list[Elimination] = []
        self._cut = np.zeros(0, dtype=np.int64)
        self._unknowns = self._per_cut = 0
        self.needed: frozenset[int] = frozenset()

    @property
    def bytes(self) -> int:
        """Size of the stored fronts."""
        return sum(
            each.factor.nbytes + each.below.nbytes for part in self._parts for each in part.fronts
        )

    def begin(self, order: Dissection, cut: Numbers, unknowns: int, per_cut: int) -> None:
        """Begin a condensation to nodes of cuts, with numbers of unknowns per node."""
        self._cut, self._unknowns, self._per_cut = cut, unknowns, per_cut
        fronts = order.fronts
        needed = np.ones(len(fronts), dtype=bool)
        if self._nodes is not None:
            nodes = self._nodes
            if order.images is not None:
                nodes = np.append(nodes, np.flatnonzero(np.isin(order.images, nodes)))
            needed[:] = [np.isin(front.own, nodes).any() for front in fronts]
            after = {part: number for number, front in enumerate(fronts) for part in front.parts}
            for number in range(len(fronts)):
                if needed[number] and number in after:
                    needed[after[number]] = True
        self.needed = frozenset(np.flatnonzero(needed).tolist())

    def add(self, part: Elimination) -> None:
        """Add the stored fronts of a set of unknowns."""
        self._parts.append(part)

    @one_blas_thread()
    def under_loads(self, nodes: int, first: int, last: int) -> Floats:
        """Displacements (N, u, r) of all nodes under unit loads first ... last - 1, fixed cuts."""
        found = np.zeros((nodes, self._unknowns, last - first))
        for part in self._parts:
            problem = part.problem
            own = np.flatnonzero((problem.columns >= first) & (problem.columns < last))
            x = np.zeros((int(problem.base[-1]), problem.halves * own.size))
            x[problem.first_load + own, np.arange(own.size)] = -1.0
            for inner, moved in _substituted(part, x):
                found[np.ix_(inner, problem.unknowns, problem.columns[own] - first)] = moved
        return found

    def read(self, sector: CondensedSector, columns: Floats, moved: Floats) -> CondensedSector:
        """The sector with a further kind of reading: columns (N, u, r) for all displacements.

        `moved` (N, u, p): those under the loads of the sector, with fixed cuts.
        """
        r = columns.shape[2]
        local = columns.reshape(-1, r).T @ moved.reshape(-1, moved.shape[2])
        carried = np.zeros((0, r))
        if self._cut.size:
            _, carried = self.reduced(columns)
        return replace(sector, local=(*sector.local, local), carried=(*sector.carried, carried))

    @one_blas_thread()
    def reduced(self, forces: Floats) -> tuple[list[Floats], Floats]:
        """Reduce forces (N, u, r) on all nodes; those on fixed nodes are ignored.

        Returns y of (R5) by part, followed by that of the second half in further columns, and the
        forces (2 m, r) on the cuts, as in `CondensedSector`.
        """
        found, r = [], forces.shape[2]
        carried = np.zeros((self._cut.size, self._per_cut, r))
        for part in self._parts:
            problem, kept = part.problem, _kept(part.problem)
            y = np.zeros((int(problem.base[-1]), problem.halves * r))
            for side, nodes in enumerate(problem.nodes()):
                own = forces[nodes][:, problem.unknowns].reshape(-1, r)
                own = problem.reflected(own, nodes.size) if side else own
                y[: len(own), side * r : (side + 1) * r] = own
            y[kept, :r] = forces[self._cut][:, problem.of_kept].reshape(-1, r)
            half, axis = _sides(part)
            _forward(half, y)
            if problem.halves > 1:
                boundary, images = problem.boundary()
                y[images, :r] += problem.reflected(y[boundary, r:], problem.on_axis)
            _forward(axis, y[:, :r])
            of_cuts = y[kept, :r].reshape(self._cut.size, problem.of_kept.size, r)
            carried[:, problem.of_kept] = of_cuts
            found.append(y[: kept.start])
        return found, carried.reshape(-1, r)

    @one_blas_thread()
    def displacements(self, kept: list[Floats], on_cuts: Floats, nodes: int) -> Floats:
        """Displacements (N, u, r) of all nodes; 0 at fixed ones.

        From the reduced forces and the displacements (2 m, r) of the cuts.
        """
        r = on_cuts.shape[1]
        found = np.zeros((nodes, self._unknowns, r))
        of_cuts = on_cuts.reshape(self._cut.size, self._per_cut, r)
        found[self._cut, : self._per_cut] = of_cuts
        for part, forces in zip(self._parts, kept, strict=True):
            problem = part.problem
            x = np.zeros((int(problem.base[-1]), forces.shape[1]))
            x[: len(forces)] = forces
            x[_kept(problem), :r] = of_cuts[:, problem.of_kept].reshape(-1, r)
            for inner, moved in _substituted(part, x):
                found[inner[:, None], problem.unknowns] = moved
        return found


def _kept(problem: Problem) -> slice:
    """Unknowns of the cuts."""
    return slice(int(problem.base[problem.order.inner]), problem.first_load)


def _sides(part: Elimination) -> tuple[list[EliminatedFront], list[EliminatedFront]]:
    """Stored fronts of the first half (all without symmetry), and of the axis."""
    first = part.problem.base[part.order.half]
    half = [each for each in part.fronts if each.first < first]
    return half, part.fronts[len(half) :]


def _forward(fronts: list[EliminatedFront], y: Floats) -> None:
    """Reduce forces y by fronts in place."""
    for each in fronts:
        own = np.asfortranarray(y[each.first : each.last])
        _core.flankload_front_solve(0, each.factor, own)
        y[each.first : each.last] = own
        y[each.rest] -= each.below @ own


def _backward(fronts: list[EliminatedFront], x: Floats) -> None:
    """Solve (R5) in place: known displacements of the boundary, -c of the loads, y of the rest."""
    for each in reversed(fronts):
        own = np.asfortranarray(x[each.first : each.last] - each.below.T @ x[each.rest])
        _core.flankload_front_solve(1, each.factor, own)
        x[each.first : each.last] = own


def _substituted(part: Elimination, x: Floats) -> Iterator[tuple[Numbers, Floats]]:
    """Nodes and their displacements (i, n, r) from x of (R5), which changes, by side."""
    problem = part.problem
    r, loads = x.shape[1] // problem.halves, problem.first_load
    half, axis = _sides(part)
    _backward(axis, x[:, :r])
    if problem.halves > 1:
        boundary, images = problem.boundary()
        x[boundary, r:] = problem.reflected(x[images, :r], problem.on_axis)
        x[loads + problem.columns.size :, r:] = x[loads : loads + problem.columns.size, :r]
    _backward(half, x)
    for side, nodes in enumerate(problem.nodes()):
        own = x[: nodes.size * problem.unknowns.size, side * r : (side + 1) * r]
        own = problem.reflected(own, nodes.size) if side else own
        yield nodes, own.reshape(nodes.size, problem.unknowns.size, r)
