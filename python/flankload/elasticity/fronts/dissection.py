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
#: Lines that are tried for the bisection of a part: number of directions, and parts behind them.
DIRECTIONS, PARTS = 8, (0.4, 0.5, 0.6)


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
    images : (N,) array or None
        For a symmetric mesh, whose second half is not in the order: `mirror.images_of`. The last
        front has the nodes on the axis; its only part is the last front of the first half.
    """

    fronts: list[Front]
    order: Numbers
    position: Numbers
    inner: int
    images: Numbers | None = None

    @property
    def half(self) -> int:
        """Number of nodes of the first half that are eliminated, all without symmetry."""
        return self.inner if self.images is None else self.inner - self.fronts[-1].own.size

    @property
    def second(self) -> Numbers:
        """Images of the nodes of the first half, in their order; empty without symmetry."""
        return self.order[:0] if self.images is None else self.images[self.order[: self.half]]


def dissect(
    places: Floats,
    cells: Sequence[Numbers],
    *,
    inner: Flags,
    kept: Numbers,
    unknowns: int,
    images: Numbers | None = None,
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
    images : (N,) array, optional
        For a symmetric mesh: `Dissection.images`.
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

    first = inner if images is None else inner & (images >= 0) & (images != np.arange(inner.size))
    split(element[first[node]], node[first[node]])
    if images is not None:
        parts.append((len(owns) - 1,))
        owns.append(np.flatnonzero(inner & (images == np.arange(inner.size))))
    position = np.full(inner.size, -1)
    order = np.concatenate([*owns, kept])
    position[order] = np.arange(order.size)
    fronts: list[Front] = []
    for own, below in zip(owns, parts, strict=True):
        touched = _among(element[_among(own, inner.size)[node]], sizes.size)
        beside = [node[touched[element]], *(fronts[part].rest for part in below)]
        if images is not None and len(fronts) == len(owns) - 1:
            beside.append(images[fronts[-1].rest])
        rest = np.flatnonzero(_among(np.concatenate(beside), inner.size))
        rest = rest[position[rest] > position[own].max(initial=-1)]
        rest = rest[np.argsort(position[rest])]
        fronts.append(Front(own, rest, below))
    return Dissection(fronts, order, position, order.size - kept.size, images)


def _among(numbers: Numbers, count: int) -> Flags:
    """Flags (count,) of the numbers that occur, from 0."""
    found = np.zeros(count, dtype=bool)
    found[numbers] = True
    return found


def _bisected(
    element: Numbers, node: Numbers, middles: Floats, nodes: int
) -> tuple[Numbers, list[Flags]]:
    """Nodes that both halves share, and the pairs of each half without them.

    Several lines are tried; the best has the least ratio cut, shared nodes over the product of both
    parts. No halves if all elements are in one place. `nodes` is the number of nodes of the mesh.
    """
    elements = np.flatnonzero(_among(element, len(middles)))
    last, least = elements.size - 1, np.inf
    best: tuple[Numbers, list[Flags]] = elements[:0], []
    for turn in np.arange(DIRECTIONS) * (np.pi / DIRECTIONS):
        along = middles @ [np.cos(turn), np.sin(turn)]
        places, ascending = along[element], np.sort(along[elements])
        for part in PARTS:
            behind = int(part * last)
            ahead = places > 0.5 * (ascending[behind] + ascending[min(behind + 1, last)])
            count = np.count_nonzero(ahead)
            if count == 0:
                continue
            shared = _among(node[ahead], nodes) & _among(node[~ahead], nodes)
            ratio = np.count_nonzero(shared) / (count * (ahead.size - count))
            if ratio < least:
                free = ~shared[node]
                least, best = ratio, (np.flatnonzero(shared), [ahead & free, ~ahead & free])
    return best
