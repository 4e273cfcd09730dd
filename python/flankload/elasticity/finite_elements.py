"""Stiffness of plane sections, of plane bodies and of prisms, and loads on their elements.

A plane body is one with constant displacements along its axis, per mm of width. In a prism, in the
frame that rotates with the section, the displacement v has the axial derivative
D v = dv/dz + kappa L v, L v = y dv/dx - x dv/dy + (-v_y, v_x, 0). The strain
(xx, yy, zz, 2xy, 2xz, 2yz) is P v + Q dv/dz, and with functions phi_a of z

    K = K_PP x M + K_PQ x D1 + K_PQ' x D1' + K_QQ x S1,  K_PP = integral of P'CP dA, ...

(x: Kronecker product; M, D1, S1: `axial_basis`). The Jacobian of the twist is 1. In the plane there
is K_PP alone, of the strains xx, yy and 2xy.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from flankload.elasticity.axial_basis import PLANE, AxialBasis, cross_terms
from flankload.elasticity.shape_functions import block_basis

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flankload.base.arrays import Cells, Floats, Numbers
    from flankload.bodies.body import Material
    from flankload.elasticity.axial_basis import AxialFunctions
    from flankload.elasticity.shape_functions import BlockBasis

#: Strains and products of operators (P is 0, Q is 1) in the plane and in a prism.
PLANE_STRAINS, PLANE_TERMS = (0, 1, 3), ((0, 0),)
ALL_STRAINS, ALL_TERMS = tuple(range(6)), ((0, 0), (0, 1), (1, 0), (1, 1))


@dataclass(frozen=True, eq=False)
class SectionStiffness:
    """Blocks of the section matrices for pairs of nodes that share an element, and functions of z.

    A node has c (p + 1) unknowns for c components, by axial function, then component: 2 in the
    plane, 3 (p + 1) in a prism.

    Attributes
    ----------
    rows, columns : (n,) arrays
        Nodes i and j, each pair once in a region, by ascending region, i, j.
    blocks : (n, t, c, c) array
        For c components: K_PP, and in a prism K_PQ, K_QP = K_PQ' and K_QQ; N/mm per mm, N/mm, N/mm,
        N.
    nodes : int
        Number of nodes.
    regions : (n,) array
        Number of the region of each block.
    region_of_cells : tuple of int
        Number of the region of each entry of the mesh's cells.
    twist : float
        kappa, rad/mm, counter-clockwise with increasing z.
    functions : AxialFunctions
        Functions of the nodes.
    cut_degree : int
        Degree q <= p in z of the displacements of the cuts of a sector: the first c (q + 1)
        unknowns of their nodes.
    halved : bool
        Whether the second half of a symmetric sector is taken as the image of the first.
    """

    rows: Numbers
    columns: Numbers
    blocks: Floats
    nodes: int
    regions: Numbers
    region_of_cells: tuple[int, ...] = (0,)
    twist: float = 0.0
    functions: AxialFunctions = PLANE
    cut_degree: int = 0
    halved: bool = True

    @property
    def components(self) -> int:
        """Components of a displacement."""
        return self.blocks.shape[-1]

    @property
    def unknowns(self) -> int:
        """Unknowns of a node."""
        return self.components * self.functions.count

    @property
    def bytes(self) -> int:
        """Size of the arrays."""
        return self.rows.nbytes + self.columns.nbytes + self.blocks.nbytes + self.regions.nbytes

    def in_section(self, values: Floats) -> Floats:
        """Unknowns (N, u) of displacements (N, 2) in the section that do not depend on z."""
        bases, of_node = self.functions.of_nodes(np.arange(self.nodes))
        found = np.zeros((self.nodes, self.functions.count, self.components))
        widths = np.array([basis.width_mm for basis in bases])
        found[:, 0, :2] = np.sqrt(widths[of_node])[:, None] * values
        return found.reshape(self.nodes, self.unknowns)

    def times(self, moved: Floats) -> Floats:
        """Forces (N, u) of displacements (N, u)."""
        by_function = moved.reshape(self.nodes, -1, self.components)
        found = np.zeros_like(by_function)
        number, terms = self.functions.products(self)
        for each, axial in enumerate(terms[:, : self.blocks.shape[1]]):
            own = np.flatnonzero(number == each)
            by_z = np.einsum("tab,nbd->ntad", axial, by_function[self.columns[own]])
            np.add.at(found, self.rows[own], np.einsum("ntcd,ntad->nac", self.blocks[own], by_z))
        return found.reshape(moved.shape)


def plane_moduli(material: Material, plane: str) -> tuple[float, float]:
    """E' (MPa) and nu' of the plane: E and nu, in plane strain E/(1 - nu²) and nu/(1 - nu)."""
    modulus, ratio = material.young_modulus_MPa, material.poisson_ratio
    if plane == "strain":
        return modulus / (1.0 - ratio**2), ratio / (1.0 - ratio)
    return modulus, ratio


def lame_parameters(material: Material, plane: str) -> tuple[float, float]:
    """Lamé's lambda and mu (MPa) in plane "strain" or "stress"."""
    modulus, ratio = plane_moduli(material, plane)
    return modulus * ratio / (1.0 - ratio**2), modulus / (2.0 * (1.0 + ratio))


