"""Compliance of the flanks of a prism: a plane section over a width, straight or twisted.

The normal displacement at (s, z) of a flank under a normal unit force at (s', z') is

    near field + V(s, z) g V(s', z')',  V = P_a(xi_s) P_b(xi_z) at index a (q_z + 1) + b

with g = `smooth[t]` for the tooth at t pitches, xi_s over `mode_range_mm` and xi_z over
`axial.range_mm`. The near field on the same flank is that of `flank_potential`: a half-space with
k = `kernel`/2, and images behind both end faces with the strengths `axial.end` and behind free
corners with `wedge`. Hence

    g_0 = D⁻¹ (B'CB - <P, near P>) D⁻¹,  g_t = D⁻¹ B'C_t B D⁻¹
    D_ab = L_s b/((2a + 1)(2b + 1) cos(beta_b))

with area elements ds dz/cos(beta_b), included in the loads n/cos(beta_b) = (n_t, -kappa l) per
ds dz. With a tip rounding or chamfer, D = <P, P> over flank and tip, including the modes of the tip
(`bodies.tip_modes`) times the same polynomials of z.

With friction, loads along the profile, t/cos(beta_b) per ds dz, are further columns of the same
elimination; `tangential` is their g, without the near field with `jump` and `wedge_along`.

Loads on coast flanks are those on working flanks rotated by 180 degrees about the centre line of
the tooth: they lean out of the other end face, so that the near field is that of reversed z.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Literal

import numpy as np

from flankload.base.blas_threads import one_blas_thread
from flankload.bodies.body import SectorMesh
from flankload.bodies.tip_modes import with_tip
from flankload.cost import Account
from flankload.elasticity.axial_basis import mode_norms_z
from flankload.elasticity.compliance.body_compliance import BodyCompliance, no_compliance
from flankload.elasticity.compliance.contributions import (
    AxialModes,
    CoastCompliance,
    FlankModes,
    NearField,
    RootResponse,
    opposite,
)
from flankload.elasticity.compliance.job import JobOptions, flank_compliance
from flankload.elasticity.job_log import JobLog
from flankload.elasticity.mean_motion import bore_reactions
from flankload.elasticity.near_field import (
    jump_strength,
    logarithm_strength,
    mirrored_loads,
    mode_loads,
)
from flankload.elasticity.prism.flank_potential import projected_potential, projected_tangential
from flankload.elasticity.prism.flank_surface import flank_surface
from flankload.elasticity.prism.flexible_bore import FlexibleBore
from flankload.elasticity.prism.prism import COMPONENTS
from flankload.elasticity.prism.root_surface import root_surface_stress
from flankload.elasticity.sector_closure import (
    condense_sector,
    made_symmetric,
    unknowns_of,
)
from flankload.elasticity.sector_row import teeth_response
from flankload.errors import SceneError

if TYPE_CHECKING:
    from flankload.base.arrays import Floats
    from flankload.bodies.body import Body
    from flankload.bodies.root_fillet import RootFillets
    from flankload.elasticity.prism.flank_surface import FlankSurface
    from flankload.elasticity.prism.prism import Prism


def prism_compliance(
    body: Body,
    prism: Prism,
    *,
    n_modes: int,
    friction: bool = False,
    coast_flanks: bool = False,
    fillets: RootFillets | None = None,
    estimate: bool = False,
    account: Account | None = None,
) -> BodyCompliance:
    """Compliance of a body's flanks in three dimensions.

    The fixed nodes of the sector are fixed over their whole width or follow a shaft
    (`flexible_bore`); of a free bore the mean motion is held (`mean_motion`). The degree of the
    pressure modes along s should be at most half the number of flank elements; those of a tip are
    added. With friction, as many loads along the profile are solved; with coast flanks, the same
    loads on these. `fillets`: points for root stress, without coast flanks; `estimate`: error
    estimate of the plane elements.

    Returns
    -------
    BodyCompliance
        With `axial`; smooth and tangential are (z, p, p), p = n_modes (q_z + 1), in mm/N of the
        whole width.

    Raises
    ------
    SceneError
        If the load degree exceeds the axial degree less 4, an edge between flank and end face is
        sharper than 50 degrees, or the mesh is that of a whole body.
    """
    prism.check()
    if body.rigid or body.mesh is None:
        return no_compliance(body)
    log, modes = JobLog(account), n_modes if body.tip is None else with_tip(n_modes)
    loads, tooth = _flank_loads(body, prism, modes, friction=friction, coast_flanks=coast_flanks)
    response, of_roots = _responses(body, prism, loads, log, fillets)
    surface = flank_surface(body, prism)
    found = _compliance(body, prism, surface, response, log, friction=friction, tooth=tooth)
    fe_error = None
    if estimate:
        options = JobOptions(n_modes=n_modes, plane="strain", friction=friction, estimate=True)
        fe_error = _fe_error(body, options, surface, prism.load_degree, log)
    root = None if fillets is None else _of_roots(fillets, of_roots, surface, modes, prism)
    job = log.cost(found.job.asymmetry, found.job.degrees_of_freedom)
    return replace(found, root=root, fe_error=fe_error, job=job)


def _compliance(
    body: Body,
    prism: Prism,
    surface: FlankSurface,
    response: Floats,
    log: JobLog,
    *,
    friction: bool,
    tooth: int | None,
) -> BodyCompliance:
    """Compliance from the response (z, q, q) of a body, without roots and error estimate.

    `tooth`: tooth whose coast flank is in the sector, if the second half of the columns are loads
    on coast flanks; else None.
    """
    near, columns = _near_field(body, surface, friction=friction), response.shape[1]
    q = columns if tooth is None else columns // 2
    p = q // 2 if friction else q
    working = response[:, :q, :q]
    smooth, asymmetry, along_near = _smooth_coefficients(
        working, surface, near, p, prism.load_degree
    )
    coast = None
    if tooth is not None:
        blocks = _coast_blocks(response, surface, near, p, prism.load_degree, tooth)
        along = np.ascontiguousarray(blocks[:, :p, p:]) if friction else None
        coast = CoastCompliance(np.ascontiguousarray(blocks[:, :p, :p]), along)
        log.account.count(coast_readings=q)
    per_node = COMPONENTS * (prism.degree + 1)
    unknowns = unknowns_of(_sector_of(body), held=prism.sectors == 1, per_node=per_node)
    log.account.count(fe_unknowns=unknowns, fe_solutions=columns)
    log.count_loads(q, friction=friction)
    log.end_step("near field")
    axial = AxialModes(
        prism.range_mm, prism.load_degree, prism.twist, surface.cos_base_helix, surface.end
    )
    return BodyCompliance(
        smooth=np.ascontiguousarray(smooth[:, :p, :p]),
        near=near,
        modes=FlankModes(body.mode_range_mm, tip=body.tip, axial=axial),
        tangential=np.ascontiguousarray(smooth[:, :p, p:]) if friction else None,
        along_near=along_near,
        coast=coast,
        job=log.cost(asymmetry, unknowns),
    )


def _coast_blocks(
    response: Floats, surface: FlankSurface, near: NearField, p: int, degree_z: int, tooth: int
) -> Floats:
    """Blocks (3 z, q, q) of `CoastCompliance` from the response (z, 2 q, 2 q) of both flanks."""
    q, count = response.shape[1] // 2, degree_z + 1
    inverse = _to_coefficients(surface, p // count, degree_z, friction=q > p)
    across = inverse @ np.roll(response[:, q:, :q], tooth, axis=0) @ inverse
    back = inverse @ np.roll(response[:, :q, q:], -tooth, axis=0) @ inverse
    # equal by reciprocity (Betti)
    across = 0.5 * (across + back[opposite(len(back))].transpose(0, 2, 1))
    back = across[opposite(len(back))].transpose(0, 2, 1)
    signs = np.tile((-1.0) ** np.arange(count), q // count)
    turned = signs[:, None] * response[:, q:, q:] * signs
    between, _, _ = _smooth_coefficients(turned, surface, near, p, degree_z)
    return np.concatenate([across, back, signs[:, None] * between * signs])


def _near_field(body: Body, surface: FlankSurface, *, friction: bool) -> NearField:
    """Strengths of the near field, which the modes do not include."""
    return NearField(
        logarithm_strength(body.material, "strain"),
        jump=jump_strength(body.material, "strain") if friction else 0.0,
        wedge=surface.wedge,
        wedge_along=surface.wedge_along if friction else (0.0, 0.0),
    )


def _smooth_coefficients(
    response: Floats, surface: FlankSurface, near: NearField, p: int, degree_z: int
) -> tuple[Floats, float, Floats | None]:
    """Readings (z, r, r), which change, as mode coefficients without the near field; asymmetry.

    Also the near field of loads along the profile as mode coefficients (p, p), with friction. The p
    columns of normal loads are followed, with friction, by as many along the profile.
    """
    n_modes, count = p // (degree_z + 1), response.shape[1]
    response[0, :p, :p] -= 0.5 * near.kernel * projected_potential(surface, n_modes, degree_z)
    if count > p:
        tangential = projected_tangential(
            surface, n_modes, degree_z, kernel=near.kernel, jump=near.jump
        )
        response[0, :p, p:] -= tangential
        response[0, p:, :p] -= tangential.T
    inverse = _to_coefficients(surface, n_modes, degree_z, friction=count > p)
    along_near = inverse[:p, :p] @ tangential @ inverse[:p, :p] if count > p else None
    back = opposite(len(response))
    return *made_symmetric(inverse @ response @ inverse, back), along_near


def _to_coefficients(
    surface: FlankSurface, n_modes: int, degree_z: int, *, friction: bool
) -> Floats:
    """Inverse of the products of the modes <P_ab, P_cd>, for both directions of loads."""
    along_axis = mode_norms_z(surface.width_mm, degree_z)
    inverse = np.kron(np.linalg.inv(surface.products(n_modes)), np.diag(1.0 / along_axis))
    return np.asarray(np.kron(np.eye(1 + friction), inverse))


def _fe_error(
    body: Body, options: JobOptions, surface: FlankSurface, load_degree: int, log: JobLog
) -> Floats:
    """Estimated error of the response of a flank to its own loads: `BodyCompliance.fe_error`.

    The error varies within a few elements, over which the load hardly changes along the axis.
    Therefore it is that of line loads per length, from stress recovery in plane strain
    (`fe_error`).
    """
    section = flank_compliance(body, options, sectors=1)
    assert section.fe_error is not None
    log.account.count(fe_factorisations=1, fe_solutions=section.fe_error.shape[2])
    along = np.diag(1.0 / mode_norms_z(surface.width_mm, load_degree))
    cosine = surface.cos_base_helix
    fe_error = cosine**2 * np.kron(section.fe_error[0], along)
    fe_error[:, len(fe_error) :] /= cosine  # loads along the profile are in the section
    log.end_step("estimate")
    return np.asarray(fe_error[None])


def _of_roots(
    fillets: RootFillets, response: Floats, surface: FlankSurface, n_modes: int, prism: Prism
) -> RootResponse:
    """Root stress from readings (z, r, p) by point and function of z."""
    friction = response.shape[2] > n_modes * (prism.load_degree + 1)
    inverse = _to_coefficients(surface, n_modes, prism.load_degree, friction=friction)
    shape = len(response), fillets.points.arc_length_mm.size, prism.degree + 1, len(inverse)
    return RootResponse(fillets.points, (response @ inverse).reshape(shape), prism.range_mm)


def _flank_loads(
    body: Body, prism: Prism, n_modes: int, *, friction: bool, coast_flanks: bool
) -> tuple[Floats, int | None]:
    """Loads (N, 3 (p + 1), q) of the modes, and the tooth whose coast flank is in the sector.

    Normal loads, with friction followed by loads along the profile; with coast flanks, the same
    loads on the coast flank follow.
    """
    mesh, tooth = _sector_of(body), None
    directions: tuple[Literal["normal", "tangent"], ...] = ("normal", "tangent")
    in_plane = np.hstack(
        [
            mode_loads(
                mesh, body.mode_range_mm, n_modes, along=each, tip=body.tip, twist=prism.twist
            )
            for each in directions[: 1 + friction]
        ]
    )
    if coast_flanks:
        assert body.involute is not None
        images, tooth = mirrored_loads(mesh, in_plane, body.involute.turn_rad)
        in_plane = np.hstack([in_plane, images])
    along = prism.axial.load_vectors(prism.load_degree)
    return _prism_loads(in_plane, along), tooth


def _responses(
    body: Body, prism: Prism, loads: Floats, log: JobLog, fillets: RootFillets | None
) -> tuple[Floats, Floats]:
    """Readings B'C_t B (z, q, q) of the loads on all teeth, and of the roots (z, r, q)."""
    mesh, count, bore = _sector_of(body), loads.shape[2], None
    section, regions = prism.section(mesh, body.material)
    reactions = bore_reactions(mesh, section, body.material.young_modulus_MPa)
    if prism.shaft is not None and not mesh.has_free_bore:
        bore = FlexibleBore.of(prism.shaft, section, mesh, regions)
        loads = np.concatenate([loads, bore.columns], axis=2)
        # the bore is the difference of large stiffnesses, in which rounding of an image would count
        section = replace(section, halved=False)
    readings = []
    if fillets is not None:
        nodes = fillets.on_elements
        stress = root_surface_stress(
            nodes, section.functions, prism.axial, body.material, prism.twist
        )
        readings.append(np.zeros((*loads.shape[:2], len(stress))))
        readings[0][nodes.nodes] = stress.T.reshape(nodes.nodes.size, -1, len(stress))
        log.account.count(stress_recoveries=fillets.points.arc_length_mm.size)
    log.end_step("assembly")
    tooth = prism.sectors == 1
    sector = condense_sector(section, mesh, loads, readings, log, reactions, held=tooth)
    # most matrices are too small for several threads
    with one_blas_thread():
        if bore is None:
            response = teeth_response(sector, mesh.teeth, prism.sectors)
        else:
            response = bore.close_ring(sector)
    log.end_step("ring")
    return response[:, :count], response[:, count:]


def _sector_of(body: Body) -> SectorMesh:
    """The mesh of a sector; other meshes are refused."""
    if not isinstance(body.mesh, SectorMesh):
        raise SceneError(
            key=body.kind,
            expected="a body of equal sectors in three dimensions",
            found="the mesh of a whole body",
        )
    return body.mesh


def _prism_loads(in_plane: Floats, along: Floats) -> Floats:
    """Loads (N, 3 (p + 1), n_s n_z) of the products of modes, by node and unknown."""
    n_s, (functions, n_z) = in_plane.shape[1], along.shape
    of_nodes = in_plane.reshape(-1, COMPONENTS, n_s)
    loads = np.einsum("ica,kb->ikcab", of_nodes, along)
    return loads.reshape(len(of_nodes), COMPONENTS * functions, n_s * n_z)
