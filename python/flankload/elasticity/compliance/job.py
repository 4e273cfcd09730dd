"""The finite-element job of a body: compliances of its flanks from one factorisation.

The flanks of a whole mesh are loaded one after the other. For a body of equal sectors, the
stiffness matrix of one sector is factorised once, with the pressure modes of the flank and the
unknowns of the cuts as right-hand sides (`sector_closure`). A plane body is one with constant
displacements along its axis; a prism has functions of z over its width.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from flankload.bodies.body import SectorMesh
from flankload.bodies.tip_modes import with_tip
from flankload.elasticity.compliance.body_compliance import BodyCompliance, no_compliance
from flankload.elasticity.compliance.contributions import Expansion
from flankload.elasticity.compliance.loads import ModeLoads, NodeLoads
from flankload.elasticity.compliance.plane_extent import PlaneExtent
from flankload.elasticity.compliance.response import Job, Response, of_sector, of_whole
from flankload.elasticity.fe_error import compliance_error, fillet_difference, recovered_strains
from flankload.elasticity.finite_elements import centrifugal_load
from flankload.elasticity.job_log import JobLog
from flankload.elasticity.sector_closure import made_symmetric

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flankload.base.arrays import Floats
    from flankload.bodies.body import Body
    from flankload.bodies.root_fillet import RootFillets
    from flankload.cost import Account
    from flankload.elasticity.compliance.loads import FlankLoads
    from flankload.elasticity.finite_elements import SectionStiffness
    from flankload.elasticity.prism import Prism
    from flankload.pairing.expansion import BodyLoad


#: Degrees along the axis that are left out to show their error.
LESS_DEGREES = 2


@dataclass(frozen=True, eq=False)
class JobOptions:
    """Loads and readings of a finite-element job.

    Attributes
    ----------
    n_modes : int
        Number of pressure modes of a flank, without those of a tip; their degree should be at most
        half the number of flank elements. Ignored with `nodal`.
    plane : {"strain", "stress"}
    friction : bool
        Tangential loads are solved as well, as many as normal ones.
    along : bool
        Tangential displacements under these loads are returned.
    nodal : bool
        The loads are unit forces at the nodes of the flank instead of modes.
    coast_flanks : bool
        Coast flanks are loaded, too, and their displacements returned; for sector meshes only.
    fillets : RootFillets or None
        Points at which the stress is returned.
    estimate : bool
        The discretization error of the elements is estimated; with modes only.
    rim : bool
        The displacements of a free rim are returned; for sector meshes with modes only.
    prism : Prism or None
        Extent and discretization along the axis, in plane strain; None: a plane body.
    """

    n_modes: int
    plane: str = "strain"
    friction: bool = False
    along: bool = False
    nodal: bool = False
    coast_flanks: bool = False
    fillets: RootFillets | None = None
    estimate: bool = False
    rim: bool = False
    prism: Prism | None = None

    @property
    def extent(self) -> PlaneExtent | Prism:
        """Extent and discretization along the axis."""
        return self.prism or PlaneExtent(self.plane)


def flank_compliance(
    body: Body,
    options: JobOptions,
    *,
    sectors: int | None = None,
    body_load: BodyLoad | None = None,
    account: Account | None = None,
) -> BodyCompliance:
    """Compliance of the flanks of a body from one finite-element job.

    Parameters
    ----------
    body : Body
        With a mesh, or rigid. The fixed nodes of a sector are fixed over their whole width or
        follow a shaft (`flexible_bore`); of a free bore the mean motion is held (`mean_motion`).
    sectors : int, optional
        Odd number of equal sectors of a segment with both ends fixed; 1: a single tooth. Default:
        the whole body; not for whole meshes, nor on a shaft that the bore follows.
    body_load : BodyLoad, optional
        Causes of the expansion of the body; a single tooth expands uniformly only.
    account : Account, optional
        Counters and progress; by default a new one.

    Raises
    ------
    SceneError
        For a prism: if the load degree exceeds the axial degree minus 4, an edge between flank
        and end face is sharper than 50 degrees, or the mesh is that of a whole body.
    """
    options.extent.check(body)
    if body.rigid or body.mesh is None:
        return no_compliance(body, body_load)
    job, load_vectors = _prepared(body, body_load, options, account)
    if isinstance(body.mesh, SectorMesh):
        response = of_sector(job, body.mesh, sectors)
    else:
        response = of_whole(job, body.mesh)
    found = _compliance(job, response, options)
    moved = {name: response.by_force[:, k] for k, name in enumerate(load_vectors)}
    expansion = _expansion(job, body_load, moved)
    job.log.end_step("near field")
    miss, of_roots = _fe_errors(job, options)
    if miss is not None and options.extent.regions:
        miss = miss + _degree_error(job, options, found, sectors)
    root = None if found.root is None else replace(found.root, difference=of_roots)
    log = replace(found.job, seconds=job.log.seconds())
    return replace(found, expansion=expansion, fe_error=miss, root=root, job=log)


def _prepared(
    body: Body,
    body_load: BodyLoad | None,
    options: JobOptions,
    account: Account | None,
) -> tuple[Job, dict[str, Floats]]:
    """Stiffness, loads and readings of a job, and the vectors of the body load by name."""
    extent, mesh, loads = options.extent, body.mesh, _loads(body, options)
    assert mesh is not None

    def estimate(moved: Floats) -> tuple[Floats, float]:
        moved, fillets = moved[:, : loads.count], options.fillets  # under normal loads
        smoothed = recovered_strains(mesh.nodes, mesh.cells, moved)
        return compliance_error(
            mesh.nodes, mesh.cells, body.material, options.plane, moved, smoothed
        ), 0.0 if fillets is None else fillet_difference(fillets, moved, smoothed)

    estimated = options.estimate and not options.nodal and extent.recovers_stress
    log = JobLog(account, estimate=estimate if estimated else None)
    section = extent.section(mesh, body.material)
    log.account.workspace_bytes += section.bytes
    load_vectors = _load_vectors(section, body, body_load)

    def readings(flank: int) -> dict[str, tuple[Floats, int]]:
        if options.fillets is None:
            return {}
        columns = extent.root_columns(options.fillets, flank, section, body.material)
        return {"stress_recoveries": (columns, extent.axial.count)}

    job = Job(
        body=body,
        section=section,
        loads=loads,
        readings=readings,
        forces=np.stack(list(load_vectors.values()), axis=2) if load_vectors else None,
        log=log,
        coast_flanks=options.coast_flanks,
        rim=options.rim,
        bore=extent.bore(section, mesh),
    )
    return job, load_vectors


def _loads(body: Body, options: JobOptions) -> FlankLoads:
    """Unit loads of a flank."""
    if options.nodal:
        return NodeLoads(body, PlaneExtent(options.plane), options.friction)
    count = options.n_modes if body.tip is None else with_tip(options.n_modes)
    return ModeLoads(body, options.extent, count, options.friction)


def _compliance(job: Job, found: Response, options: JobOptions) -> BodyCompliance:
    """Compliance from the response of the elements, without the near field."""
    loads, friction = job.loads, options.friction
    q, p = found.response.shape[2], loads.count
    response, below = found.response[:, :q], found.response[:, q:]
    root = None
    if options.fillets is not None:
        places = options.fillets.points.arc_length_mm.size * options.extent.axial.count
        root = options.extent.roots(options.fillets, below[:, :places].copy(), loads)
        if found.by_coast is not None:
            by_coast = options.extent.roots(
                options.fillets, found.by_coast[:, :places].copy(), loads
            )
            root = replace(root, coast=by_coast.response)
    loads.subtract_near_field(response, found.own, job.log.account)
    response, asymmetry = made_symmetric(response, found.across)
    job.log.account.count(fe_unknowns=found.degrees_of_freedom)
    return BodyCompliance(
        smooth=np.ascontiguousarray(response[:, :p, :p]),
        near=loads.near_field,
        modes=loads.modes,
        flanks=found.flanks,
        tangential=np.ascontiguousarray(response[:, :p, p:]) if friction else None,
        along_near=loads.along_near(),
        along=np.ascontiguousarray(response[:, p:, p:]) if options.along and friction else None,
        coast=found.coast,
        root=root,
        rim=found.rim,
        job=job.log.cost(asymmetry, found.degrees_of_freedom),
    )


def _fe_errors(job: Job, options: JobOptions) -> tuple[Floats | None, float]:
    """`BodyCompliance.fe_error` and `RootResponse.difference`; None and 0 without an estimate.

    For a prism, they come from a job for one tooth of its section, in plane strain.
    """
    log, loads = job.log, job.loads
    if log.errors:
        errors = np.stack([error for error, _ in log.errors])
        return loads.between(errors), log.errors[0][1]
    if not (options.estimate and isinstance(loads, ModeLoads)):
        return None, 0.0
    in_plane = replace(options, prism=None, coast_flanks=False, friction=False)
    section = flank_compliance(job.body, in_plane, sectors=1)
    assert section.fe_error is not None
    log.account.count(fe_factorisations=1, fe_solutions=section.fe_error.shape[2])
    found_error = loads.from_section(section.fe_error)
    log.end_step("estimate")
    return found_error, 0.0 if section.root is None else section.root.difference


def _degree_error(
    job: Job, options: JobOptions, found: BodyCompliance, sectors: int | None
) -> Floats:
    """Change of the response of a flank to its own loads by the last degrees along the axis.

    Only for a body whose widths jump, where displacements converge slowly in the degree; elsewhere
    this error is below those of elements and modes.
    """
    body, prism, log = job.body, options.prism, job.log
    assert prism is not None
    assert isinstance(body.mesh, SectorMesh)
    fewer = replace(prism, degree=max(prism.degree - LESS_DEGREES, prism.load_degree))
    keys = replace(
        options, prism=fewer, coast_flanks=False, friction=False, fillets=None, estimate=False
    )
    reduced, _ = _prepared(body, None, keys, None)
    response = of_sector(reduced, body.mesh, sectors)
    lower = _compliance(reduced, response, keys)
    log.account.count(
        fe_factorisations=reduced.log.account.counters["fe_factorisations"],
        fe_solutions=response.response.shape[2],
    )
    log.end_step("estimate")
    return np.asarray(found.smooth[:1] - lower.smooth[:1])


def _load_vectors(
    section: SectionStiffness, body: Body, body_load: BodyLoad | None
) -> dict[str, Floats]:
    """Nodal loads (N, u) of a body load relative to the support, by cause.

    The displacement is e_s x plus the response to these loads with a fixed support. The stiffness
    times the coordinates of the nodes is the load for a strain of 1 in the section. Axial expansion
    is free, also in plane strain and of a fixed bore.
    """
    loads: dict[str, Floats] = {}
    if body_load is None:
        return loads
    assert body.mesh is not None
    if body_load.strain != body_load.held_strain:
        evenly = section.in_section(body.mesh.nodes)
        loads["temperature"] = (body_load.strain - body_load.held_strain) * section.times(evenly)
    if body_load.speed_rad_per_s > 0.0:
        pull = body_load.density_Ns2_per_mm4 * body_load.speed_rad_per_s**2
        loads["speed"] = pull * centrifugal_load(section, body.mesh.nodes, body.mesh.cells)
    return loads


def _expansion(job: Job, body_load: BodyLoad | None, moved: Mapping[str, Floats]) -> Expansion:
    """Uniform strain of a body, and the displacements of its flanks beyond it.

    Normal displacements do not describe the motion of a tip corner, which touches its mate
    elsewhere. Therefore the strain that fits all flanks best, by least squares, scales the section
    of the whole body. `moved`: readings (f, q) of the loads on each of f flanks under each of
    `_load_vectors`, mm²; those on a coast flank follow.
    """
    if body_load is None:
        return Expansion()
    mesh, loads, p = job.body.mesh, job.loads, job.loads.count
    held, along = body_load.held_strain, body_load.strain
    if mesh is None or not moved:
        return Expansion(held, axial_excess=along - held)
    evenly = job.section.in_section(mesh.nodes)
    read = [np.einsum("nuq,nu->q", loads.columns(flank)[..., :p], evenly) for flank in mesh.flanks]
    unit = loads.coefficients(np.array(read))
    square = float(np.sum(np.array(read) * unit))
    parts = {name: float(np.sum(unit * each[:, :p])) / square for name, each in moved.items()}

    def beyond(first: int) -> dict[str, Floats]:
        rows = {name: each[:, first : first + p] for name, each in moved.items()}
        return {name: loads.coefficients(row) - parts[name] * unit for name, row in rows.items()}

    coast = beyond(p * (1 + loads.friction)) if job.coast_flanks else {}
    strain = held + sum(parts.values())
    return Expansion(strain, beyond(0), coast, axial_excess=along - strain)
