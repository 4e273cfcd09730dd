"""The finite-element job of a body: compliances of its flanks from one factorisation.

The flanks of a whole mesh are loaded one after the other. For a body of equal sectors, the
stiffness matrix of one sector is factorised once, with the pressure modes of the flank and the
unknowns of the cuts as right-hand sides (`sector_closure`).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from flankload.bodies.body import WholeMesh
from flankload.bodies.tip_modes import with_tip
from flankload.elasticity.compliance.body_compliance import BodyCompliance, no_compliance
from flankload.elasticity.compliance.contributions import (
    CoastCompliance,
    Expansion,
    FlankModes,
    RootResponse,
)
from flankload.elasticity.compliance.loads import ModeLoads, NodeLoads
from flankload.elasticity.compliance.response import Job, Response, of_sector, of_whole
from flankload.elasticity.compliance.tip_force import (
    has_turned_forces,
    turned_coefficients,
    turned_columns,
)
from flankload.elasticity.fe_error import compliance_error
from flankload.elasticity.finite_elements import (
    centrifugal_load,
    stiffness,
)
from flankload.elasticity.job_log import JobLog
from flankload.elasticity.near_field import mode_loads, to_coefficients
from flankload.elasticity.nodal_loads import nodes_of
from flankload.elasticity.sector_closure import made_symmetric

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from flankload.base.arrays import Floats
    from flankload.bodies.body import Body, SectorMesh
    from flankload.bodies.root_fillet import RootFillets
    from flankload.elasticity.finite_elements import SectionStiffness
    from flankload.pairing.expansion import BodyLoad


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
        As many tangential loads as normal ones are solved.
    along : bool
        Tangential displacements under these loads are returned.
    nodal : bool
        The loads are unit forces at the nodes of the flank instead of modes.
    coast_flanks : bool
        Displacements of the coast flanks are returned; for sector meshes only.
    fillets : RootFillets or None
        Points at which the stress is returned.
    estimate : bool
        The discretization error of the elements is estimated; with modes only.
    rim : bool
        The displacements of a free rim are returned; for sector meshes with modes only.
    """

    n_modes: int
    plane: str
    friction: bool = False
    along: bool = False
    nodal: bool = False
    coast_flanks: bool = False
    fillets: RootFillets | None = None
    estimate: bool = False
    rim: bool = False


def flank_compliance(
    body: Body,
    options: JobOptions,
    *,
    sectors: int | None = None,
    body_load: BodyLoad | None = None,
    section: SectionStiffness | None = None,
) -> BodyCompliance:
    """Compliance of the flanks of a body from one finite-element job.

    Parameters
    ----------
    body : Body
        With a mesh, or rigid.
    sectors : int, optional
        Odd number of equal sectors of a segment with both ends fixed; 1: a single tooth. Default:
        the whole body; not for whole meshes.
    body_load : BodyLoad, optional
        Causes of the expansion of the body; a single tooth expands uniformly only.
    section : SectionStiffness, optional
        Stiffness of the mesh, if available.
    """
    if body.rigid or body.mesh is None:
        return no_compliance(body, body_load)
    job, load_vectors = _prepared(body, body_load, options, section)
    if isinstance(body.mesh, WholeMesh):
        response = of_whole(job, body.mesh)
    else:
        response = of_sector(job, body.mesh, sectors, coast_flanks=options.coast_flanks)
    found = _compliance(job, response, options)
    moved = {name: response.by_force[:, k] for k, name in enumerate(load_vectors)}
    expansion = Expansion(*_flank_expansion(body, body_load, job.loads.count, moved))
    job.log.end_step("ring")
    modes, errors, miss = job.loads, job.log.errors, None
    if errors and isinstance(modes, ModeLoads):
        p = response.response.shape[2]  # without the forces on a rim
        miss = modes.fe_error(np.stack(errors)[:, :p, :p])
    log = replace(found.job, seconds=job.log.seconds())
    return replace(found, expansion=expansion, fe_error=miss, job=log)


def _prepared(
    body: Body,
    body_load: BodyLoad | None,
    options: JobOptions,
    section: SectionStiffness | None,
) -> tuple[Job, dict[str, Floats]]:
    """Stiffness, loads and readings of a job, and the vectors of the body load by name."""
    plane = options.plane
    assert body.mesh is not None
    mesh, nodes, cells = body.mesh, body.mesh.nodes, body.mesh.cells

    def estimate(moved: Floats) -> Floats:
        return compliance_error(nodes, cells, body.material, plane, moved)

    log = JobLog(estimate=estimate if options.estimate and not options.nodal else None)
    loads = _loads(body, options)
    if section is None:
        section = stiffness(nodes, cells, body.material, plane)
    log.account.workspace_bytes += section.bytes
    load_vectors = _load_vectors(section, mesh, body_load)
    job = Job(
        body=body,
        stiffness=section,
        loads=loads,
        friction=options.friction,
        readings=_readings(body, options, 2 * len(nodes)),
        forces=np.stack(list(load_vectors.values()), axis=1) if load_vectors else None,
        log=log,
        rim=options.rim,
    )
    return job, load_vectors


