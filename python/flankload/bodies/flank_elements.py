"""Line elements along a flank for the interpolation of nodal loads and displacements."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flankload.base.gauss import leggauss

if TYPE_CHECKING:
    from flankload.base.arrays import Floats


GAUSS_POINTS = 8


def gauss_places(nodes: Floats, *, quadratic: bool) -> tuple[Floats, Floats, Floats]:
    """Gauss points of all elements, and the shape functions there.

    The nodes (n,) are ascending arc lengths, mm; `quadratic`: every second one is a middle node.
    Returns arc lengths (g,) and weights (g,) of the points, mm, and values (g, n) of the shape
    functions.
    """
    points, weights = leggauss(GAUSS_POINTS)
    if quadratic:
        local = np.stack([points * (points - 1) / 2, 1 - points**2, points * (points + 1) / 2], 1)
        slope = np.stack([points - 0.5, -2 * points, points + 0.5], 1)
    else:
        local = np.stack([(1 - points) / 2, (1 + points) / 2], 1)
        slope = np.broadcast_to([-0.5, 0.5], local.shape)
    order = local.shape[1] - 1
    first = np.arange(0, nodes.size - 1, order)
    members = first[:, None] + np.arange(order + 1)  # (m, order + 1)
    places = nodes[members] @ local.T  # (m, g)
    lengths = nodes[members] @ slope.T * weights
    shapes = np.zeros((first.size, GAUSS_POINTS, nodes.size))
    for element, row in enumerate(members):
        shapes[element][:, row] = local
    return places.ravel(), lengths.ravel(), shapes.reshape(-1, nodes.size)


def mass_matrix(nodes: Floats, *, quadratic: bool) -> Floats:
    """Mass matrix (n, n) of the shape functions, mm, from nodal pressures to nodal forces."""
    _, weights, shapes = gauss_places(nodes, quadratic=quadratic)
    return np.asarray(shapes.T @ (weights[:, None] * shapes))
