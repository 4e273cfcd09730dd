"""Elimination of the inner nodes of a mesh front by front, in the core (multifrontal Cholesky).

The unknowns of a problem are numbered in the order of elimination, followed by those of the kept
nodes and by the columns of loads: the remainder of

    [[K_ii, K_ic, F_i], [K_ci, K_cc, F_c], [F_i', F_c', 0]]

is [[S, G], [G', -C_loc]]. The eliminated part is positive definite, so that no pivoting is needed.
A front has the columns of the loads on nodes that are eliminated in it or before it. Of a symmetric
mesh, the first half and then the axis are eliminated (`mirror`): the columns of loads are followed
by those of the reflected loads on the second half.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from flankload import _core
from flankload.errors import MeshError

if TYPE_CHECKING:
    from flankload.base.arrays import Floats, Numbers
    from flankload.cost import Account
    from flankload.elasticity.finite_elements import SectionStiffness
    from flankload.elasticity.fronts.dissection import Dissection
    from flankload.elasticity.fronts.problem import Problem


@dataclass(frozen=True, eq=False)
class EliminatedFront:
    """Factor of a front.

    Attributes
    ----------
    first, last : int
        Range of the unknowns that it eliminates.
    rest : (r,) array
        Unknowns and columns of loads below these.
    factor : (o, o) array
        Lower triangle L.
    below : (r, o) array
        Rows of `rest` times L'⁻¹.
    """

    first: int
    last: int
    rest: Numbers
    factor: Floats
    below: Floats


@dataclass(eq=False)
class Elimination:
    """Elimination of the fronts of one problem.

    Attributes
    ----------
    parts : (float, float)
        Parts of the work of a body that are done before and after it.
    kept : set of int
        Fronts to be stored.
    fronts : list of EliminatedFront
        Stored fronts, in the order of elimination.
    """

    order: Dissection
    problem: Problem
    stiffness: PairStiffness
    account: Account
    parts: tuple[float, float]
    kept: frozenset[int] = frozenset()
    fronts: list[EliminatedFront] = field(default_factory=list)

    def remainder(self) -> Floats:
        """Symmetric matrix of the kept nodes and the columns of loads after the elimination."""
        order, problem = self.order, self.problem
        left: dict[int, tuple[Numbers, Floats]] = {}
        held = most = 0
        sizes = [(front.own.size, front.rest.size) for front in order.fronts]
        work = np.cumsum([own * (own + rest) ** 2 for own, rest in sizes])
        done = self.parts[0] + (self.parts[1] - self.parts[0]) * work / work[-1]
        for number, front in enumerate(order.fronts):
            joined = [left.pop(part) for part in front.parts]
            if problem.halves > 1 and number + 1 == len(order.fronts):
                joined = self._halves(*joined[0])
            left[number] = self._eliminated(number, joined)
            self.account.report(float(done[number]))
            held += left[number][1].nbytes
            most = max(most, held)
            held -= sum(matrix.nbytes for _, matrix in joined)
        self.account.count(fe_factorisations=1)
        self.account.workspace_bytes += most
        ((rest, matrix),) = left.values()
        first = int(problem.base[order.inner])
        size = problem.first_load + problem.columns.size - first
        whole = np.zeros((size, size), order="F")
        whole[np.ix_(rest - first, rest - first)] = matrix
        self.stiffness.add(order.inner, order.order.size, _Rows(first, len(whole)), whole)
        return np.tril(whole) + np.tril(whole, -1).T

    def _halves(self, known: Numbers, matrix: Floats) -> list[tuple[Numbers, Floats]]:
        """Unknowns and remainders of both halves from those of the first one."""
        problem = self.problem
        own, images = problem.boundary()
        count = int(np.searchsorted(known, problem.first_load + problem.columns.size))
        at = np.append(np.arange(own.size), np.arange(count, known.size))
        image = matrix[np.ix_(at, at)]
        if problem.mixes:  # else the lower triangle suffices
            image = np.tril(image) + np.tril(image, -1).T
        for _ in range(2):  # rows, then columns
            image[: own.size] = problem.reflected(image[: own.size], problem.on_axis)
            image = image.T
        columns = known[count:] - problem.columns.size
        return [
            (known[:count], matrix[:count, :count]),
            (np.append(images, columns), np.asfortranarray(image)),
        ]

    def _eliminated(
        self, number: int, joined: list[tuple[Numbers, Floats]]
    ) -> tuple[Numbers, Floats]:
        """Assemble a front and eliminate its nodes: unknowns of the remainder, and remainder."""
        front, problem = self.order.fronts[number], self.problem
        positions = self.order.position
        start = int(positions[front.own[0]]) if front.own.size else 0
        loaded, forces = problem.forces(start, start + front.own.size)
        columns = loaded
        for known, _ in joined:
            columns = np.union1d(columns, known[known >= problem.first_load])
        rest = np.append(problem.numbers(positions[front.rest]), columns)
        size = max(1, rest.size)  # f2py takes no empty arrays
        remainder = np.zeros((size, size), order="F")
        if not front.own.size:  # parts that share no nodes
            for known, matrix in joined:
                place = np.searchsorted(rest, known)
                remainder[np.ix_(place, place)] += matrix
            return rest, remainder[: rest.size, : rest.size]
        own = front.own.size * problem.unknowns.size
        first = int(problem.base[start])
        pivot = np.zeros((own, own), order="F")
        below = np.zeros((size, own), order="F")
        rows = _Rows(first, own, rest)
        self.stiffness.add(start, start + front.own.size, rows, pivot, below)
        below[np.searchsorted(rest, loaded)] = forces.T
        for known, matrix in joined:
            if known.size:
                place = rows.places(known) + 1
                _core.flankload_front_extend(place, matrix, pivot, below, remainder)
        if _core.flankload_front_eliminate(pivot, below, remainder):
            raise MeshError(
                key="mesh",
                expected="elements whose held nodes permit no motion",
                found="a stiffness that is not positive definite",
            )
        below = below[: rest.size]
        if number in self.kept:
            self.fronts.append(EliminatedFront(first, first + own, rest, pivot, below))
        return rest, remainder[: rest.size, : rest.size]


@dataclass(frozen=True, eq=False)
class _Rows:
    """Rows of a front: a range of unknowns, then others in ascending order."""

    first: int
    own: int
    rest: Numbers | None = None

    def places(self, numbers: Numbers) -> Numbers:
        """Rows of unknowns."""
        places = numbers - self.first
        if self.rest is None:
            return places
        return np.where(places < self.own, places, self.own + np.searchsorted(self.rest, numbers))


class PairStiffness:
    """Stiffness between pairs of nodes, by blocks of a section and axial matrices.

    Parameters
    ----------
    products : ((n,) array, (k, t, p + 1, p + 1) array)
        Axial matrices of each pair: `AxialFunctions.products`.
    """

    def __init__(
        self,
        section: SectionStiffness,
        products: tuple[Numbers, Floats],
        order: Dissection,
        problem: Problem,
    ) -> None:
        row, column = order.position[section.rows], order.position[section.columns]
        lower = np.flatnonzero((column >= 0) & (row >= column))
        lower = lower[np.argsort(column[lower], kind="stable")]
        self._first = np.searchsorted(column[lower], np.arange(order.order.size + 1))
        size = np.diff(problem.base)
        self._rows, self._columns = problem.base[row[lower]], problem.base[column[lower]]
        self._sizes = np.stack([size[row[lower]], size[column[lower]]])
        self._pair, self._kind = lower + 1, products[0][lower] + 1
        self._blocks, self._terms = section.blocks.T, products[1][:, : section.blocks.shape[1]].T
        function, component = np.divmod(problem.unknowns, section.components)
        self._unknowns = np.stack([function, component]) + 1

    def add(
        self,
        first: int,
        last: int,
        rows: _Rows,
        pivot: Floats,
        below: Floats | None = None,
    ) -> None:
        """Add the stiffness of pairs whose columns are in a range of positions to a front."""
        some = slice(self._first[first], self._first[last])
        if some.start == some.stop:
            return
        _core.flankload_front_stiffness(
            self._unknowns,
            rows.places(self._rows[some]),
            rows.places(self._columns[some]),
            self._sizes[:, some],
            self._pair[some],
            self._kind[some],
            self._blocks,
            self._terms,
            pivot,
            np.zeros((1, len(pivot)), order="F") if below is None else below,
        )