def _loads(body: Body, options: JobOptions) -> ModeLoads | NodeLoads:
    """Unit loads of a flank."""
    if options.nodal:
        assert body.mesh is not None
        return NodeLoads(body, nodes_of(body.mesh), options.plane)
    count = options.n_modes if body.tip is None else with_tip(options.n_modes)
    return ModeLoads(body, count, options.plane, friction=options.friction)


def _readings(body: Body, options: JobOptions, size: int) -> Callable[[int], dict[str, Floats]]:
    """Columns for readings, by counter: root stress, tangential displacement of a sharp tip.

    Stress at a free surface is the strain along it times E, in plane strain E/(1 - nu²).
    """
    modulus = body.material.young_modulus_MPa
    if options.plane == "strain":
        modulus /= 1 - body.material.poisson_ratio**2

    def readings(flank: int) -> dict[str, Floats]:
        found = {}
        if options.fillets is not None:
            found["stress_recoveries"] = modulus * options.fillets.columns(flank, size)
        if not options.nodal and has_turned_forces(body):
            found["corner_readings"] = turned_columns(body, flank)
        return found

    return readings


def _compliance(job: Job, found: Response, options: JobOptions) -> BodyCompliance:
    """Compliance from the response of the elements, without the near field."""
    body, loads, friction = job.body, job.loads, options.friction
    p, n_modes = found.response.shape[2], loads.count
    response, below = found.response[:, :p], found.response[:, p:]
    root, turned, places = None, None, 0
    if options.fillets is not None:
        places = options.fillets.points.arc_length_mm.size
        root = RootResponse(options.fillets.points, below[:, :places])
    if not options.nodal and has_turned_forces(body):
        turned = turned_coefficients(body, below[:, places, :n_modes], found.own, options.plane)
    loads.subtract_near_field(response, found.own, job.log.account)
    response, asymmetry = made_symmetric(response, found.across)
    coast, across = None, found.coast
    if across is not None:
        parts = across[..., n_modes:], response[:, :n_modes, n_modes:]
        coast = CoastCompliance.mirrored(
            across[..., :n_modes], response[:, :n_modes, :n_modes], parts if friction else None
        )
    job.log.account.count(fe_unknowns=found.degrees_of_freedom)
    return BodyCompliance(
        smooth=response[:, :n_modes, :n_modes],
        near=loads.near_field,
        modes=FlankModes(
            body.mode_range_mm, closed=body.curve.closed, tip=loads.tip, nodes=loads.nodes
        ),
        flanks=found.flanks,
        tangential=response[:, :n_modes, n_modes:] if friction else None,
        along_near=loads.along_near() if friction else None,
        along=response[:, n_modes:, n_modes:] if options.along and friction else None,
        turned=turned,
        coast=coast,
        root=root,
        rim=found.rim,
        job=job.log.cost(asymmetry, found.degrees_of_freedom),
    )


def _load_vectors(
    section: SectionStiffness,
    mesh: SectorMesh | WholeMesh,
    body_load: BodyLoad | None,
) -> dict[str, Floats]:
    """Nodal loads (2N,) of a body load relative to the support, N per mm of width, by cause.

    The displacement is e_s x plus the response to these loads with a fixed support. The stiffness
    times the coordinates of the nodes is the load for a strain of 1 in the plane. Axial expansion
    is free, also in plane strain.
    """
    loads: dict[str, Floats] = {}
    if body_load is None:
        return loads
    if body_load.strain != body_load.held_strain:
        loads["temperature"] = (body_load.strain - body_load.held_strain) * (
            section.times(mesh.nodes)
        )
    if body_load.speed_rad_per_s > 0.0:
        pull = body_load.density_Ns2_per_mm4 * body_load.speed_rad_per_s**2
        loads["speed"] = pull * centrifugal_load(mesh.nodes, mesh.cells)
    return loads


def _flank_expansion(
    body: Body, body_load: BodyLoad | None, n_modes: int, moved: Mapping[str, Floats]
) -> tuple[float, dict[str, Floats]]:
    """Uniform strain of a body, and the displacements of its flanks beyond it.

    Normal displacements do not describe the motion of a tip corner, which touches its mate
    elsewhere. Therefore the strain that fits all flanks best, by least squares, scales the whole
    body. `moved`: readings (f, p) of the modes on each of f flanks under each of `_load_vectors`,
    pressure modes first, mm². Returns the strain, and mode coefficients (f, n_modes) by load, mm.
    """
    if body_load is None:
        return 0.0, {}
    mesh, closed = body.mesh, body.curve.closed
    if mesh is None or not moved:
        return body_load.held_strain, {}
    span, tip = body.mode_range_mm, body.tip
    read = [mode_loads(flank, span, n_modes, closed=closed, tip=tip) for flank in mesh.flanks]

    def settled(moments: Floats) -> Floats:
        return to_coefficients(moments.T, span, closed=closed, tip=tip).T

    evenly = np.array([columns.T @ mesh.nodes.ravel() for columns in read])
    unit = settled(evenly)
    shifts = {name: settled(part[:, :n_modes]) for name, part in moved.items()}
    square = float(np.sum(evenly * unit))
    parts = {name: float(np.sum(evenly * shift)) / square for name, shift in shifts.items()}
    left = {name: shift - parts[name] * unit for name, shift in shifts.items()}
    return body_load.held_strain + sum(parts.values()), left