def stiffness(nodes: Floats, cells: Cells, material: Material, plane: str) -> SectionStiffness:
    """Stiffness of a plane mesh of quadratic elements, N/mm per mm of width.

    Parameters
    ----------
    nodes : (N, 2) array
        mm.
    cells : ((kind, (E, k) array), ...)
        "quad9" or "triangle6" in meshio's node order; blocks of both kinds may share nodes.
    plane : {"strain", "stress"}
    """
    moduli = _moduli(material, plane)[np.ix_(PLANE_STRAINS, PLANE_STRAINS)]
    blocks = []
    for kind, own in cells:
        basis = block_basis(nodes, kind, own)
        operators = _in_section(basis, 1, PLANE_STRAINS, 2)
        blocks.append(_element_blocks(basis, operators, moduli, PLANE_TERMS))
    return _summed(len(nodes), cells, blocks, [0] * len(cells))


def section_stiffness(
    nodes: Floats, cells: Cells, material: Material, twist: float, regions: Sequence[int] = ()
) -> SectionStiffness:
    """Section matrices of a prism with the axis at the origin, without its functions of z.

    Nodes and cells as for `stiffness`; `twist`: kappa, rad/mm; `regions`: number of the region of
    each entry of `cells`, by default one.
    """
    moduli = _moduli(material, "strain")
    blocks = []
    for kind, own in cells:
        basis = block_basis(nodes, kind, own)
        blocks.append(_element_blocks(basis, _along_axis(basis, twist), moduli, ALL_TERMS))
    return replace(_summed(len(nodes), cells, blocks, regions or [0] * len(cells)), twist=twist)


def _summed(
    count: int, cells: Cells, blocks: Sequence[Floats], regions: Sequence[int]
) -> SectionStiffness:
    """Stiffness of `count` nodes from the blocks of elements."""
    places = []
    for number, (_, connectivity) in zip(regions, cells, strict=True):
        k = connectivity.shape[1]
        row = np.repeat(connectivity, k, axis=1).ravel()
        column = np.tile(connectivity, k).ravel()
        places.append((number * count + row) * count + column)
    place, part = np.concatenate(places), np.concatenate(blocks)
    order = np.argsort(place, kind="stable")
    place = place[order]
    first = np.flatnonzero(np.append(True, place[1:] != place[:-1]))
    total = np.add.reduceat(part[order], first, axis=0)
    region_and_row, columns = np.divmod(place[first], count)
    region, rows = np.divmod(region_and_row, count)
    return SectionStiffness(rows, columns, total, count, region, tuple(regions))


