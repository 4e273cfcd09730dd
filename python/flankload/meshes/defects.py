"""Defects of a plane mesh, and conversion of a sound mesh to standard form.

The command `check` prints all defects; a body from a mesh raises an error at the first one.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flankload.errors import MeshError
from flankload.meshes.plane_mesh import (
    CORNERS,
    EDGES,
    boundary_edges,
    counter_clockwise,
    edge_lengths,
    jacobians,
    pair_numbers,
    raise_to_quadratic,
)

if TYPE_CHECKING:
    from collections.abc import Iterator

    from flankload.base.arrays import Cells, Floats, Numbers
    from flankload.meshes.io import RawMesh


#: Largest distance of coincident nodes, over the shortest edge.
COINCIDENCE_TOLERANCE = 1e-3
#: Largest distance of a middle node from the middle of its edge, along the edge, in edge lengths;
#: at 0.25 the element is inverted at its corner.
MIDDLE_TOLERANCE = 0.15
#: Direction of the line along which nodes are sorted: no simple ratio.
ALONG = np.array([1.0, 0.6180339887498949])


@dataclass(frozen=True)
class Defect:
    """A defect of a mesh.

    Attributes
    ----------
    expected, found : str
        Each is the end of a sentence.
    """

    expected: str
    found: str


@dataclass(frozen=True)
class PlaneBody:
    """A sound mesh in standard form: quadratic elements, counter-clockwise.

    Attributes
    ----------
    nodes : (N, 2) array
        Nodes of the file first.
    cells : ((kind, (E, k) array), ...)
    edges : (m, 3) array
        The boundary: first, last and middle node; the material is on the left.
    linear : bool
        The elements in the file are linear.
    notes : tuple of str
    """

    nodes: Floats
    cells: Cells
    edges: Numbers
    linear: bool
    notes: tuple[str, ...]


def sound_body(raw: RawMesh, key: str, *, one_material: bool = False) -> PlaneBody:
    """Convert a mesh to standard form; `key` is the scene's key of the file.

    `one_material`: element groups are not materials.

    Raises
    ------
    MeshError
        At the first defect.
    """
    for defect in find_defects(raw, one_material=one_material):
        raise MeshError(file=raw.file, key=key, expected=defect.expected, found=defect.found)
    nodes, cells = raise_to_quadratic(raw.nodes, raw.cells)
    cells, turned = counter_clockwise(nodes, cells)
    linear = any(kind in CORNERS for kind, _ in raw.cells)
    notes = list(raw.notes)
    if linear:
        notes.append(
            "linear elements become quadratic ones with straight edges: finer elements, or "
            "quadratic ones with their middle nodes on the profile, follow the flank better"
        )
    if turned:
        notes.append(f"{turned} elements are numbered clockwise: their numbering is reversed")
    return PlaneBody(nodes, cells, boundary_edges(cells), linear, tuple(notes))


def find_defects(raw: RawMesh, *, one_material: bool = False) -> Iterator[Defect]:
    """All defects of a mesh; if one prevents further checks, only this one.

    `one_material`: element groups are not materials.
    """
    mixed = _mixed_orders(raw)
    if mixed is not None:
        yield mixed
        return
    nodes, cells = raise_to_quadratic(raw.nodes, raw.cells)
    checks = [_double_nodes(raw), _double_elements(raw), _middles_off(raw)]
    inverted = _inverted(nodes, cells)
    checks.append(inverted)
    if inverted is None:
        cells, _ = counter_clockwise(nodes, cells)
        checks += [_folded(nodes, cells), _loose_parts(cells)]
    if not one_material:
        checks.append(_materials(raw))
    yield from (defect for defect in checks if defect is not None)


def _place(nodes: Floats, number: int | np.integer) -> str:
    return f"x = {nodes[number, 0]:.4f}, y = {nodes[number, 1]:.4f} mm"


def _mixed_orders(raw: RawMesh) -> Defect | None:
    linear = sum(len(data) for kind, data in raw.cells if kind in CORNERS)
    quadratic = sum(len(data) for kind, data in raw.cells if kind not in CORNERS)
    if not linear or not quadratic:
        return None
    return Defect("elements of one order", f"{linear} linear and {quadratic} quadratic elements")


def _double_nodes(raw: RawMesh) -> Defect | None:
    lengths = np.concatenate(
        [edge_lengths(raw.nodes, kind, data).ravel() for kind, data in raw.cells]
    )
    reach = COINCIDENCE_TOLERANCE * float(np.min(lengths[lengths > 0], initial=np.inf))
    if not np.isfinite(reach):
        return Defect("elements with an area", "only elements that are shrunk to a point")
    pairs = _near_pairs(raw.nodes, reach)
    if not len(pairs):
        return None
    count = np.unique(pairs[:, 1]).size
    return Defect(
        "one node at a place (merge them in the mesher)",
        f"{count} nodes that coincide with others, the first at {_place(raw.nodes, pairs[0, 0])}",
    )


def _near_pairs(nodes: Floats, reach: float) -> Numbers:
    """Pairs (n, 2) of nodes that are at most `reach` apart, ascending.

    Candidates are neighbours along a line that few nodes share a place on: faster than the import
    of a search tree.
    """
    along = nodes @ ALONG
    order = np.argsort(along, kind="stable")
    found, ahead = [np.zeros((0, 2), dtype=np.int64)], 1
    while ahead < order.size:
        gaps = along[order[ahead:]] - along[order[:-ahead]]
        close = np.flatnonzero(gaps <= np.linalg.norm(ALONG) * reach)
        if not close.size:
            break
        pairs = np.sort(np.column_stack([order[close], order[close + ahead]]), axis=1)
        apart = np.linalg.norm(nodes[pairs[:, 0]] - nodes[pairs[:, 1]], axis=1)
        found.append(pairs[apart <= reach])
        ahead += 1
    return np.unique(np.concatenate(found), axis=0)


def _double_elements(raw: RawMesh) -> Defect | None:
    twice = 0
    first = -1
    for _, data in raw.cells:
        _, index, count = np.unique(
            np.sort(data, axis=1), axis=0, return_index=True, return_counts=True
        )
        twice += int((count - 1).sum())
        if (count > 1).any() and first < 0:
            first = int(data[index[np.argmax(count > 1)], 0])
    if not twice:
        return None
    return Defect(
        "each element once", f"{twice} repeated elements, the first at {_place(raw.nodes, first)}"
    )


def _middles_off(raw: RawMesh) -> Defect | None:
    """Middle nodes far from the middle of their edges: wrong node order, or moved nodes."""
    edges = [
        data[:, edge]
        for kind, data in raw.cells
        if kind not in CORNERS
        for edge in EDGES["triangle6" if kind == "triangle6" else "quad9"]
    ]
    if not edges:
        return None
    first, last, middle = np.vstack(edges).T
    chord = raw.nodes[last] - raw.nodes[first]
    away = raw.nodes[middle] - 0.5 * (raw.nodes[first] + raw.nodes[last])
    square = np.maximum((chord**2).sum(axis=1), np.finfo(float).tiny)
    bad = np.abs((away * chord).sum(axis=1)) > MIDDLE_TOLERANCE * square
    if not bad.any():
        return None
    return Defect(
        f"middle nodes within {MIDDLE_TOLERANCE:g} of an edge's length from its middle",
        f"{bad.sum()} of {bad.size} further off, the first at "
        f"{_place(raw.nodes, middle[np.argmax(bad)])}",
    )


def _inverted(nodes: Floats, cells: Cells) -> Defect | None:
    """Elements that are inverted somewhere, in either direction of numbering."""
    count, total, where = 0, 0, ""
    for kind, data in cells:
        determinants = jacobians(nodes, kind, data)
        clockwise = (determinants < 0).all(axis=1)
        broken = ~clockwise & (determinants <= 0).any(axis=1)
        count, total = count + int(broken.sum()), total + len(data)
        if broken.any() and not where:
            x, y = nodes[data[int(np.flatnonzero(broken)[0])]].mean(axis=0)
            where = f"({kind}) at x = {x:.4f}, y = {y:.4f} mm"
    if not count:
        return None
    return Defect(
        "elements with a positive Jacobian", f"{count} inverted of {total}, the first {where}"
    )


def _folded(nodes: Floats, cells: Cells) -> Defect | None:
    """Overlapping elements: two elements have their common edge in the same direction."""
    edges = np.vstack([data[:, edge] for kind, data in cells for edge in EDGES[kind]])
    numbers = pair_numbers(edges[:, :2])
    _, first, count = np.unique(numbers, return_index=True, return_counts=True)
    if (count == 1).all():
        return None
    place = edges[first[count > 1][0], 2]
    return Defect(
        "elements that do not lie on each other",
        f"{int((count > 1).sum())} edges with two elements on the same side, the first at "
        f"{_place(nodes, place)}",
    )


def _loose_parts(cells: Cells) -> Defect | None:
    """Several parts; those without a support could move freely."""
    numbers = np.cumsum([0, *(len(data) for _, data in cells)])
    edges = np.vstack([data[:, edge[:2]] for kind, data in cells for edge in EDGES[kind]])
    element = np.concatenate(
        [
            np.tile(first + np.arange(len(data)), len(EDGES[kind]))
            for first, (kind, data) in zip(numbers[:-1], cells, strict=True)
        ]
    )
    _, edge = np.unique(pair_numbers(np.sort(edges, axis=1)), return_inverse=True)
    _, counts = np.unique(_connected(element, edge.ravel()), return_counts=True)
    if counts.size == 1:
        return None
    sizes = sorted(counts.tolist(), reverse=True)
    more = ", …" if len(sizes) > 4 else ""
    return Defect(
        "one connected body in a file",
        f"{len(sizes)} parts that share no edge, of {', '.join(map(str, sizes[:4]))}{more} "
        "elements",
    )


def _connected(element: Numbers, edge: Numbers) -> Numbers:
    """First element (E,) of the part of each, from all pairs of an element and its edge."""
    part = np.arange(int(element.max()) + 1)
    while True:
        least = np.full(int(edge.max()) + 1, part.size)
        np.minimum.at(least, edge, part[element])
        found = part.copy()
        np.minimum.at(found, element, least[edge])
        np.minimum.at(found, part, found.copy())  # the first element of a part joins with it
        found = found[found]
        if np.array_equal(found, part):
            return part
        part = found


def _materials(raw: RawMesh) -> Defect | None:
    if len(raw.materials) < 2:
        return None
    sizes = [f"{name} ({count} elements)" for name, count in sorted(raw.materials.items())]
    return Defect(
        "one material (one_material = true in the scene if groups do not mean materials)",
        f"{len(sizes)}: {', '.join(sizes[:4])}{', …' if len(sizes) > 4 else ''}",
    )
