"""Stiffness of the plane section of a prism with three displacement components and twist.

In the frame that rotates with the section, the displacement v has the axial derivative
D v = dv/dz + kappa L v, L v = y dv/dx - x dv/dy + (-v_y, v_x, 0). The strain
(xx, yy, zz, 2xy, 2xz, 2yz) is P v + Q dv/dz, and with functions phi_a of z

    K = K_PP x M + K_PQ x D1 + K_PQ' x D1' + K_QQ x S1,  K_PP = integral of P'CP dA, ...

(x: Kronecker product; M, D1, S1: `axial_basis`). The Jacobian of the twist is 1.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flankload.elasticity.finite_elements import block_basis, lame_parameters

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flankload.base.arrays import Cells, Floats, Numbers
    from flankload.bodies.body import Material

#: Degree of the integration, for products of shape functions and of gradients times x and y.
SECTION_DEGREE = 6


@dataclass(frozen=True, eq=False)
class SectionStiffness:
    """Blocks of the four section matrices for pairs of nodes that share an element.

    Attributes
    ----------
    rows, columns : (n,) arrays
        Nodes i and j, each pair once in a region, by ascending region, i, j.
    blocks : (n, 4, 3, 3) array
        K_PP, K_PQ, K_QP = K_PQ' and K_QQ; N/mm per mm, N/mm, N/mm, N.
    nodes : int
        Number of nodes.
    regions : (n,) array
        Number of the region of each block.
    """

    rows: Numbers
    columns: Numbers
    blocks: Floats
    nodes: int
    regions: Numbers


def section_stiffness(
    nodes: Floats, cells: Cells, material: Material, twist: float, regions: Sequence[int] = ()
) -> SectionStiffness:
    """Section matrices of a plane mesh with the axis at the origin.

    Nodes and cells as of `finite_elements.stiffness`; `twist`: kappa, rad/mm, counter-clockwise
    with increasing z; `regions`: number of the region of each entry of `cells`, by default one.
    """
    places, parts, count = [], [], len(nodes)
    for number, (kind, connectivity) in zip(regions or [0] * len(cells), cells, strict=True):
        parts.append(_element_blocks(nodes, kind, connectivity, material, twist))
        k = connectivity.shape[1]
        row = np.repeat(connectivity, k, axis=1).ravel()
        column = np.tile(connectivity, k).ravel()
        places.append((number * count + row) * count + column)
    place, part = np.concatenate(places), np.concatenate(parts)
    order = np.argsort(place, kind="stable")
    place = place[order]
    first = np.flatnonzero(np.append(True, place[1:] != place[:-1]))
    total = np.add.reduceat(part[order], first, axis=0)
    region_and_row, columns = np.divmod(place[first], count)
    region, rows = np.divmod(region_and_row, count)
    return SectionStiffness(rows, columns, total, count, region)


def _element_blocks(
    nodes: Floats, kind: str, connectivity: Numbers, material: Material, twist: float
) -> Floats:
    """Blocks (E k k, 4, 3, 3) of all pairs of nodes of each element."""
    basis = block_basis(nodes, kind, connectivity, SECTION_DEGREE)
    dx, dy = basis.slopes[:, 0], basis.slopes[:, 1]
    x, y = basis.places
    turned = twist * (y * dx - x * dy)
    k, elements, points = dx.shape
    value = np.broadcast_to(basis.values[:, None], dx.shape)
    own = np.zeros((2, 6, k, 3, elements, points))  # P and Q: strain, shape, component
    p, q = own
    p[0, :, 0] = p[3, :, 1] = p[4, :, 2] = dx
    p[1, :, 1] = p[3, :, 0] = p[5, :, 2] = dy
    p[2, :, 2] = p[4, :, 0] = p[5, :, 1] = turned
    p[4, :, 1], p[5, :, 0] = -twist * value, twist * value
    q[2, :, 2] = q[4, :, 0] = q[5, :, 1] = value
    strain = own.transpose(0, 4, 5, 1, 2, 3).reshape(2, elements, points * 6, 3 * k)
    stress = np.einsum(
        "st,pegtn->pegsn", _moduli(material), strain.reshape(2, elements, points, 6, -1)
    )
    stress = (stress * basis.dx[:, :, None, None]).reshape(strain.shape)
    blocks = np.empty((elements, k, k, 4, 3, 3))
    for term, (one, two) in enumerate(((0, 0), (0, 1), (1, 0), (1, 1))):
        product = strain[one].transpose(0, 2, 1) @ stress[two]
        blocks[:, :, :, term] = product.reshape(elements, k, 3, k, 3).transpose(0, 1, 3, 2, 4)
    return blocks.reshape(-1, 4, 3, 3)


def _moduli(material: Material) -> Floats:
    """C for strains (xx, yy, zz, 2xy, 2xz, 2yz), MPa."""
    lame_lambda, lame_mu = lame_parameters(material, "strain")
    moduli = np.diag([2.0 * lame_mu] * 3 + [lame_mu] * 3)
    moduli[:3, :3] += lame_lambda
    return moduli
