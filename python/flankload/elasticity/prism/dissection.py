"""The order in which the inner nodes of a plane mesh are eliminated: nested dissection.

The nodes are bisected again and again. Those of one half that share an element with the other half
separate both: they are eliminated after them. What is left of a front, its boundary, is small.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Nodes = NDArray[np.int64]

#: Parts of no more nodes are eliminated at once.
LEAF = 24


@dataclass(frozen=True, eq=False)
class Front:
    """Nodes that are eliminated together.

    Attributes
    ----------
    own : (o,) array
        The nodes, in their order.
    rest : (r,) array
        Nodes of the boundary: first those that are eliminated later, in their order, then those
        that are kept.
    inner : int
        How many of `rest` are eliminated later.
    parts : tuple of int
        Fronts whose remainder goes into this one.
    loaded : bool
        Whether one of the nodes eliminated so far carries a load.
    """

    own: Nodes
    rest: Nodes
    inner: int
    parts: tuple[int, ...]
    loaded: bool


def dissect(
    places: NDArray[np.float64],
    rows: Nodes,
    columns: Nodes,
    *,
    inner: NDArray[np.bool_],
    kept: NDArray[np.bool_],
    loaded: NDArray[np.bool_],
) -> tuple[list[Front], Nodes]:
    """Fronts of a mesh, each after its parts; the last one has no boundary but the kept nodes.

    Parameters
    ----------
    places : (N, 2) array
        Of the nodes, mm.
    rows, columns : (n,) arrays
        Pairs of nodes that share an element.
    inner, kept, loaded : (N,) arrays
        Nodes to be eliminated; nodes that stay; nodes that carry loads.

    Returns
    -------
    fronts : list of Front
    position : (N,) array
        When a node is eliminated; kept nodes stand behind all others, held ones before.
    """
    inside = inner[rows] & inner[columns]
    one, other = rows[inside], columns[inside]
    owns: list[Nodes] = []
    parts: list[tuple[int, ...]] = []

    def split(nodes: Nodes, one: Nodes, other: Nodes) -> int:
        if nodes.size <= LEAF:
            owns.append(nodes)
            parts.append(())
            return len(owns) - 1
        side, between = _bisected(nodes, places, one, other)
        below = []
        for number in (0, 1):
            mine = (side[one] == number) & (side[other] == number)
            half = nodes[side[nodes] == number]
            if half.size:
                below.append(split(half, one[mine], other[mine]))
        owns.append(between)
        parts.append(tuple(below))
        return len(owns) - 1

    split(np.flatnonzero(inner), one, other)
    return _fronts(owns, parts, rows, columns, inner=inner, kept=kept, loaded=loaded)


def _bisected(
    nodes: Nodes, places: NDArray[np.float64], one: Nodes, other: Nodes
) -> tuple[Nodes, Nodes]:
    """Side of each node (0, 1; 2: between them), and the smallest separator of four directions."""
    best: tuple[Nodes, Nodes] | None = None
    for turn in np.arange(4) * (np.pi / 4):
        along = places[nodes] @ [np.cos(turn), np.sin(turn)]
        side = np.full(len(places), 3)
        side[nodes] = along > np.median(along)
        between = np.unique(other[(side[one] == 0) & (side[other] == 1)])
        side[between] = 2
        if best is None or between.size < best[1].size:
            best = side, between
    assert best is not None
    return best


def _fronts(
    owns: list[Nodes],
    parts: list[tuple[int, ...]],
    rows: Nodes,
    columns: Nodes,
    *,
    inner: NDArray[np.bool_],
    kept: NDArray[np.bool_],
    loaded: NDArray[np.bool_],
) -> tuple[list[Front], Nodes]:
    """Fronts with their boundaries, from the nodes that each eliminates."""
    position = np.full(inner.size, -1)
    order = np.concatenate(owns)
    position[order] = np.arange(order.size)
    position[kept] = order.size + np.arange(np.count_nonzero(kept))
    live = inner | kept
    fronts: list[Front] = []
    for own, below in zip(owns, parts, strict=True):
        beside = np.zeros(inner.size, dtype=bool)
        mine = np.zeros(inner.size, dtype=bool)
        mine[own] = True
        beside[columns[mine[rows]]] = True
        for part in below:
            beside[fronts[part].rest] = True
        beside[own] = False
        last = position[own].max() if own.size else -1
        rest = np.flatnonzero(beside & live & (position > last))
        rest = rest[np.argsort(position[rest])]
        fronts.append(
            Front(
                own,
                rest,
                int(np.count_nonzero(inner[rest])),
                below,
                bool(loaded[own].any() or any(fronts[part].loaded for part in below)),
            )
        )
    return fronts, position
