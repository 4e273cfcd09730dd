"""Elimination order of the inner nodes of a plane mesh: nested dissection.

The elements are bisected recursively; the nodes that both halves share are eliminated after them.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flankload.base.arrays import Flags, Floats, Numbers

#: Unknowns, and least number of nodes, of the largest part that is not bisected. Measured: smaller
#: fronts cost more calls in the plane, larger ones more operations in three dimensions.
LEAF_UNKNOWNS, LEAF_NODES = 64, 6
#: Number of directions that are tried for the bisection of a part.
DIRECTIONS = 8


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
    parts : tuple of int
        Fronts whose remainders are added to this one.
    """

    own: Numbers
    rest: Numbers
    parts: tuple[int, ...]


@dataclass(frozen=True, eq=False)
class Dissection:
    """Elimination order of the nodes of a mesh.

    Attributes
    ----------
    fronts : list of Front
        Each after its parts; the boundary of the last one are the kept nodes.
    order : (P,) array
        Nodes in the order of elimination, followed by the kept ones.
    position : (N,) array
        Position of each node in `order`, -1 for other nodes.
    inner : int
        Number of nodes that are eliminated.
    """

    fronts: list[Front]
    order: Numbers
    position: Numbers
    inner: int


def dissect(
    places: Floats, cells: Sequence[Numbers], *, inner: Flags, kept: Numbers, unknowns: int
) -> Dissection:
    """Fronts of a mesh.

    Parameters
    ----------
    places : (N, 2) array
        Positions of the nodes, mm.
    cells : sequence of (E, k) arrays
        Elements by kind.
    inner : (N,) array of bool
        Nodes to be eliminated.
    kept : (c,) array
        Kept nodes; others are fixed.
    unknowns : int
        Number of unknowns of a node.
    """
    leaf = max(LEAF_NODES, LEAF_UNKNOWNS // unknowns)
    sizes = np.concatenate([np.full(len(part), part.shape[1]) for part in cells])
    element = np.repeat(np.arange(sizes.size), sizes)
    node = np.concatenate([part.ravel() for part in cells])
    middles = np.concatenate([places[part].mean(axis=1) for part in cells])
    owns: list[Numbers] = []
    parts: list[tuple[int, ...]] = []

    def split(element: Numbers, node: Numbers) -> int:
        """Number of the front that eliminates the last nodes of these pairs."""
        own, below = np.flatnonzero(_among(node, inner.size)), []
        if own.size > leaf:
            shared, halves = _bisected(element, node, middles, inner.size)
            if halves:
                own = shared
                below = [split(element[half], node[half]) for half in halves if half.any()]
        owns.append(own)
        parts.append(tuple(below))
        return len(owns) - 1

    split(element[inner[node]], node[inner[node]])
    position = np.full(inner.size, -1)
    order = np.concatenate([*owns, kept])
    position[order] = np.arange(order.size)
    fronts: list[Front] = []
    for own, below in zip(owns, parts, strict=True):
        touched = _among(element[_among(own, inner.size)[node]], sizes.size)
        beside = [node[touched[element]], *(fronts[part].rest for part in below)]
        rest = np.flatnonzero(_among(np.concatenate(beside), inner.size))
        rest = rest[position[rest] > position[own].max(initial=-1)]
        rest = rest[np.argsort(position[rest])]
        fronts.append(Front(own, rest, below))
    return Dissection(fronts, order, position, order.size - kept.size)


def _among(numbers: Numbers, count: int) -> Flags:
    """Flags (count,) of the numbers that occur, from 0."""
    found = np.zeros(count, dtype=bool)
    found[numbers] = True
    return found


def _bisected(
    element: Numbers, node: Numbers, middles: Floats, nodes: int
) -> tuple[Numbers, list[Flags]]:
    """Nodes that both halves share, and the pairs of each half without them.

    Of some directions, the one with the fewest nodes; no halves if all elements are in one place.
    `nodes` is the number of nodes of the mesh.
    """
    elements = np.flatnonzero(_among(element, len(middles)))
    best: tuple[Numbers, list[Flags]] | None = None
    for turn in np.arange(DIRECTIONS) * (np.pi / DIRECTIONS):
        along = middles @ [np.cos(turn), np.sin(turn)]
        ahead = along[element] > _middle(along[elements])
        if not ahead.any():
            continue
        shared = _among(node[ahead], nodes) & _among(node[~ahead], nodes)
        own = np.flatnonzero(shared)
        if best is None or own.size < best[0].size:
            free = ~shared[node]
            best = own, [ahead & free, ~ahead & free]
    return (elements[:0], []) if best is None else best


def _middle(values: Floats) -> np.float64:
    """Median of some hundred numbers or fewer: np.median takes six times as long."""
    ascending = np.sort(values)
    middle: np.float64 = 0.5 * (ascending[(values.size - 1) // 2] + ascending[values.size // 2])
    return middle
