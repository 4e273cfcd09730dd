"""Contact of splines in three dimensions: slices whose flanks conform over a common height.

A slice has one unknown, its force F. It is distributed over strips of the height, q_i F on strip i,
like that of a coupling with equal forces on all slices and teeth:

    sum_k (sum over teeth and slices of C)_ik q_k = const,  sum q = 1                          (S5)
    K = q' C q,  g0 = sum_i q_i g_i,  K F + g0 - r_b phi >= 0,  r_b sum F = T                  (S6)

C is the compliance of both bodies between strips of slices. All normals of an involute have the
lever arm r_b. For a uniform load the rotation is exact; for gaps that vary over the height, the
error of K is of second order in the change of q. The core solves these equations at each position
(`fortran/position/conforming_slices.f90`).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from flankload.base.arrays import Floats
    from flankload.elasticity.compliance import BodyCompliance
    from flankload.pairing.gear_mesh import GearMesh

    Compliances = tuple[BodyCompliance, BodyCompliance]


def conforming_height(mesh: GearMesh, compliances: Compliances) -> Floats:
    """Part "height" of the record of the mesh, for S sites and J slices: (9 + (S J)²,)."""
    height, fit = mesh.slices.conforming, mesh.pairing.fit
    assert height is not None
    assert fit is not None
    spread, compliance = reduced_compliance(mesh, compliances)
    numbers = [*height.middle_s_mm, height.height_mm, *(spread @ height.normal), fit.turn_rad]
    return np.concatenate([numbers, height.tilt, [height.middle_z_mm], compliance.ravel()])


def reduced_compliance(mesh: GearMesh, compliances: Compliances) -> tuple[Floats, Floats]:
    """Part q (N,) of the force on each strip of the height, and K (S J, S J), mm/N, symmetric."""
    from flankload.elasticity.prism.strip_field import StripField

    pairing, slices, height = mesh.pairing, mesh.slices, mesh.slices.conforming
    assert height is not None
    fields = [
        StripField.of(compliance, body.teeth, s, height.strip_mm, slices.edges_mm)
        for body, compliance, s in zip(mesh.bodies, compliances, height.s_mm, strict=True)
    ]
    even = fields[0].of_even_load() + fields[1].of_even_load()
    # without elements, as for a run without torque, the strips are equal
    equal = np.ones(len(even))
    together = np.linalg.solve(even, equal) if even.any() else equal
    spread: Floats = np.asarray(together / together.sum(), dtype=float)
    one, two = (
        field.between_sites(spread, pairing.teeth_of(z), pairing.sites.size)
        for z, field in enumerate(fields)
    )
    size = one.shape[0] * slices.count
    compliance = (one + two).reshape(size, size)
    return spread, 0.5 * (compliance + compliance.T)
