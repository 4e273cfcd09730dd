"""Unknowns and loads of a mesh in the order of elimination, and their reflection."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from flankload.base.arrays import Flags, Floats, Numbers
    from flankload.elasticity.fronts.dissection import Dissection


@dataclass(frozen=True, eq=False)
class Problem:
    """Unknowns of the nodes of a mesh that are not coupled to others, and their loads.

    Attributes
    ----------
    unknowns, of_kept : (n,), (m,) arrays
        Unknowns of an inner node; the first of these, which a kept node has.
    columns : (k,) array
        Columns of loads that are not 0.
    loads : (N, u, r) array
        All loads, by node and unknown.
    loaded : (N,) array of bool
        Nodes with loads.
    base : (P + 2,) array
        First unknown of each position in the order of elimination, then that of the loads, then
        the number of all.
    order : Dissection
    turn : (n, n) array or None
        Reflection of the unknowns of a node, for a symmetric mesh.
    """

    unknowns: Numbers
    of_kept: Numbers
    columns: Numbers
    loads: Floats
    loaded: Flags
    base: Numbers
    order: Dissection
    turn: Floats | None

    @classmethod
    def of(
        cls, order: Dissection, unknowns: Numbers, per_kept: int, loads: Floats, turn: Floats | None
    ) -> Problem:
        """Problem of a set of unknowns of each node; loads (N, u, r) and `turn` (u, u) of all."""
        loaded = np.asarray(loads.any(axis=(1, 2)))
        columns = np.flatnonzero(loads[loaded][:, unknowns].any(axis=(0, 1)))
        of_kept = unknowns[unknowns < per_kept]
        sizes = np.full(order.order.size + 2, unknowns.size)
        sizes[0] = 0
        sizes[order.inner + 1 : -1] = of_kept.size
        sizes[-1] = columns.size if turn is None else 2 * columns.size
        turn = None if turn is None else turn[np.ix_(unknowns, unknowns)]
        return cls(unknowns, of_kept, columns, loads, loaded, np.cumsum(sizes), order, turn)

    def forces(self, first: int, last: int) -> tuple[Numbers, Floats]:
        """Loads on a range of positions: their columns (k,) that are not 0, and forces (o, k)."""
        found, numbers = [], []
        for side, nodes in enumerate(self.nodes()):
            nodes = nodes[first:last]
            if not self.loaded[nodes].any():
                continue
            own = self.loads[np.ix_(nodes, self.unknowns, self.columns)]
            own = own.reshape(nodes.size * self.unknowns.size, self.columns.size)
            own = self.reflected(own, nodes.size) if side else own
            some = np.flatnonzero(own.any(axis=0))
            numbers.append(self.first_load + side * self.columns.size + some)
            found.append(own[:, some])
        if not found:
            return self.columns[:0], np.zeros(((last - first) * self.unknowns.size, 0))
        return np.concatenate(numbers), np.hstack(found)

    @property
    def first_load(self) -> int:
        """Number of the first column of loads among the unknowns."""
        return int(self.base[-2])

    def numbers(self, positions: Numbers) -> Numbers:
        """Unknowns of positions, in their order."""
        first, last = self.base[positions], self.base[positions + 1]
        return _ranges(first, last - first)

    @property
    def halves(self) -> int:
        """2 for a symmetric mesh, else 1."""
        return 1 if self.turn is None else 2

    def nodes(self) -> list[Numbers]:
        """Eliminated nodes in their order, then the images of those of the first half."""
        return [self.order.order[: self.order.inner], self.order.second][: self.halves]

    @property
    def on_axis(self) -> int:
        """Number of nodes on the axis of symmetry that are eliminated."""
        return self.order.inner - self.order.half

    def boundary(self) -> tuple[Numbers, Numbers]:
        """Unknowns of the boundary of the first half, and their images."""
        images, rest = self.order.images, self.order.fronts[-2].rest
        assert images is not None
        positions = self.order.position
        return self.numbers(positions[rest]), self.numbers(positions[images[rest]])

    @property
    def mixes(self) -> bool:
        """Whether a reflection combines components, rather than changing signs."""
        return self.turn is not None and bool((self.turn != np.diag(np.diagonal(self.turn))).any())

    def reflected(self, values: Floats, inner: int) -> Floats:
        """Reflected values by unknown and column of `inner` eliminated nodes, then of kept ones."""
        assert self.turn is not None
        n, m = self.unknowns.size, self.of_kept.size
        kept = (len(values) - inner * n) // m
        signs = np.diagonal(self.turn)
        found = values * np.concatenate([np.tile(signs, inner), np.tile(signs[:m], kept)])[:, None]
        if self.mixes:  # each unknown with one other one of its node
            other = self.turn - np.diag(signs)
            partner = np.abs(other).argmax(axis=1)
            part = other[np.arange(n), partner]
            first = n * np.arange(inner)[:, None] + partner
            then = inner * n + m * np.arange(kept)[:, None] + partner[:m]
            rows = np.concatenate([first.ravel(), then.ravel()])
            parts = np.concatenate([np.tile(part, inner), np.tile(part[:m], kept)])
            found += parts[:, None] * values[rows]
        return found


def _ranges(first: Numbers, sizes: Numbers) -> Numbers:
    """Consecutive numbers from each of `first`, joined."""
    ends = np.cumsum(sizes)
    total = int(ends[-1]) if ends.size else 0
    return np.arange(total) + np.repeat(first - ends + sizes, sizes)
