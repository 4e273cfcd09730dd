"""Reactions on a bore of which only the mean motion is held.

Only the six mean rigid motions of the bore (or of the outside of a ring) are held, three in the
plane: the means of the displacement u and of r x u over the surface. The reactions that do this are
tractions in proportion to the same motions,

    t = (E/R) (u_0 + t_0 x r/R),  R the radius of the bore,                                  (M2)

which carry the torque evenly, and a force as a cosine around the bore, without a resistance to
oval deformation (a distributing coupling). As readings, their nodal forces are the mean motions,
which vanish: the rotation of the body is the mean rotation of its bore. The factor E/R makes the
unknowns of (M1) lengths.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flankload.base.gauss import leggauss
from flankload.base.rotation import directions
from flankload.elasticity.condensed_sector import IN_PLANE

if TYPE_CHECKING:
    from flankload.base.arrays import Floats, Numbers
    from flankload.bodies.body import SectorMesh
    from flankload.elasticity.axial_basis import AxialBasis
    from flankload.elasticity.finite_elements import SectionStiffness

#: Gauss points along an edge, exact for straight ones with shape function and coordinate.
EDGE_POINTS = 4
#: Gauss points along the axis beyond the degree of the displacements: a helix turns the motions,
#: whose sines and cosines these integrate to rounding errors.
TURN_POINTS = 8


def bore_reactions(mesh: SectorMesh, section: SectionStiffness, young_modulus_MPa: float) -> Floats:
    """Forces (N, u, n) of unit reactions on the free bore of a sector, N/mm, per mm in the plane.

    By node and unknown, in the frame that rotates with the helix; u_x, u_y and t_z in the plane,
    all six motions in a prism, none for a fixed bore. Rotations are those about the middle of the
    bore.
    """
    if not mesh.has_free_bore:
        return np.zeros((section.nodes, section.unknowns, 0))
    nodes, moments = _moments(mesh)
    radius = float(np.hypot(*mesh.nodes[mesh.bore_edges[0, 0]]))
    basis = _basis_of_bore(section, nodes)
    along = _along(basis, section, radius, middle_mm=0.5 * sum(basis.range_mm))
    if section.components == 2:
        along = along[:, :, :2, IN_PLANE]
    found = np.zeros((section.nodes, basis.count, *along.shape[2:]))
    found[nodes] = young_modulus_MPa / radius * np.einsum("kj,ajcm->kacm", moments, along)
    return found.reshape(section.nodes, section.unknowns, -1)


def rim_forces(mesh: SectorMesh, section: SectionStiffness, degree: int) -> Floats:
    """Forces (N, u, 2 (degree + 1)) on the bore of a sector, by node and unknown.

    They are spread evenly around it, along the radius through its middle and across it, and over
    the width as P_b(xi)/b, b = 0 ... degree: pairs for each polynomial. The evenly spread ones are
    unit forces, the middle turns with the helix.
    """
    nodes, moments = _moments(mesh)
    x, y = mesh.nodes[nodes].T
    first = np.arctan2(y[0], x[0])
    angles = (np.arctan2(y, x) - first + np.pi) % (2 * np.pi) - np.pi
    middle = float(first + 0.5 * (angles.min() + angles.max()))
    share = moments[:, 0] / moments[:, 0].sum()
    along = directions(np.array([middle, middle + 0.5 * np.pi]))
    basis = _basis_of_bore(section, nodes)
    over_width = basis.load_vectors(degree) / basis.width_mm
    found = np.zeros((section.nodes, basis.count, section.components, degree + 1, 2))
    found[nodes, :, :2] = np.einsum("k,ab,fc->kacbf", share, over_width, along)
    return found.reshape(section.nodes, section.unknowns, -1)


def resultants(nodes: Floats, section: SectionStiffness, forces: Floats) -> Floats:
    """Resultants (3, n) of nodal forces (N, u, n): along x and y, and about the axis."""
    bases, of_node = section.functions.of_nodes(np.arange(len(nodes)))
    rigid = np.zeros((len(nodes), bases[0].count, section.components, 3))
    factors = np.column_stack([np.ones(len(nodes)), nodes])
    for number, basis in enumerate(bases):
        motions = _along(basis, section, 1.0, 0.0)[:, :, : section.components, IN_PLANE]
        own = of_node == number
        rigid[own] = np.einsum("kj,ajcm->kacm", factors[own], motions)
    return np.asarray(rigid.reshape(-1, 3).T @ forces.reshape(-1, forces.shape[-1]))


def _basis_of_bore(section: SectionStiffness, nodes: Numbers) -> AxialBasis:
    """Functions of z of the nodes of the bore, which belongs to one region."""
    bases, of_node = section.functions.of_nodes(nodes)
    return bases[of_node[0]]


def _along(basis: AxialBasis, section: SectionStiffness, radius: float, middle_mm: float) -> Floats:
    """(p + 1, 3, 3, 6) Integrals of functions of z times `_motions`."""
    low, high = basis.range_mm
    points, weights = leggauss(basis.count + TURN_POINTS)
    z, weights = 0.5 * (low + high + (high - low) * points), 0.5 * (high - low) * weights
    fields = _motions(z, section.twist, radius, middle_mm)
    return np.asarray(np.einsum("ga,g,gjcm->ajcm", basis.values(z), weights, fields))


def _moments(mesh: SectorMesh) -> tuple[Numbers, Floats]:
    """Nodes (k,) of the bore of a sector, and integrals (k, 3) of their functions by 1, x, y."""
    x, weights = leggauss(EDGE_POINTS)
    shapes = np.stack([0.5 * x * (x - 1.0), 0.5 * x * (x + 1.0), 1.0 - x**2], axis=1)
    slopes = np.stack([x - 0.5, x + 0.5, -2.0 * x], axis=1)
    ends = mesh.nodes[mesh.bore_edges]
    places = np.einsum("gk,mkd->mgd", shapes, ends)
    length = np.linalg.norm(np.einsum("gk,mkd->mgd", slopes, ends), axis=2) * weights
    by = np.concatenate([np.ones((*length.shape, 1)), places], axis=2)
    total = np.zeros((len(mesh.nodes), 3))
    np.add.at(total, mesh.bore_edges, np.einsum("mg,gk,mgj->mkj", length, shapes, by))
    nodes = np.unique(mesh.bore_edges)
    return nodes, total[nodes]


def _motions(z: Floats, twist: float, radius: float, middle_mm: float) -> Floats:
    """Motions (g, 3, 3, 6) of a rigid body at z (g,), in the frame that rotates with the helix.

    By the factors of 1, x, y in that frame, component and motion; rotations over the radius.
    """
    cosine, sine, apart = np.cos(twist * z), np.sin(twist * z), z - middle_mm
    found = np.zeros((z.size, 3, 3, 6))
    found[:, 0, 0, 0], found[:, 0, 1, 0] = cosine, -sine
    found[:, 0, 0, 1], found[:, 0, 1, 1] = sine, cosine
    found[:, 0, 2, 2] = 1.0
    # t x r with r = (x cos - y sin, x sin + y cos, z)
    found[:, 0, 0, 3], found[:, 0, 1, 3] = -apart * sine, -apart * cosine
    found[:, 1, 2, 3], found[:, 2, 2, 3] = sine, cosine
    found[:, 0, 0, 4], found[:, 0, 1, 4] = apart * cosine, -apart * sine
    found[:, 1, 2, 4], found[:, 2, 2, 4] = -cosine, sine
    found[:, 2, 0, 5], found[:, 1, 1, 5] = -1.0, 1.0
    found[..., 3:] /= radius
    return found
