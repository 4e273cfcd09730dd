"""Plane elements: their edges, middle nodes and quality."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flankload.base.rotation import lengths_of

if TYPE_CHECKING:
    from flankload.base.arrays import Cells, Floats, Numbers


#: Edges of quadratic elements (first, last, middle), counter-clockwise, in the node order of
#: meshio.
EDGES = {
    "triangle6": ((0, 1, 3), (1, 2, 4), (2, 0, 5)),
    "quad9": ((0, 1, 4), (1, 2, 5), (2, 3, 6), (3, 0, 7)),
}
#: Number of corners of linear elements.
CORNERS = {"triangle": 3, "quad": 4}
#: Largest distance of points from a circle through them, over its radius.
CIRCLE_TOLERANCE = 1e-6
#: Node order of a reversed element.
REVERSED = {"triangle6": [0, 2, 1, 5, 4, 3], "quad9": [0, 3, 2, 1, 7, 6, 5, 4, 8]}


def raise_to_quadratic(nodes: Floats, cells: Cells) -> tuple[Floats, Cells]:
    """Convert every element to "triangle6" or "quad9"; added nodes are behind the others (N, 2).

    Middle nodes of linear elements are on straight edges; the centre node of "quad8" is at the
    place of its shape functions: half the sum of the middle nodes minus a quarter of that of the
    corners.
    """
    places = [nodes]
    count = len(nodes)
    middles: dict[tuple[int, int], int] = {}
    done: list[tuple[str, Numbers]] = []
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


def boundary_edges(cells: Cells) -> Numbers:
    """Boundary edges (m, 3) of quadratic elements: first, last, middle node.

    The material is on their left if the elements are counter-clockwise.
    """
    edges = np.vstack([data[:, edge] for kind, data in cells for edge in EDGES[kind]])
    ends = np.sort(edges[:, :2], axis=1)
    _, first, count = np.unique(pair_numbers(ends), return_index=True, return_counts=True)
    return edges[np.sort(first[count == 1])]


def pair_numbers(pairs: Numbers) -> Numbers:
    """Numbers (m,) of pairs (m, 2) of nodes: equal for equal pairs, and in the same order."""
    one, two = pairs.astype(np.int64).T
    return np.asarray(one * (two.max(initial=0) + 1) + two)


def jacobians(nodes: Floats, kind: str, data: Numbers) -> Floats:
    """Jacobian determinants (E, g) of quadratic elements at corners, middle nodes and centre, mm².

    The reference element is [0, 1]² or its lower triangle; `kind`: "triangle6" or "quad9".
    """
    along_x, along_y = _tangents(nodes, kind, data)
    return along_x[..., 0] * along_y[..., 1] - along_x[..., 1] * along_y[..., 0]


def counter_clockwise(nodes: Floats, cells: Cells) -> tuple[Cells, int]:
    """Quadratic elements counter-clockwise, and the number of elements that were clockwise."""
    done = []
    turned = 0
    for kind, data in cells:
        clockwise = jacobians(nodes, kind, data).sum(axis=1) < 0
        data = data.copy()
        data[clockwise] = data[clockwise][:, REVERSED[kind]]
        turned += int(clockwise.sum())
        done.append((kind, data))
    return tuple(done), turned


def scaled_jacobians(nodes: Floats, kind: str, data: Numbers) -> Floats:
    """Least scaled Jacobian (E,) of elements: sine of the angle between coordinate lines.

    1 for a rectangle and an equilateral triangle, 0 for a collapsed element; arguments as of
    `jacobians`, counter-clockwise.
    """
    along_x, along_y = _tangents(nodes, kind, data)
    area = along_x[..., 0] * along_y[..., 1] - along_x[..., 1] * along_y[..., 0]
    lengths = [lengths_of(along) for along in (along_x, along_y)]
    if kind == "triangle6":
        # sines at all three corners, scaled to the equilateral triangle
        lengths.append(np.linalg.norm(along_x - along_y, axis=-1))
        lengths = [np.sort(np.stack(lengths), axis=0)[k] for k in (1, 2)]
        area = area * 2 / np.sqrt(3.0)
    product = np.maximum(lengths[0] * lengths[1], np.finfo(float).tiny)
    return np.asarray((area / product).min(axis=1))


def edge_lengths(nodes: Floats, kind: str, data: Numbers) -> Floats:
    """Lengths (E, 3) or (E, 4) of the edges of elements, from corner to corner."""
    corners = data[:, : 3 if kind.startswith("triangle") else 4]
    steps = nodes[corners] - nodes[np.roll(corners, -1, axis=1)]
    return np.asarray(np.linalg.norm(steps, axis=2))


def aspect_ratios(nodes: Floats, kind: str, data: Numbers) -> Floats:
    """Ratio of longest to shortest edge of elements, from corner to corner: (E,)."""
    lengths = edge_lengths(nodes, kind, data)
    least = np.maximum(lengths.min(axis=1), np.finfo(float).tiny)
    return np.asarray(lengths.max(axis=1) / least)


def _tangents(nodes: Floats, kind: str, data: Numbers) -> tuple[Floats, Floats]:
    """Derivatives of the position with respect to both reference coordinates, as in `jacobians`."""
    if kind == "quad9":
        x, y = (axis.ravel() for axis in np.meshgrid([0.0, 0.5, 1.0], [0.0, 0.5, 1.0]))
        lx, ly = (
            np.stack([(2 * c - 1) * (c - 1), 4 * c * (1 - c), c * (2 * c - 1)], 1) for c in (x, y)
        )
        dx, dy = (np.stack([4 * c - 3, 4 - 8 * c, 4 * c - 1], 1) for c in (x, y))
        # positions of the nodes in the 3 x 3 grid, in the order of meshio
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
    elements, k = data.shape
    place = nodes[data.T].reshape(k, -1)
    one, two = ((by @ place).reshape(len(by), elements, 2) for by in (by_x, by_y))
    return one.transpose(1, 0, 2), two.transpose(1, 0, 2)


def chain(edges: Numbers) -> list[Numbers]:
    """Sort edges (m, 3) into open and closed chains (k, 3) of consecutive edges."""
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


def circle_through(points: Floats) -> tuple[Floats, float] | None:
    """Centre (2,) and radius of the circle through points (n, 2).

    None for fewer than 4 points, points that are not on a circle, and radii much larger than the
    coordinates.
    """
    if len(points) < 4:
        return None
    scale = float(np.abs(points).max()) or 1.0
    x, y = (points / scale).T
    table = np.column_stack([x, y, np.ones_like(x)])
    (a, b, c), *_ = np.linalg.lstsq(table, -(x**2 + y**2), rcond=None)
    centre = np.array([-0.5 * a, -0.5 * b])
    radius = float(np.sqrt(max(float(centre @ centre) - c, 0.0)))
    away = np.hypot(x - centre[0], y - centre[1])
    if not 0.0 < radius < 2.0 or np.abs(away - radius).max() > CIRCLE_TOLERANCE * radius:
        return None
    return centre * scale, radius * scale
