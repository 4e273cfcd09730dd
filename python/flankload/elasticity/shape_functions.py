"""Shape functions and quadrature rules of plane elements, in meshio's node order.

Triangles have the symmetric rules of D. A. Dunavant, Int. J. Numer. Meth. Eng. 21 (1985),
1129-1148, on the triangle (0, 0), (1, 0), (0, 1); quadrilaterals have Gauss rules on the unit
square.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from itertools import permutations
from typing import TYPE_CHECKING

import numpy as np

from flankload.base.gauss import leggauss

if TYPE_CHECKING:
    from flankload.base.arrays import Floats, Numbers

#: Degree of the quadrature of stiffness, loads and errors of the elements. Degree 6 changes the
#: compliance by less than 1 % of the estimated error of the elements (docs/decisions.md).
DEGREE = 4
#: By degree: weight over the area, and barycentric coordinates whose permutations are the points.
TRIANGLE_RULES = {
    2: ((0.333333333333333, 0.666666666666667, 0.166666666666667),),
    4: (
        (0.223381589678011, 0.108103018168070, 0.445948490915965),
        (0.109951743655322, 0.816847572980459, 0.091576213509771),
    ),
    8: (
        (0.144315607677787, 0.333333333333333, 0.333333333333333),
        (0.095091634267285, 0.081414823414554, 0.459292588292723),
        (0.103217370534718, 0.658861384496480, 0.170569307751760),
        (0.032458497623198, 0.898905543365938, 0.050547228317031),
        (0.027230314174435, 0.008394777409958, 0.263112829634638),
    ),
}
#: Barycentric coordinates of the rules that differ by less are equal.
ROUNDED = 1e-12


@dataclass(frozen=True, eq=False)
class BlockBasis:
    """Shape functions of a block of elements at its quadrature points.

    Attributes
    ----------
    values : (k, g) array
        Shape k, which belongs to node k of each element, at point g.
    slopes : (k, 2, E, g) array
        Its gradient in element e, 1/mm.
    places : (2, E, g) array
        The points, mm.
    dx : (E, g) array
        Weights of the points, mm².
    """

    values: Floats
    slopes: Floats
    places: Floats
    dx: Floats


def block_basis(
    nodes: Floats, kind: str, connectivity: Numbers, degree: int = DEGREE
) -> BlockBasis:
    """Isoparametric elements with a quadrature that is exact to a degree.

    Parameters
    ----------
    nodes : (N, 2) array
        mm.
    kind : {"quad9", "triangle6"}
    connectivity : (E, k) array
    """
    at, weights = quadrature(kind, degree)
    values, slopes = shape_functions(kind, at)
    shape = (2, len(connectivity), len(weights))
    places, jacobian = np.zeros(shape), np.zeros((2, *shape))  # dx_i/dX_j: [j, i]
    for value, slope, node in zip(values, slopes, connectivity.T, strict=True):
        place = nodes[node].T[:, :, None]
        places += place * value
        jacobian += place * slope[:, None, None]
    (xx, yx), (xy, yy) = jacobian
    area = xx * yy - xy * yx
    inverse = np.array([[yy, -xy], [-yx, xx]]) / area
    gradients = slopes[:, 0, None, None] * inverse[0] + slopes[:, 1, None, None] * inverse[1]
    return BlockBasis(values, gradients, places, np.abs(area) * weights)


@cache
def quadrature(kind: str, degree: int) -> tuple[Floats, Floats]:
    """Points (2, g) and weights (g,) of the element of reference, exact to an even degree."""
    if kind == "quad9":
        points, weights = leggauss(degree // 2 + 1)
        along = 0.5 * (1.0 + points)
        x, y = np.meshgrid(along, along, indexing="ij")
        return np.stack([x.ravel(), y.ravel()]), 0.25 * np.outer(weights, weights).ravel()
    found = []
    for weight, a, b in TRIANGLE_RULES[degree]:
        c = 1.0 - a - b
        corners = (a, b, b if abs(c - b) < ROUNDED else c)
        found += [(x, y, 0.5 * weight) for x, y, _ in sorted(set(permutations(corners)))]
    table = np.array(found)
    return table[:, :2].T, table[:, 2]


def shape_functions(kind: str, at: Floats) -> tuple[Floats, Floats]:
    """Shape functions (k, g) of the element of reference at points (2, g), and slopes (k, 2, g)."""
    x, y = at
    if kind == "quad9":
        along, across = (
            (
                np.stack([(1.0 - t) * (1.0 - 2.0 * t), t * (2.0 * t - 1.0), 4.0 * t * (1.0 - t)]),
                np.stack([4.0 * t - 3.0, 4.0 * t - 1.0, 4.0 - 8.0 * t]),
            )
            for t in (x, y)
        )
        i, j = np.array([0, 1, 1, 0, 2, 1, 2, 0, 2]), np.array([0, 0, 1, 1, 0, 2, 1, 2, 2])
        slopes = np.stack([along[1][i] * across[0][j], along[0][i] * across[1][j]], axis=1)
        return along[0][i] * across[0][j], slopes
    corner = np.stack([1.0 - x - y, x, y])
    change = np.array([[-1.0, -1.0], [1.0, 0.0], [0.0, 1.0]])
    one, two = np.array([0, 1, 2]), np.array([1, 2, 0])
    values = np.concatenate([corner * (2.0 * corner - 1.0), 4.0 * corner[one] * corner[two]])
    of_corner = (4.0 * corner - 1.0)[:, None] * change[:, :, None]
    of_edge = corner[one, None] * change[two, :, None] + corner[two, None] * change[one, :, None]
    return values, np.concatenate([of_corner, 4.0 * of_edge])


def places_of_nodes(kind: str) -> Floats:
    """Nodes (k, 2) of the element of reference."""
    if kind == "quad9":
        x = [0.0, 1.0, 1.0, 0.0, 0.5, 1.0, 0.5, 0.0, 0.5]
        y = [0.0, 0.0, 1.0, 1.0, 0.0, 0.5, 1.0, 0.5, 0.5]
    else:
        x, y = [0.0, 1.0, 0.0, 0.5, 0.5, 0.0], [0.0, 0.0, 1.0, 0.0, 0.5, 0.5]
    return np.column_stack([x, y])
