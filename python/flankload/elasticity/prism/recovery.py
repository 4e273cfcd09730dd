"""Displacements inside a condensed sector of a prism by back substitution in stored fronts.

A front with the factor L of its nodes and the rows B L'⁻¹ below it, with B for its boundary x_b and
the load columns, gives

    x = L'⁻¹ (y - (B L'⁻¹)' [x_b, -c]),   y = L⁻¹ f                                        (R5)

for loads with the factors c and forces f on its nodes, reduced by the previous fronts.
Displacements of a few nodes require their fronts and all later ones on the way to the cuts.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from scipy.linalg.blas import dtrsm

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flankload.base.arrays import Flags, Floats, Numbers
    from flankload.elasticity.prism.dissection import Front


@dataclass(frozen=True, eq=False)
class KeptFront:
    """An eliminated front.

    Attributes
    ----------
    factor : (o, o) array
        Lower triangle L.
    below : (r, o) array
        Rows of the boundary, then of the loads, times L'⁻¹.
    """

    front: Front
    factor: Floats
    below: Floats


@dataclass(eq=False)
class Independent:
    """Fronts of a set of unknowns of the nodes that is not coupled to others.

    Attributes
    ----------
    unknowns, of_cut : (n,), (m,) arrays
        Unknowns of an inner node, and of a node of a cut.
    columns : (k,) array
        Load columns that are not 0 in this set.
    needed : (f,) array of bool
        Fronts to be stored, in the order of elimination.
    """

    unknowns: Numbers
    of_cut: Numbers
    columns: Numbers
    needed: Flags
    fronts: list[KeptFront] = field(default_factory=list)

    def keep(self, number: int, front: Front, factor: Floats, below: Floats) -> None:
        """Store a front, if needed."""
        if self.needed[number] and front.own.size:
            self.fronts.append(KeptFront(front, factor, below))


class Recovery:
    """Stored fronts of a condensation, and displacements from them.

    Parameters
    ----------
    nodes : (k,) array, optional
        Nodes whose displacements are needed; default: all.
    """

    def __init__(self, nodes: Numbers | None = None) -> None:
        self._nodes = nodes
        self._parts: list[Independent] = []
        self._cut = np.zeros(0, dtype=np.int64)
        self._unknowns = self._per_cut = 0

    @property
    def bytes(self) -> int:
        """Size of the stored fronts."""
        return sum(
            kept.factor.nbytes + kept.below.nbytes for part in self._parts for kept in part.fronts
        )

    def begin(self, cut: Numbers, unknowns: int, per_cut: int) -> None:
        """Begin a condensation to nodes of cuts, with numbers of unknowns per node."""
        self._cut, self._unknowns, self._per_cut = cut, unknowns, per_cut

    def part(
        self, fronts: Sequence[Front], unknowns: Numbers, of_cut: Numbers, columns: Numbers
    ) -> Independent:
        """Add a set of unknowns whose fronts are to be stored."""
        needed = np.ones(len(fronts), dtype=bool)
        if self._nodes is not None:
            for number in range(len(fronts) - 1, -1, -1):
                needed[number] = bool(np.isin(fronts[number].own, self._nodes).any())
            after = {part: number for number, front in enumerate(fronts) for part in front.parts}
            for number in range(len(fronts)):
                if needed[number] and number in after:
                    needed[after[number]] = True
        self._parts.append(Independent(unknowns, of_cut, columns, needed))
        return self._parts[-1]

    def unit_displacements(self, nodes: Numbers, loads: int) -> tuple[Floats, Floats]:
        """Displacements of nodes (k,) under unit loads and under unit displacements of the cuts.

        By loads (k, 3 (p + 1), loads) with fixed cuts; by cuts (k, 3 (p + 1), 2 m) without loads,
        with unknowns of the cuts as in `CondensedSector`.
        """
        cuts, per_cut = self._cut.size, self._per_cut
        by_loads = np.zeros((nodes.size, self._unknowns, loads))
        by_cuts = np.zeros((nodes.size, self._unknowns, cuts * per_cut))
        for part in self._parts:
            m, columns = part.of_cut.size, part.columns.size
            on_cuts = np.zeros((cuts, m, cuts * m + columns))
            on_cuts[..., : cuts * m] = np.eye(cuts * m).reshape(cuts, m, -1)
            factors = np.eye(columns, cuts * m + columns, cuts * m)
            moved = self._substituted(part, on_cuts, factors)
            found = np.zeros((nodes.size, part.unknowns.size, cuts * m + columns))
            for k, node in enumerate(nodes.tolist()):
                found[k, : len(moved[node])] = moved[node]
            at = (np.arange(cuts)[:, None] * per_cut + part.of_cut).ravel()
            by_cuts[:, part.unknowns[:, None], at] = found[..., : cuts * m]
            by_loads[:, part.unknowns[:, None], part.columns] = found[..., cuts * m :]
        return by_loads, by_cuts

    def reduced(self, forces: Floats) -> tuple[list[list[Floats]], Floats]:
        """Reduce forces (N, 3 (p + 1), r) on all nodes; those on fixed nodes are ignored.

        Returns y of (R5), by part and front, and the forces (2 m, r) on the cuts, as in
        `CondensedSector`.
        """
        kept, r = [], forces.shape[2]
        carried = np.zeros((self._cut.size, self._per_cut, r))
        for part in self._parts:
            left = forces[:, part.unknowns].copy()
            of_front = []
            for each in part.fronts:
                own = left[each.front.own].reshape(-1, r)
                own = dtrsm(1.0, each.factor, own, lower=1)
                of_front.append(own)
                change = each.below @ own
                for node, rows in _rows(each.front, part):
                    left[node, : rows.stop - rows.start] -= change[rows]
            kept.append(of_front)
            carried[:, part.of_cut] = left[self._cut][:, : part.of_cut.size]
        return kept, carried.reshape(-1, r)

    def displacements(self, kept: list[list[Floats]], on_cuts: Floats, nodes: int) -> Floats:
        """Displacements (N, 3 (p + 1), r) of all nodes; 0 at fixed ones.

        From the reduced forces and the displacements (2 m, r) of the cuts.
        """
        r = on_cuts.shape[1]
        found = np.zeros((nodes, self._unknowns, r))
        of_cuts = on_cuts.reshape(self._cut.size, self._per_cut, r)
        for part, forces in zip(self._parts, kept, strict=True):
            moved = self._substituted(part, of_cuts[:, part.of_cut], None, forces)
            for node, values in moved.items():
                found[node, part.unknowns[: len(values)]] = values
        return found

    def _substituted(
        self,
        part: Independent,
        on_cuts: Floats,
        factors: Floats | None,
        forces: list[Floats] | None = None,
    ) -> dict[int, Floats]:
        """Displacements (n, r) of each node of the stored fronts, and (m, r) of the cuts."""
        r, n = on_cuts.shape[2], part.unknowns.size
        moved = dict(zip(self._cut.tolist(), on_cuts, strict=True))
        for number in range(len(part.fronts) - 1, -1, -1):
            each = part.fronts[number]
            known = [moved[node] for node in each.front.rest.tolist()]
            if factors is not None and each.front.loaded:
                known.append(-factors)
            own = np.zeros((each.front.own.size * n, r)) if forces is None else forces[number]
            if known:  # rows of loads are last
                beside = np.concatenate(known)
                own = own - each.below[: len(beside)].T @ beside
            own = dtrsm(1.0, each.factor, own, lower=1, trans_a=1)
            moved |= zip(each.front.own.tolist(), own.reshape(-1, n, r), strict=True)
        return moved


def _rows(front: Front, part: Independent) -> list[tuple[int, slice]]:
    """Nodes of the boundary of a front, and the rows of each."""
    sizes = np.where(np.arange(front.rest.size) < front.inner, part.unknowns.size, part.of_cut.size)
    ends = np.cumsum(sizes)
    return [
        (node, slice(end - size, end))
        for node, end, size in zip(front.rest.tolist(), ends.tolist(), sizes.tolist(), strict=True)
    ]
