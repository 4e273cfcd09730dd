"""Columns of nodal forces on a timing belt: linear hats on its flanks and its lands.

A hat is 1 at an end of an element's edge and falls to 0 at its neighbours. Forces are spread over
the elements by it, and displacements are read by the same.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.polynomial.legendre import leggauss
from scipy.sparse import csc_matrix, hstack

from flankload.elasticity import degrees_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from flankload.bodies.belt import Strip
    from flankload.bodies.belt_mesh import BeltMesh

    Floats = NDArray[np.float64]
    Numbers = NDArray[np.int64]

#: Of the edges.
GAUSS_POINTS = 4


@dataclass(frozen=True)
class Flanks:
    """Contact pairs on the working flanks; n pairs.

    Attributes
    ----------
    tooth : (n,) array
        On which each stands, from the tight end.
    places, normals : (n, 2) arrays
        About the axis of the pulley, mm; normals out of the belt.
    levers_mm : (n,) array
        Moment about the axis of a unit force of the pulley on the belt.
    gaps_mm : (n,) array
        To the groove, along the normals.
    lengths_mm : (n,) array
        Of flank that each stands for.
    """

    tooth: Numbers
    places: Floats
    normals: Floats
    levers_mm: Floats
    gaps_mm: Floats
    lengths_mm: Floats


def flank_columns(strip: Strip, mesh: BeltMesh) -> tuple[Flanks, csc_matrix]:
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
    columns : (2N, n) csc_matrix
        Nodal loads in x and y of a unit force of the pulley on each.
    """
    parts: list[tuple[Floats, ...]] = []
    columns = []
    for k, nodes in enumerate(mesh.flanks):
        assert strip.tooth is not None
        angle = float(strip.tooth_angles_rad[k])
        places = mesh.nodes[nodes]
        shapes, hats, along = _hats(places)
        out = np.column_stack([-along[:, 1], along[:, 0]])
        at = shapes @ places
        length = hats.T @ np.linalg.norm(along, axis=1)
        lever = -(hats.T @ (at[:, 0] * out[:, 1] - at[:, 1] * out[:, 0])) / length
        inside = strip.gaps(strip.in_tooth(at, angle))
        gap = (hats.T @ (np.linalg.norm(along, axis=1) * inside)) / length
        middle = (hats.T @ (np.linalg.norm(along, axis=1)[:, None] * at)) / length[:, None]
        normal = hats.T @ out
        normal = normal / np.linalg.norm(normal, axis=1)[:, None]
        parts.append((np.full(length.size, k), middle, normal, lever, gap, length))
        own = -np.einsum("gq,gh,gd->qdh", shapes, hats, out) / length
        columns.append(_at_nodes(own.reshape(-1, length.size), degrees_of(nodes), mesh))
    if not parts:
        nothing = np.zeros(0)
        none = Flanks(
            nothing.astype(int),
            nothing.reshape(0, 2),
            nothing.reshape(0, 2),
            nothing,
            nothing,
            nothing,
        )
        return none, csc_matrix((2 * len(mesh.nodes), 0))
    return Flanks(*(np.concatenate(part) for part in zip(*parts, strict=True))), hstack(
        columns, format="csc"
    )


def land_columns(mesh: BeltMesh) -> tuple[Numbers, csc_matrix, csc_matrix]:
    """Hats on all lands.

    Parameters
    ----------
    mesh : BeltMesh
        N nodes.

    Returns
    -------
    numbers : (h,) array
        Land of each hat.
    hats : (2N, h) csc_matrix
        The hats outwards, at the nodes; components outwards and along the turn.
    forces : (2N, h) csc_matrix
        Nodal loads of a unit force along the turn on each.
    """
    numbers, hats, spread = [], [], []
    for k, nodes in enumerate(mesh.lands):
        shapes, values, along = _hats(mesh.nodes[nodes])
        length = np.linalg.norm(along, axis=1)
        count = values.shape[1]
        own = np.repeat(np.eye(count), 2, axis=0)[:-1]
        own[1::2] = 0.5 * (np.eye(count)[:-1] + np.eye(count)[1:])
        force = shapes.T @ (length[:, None] * values) / (length @ values)
        numbers.append(np.full(count, k))
        hats.append(_at_nodes(own, 2 * nodes, mesh))
        spread.append(_at_nodes(force, 2 * nodes + 1, mesh))
    return np.concatenate(numbers), hstack(hats, format="csc"), hstack(spread, format="csc")


def _at_nodes(values: Floats, degrees: Numbers, mesh: BeltMesh) -> csc_matrix:
    """Columns (2N, k) that are 0 but for these degrees of freedom."""
    rows = np.repeat(degrees, values.shape[1])
    columns = np.tile(np.arange(values.shape[1]), degrees.size)
    shape = (2 * len(mesh.nodes), values.shape[1])
    return csc_matrix((values.ravel(), (rows, columns)), shape=shape)


def _hats(places: Floats) -> tuple[Floats, Floats, Floats]:
    """Linear hats on the ends of quadratic edges, and the edges' own functions.

    Parameters
    ----------
    places : (m, 2) array
        Of nodes in order, every second one a middle.

    Returns
    -------
    shapes : (g, m) array
        Of the nodes at the Gauss points of all edges.
    hats : (g, (m + 1)/2) array
    along : (g, 2) array
        Tangents there, times the weight of the point and the length of the edge, mm.
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
