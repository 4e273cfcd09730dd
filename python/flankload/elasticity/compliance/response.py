"""Displacements of a whole mesh, or of equal sectors, under unit loads."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flankload.elasticity.compliance.contributions import RimResponse
from flankload.elasticity.compliance.loads import ModeLoads, NodeLoads
from flankload.elasticity.fronts.condensation import condense_nodes
from flankload.elasticity.fronts.recovery import Recovery
from flankload.elasticity.mean_motion import bore_reactions, resultants, rim_forces
from flankload.elasticity.near_field import mirrored_loads
from flankload.elasticity.sector_closure import (
    condense,
    uniform_response,
    unknowns_of,
)
from flankload.elasticity.sector_row import teeth_response

if TYPE_CHECKING:
    from collections.abc import Callable

    from flankload.base.arrays import Floats, Numbers
    from flankload.bodies.body import Body, MeshedFlank, SectorMesh, WholeMesh
    from flankload.elasticity.finite_elements import SectionStiffness
    from flankload.elasticity.job_log import JobLog


@dataclass(frozen=True, eq=False)
class Job:
    """A finite-element job: a stiffness, its loads and its readings.

    Attributes
    ----------
    stiffness : SectionStiffness
        That of its mesh.
    friction : bool
        Whether tangential loads follow the normal ones.
    readings : callable
        Index of a flank -> columns (2N, q) for further readings of the displacements, by counter.
    forces : (2N, k) array or None
        Vectors of body loads.
    rim : bool
        Whether a free rim is loaded and read.
    """

    body: Body
    stiffness: SectionStiffness
    loads: ModeLoads | NodeLoads
    friction: bool
    readings: Callable[[int], dict[str, Floats]]
    forces: Floats | None
    log: JobLog
    rim: bool = False

    def unit_loads(self, flank: SectorMesh | MeshedFlank) -> Floats:
        """Normal unit loads (2N, p) of a flank, with friction followed by tangential ones."""
        normal = self.loads.columns(flank, "normal")
        if not self.friction:
            return normal
        return np.hstack([normal, self.loads.columns(flank, "tangent")])

    @property
    def no_forces(self) -> Floats:
        """Empty response (0, k, p) to body loads."""
        known = 0 if self.forces is None else self.forces.shape[1]
        return np.zeros((0, known, self.loads.count))


@dataclass(frozen=True, eq=False)
class Response:
    """Response of the elements to unit loads.

    Attributes
    ----------
    response : (k, r, p) array
        By blocks as in `BodyCompliance.smooth`, with further readings in the rows below.
    own, across : arrays
        Blocks of flanks under their own loads; for each block, that with load and reading
        exchanged.
    by_force : (f, k, p) array
        Readings by the unit loads of each flank under each body load.
    coast : (z, n, p) array or None
        Response of the coast flanks, as coefficients.
    rim : RimResponse or None
    """

    response: Floats
    own: Numbers
    across: Numbers
    by_force: Floats
    degrees_of_freedom: int
    flanks: tuple[int, ...] = ()
    coast: Floats | None = None
    rim: RimResponse | None = None


def of_whole(job: Job, mesh: WholeMesh) -> Response:
    """Response of a whole mesh with f flanks; response[i * f + j]: flank i, loads on flank j."""
    log, size = job.log, len(mesh.nodes)
    log.end_step("assembly")
    loads = [job.unit_loads(flank) for flank in mesh.flanks]
    further = [list(job.readings(i).values()) for i in range(len(loads))]
    f, p, forces = len(loads), loads[0].shape[1], job.forces
    columns = np.hstack(loads)
    log.account.count(fe_solutions=columns.shape[1])
    log.count_loads(f * p, friction=job.friction)
    recovery = Recovery() if log.estimates or further[0] or forces is not None else None
    by_node = columns.reshape(size, 2, -1)
    sector = condense_nodes(job.stiffness, mesh, by_node, account=log.account, recovery=recovery)
    log.end_step("factorisation")
    response = np.empty((f, f, p + sum(part.shape[1] for part in further[0]), p))
    response[:, :, :p] = sector.local[0].reshape(f, p, f, p).swapaxes(1, 2)
    by_force = np.zeros((f, 0 if forces is None else forces.shape[1], p))
    if forces is not None:
        log.account.count(fe_solutions=forces.shape[1], fe_load_cases_growth=forces.shape[1])
    if recovery is not None:
        for j in range(f):
            moved = recovery.under_loads(size, j * p, (j + 1) * p).reshape(-1, p)
            log.solution(moved)
            for i, parts in enumerate(further):
                if parts:
                    response[i, j, p:] = np.concatenate([part.T @ moved for part in parts])
            if forces is not None:
                by_force[j] = forces.T @ moved
    log.end_step("solution")
    return Response(
        response.reshape(f * f, -1, p),
        own=np.arange(f) * (f + 1),
        across=np.arange(f * f).reshape(f, f).T.ravel(),
        by_force=by_force,
        degrees_of_freedom=unknowns_of(mesh),
        flanks=tuple(flank.tooth for flank in mesh.flanks),
    )


def of_sector(job: Job, mesh: SectorMesh, sectors: int | None, *, coast_flanks: bool) -> Response:
    """Response of a body of equal sectors.

    `sectors`: as of `teeth_response`.
    """
    log, loads = job.log, job.unit_loads(mesh)
    readings, tooth, across, rim = {}, 0, None, None
    modes = loads.shape[1]
    if coast_flanks:
        assert job.body.involute is not None
        normal, turn_rad = loads[:, : job.loads.count], job.body.involute.turn_rad
        columns, tooth = mirrored_loads(mesh, normal, turn_rad)
        readings["coast_readings"] = columns
    if job.rim:
        loads = np.hstack([loads, rim_forces(mesh)[0]])
    log.end_step("assembly")
    readings |= job.readings(0)
    log.count_loads(loads.shape[1], friction=job.friction)
    by_force = job.no_forces
    if sectors == 1:
        sector, free = condense(job.stiffness, loads, mesh, readings, log, held=True)
    else:
        if job.forces is not None:
            readings["fe_load_cases_growth"] = job.forces
        reactions = None
        if mesh.has_free_bore:
            modulus = job.body.material.young_modulus_MPa
            reactions = bore_reactions(mesh, job.stiffness, modulus)
        sector, free = condense(job.stiffness, loads, mesh, readings, log, reactions)
        if job.forces is not None:
            by_force = uniform_response(sector, mesh.teeth)[None, -job.forces.shape[1] :]
    response = teeth_response(sector, mesh.teeth, sectors)
    if job.rim:
        assert isinstance(job.loads, ModeLoads)
        response, rim = _split_rim(response, job.loads, mesh, loads, modes)
    if coast_flanks:
        assert isinstance(job.loads, ModeLoads)
        response, across = _split_coast(response, job.loads, tooth)
    return Response(
        response,
        own=np.zeros(1, dtype=np.int64),
        across=-np.arange(mesh.teeth) % mesh.teeth,
        by_force=by_force,
        degrees_of_freedom=free,
        coast=across,
        rim=rim,
    )


def _split_rim(
    response: Floats, modes: ModeLoads, mesh: SectorMesh, loads: Floats, count: int
) -> tuple[Floats, RimResponse]:
    """Response (z, r - 2, count) without the forces on the rim, which follow the modes."""
    rim, n = slice(count, count + 2), modes.count
    moments = resultants(mesh.nodes, loads)

    def by_coefficients(rows: Floats) -> Floats:
        return modes.coefficients(rows.swapaxes(1, 2)).swapaxes(1, 2)

    found = RimResponse(
        by_modes=by_coefficients(response[:, rim, :n]),
        by_forces=response[:, rim, rim],
        modes=by_coefficients(moments[None, :, :n])[0],
        forces=moments[:, rim],
        middle_rad=rim_forces(mesh)[1],
    )
    return np.delete(response, rim, axis=1)[..., :count], found


def _split_coast(response: Floats, modes: ModeLoads, tooth: int) -> tuple[Floats, Floats]:
    """Response (z, r - n, p) without the readings of the coast flank, and the latter (z, n, p).

    In the response, these follow the readings of the working flank; `tooth`: tooth of the coast
    flank. They are returned as the map from mode coefficients of loads on the working flank of
    tooth 0 to those of displacements on the coast flank of tooth t.
    """
    first, n = response.shape[2], modes.count
    cross_compliance = modes.between(np.roll(response[:, first : first + n], tooth, axis=0))
    # symmetric by reciprocity (Betti) and mirror symmetry of both flanks
    pressures = cross_compliance[..., :n]
    cross_compliance[..., :n] = 0.5 * (pressures + pressures.transpose(0, 2, 1))
    return np.delete(response, slice(first, first + n), axis=1), cross_compliance
