"""Displacements inside a condensed mesh by back substitution in stored fronts.

A front with the factor L of its unknowns and the rows B L'⁻¹ below it, with B for its boundary x_b
and the load columns, gives

    x = L'⁻¹ (y - (B L'⁻¹)' [x_b, -c]),   y = L⁻¹ f                                        (R5)

for loads with the factors c and forces f on its nodes, reduced by the previous fronts.
Displacements of a few nodes require their fronts and all later ones on the way to the cuts.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from flankload import _core
from flankload.base.blas_threads import one_blas_thread

if TYPE_CHECKING:
    from flankload.base.arrays import Floats, Numbers
    from flankload.elasticity.condensed_sector import CondensedSector
    from flankload.elasticity.fronts.dissection import Dissection
    from flankload.elasticity.fronts.elimination import Elimination, Problem


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
            needed[:] = [np.isin(front.own, self._nodes).any() for front in fronts]
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
            problem, inner = part.problem, self._inner(part)
            own = np.flatnonzero((problem.columns >= first) & (problem.columns < last))
            x = np.zeros((int(problem.base[-1]), own.size))
            x[problem.first_load + own, np.arange(own.size)] = -1.0
            self._substitute(part, x)
            moved = x[: self._kept(problem).start].reshape(
                inner.size, problem.unknowns.size, own.size
            )
            at = np.ix_(inner, problem.unknowns, problem.columns[own] - first)
            found[at] = moved.reshape(inner.size, problem.unknowns.size, own.size)
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

        Returns y of (R5) by part, and the forces (2 m, r) on the cuts, as in `CondensedSector`.
        """
        found, r = [], forces.shape[2]
        carried = np.zeros((self._cut.size, self._per_cut, r))
        for part in self._parts:
            problem, kept = part.problem, self._kept(part.problem)
            y = np.zeros((int(problem.base[-1]), r))
            of_inner = forces[self._inner(part)][:, problem.unknowns]
            y[: kept.start] = of_inner.reshape(-1, r)
            y[kept] = forces[self._cut][:, problem.of_kept].reshape(-1, r)
            for each in part.fronts:
                own = np.asfortranarray(y[each.first : each.last])
                _core.flankload_front_solve(0, each.factor, own)
                y[each.first : each.last] = own
                y[each.rest] -= each.below @ own
            carried[:, problem.of_kept] = y[kept].reshape(self._cut.size, problem.of_kept.size, r)
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
            problem, inner = part.problem, self._inner(part)
            x = np.zeros((int(problem.base[-1]), r))
            x[: len(forces)] = forces
            x[self._kept(problem)] = of_cuts[:, problem.of_kept].reshape(-1, r)
            self._substitute(part, x)
            own = x[: len(forces)].reshape(inner.size, problem.unknowns.size, r)
            found[inner[:, None], problem.unknowns] = own
        return found

    @staticmethod
    def _inner(part: Elimination) -> Numbers:
        """Eliminated nodes in their order."""
        return part.order.order[: part.order.inner]

    @staticmethod
    def _kept(problem: Problem) -> slice:
        """Unknowns of the cuts."""
        return slice(int(problem.base[problem.inner]), problem.first_load)

    @staticmethod
    def _substitute(part: Elimination, x: Floats) -> None:
        """Solve (R5) in place: known displacements of the cuts, -c of the loads, y of the rest."""
        for each in reversed(part.fronts):
            own = np.asfortranarray(x[each.first : each.last] - each.below.T @ x[each.rest])
            _core.flankload_front_solve(1, each.factor, own)
            x[each.first : each.last] = own
