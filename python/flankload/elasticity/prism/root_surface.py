"""Stress on the root fillets of a prism, a free surface that rotates with the section.

The surface is P(s) rotated by kappa z. With the unit tangent t of the section, e = (-kappa y,
kappa x, 1) along the line of constant s, the displacements v and
w = dv/dz + kappa (-v_y, v_x, 0), the strains of the surface are

    E_ss = t.dv/ds,  E_zz = e.w,  2 E_sz = t.w + e.dv/ds                                   (R6)

in the oblique directions t and e; g = |e|, c = t.e/g. Across and along the root line e

    e_11 = (E_ss - 2 c E_sz/g + c² E_zz/g²)/(1 - c²),  e_22 = E_zz/g²
    s_11 = E/(1 - nu²) (e_11 + nu e_22)                                                    (R7)

for a free surface. The factors do not depend on z, so that the stress is a polynomial of the degree
of the displacements.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flankload.elasticity.axial_basis import cross_terms

if TYPE_CHECKING:
    from flankload.base.arrays import Floats
    from flankload.bodies.body import Material
    from flankload.bodies.root_fillet import FilletNodes
    from flankload.elasticity.axial_basis import AxialBasis, AxialFunctions


def root_surface_stress(
    fillet: FilletNodes,
    functions: AxialFunctions,
    axial: AxialBasis,
    material: Material,
    twist: float,
) -> Floats:
    """Stress s_11 across the root line at the points of fillets, from displacements of their nodes.

    (q (p + 1), 3 m (p + 1)), MPa/mm: by point and function of z, from unknowns by node, function of
    z and component. Displacements are in terms of `functions`, the stress in terms of `axial`, of
    the same degree, over the width of the teeth; `twist` is kappa, rad/mm.
    """
    count = axial.count
    x, y = fillet.places.T
    t = np.column_stack([fillet.tangents, np.zeros(len(x))])
    e = np.column_stack([-twist * y, twist * x, np.ones_like(x)])
    g = np.linalg.norm(e, axis=1)
    c = np.einsum("qd,qd->q", t, e) / g
    slope = np.einsum("mq,ab,cd->qmacbd", fillet.slopes, np.eye(count), np.eye(3))
    turned = twist * np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
    per_z = np.einsum("ab,cd->acbd", axial.mixed, np.eye(3))
    per_z += np.einsum("ab,cd->acbd", np.eye(count), turned)
    change = np.einsum("mq,acbd->qmacbd", fillet.shapes, per_z)
    along, across = (np.einsum("qc,qmacbd->qmabd", t, part) for part in (slope, change))
    e_ss, e_zz = along, np.einsum("qc,qmacbd->qmabd", e, change)
    e_sz = 0.5 * (across + np.einsum("qc,qmacbd->qmabd", e, slope))
    g, c = g[:, None, None, None, None], c[:, None, None, None, None]
    square = 1.0 - c**2
    e_11 = (e_ss - 2.0 * c * e_sz / g + c**2 * e_zz / g**2) / square
    e_22 = e_zz / g**2
    nu = material.poisson_ratio
    stress = material.young_modulus_MPa / (1.0 - nu**2) * (e_11 + nu * e_22)
    bases, number = functions.of_nodes(fillet.nodes)
    if bases != (axial,):  # projection of each node's functions on those of the teeth
        in_axial = np.stack([cross_terms(axial, basis, axial)[0] for basis in bases])[number]
        stress = np.einsum("qmabd,mbe->qmaed", stress, in_axial)
    return np.ascontiguousarray(stress.transpose(0, 2, 1, 3, 4)).reshape(len(x) * count, -1)
