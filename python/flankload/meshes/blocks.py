"""Blocks of quadratic quadrilaterals: transfinite grids that share their edges."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, TypeVar

import numpy as np

from flankload.base.rounding import TIE, round_up
from flankload.errors import SceneError

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from flankload.base.arrays import Floats, Numbers

    T = TypeVar("T", np.int64, np.float64)


#: Largest number of nodes of a block, and of parts of a line, to limit memory.
MOST_NODES, MOST_PARTS = 1_000_000, 50_000
LOW, MIDDLE, HIGH = slice(None, -2, 2), slice(1, None, 2), slice(2, None, 2)
#: Rows and columns of a block at the nodes of its "quad9" elements, in their order.
NODES_OF_QUAD = (
    *((LOW, LOW), (LOW, HIGH), (HIGH, HIGH), (HIGH, LOW)),
    *((LOW, MIDDLE), (MIDDLE, HIGH), (HIGH, MIDDLE), (MIDDLE, LOW), (MIDDLE, MIDDLE)),
)


def check_count(count: float, most: int, what: str) -> None:
    """Refuse elements that are too small: their count exceeds `most`."""
    if count > most:
        raise SceneError(
            key="accuracy.flank_element_mm",
            expected=f"elements so large that a block of a mesh has at most {most} {what}",
            found=f"{count:.3g} {what}",
        )


def with_middles(breaks: Floats) -> Floats:
    """Breaks (n + 1,) and the middles between them, in order: (2 n + 1,)."""
    result = np.empty(2 * breaks.size - 1)
    result[::2] = breaks
    result[1::2] = 0.5 * (breaks[:-1] + breaks[1:])
    return result


def edges_along(path: NDArray[T]) -> NDArray[T]:
    """First, last and middle (m, 3) of each edge of a path (2 m + 1,) through ends and middles."""
    return np.stack([path[:-2:2], path[2::2], path[1:-1:2]], axis=1)


def even_breaks(start: float, end: float, largest: float, least_count: int = 1) -> Floats:
    """Divide [start, end] into equal parts, none longer than `largest`."""
    parts = (end - start) / largest
    check_count(parts, MOST_PARTS, "elements along a line")
    count = max(least_count, round_up(parts))
    return np.linspace(start, end, count + 1)


def growing_breaks(length: float, first: float, growth: float, caps: Floats | None) -> Floats:
    """Divide [0, 1] into parts that begin near first/length and grow by at most `growth`.

    Parameters
    ----------
    length : float
        Total length, mm.
    first : float
        Desired length of the first part, mm.
    growth : float
        Largest ratio of neighbouring parts.
    caps : (2, m) array or None
        Largest length of a part (second row) at distances from the start (first row), mm.
    """
    ends = [0.0]
    part = first
    rounding = TIE * length
    while ends[-1] < length - rounding:
        if caps is not None:
            part = min(part, float(np.interp(ends[-1], caps[0], caps[1])))
        check_count(len(ends), MOST_PARTS, "elements along a line")
        ends.append(ends[-1] + part)
        part *= growth
    # scale all parts to the length; without the last part if that is closer to it
    if len(ends) > 3 and ends[-1] - length > length - ends[-2] + rounding:
        ends.pop()
    return np.array(ends) / ends[-1]


def symmetric_breaks(width: float, first: float, growth: float, largest: float) -> Floats:
    """Divide [0, 1] symmetrically into an even number of parts (at least 4), fine at both ends."""
    half = growing_breaks(0.5 * width, first, growth, np.array([[0.0], [largest]]))
    if half.size < 3:
        half = np.array([0.0, 0.4, 1.0])
    return np.concatenate([0.5 * half, (1.0 - 0.5 * half[:-1])[::-1]])


def coons(bottom: Floats, top: Floats, left: Floats, right: Floats, x: Floats, y: Floats) -> Floats:
    """Points (n, m, 2) inside four edges (Coons patch).

    Parameters
    ----------
    bottom, top : (m, 2) arrays
        Edges from left to right.
    left, right : (n, 2) arrays
        Edges from bottom to top.
    x, y : (2, m) or (m,) array, (2, n) or (n,) array
        Relative positions along bottom and top, along left and right, or along both.
    """
    x, y = (np.broadcast_to(part, (2, part.shape[-1])) for part in (x, y))
    check_count(x.shape[1] * y.shape[1], MOST_NODES, "nodes")
    # both coordinates are interpolated between opposite edges; two passes suffice
    across = np.broadcast_to(x[0], (y.shape[1], x.shape[1]))
    for _ in range(2):
        up = (1 - across) * y[0][:, None] + across * y[1][:, None]
        across = (1 - up) * x[0] + up * x[1]
    u, v = across[..., None], up[..., None]
    return (
        (1 - v) * bottom
        + v * top
        + (1 - u) * left[:, None]
        + u * right[:, None]
        - (1 - u) * (1 - v) * bottom[0]
        - u * (1 - v) * bottom[-1]
        - (1 - u) * v * top[0]
        - u * v * top[-1]
    )


@dataclass
class BlockMesh:
    """A mesh under construction from blocks that share the nodes of common edges.

    Attributes
    ----------
    places : list of (m, 2) arrays
    cells : list of (E, 9) arrays
        Nodes in the order of meshio's "quad9".
    """

    places: list[Floats] = field(default_factory=list)
    cells: list[Numbers] = field(default_factory=list)
    _count: int = 0

    @property
    def nodes(self) -> Floats:
        """All nodes (N, 2)."""
        return np.concatenate(self.places)

    @property
    def quads(self) -> tuple[tuple[str, Numbers], ...]:
        """All elements, as in a mesh of a body."""
        return (("quad9", np.concatenate(self.cells)),)

    def add(self, grid: Floats, known: dict[str, Numbers]) -> Numbers:
        """Add a block and return its node numbers (n, m).

        Parameters
        ----------
        grid : (n, m, 2) array
            Points, rows from bottom to top, columns from left to right; n and m odd. The block
            must be right-handed.
        known : dict
            Numbers of existing nodes, by edge: "bottom", "top" (m,), "left", "right" (n,).
        """
        edges = {"bottom": (0, slice(None)), "top": (-1, slice(None))}
        edges |= {"left": (slice(None), 0), "right": (slice(None), -1)}  # type: ignore[dict-item]
        numbers = np.full(grid.shape[:2], -1)
        for name, nodes in known.items():
            numbers[edges[name]] = nodes
        new = numbers < 0
        numbers[new] = self._count + np.arange(int(new.sum()))
        self._count += int(new.sum())
        self.places.append(grid[new])
        quads = np.stack([numbers[row, column] for row, column in NODES_OF_QUAD], axis=-1)
        self.cells.append(quads.reshape(-1, 9))
        return numbers
