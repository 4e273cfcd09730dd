"""Response of the elements of a body to the loads of its flanks: a whole mesh, or equal sectors."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from flankload.base.blas_threads import one_blas_thread
from flankload.elasticity.compliance.contributions import CoastCompliance, RimResponse, opposite
from flankload.elasticity.fronts.condensation import condense_nodes
from flankload.elasticity.fronts.recovery import Recovery
from flankload.elasticity.mean_motion import bore_reactions, resultants, rim_forces
from flankload.elasticity.sector_closure import (
    condense_sector,
    made_symmetric,
    uniform_response,
    unknowns_of,
)
from flankload.elasticity.sector_row import teeth_response

if TYPE_CHECKING:
    from collections.abc import Callable

    from flankload.base.arrays import Floats, Numbers
    from flankload.bodies.body import Body, SectorMesh, WholeMesh
    from flankload.elasticity.compliance.loads import FlankLoads
    from flankload.elasticity.finite_elements import SectionStiffness
    from flankload.elasticity.job_log import JobLog
    from flankload.elasticity.prism.flexible_bore import FlexibleBore


@dataclass(frozen=True, eq=False)
class Job:
    """A finite-element job: a stiffness, its loads and its readings.

    Attributes
    ----------
    section : SectionStiffness
        Stiffness of its mesh.
    readings : callable
        Index of a flank -> further readings of the displacements by counter: columns (N, u, r), and
        how many of them count as one.
    forces : (N, u, k) array or None
        Vectors of body loads.
    coast_flanks, rim : bool
        Whether coast flanks or a free rim are loaded and read.
    bore : FlexibleBore or None
        Bore that follows a shaft.
    """

    body: Body
    section: SectionStiffness
    loads: FlankLoads
    readings: Callable[[int], dict[str, tuple[Floats, int]]]
    forces: Floats | None
    log: JobLog
    coast_flanks: bool = False
    rim: bool = False
    bore: FlexibleBore | None = None


@dataclass(frozen=True, eq=False)
class Response:
    """Response of the elements to unit loads.

    Attributes
    ----------
    response : (k, r, q) array
        By blocks as in `BodyCompliance.smooth`, with further readings in the rows below.
    own, across : arrays
        Blocks of flanks under their own loads; for each block, that with load and reading
        exchanged.
    by_force : (f, k, q) array
        Readings by the unit loads of each flank under each body load, then by other loads.
    coast : CoastCompliance or None
    by_coast : (k, r, q) array or None
        Further readings under loads on the coast flank in the sector of the working one.
    rim : RimResponse or None
    """

    response: Floats
    own: Numbers
    across: Numbers
    by_force: Floats
    degrees_of_freedom: int
    flanks: tuple[int, ...] = ()
    coast: CoastCompliance | None = None
    by_coast: Floats | None = None
    rim: RimResponse | None = None


def of_whole(job: Job, mesh: WholeMesh) -> Response:
    """Response of a whole mesh with f flanks; response[i * f + j]: flank i, loads on flank j."""
    log, size = job.log, len(mesh.nodes)
    log.end_step("assembly")
    loads = [job.loads.columns(flank) for flank in mesh.flanks]
    further = [[part for part, _ in job.readings(i).values()] for i in range(len(loads))]
    f, p, forces = len(loads), loads[0].shape[2], job.forces
    columns = np.concatenate(loads, axis=2)
    log.account.count(fe_solutions=f * p)
    log.count_loads(f * p, tangential=f * (p - job.loads.count))
    recovery = Recovery() if log.estimates or further[0] or forces is not None else None
    sector = condense_nodes(job.section, mesh, columns, account=log.account, recovery=recovery)
    log.end_step("factorisation")
    response = np.empty((f, f, p + sum(part.shape[2] for part in further[0]), p))
    response[:, :, :p] = sector.local[0].reshape(f, p, f, p).swapaxes(1, 2)
    by_force = np.zeros((f, 0 if forces is None else forces.shape[2], p))
    if forces is not None:
        count = forces.shape[2]
        log.account.count(fe_solutions=count, fe_load_cases_growth=count)
    if recovery is not None:
        for j in range(f):
            moved = recovery.under_loads(size, j * p, (j + 1) * p).reshape(-1, p)
            log.solution(moved)
            for i, parts in enumerate(further):
                if parts:
                    response[i, j, p:] = np.concatenate(
                        [_by_unknown(part).T @ moved for part in parts]
                    )
            if forces is not None:
                by_force[j] = _by_unknown(forces).T @ moved
    log.end_step("solution")
    return Response(
        response.reshape(f * f, -1, p),
        own=np.arange(f) * (f + 1),
        across=np.arange(f * f).reshape(f, f).T.ravel(),
        by_force=by_force,
        degrees_of_freedom=unknowns_of(mesh, per_node=job.section.unknowns),
        flanks=tuple(flank.tooth for flank in mesh.flanks),
    )


def of_sector(job: Job, mesh: SectorMesh, sectors: int | None) -> Response:
    """Response of a body of equal sectors; `sectors`: as for `teeth_response`."""
    log, held, section = job.log, sectors == 1, job.section
    own = job.loads.columns(mesh)
    q, tooth, loads = own.shape[2], 0, [own]
    if job.coast_flanks:
        images, tooth = job.loads.on_coast(mesh)
        loads.append(images)
        log.account.count(coast_readings=q, fe_solutions=q)
    if job.rim:
        loads.append(rim_forces(mesh, section, job.loads.modes.axial.degree))
    flanks = q + (loads[-1].shape[2] if job.rim else 0)
    count = sum(part.shape[2] for part in loads)
    if job.bore is not None:
        loads.append(job.bore.columns)
        # the bore is the difference of large stiffnesses, in which rounding of an image would count
        section = replace(section, halved=False)
    log.end_step("assembly")
    log.account.count(fe_solutions=flanks)
    log.count_loads(flanks, tangential=q - job.loads.count)
    readings = job.readings(0)
    growth = 0 if held or job.forces is None else job.forces.shape[2]
    if growth:
        assert job.forces is not None
        readings["fe_load_cases_growth"] = job.forces, 1
    reactions = None
    if not held:
        reactions = bore_reactions(mesh, section, job.body.material.young_modulus_MPa)
        log.account.count(bore_reactions=reactions.shape[2], fe_solutions=reactions.shape[2])
        for name, (part, each) in readings.items():
            columns = part.shape[2]
            log.account.count(fe_solutions=columns, **{name: columns // each})
    parts = [part for part, _ in readings.values()]
    sector = condense_sector(
        section, mesh, np.concatenate(loads, axis=2), parts, log, reactions, held=held
    )
    # most matrices are too small for several threads
    with one_blas_thread():
        if job.bore is None:
            response = teeth_response(sector, mesh.teeth, sectors)
        else:
            response = job.bore.close_ring(sector)
    by_force = np.zeros((0, 0 if job.forces is None else job.forces.shape[2], q))
    if growth:
        of_ring = uniform_response(sector, mesh.teeth) if job.bore is None else response.sum(axis=0)
        by_force = of_ring[None, -growth:]
    log.end_step("ring")
    rows = np.append(np.arange(q), np.arange(count, response.shape[1]))
    return Response(
        response[:, rows, :q],
        own=np.zeros(1, dtype=np.int64),
        across=opposite(mesh.teeth),
        by_force=by_force,
        degrees_of_freedom=unknowns_of(mesh, held=held, per_node=section.unknowns),
        coast=_coast(job, response, q, tooth) if job.coast_flanks else None,
        by_coast=response[:, count:, q : 2 * q] if job.coast_flanks else None,
        rim=_rim(job, mesh, response, loads) if job.rim else None,
    )


def _by_unknown(columns: Floats) -> Floats:
    """Columns (N, u, r) as (N u, r)."""
    return columns.reshape(-1, columns.shape[2])


def _rim(job: Job, mesh: SectorMesh, response: Floats, loads: list[Floats]) -> RimResponse:
    """Displacements of a rim from the response to loads on the flank, then the forces on it."""
    modes, q = job.loads, loads[0].shape[2]
    rim = slice(q, q + loads[1].shape[2])
    moments, forces = (resultants(mesh.nodes, job.section, part) for part in loads[:2])
    return RimResponse(
        by_modes=modes.by_coefficients(response[:, rim, :q]),
        by_forces=response[:, rim, rim],
        modes=modes.by_coefficients(moments[None])[0],
        forces=forces,
    )


def _coast(job: Job, response: Floats, q: int, tooth: int) -> CoastCompliance:
    """Response of coast flanks from that to q loads on the working flank, then those on the coast
    flank, which belongs to `tooth`.
    """
    loads, p, back = job.loads, job.loads.count, opposite(len(response))
    across = loads.between(np.roll(response[:, q : 2 * q, :q], tooth, axis=0))
    returned = loads.between(np.roll(response[:, :q, q : 2 * q], -tooth, axis=0))
    # equal by reciprocity (Betti)
    across = 0.5 * (across + returned[back].transpose(0, 2, 1))
    signs = loads.modes.mirror_signs(q)
    between = signs[:, None] * response[:, q : 2 * q, q : 2 * q] * signs
    loads.subtract_near_field(between, np.zeros(1, dtype=np.int64), job.log.account)
    between, _ = made_symmetric(between, back)
    blocks = [across, across[back].transpose(0, 2, 1), signs[:, None] * between * signs]
    both = np.concatenate(blocks)[:, :p]
    return CoastCompliance(
        np.ascontiguousarray(both[..., :p]),
        np.ascontiguousarray(both[..., p:]) if loads.friction else None,
    )
