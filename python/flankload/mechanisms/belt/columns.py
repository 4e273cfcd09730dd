"""Columns of nodal forces on a timing belt: linear shape functions on its flanks and lands.

A shape function is 1 at an end of an element's edge and decreases to 0 at its neighbours. It
distributes forces over the elements, and displacements are averaged with the same function.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.polynomial.legendre import leggauss
from scipy.sparse import csc_array, hstack

from flankload.elasticity.finite_elements import assembled, degrees_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from flankload.mechanisms.belt.belt import Strip
    from flankload.mechanisms.belt.belt_mesh import BeltMesh

    Floats = NDArray[np.float64]
    Numbers = NDArray[np.int64]

#: Gauss points of the edges.
GAUSS_POINTS = 4
#: Moments below this part of a shape function's own moment are roundoff.
NO_MOMENT = 1e-12


@dataclass(frozen=True)
class Flanks:
    """Contact pairs on the working flanks; n pairs.

    Attributes
    ----------
    tooth : (n,) array
        Tooth of each pair, counted from the tight end.
    places, normals : (n, 2) arrays
        Relative to the axis of the pulley, mm; normals point out of the belt.
    levers_mm : (n,) array
        Moment about the axis of a unit force of the pulley on the belt.
    gaps_mm : (n,) array
        Gaps to the groove, along the normals.
    lengths_mm : (n,) array
        Flank length represented by each pair.
    """

    tooth: Numbers
    places: Floats
    normals: Floats
    levers_mm: Floats
    gaps_mm: Floats
    lengths_mm: Floats


@dataclass(frozen=True)
class FlankLine:
    """The working flank of a tooth.

    Attributes
    ----------
    tooth : int
    places : (2 c - 1, 2) array
        Places of its nodes, from the land to the tip, mm; its c shape functions are pairs.
    """

    tooth: int
    places: Floats


def flank_columns(strip: Strip, mesh: BeltMesh) -> tuple[Flanks, tuple[FlankLine, ...], csc_array]:
    """Contact pairs on all working flanks.

    Parameters
    ----------
    strip : Strip
    mesh : BeltMesh
        N nodes.

    Returns
    -------
    flanks : Flanks
        n pairs.
    lines : tuple of FlankLine
    columns : (2N, n) csc_array
        Nodal loads in x and y of a unit force of the pulley on each pair.
    """
    parts: list[tuple[Floats, ...]] = [(np.zeros(0, dtype=np.int64), *_no_pairs())]
    lines, columns = [], [csc_array((2 * len(mesh.nodes), 0))]
    for tooth, nodes in sorted(mesh.flanks.items()):
        angle = strip.pitch_rad * (tooth + 0.5)
        places = mesh.nodes[nodes]
        shapes, hats, along = _hats(places)
        size = np.linalg.norm(along, axis=1)
        out = np.column_stack([-along[:, 1], along[:, 0]])
        at = shapes @ places
        length = hats.T @ size
        lever = -(hats.T @ (at[:, 0] * out[:, 1] - at[:, 1] * out[:, 0])) / length
        gap = (hats.T @ (size * strip.gaps(strip.in_tooth(at, angle)))) / length
        middle = (hats.T @ (size[:, None] * at)) / length[:, None]
        normal = hats.T @ out
        normal = normal / np.linalg.norm(normal, axis=1)[:, None]
        parts.append((np.full(length.size, tooth), middle, normal, lever, gap, length))
        own = -np.einsum("gq,gh,gd->qdh", shapes, hats, out) / length
        columns.append(_at_nodes(own.reshape(-1, length.size), degrees_of(nodes), mesh))
        lines.append(FlankLine(tooth, places))
    found = Flanks(*(np.concatenate(part) for part in zip(*parts, strict=True)))
    return found, tuple(lines), hstack(columns, format="csc")


def _no_pairs() -> tuple[Floats, ...]:
    return tuple(np.zeros(shape) for shape in ((0, 2), (0, 2), 0, 0, 0))


@dataclass(frozen=True)
class Lands:
    """Shape functions on all lands: h functions, N nodes; radial and circumferential components.

    Attributes
    ----------
    number : (h,) array
        Land of each shape function.
    angle_rad : (h,) array
        Angle of the end node of each shape function.
    degrees : (h,) array
        Degrees of freedom that `basis` replaces by the displacements of the shape functions.
    basis : (2N, 2N) csc_array
        Displacements of the nodes by the other degrees of freedom and by these displacements.
    forces : (2N, h) csc_array
        Nodal loads of a unit circumferential force on each shape function.
    """

    number: Numbers
    angle_rad: Floats
    degrees: Numbers
    basis: csc_array
    forces: csc_array


def land_columns(mesh: BeltMesh) -> Lands:
    """Shape functions on all lands, and the radial displacements of lands in terms of them.

    The radial displacement of a land is the linear function whose moments with all shape functions
    equal those of the displacements u there, ∫ hat u = ∫ hat way. A land fixed in this sense is
    held by pressures that its shape functions can represent, and no single node is held further.
    The quadratic functions at the ends of an edge have a moment with their own shape function only,
    so the land displacements replace the displacements there.

    Parameters
    ----------
    mesh : BeltMesh
        N nodes.

    Returns
    -------
    Lands
    """
    size = 2 * len(mesh.nodes)
    numbers, degrees, entries = [np.zeros(0, dtype=np.int64)], [np.zeros(0, dtype=np.int64)], []
    forces = [csc_array((size, 0))]
    for number, nodes in sorted(mesh.lands.items()):
        shapes, hats, along = _hats(mesh.nodes[nodes])
        weighted = np.linalg.norm(along, axis=1)[:, None] * hats
        moments = weighted.T @ shapes
        own = moments[:, ::2].diagonal()[:, None]
        ends, middles = 2 * nodes[::2], 2 * nodes[1::2]
        for values, columns in ((weighted.T @ hats, ends), (-moments[:, 1::2], middles)):
            row, column = np.nonzero(np.abs(values) > NO_MOMENT * own)
            entries.append((ends[row], columns[column], (values / own)[row, column]))
        numbers.append(np.full(ends.size, number))
        degrees.append(ends)
        forces.append(_at_nodes(moments.T / weighted.sum(axis=0), 2 * nodes + 1, mesh))
    ways = np.concatenate(degrees)
    others = np.setdiff1d(np.arange(size), ways)
    entries.append((others, others, np.ones(others.size)))
    rows, columns, values = (np.concatenate(part) for part in zip(*entries, strict=True))
    return Lands(
        np.concatenate(numbers),
        mesh.turns_rad[ways // 2],
        ways,
        assembled(values, rows, columns, (size, size)),
        hstack(forces, format="csc"),
    )


def _at_nodes(values: Floats, degrees: Numbers, mesh: BeltMesh) -> csc_array:
    """Columns (2N, k) with these values at these degrees of freedom, and zeros elsewhere."""
    rows = np.repeat(degrees, values.shape[1])
    columns = np.tile(np.arange(values.shape[1]), degrees.size)
    shape = (2 * len(mesh.nodes), values.shape[1])
    return assembled(values.ravel(), rows, columns, shape)


def _hats(places: Floats) -> tuple[Floats, Floats, Floats]:
    """Linear shape functions on the ends of quadratic edges, and the edges' quadratic functions.

    Parameters
    ----------
    places : (m, 2) array
        Nodes in order, every second one a mid-side node.

    Returns
    -------
    shapes : (g, m) array
        Quadratic functions of the nodes at the Gauss points of all edges.
    hats : (g, (m + 1)/2) array
    along : (g, 2) array
        Tangents at the points, times the weight of the point and the length of the edge, mm.
    """
    points, weights = leggauss(GAUSS_POINTS)
    local = np.column_stack([points * (points - 1) / 2, 1 - points**2, points * (points + 1) / 2])
    slopes = np.column_stack([points - 0.5, -2 * points, points + 0.5])
    edges = (len(places) - 1) // 2
    shapes = np.zeros((edges, GAUSS_POINTS, len(places)))
    hats = np.zeros((edges, GAUSS_POINTS, edges + 1))
    along = np.zeros((edges, GAUSS_POINTS, 2))
    for e in range(edges):
        nodes = slice(2 * e, 2 * e + 3)
        shapes[e, :, nodes] = local
        hats[e, :, e] = 0.5 * (1 - points)
        hats[e, :, e + 1] = 0.5 * (1 + points)
        along[e] = weights[:, None] * (slopes @ places[nodes])
    return (
        shapes.reshape(-1, len(places)),
        hats.reshape(-1, edges + 1),
        along.reshape(-1, 2),
    )