def _in_section(
    basis: BlockBasis, operators: int, strains: tuple[int, ...], components: int
) -> Floats:
    """Operators P and perhaps Q (o, strains, k, c, E, points), with the in-plane strains of P."""
    dx, dy = basis.slopes[:, 0], basis.slopes[:, 1]
    k, *of_elements = dx.shape
    found = np.zeros((operators, len(strains), k, components, *of_elements))
    p, xy = found[0], strains.index(3)
    p[0, :, 0] = p[xy, :, 1] = dx
    p[1, :, 1] = p[xy, :, 0] = dy
    return found


def _along_axis(basis: BlockBasis, twist: float) -> Floats:
    """Both operators of a prism."""
    found = _in_section(basis, 2, ALL_STRAINS, 3)
    (p, q), (x, y) = found, basis.places
    dx, dy = basis.slopes[:, 0], basis.slopes[:, 1]
    value = np.broadcast_to(basis.values[:, None], dx.shape)
    turned = twist * (y * dx - x * dy)
    p[4, :, 2], p[5, :, 2] = dx, dy
    p[2, :, 2] = p[4, :, 0] = p[5, :, 1] = turned
    p[4, :, 1], p[5, :, 0] = -twist * value, twist * value
    q[2, :, 2] = q[4, :, 0] = q[5, :, 1] = value
    return found


def _element_blocks(
    basis: BlockBasis, own: Floats, moduli: Floats, terms: Sequence[tuple[int, int]]
) -> Floats:
    """Blocks (E k k, t, c, c) of all pairs of nodes of each element from its operators."""
    _, strains, k, c, elements, points = own.shape
    strain = np.ascontiguousarray(own.transpose(0, 4, 5, 1, 2, 3))
    strain = strain.reshape(len(own), elements, points, strains, k * c)
    stress = (moduli @ strain * basis.dx[:, :, None, None]).reshape(len(own), elements, -1, k * c)
    strain = strain.reshape(stress.shape)
    blocks = np.empty((elements, k, k, len(terms), c, c))
    for term, (one, two) in enumerate(terms):
        product = strain[one].transpose(0, 2, 1) @ stress[two]
        blocks[:, :, :, term] = product.reshape(elements, k, c, k, c).transpose(0, 1, 3, 2, 4)
    return blocks.reshape(-1, len(terms), c, c)


def _moduli(material: Material, plane: str) -> Floats:
    """C for strains (xx, yy, zz, 2xy, 2xz, 2yz), MPa."""
    lame_lambda, lame_mu = lame_parameters(material, plane)
    moduli = np.diag([2.0 * lame_mu] * 3 + [lame_mu] * 3)
    moduli[:3, :3] += lame_lambda
    return moduli


def centrifugal_load(section: SectionStiffness, nodes: Floats, cells: Cells) -> Floats:
    """Consistent nodal loads (N, u) of a force per volume equal to the distances from the axis.

    Times density and the square of the speed, the centrifugal force; in the plane per mm of width.
    """
    bases, of_node = section.functions.of_nodes(np.arange(len(nodes)))
    found = np.zeros((len(nodes), section.functions.count, section.components))
    for region, (kind, connectivity) in zip(section.region_of_cells, cells, strict=True):
        basis = block_basis(nodes, kind, connectivity)
        force, in_plane = basis.dx * basis.places, np.zeros_like(nodes)  # (2, E, points)
        for value, node in zip(basis.values, connectivity.T, strict=True):
            np.add.at(in_plane, node, (force * value).sum(axis=2).T)
        over = AxialBasis(bases[region].range_mm, 0)
        along = np.stack([cross_terms(each, over, over)[0][:, 0] for each in bases])
        along *= np.sqrt(over.width_mm)
        found[..., :2] += along[of_node][:, :, None] * in_plane[:, None, :]
    return found.reshape(len(nodes), -1)


def degrees_of(nodes: Numbers) -> Numbers:
    """Degrees of freedom of nodes, x and y alternating."""
    return (2 * np.asarray(nodes)[:, None] + np.arange(2)).ravel()
