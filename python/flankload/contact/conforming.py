"""Contact of splines in three dimensions: slices whose flanks conform over a common height.

A slice has one unknown, its force F. It is distributed over strips of the height, q_i F on strip i,
like that of a coupling with equal forces on all slices and teeth:

    sum_k (sum over teeth and slices of C)_ik q_k = const,  sum q = 1                          (S5)
    K = q' C q,  g0 = sum_i q_i g_i,  K F + g0 - r_b phi >= 0,  r_b sum F = T                  (S6)

C is the compliance of both bodies between strips of slices. All normals of an involute have the
lever arm r_b. For a uniform load the rotation is exact; for gaps that vary over the height, the
error of K is of second order in the change of q. Forces along the profile are distributed in the
same way. The core solves these equations at each position
(`fortran/position/conforming_slices.f90`).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from flankload.base.arrays import Floats
    from flankload.elasticity.compliance import BodyCompliance
    from flankload.elasticity.prism.strip_field import StripField
    from flankload.pairing.gear_mesh import GearMesh

    Compliances = tuple[BodyCompliance, BodyCompliance]


def conforming_height(mesh: GearMesh, compliances: Compliances) -> Floats:
    """Part "height" of the record of the mesh, for S sites and J slices: (9 + n (S J)²,).

    n = 1, with friction 2.
    """
    height, fit = mesh.slices.conforming, mesh.pairing.fit
    assert height is not None
    assert fit is not None
    spread, compliance = reduced_compliance(mesh, compliances)
    turn = fit.turn_rad - float(spread @ height.opened_mm) / fit.base_radius_mm
    numbers = [*height.middle_s_mm, height.height_mm, *(spread @ height.normal), turn]
    numbers += [*height.tilt, height.middle_z_mm]
    parts = [np.array(numbers), compliance.ravel()]
    if mesh.friction is not None:
        # recession of the slices by forces on both bodies towards their tips, mm/N
        recession = -_summed(mesh, _fields(mesh, compliances), spread, along=True)
        parts.append(recession.ravel(order="F"))
    return np.concatenate(parts)


def force_spread(mesh: GearMesh, compliances: Compliances) -> Floats:
    """Part q (N,) of the force of a slice on each strip of the height."""
    return _spread(_fields(mesh, compliances))


def reduced_compliance(mesh: GearMesh, compliances: Compliances) -> tuple[Floats, Floats]:
    """Part q (N,) of the force on each strip of the height, and K (S J, S J), mm/N, symmetric."""
    fields = _fields(mesh, compliances)
    spread = _spread(fields)
    compliance = _summed(mesh, fields, spread, along=False)
    return spread, 0.5 * (compliance + compliance.T)


def expansion_at_slices(mesh: GearMesh, compliances: Compliances, z: int) -> Floats:
    """Displacement (n,) of the flanks of body z out of the material by its body loads, mm.

    At the sites of the core, working flanks first: the mean over the height, weighted by q; empty
    without body loads.
    """
    shifts = compliances[z].shift_of(mesh.pairing.teeth_of(z), mesh.pairing.sites.size)
    if not len(shifts):
        return np.empty(0)
    fields = _fields(mesh, compliances)
    return np.asarray(np.einsum("i,sij->sj", _spread(fields), fields[z].expansion(shifts)).ravel())


def touches_over_height(mesh: GearMesh, compliances: Compliances, torque_Nmm: float) -> bool:
    """Whether an even load closes the gap by the expansion of both bodies on all strips."""
    height, pairing = mesh.slices.conforming, mesh.pairing
    assert height is not None
    assert pairing.fit is not None
    if not (height.opened_mm.any() or any(one.expansion.shifts for one in compliances)):
        return True
    fields, opened = _fields(mesh, compliances), height.opened_mm
    for z, field in enumerate(fields):
        shifts = compliances[z].shift_of(pairing.teeth_of(z)[:1])
        opened = opened - (field.expansion(shifts) @ field.weight).sum(axis=0)
    even = fields[0].of_even_load() + fields[1].of_even_load()
    if not even.any():
        return True
    alike, moved = np.linalg.solve(even, np.column_stack([np.ones(opened.size), opened])).T
    force = torque_Nmm / (pairing.fit.base_radius_mm * mesh.body_1.teeth)
    closed = (force + moved.sum()) / alike.sum()
    return bool((closed * alike - moved).min() >= 0.0)


def _fields(mesh: GearMesh, compliances: Compliances) -> tuple[StripField, StripField]:
    from flankload.elasticity.prism.strip_field import StripField

    slices, height = mesh.slices, mesh.slices.conforming
    assert height is not None
    one, two = (
        StripField.of(compliance, body.teeth, s, height.strip_mm, slices.edges_mm)
        for body, compliance, s in zip(mesh.bodies, compliances, height.s_mm, strict=True)
    )
    return one, two


def _spread(fields: tuple[StripField, StripField]) -> Floats:
    even = fields[0].of_even_load() + fields[1].of_even_load()
    # without elements, as for a run without torque, the strips are equal
    equal = np.ones(len(even))
    together = np.linalg.solve(even, equal) if even.any() else equal
    return np.asarray(together / together.sum(), dtype=float)


def _summed(
    mesh: GearMesh, fields: tuple[StripField, StripField], spread: Floats, *, along: bool
) -> Floats:
    """Compliance (S J, S J) of both bodies between slices."""
    pairing = mesh.pairing
    one, two = (
        field.between_sites(spread, pairing.teeth_of(z), pairing.sites.size, along=along)
        for z, field in enumerate(fields)
    )
    size = one.shape[0] * mesh.slices.count
    return np.asarray((one + two).reshape(size, size))
