"""Elimination order of the inner nodes of a plane mesh: nested dissection.

The elements are bisected recursively; the nodes that both halves share are eliminated after them.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from flankload.base.rotation import directions

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flankload.base.arrays import Flags, Floats, Numbers

#: Largest number of nodes of a part that is not bisected.
LEAF = 12
#: Directions of the lines that are tried to bisect a part: normals (2, n) of the lines.
DIRECTIONS = 8
TURNS = directions(np.linspace(0.0, np.pi, DIRECTIONS, endpoint=False)).T


@dataclass(frozen=True, eq=False)
class Front:
    """Nodes that are eliminated together.

    Attributes
    ----------
    own : (o,) array
        The nodes, in their order.
    rest : (r,) array
        Nodes of the boundary: first those that are eliminated later, in their order, then kept
        ones.
    inner : int
        Number of nodes of `rest` that are eliminated later.
    parts : tuple of int
        Fronts whose remainders are added to this one.
    loaded : bool
        Whether one of the nodes eliminated so far has a load.
    """

    own: Numbers
    rest: Numbers
    inner: int
    parts: tuple[int, ...]
    loaded: bool


def dissect(
    places: Floats, cells: Sequence[Numbers], *, inner: Flags, kept: Numbers, loaded: Flags
) -> tuple[list[Front], Numbers]:
    """Fronts of a mesh, each after its parts; the boundary of the last one are the kept nodes.

    Arguments: positions (N, 2) of the nodes, mm, cells (E, k) by kind, whether a node is eliminated
    (N,), kept nodes (c,), whether a node has loads (N,). Also returns the position of each node
    (N,) in the order of elimination: kept nodes are last, -1 for other nodes.
    """
    sizes = np.concatenate([np.full(len(part), part.shape[1]) for part in cells])
    element = np.repeat(np.arange(sizes.size), sizes)
    node = np.concatenate([part.ravel() for part in cells])
    middles = np.concatenate([places[part].mean(axis=1) for part in cells])
    owns: list[Numbers] = []
    parts: list[tuple[int, ...]] = []

    def split(element: Numbers, node: Numbers) -> int:
        """Number of the last front of these pairs of element and node."""
        own, below = np.unique(node), []
        if own.size > LEAF:
            own, halves = _bisected(element, node, middles)
            below = [split(element[half], node[half]) for half in halves if half.any()]
        owns.append(own)
        parts.append(tuple(below))
        return len(owns) - 1

    split(element[inner[node]], node[inner[node]])
    position = np.full(inner.size, -1)
    order = np.concatenate(owns)
    position[order] = np.arange(order.size)
    position[kept] = order.size + np.arange(kept.size)
    beside = _neighbours(element, node, inner.size)
    fronts: list[Front] = []
    for own, below in zip(owns, parts, strict=True):
        touched = [*(beside[each] for each in own.tolist()), *(fronts[part].rest for part in below)]
        rest = np.unique(np.concatenate(touched)) if touched else own
        rest = rest[position[rest] > position[own].max(initial=-1)]
        rest = rest[np.argsort(position[rest])]
        carries = loaded[own].any() or any(fronts[part].loaded for part in below)
        fronts.append(Front(own, rest, int(inner[rest].sum()), below, bool(carries)))
    return fronts, position


def _neighbours(element: Numbers, node: Numbers, count: int) -> list[Numbers]:
    """Nodes of the elements of each node, from pairs of both, element by element."""
    order = np.argsort(node, kind="stable")
    first = np.searchsorted(node[order], np.arange(count + 1)).tolist()
    of_node = element[order]
    ends = np.searchsorted(element, np.arange(element.max(initial=-1) + 2)).tolist()
    nodes_of = [node[one:two] for one, two in pairwise(ends)]
    return [
        np.concatenate([nodes_of[each] for each in of_node[one:two].tolist()])
        if two > one
        else node[:0]
        for one, two in pairwise(first)
    ]


def _bisected(element: Numbers, node: Numbers, middles: Floats) -> tuple[Numbers, list[Flags]]:
    """Nodes that both halves share, and the pairs of each half without them.

    The best of some directions: the fewest nodes.
    """
    nodes, at = np.unique(node, return_inverse=True)
    elements, of_element = np.unique(element, return_inverse=True)
    along = middles[elements] @ TURNS
    ahead = (along > np.median(along, axis=0))[of_element]
    shared = np.zeros((2, nodes.size, DIRECTIONS), dtype=bool)
    for half, part in enumerate((ahead, ~ahead)):
        pair, direction = np.nonzero(part)
        shared[half, at[pair], direction] = True
    both = shared[0] & shared[1]
    best = int(np.argmin(both.sum(axis=0)))
    free = ~both[at, best]
    return nodes[both[:, best]], [ahead[:, best] & free, ~ahead[:, best] & free]
