"""Plane elements as such: their edges, their middle nodes, their quality."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Cells = tuple[tuple[str, NDArray[np.int64]], ...]

#: Edges of the quadratic elements (first, last, middle), counter-clockwise, meshio's node order.
EDGES = {
    "triangle6": ((0, 1, 3), (1, 2, 4), (2, 0, 5)),
    "quad9": ((0, 1, 4), (1, 2, 5), (2, 3, 6), (3, 0, 7)),
}
#: Corners of linear elements and of those whose nodes are completed.
CORNERS = {"triangle": 3, "quad": 4}
#: Order of the nodes of an element that was numbered clockwise.
REVERSED = {"triangle6": [0, 2, 1, 5, 4, 3], "quad9": [0, 3, 2, 1, 7, 6, 5, 4, 8]}


def raise_to_quadratic(
    nodes: NDArray[np.float64], cells: Cells
) -> tuple[NDArray[np.float64], Cells]:
    """Bring every element to "triangle6" or "quad9".

    Linear elements get middle nodes on their straight edges, "quad8" gets the centre that its own
    shape functions have there (half the sum of the middles minus a quarter of the corners).

    Parameters
    ----------
    nodes : (N, 2) array
    cells : ((kind, (E, k) array), ...)

    Returns
    -------
    nodes : (N', 2) array
        The old nodes first.
    cells : ((kind, (E, k) array), ...)
    """
    places = [nodes]
    count = len(nodes)
    middles: dict[tuple[int, int], int] = {}
    done: list[tuple[str, NDArray[np.int64]]] = []
    for kind, data in cells:
        if kind in CORNERS:
            corners = CORNERS[kind]
            ring = np.stack([data, np.roll(data, -1, axis=1)], axis=2).reshape(-1, 2)
            numbers = []
            for a, b in np.sort(ring, axis=1).tolist():
                if (a, b) not in middles:
                    middles[a, b] = count
                    count += 1
                    places.append(0.5 * (nodes[a] + nodes[b])[None])
                numbers.append(middles[a, b])
            data = np.hstack([data, np.array(numbers).reshape(-1, corners)])
            kind = "triangle6" if corners == 3 else "quad8"
        if kind == "quad8":
            every = np.vstack(places)
            centre = 0.5 * every[data[:, 4:8]].sum(axis=1) - 0.25 * every[data[:, :4]].sum(axis=1)
            data = np.hstack([data, count + np.arange(len(data))[:, None]])
            places = [every, centre]
            count += len(data)
            kind = "quad9"
        done.append((kind, data))
    return np.vstack(places), tuple(done)


def boundary_edges(cells: Cells) -> NDArray[np.int64]:
    """Edges that belong to one element only.

    Parameters
    ----------
    cells : ((kind, (E, k) array), ...)
        Quadratic elements numbered counter-clockwise.

    Returns
    -------
    (m, 3) array
        First, last, middle node; the material lies on the left.
    """
    edges = np.vstack([data[:, edge] for kind, data in cells for edge in EDGES[kind]])
    _, first, count = np.unique(
        np.sort(edges[:, :2], axis=1), axis=0, return_index=True, return_counts=True
    )
    return edges[np.sort(first[count == 1])]


def jacobians(
    nodes: NDArray[np.float64], kind: str, data: NDArray[np.int64]
) -> NDArray[np.float64]:
    """Jacobian determinants of quadratic elements at their corners, middles and centre.

    Parameters
    ----------
    nodes : (N, 2) array
    kind : {"triangle6", "quad9"}
    data : (E, k) array

    Returns
    -------
    (E, g) array
        mm² (reference element [0, 1]² or its triangle); negative where an element is inverted.
    """
    if kind == "quad9":
        x, y = (axis.ravel() for axis in np.meshgrid([0.0, 0.5, 1.0], [0.0, 0.5, 1.0]))
        lx, ly = (
            np.stack([(2 * c - 1) * (c - 1), 4 * c * (1 - c), c * (2 * c - 1)], 1) for c in (x, y)
        )
        dx, dy = (np.stack([4 * c - 3, 4 - 8 * c, 4 * c - 1], 1) for c in (x, y))
        # places of meshio's nodes in the 3 x 3 grid
        column = np.array([0, 2, 2, 0, 1, 2, 1, 0, 1])
        row = np.array([0, 0, 2, 2, 0, 1, 2, 1, 1])
        by_x, by_y = dx[:, column] * ly[:, row], lx[:, column] * dy[:, row]
    else:
        corners = np.array([[0, 0], [1, 0], [0, 1], [0.5, 0], [0.5, 0.5], [0, 0.5], [1 / 3, 1 / 3]])
        x, y = corners.T
        z = 1 - x - y
        zero = np.zeros_like(x)
        by_x = np.stack([1 - 4 * z, 4 * x - 1, zero, 4 * (z - x), 4 * y, -4 * y], 1)
        by_y = np.stack([1 - 4 * z, zero, 4 * y - 1, -4 * x, 4 * x, 4 * (z - y)], 1)
    place = nodes[data]
    along_x = np.einsum("gk,ekd->egd", by_x, place)
    along_y = np.einsum("gk,ekd->egd", by_y, place)
    return along_x[..., 0] * along_y[..., 1] - along_x[..., 1] * along_y[..., 0]


def chain(edges: NDArray[np.int64]) -> list[NDArray[np.int64]]:
    """Sort edges into consecutive runs.

    Parameters
    ----------
    edges : (m, 3) array
        First, last, middle node of each.

    Returns
    -------
    list of (k, 3) arrays
        Each run from one of its ends to the other; closed runs start anywhere.
    """
    by_start = {int(edge[0]): edge for edge in edges}
    starts = set(by_start) - {int(edge[1]) for edge in edges}
    runs = []
    for start in [*sorted(starts), *sorted(by_start)]:
        run = []
        while start in by_start:
            edge = by_start.pop(start)
            run.append(edge)
            start = int(edge[1])
        if run:
            runs.append(np.array(run))
    return runs
