"""The finite-element job of a body: unit loads on one sector, the ring closed by Fourier.

A body meshed as a whole takes the plain way (`whole_body`): all flanks loaded one after the other.
A body of z equal sectors needs the mesh of one (`sector_closure`). Its stiffness is factorised
once; on the right stand the pressure modes of the flank and the columns of the cut faces.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from flankload.bodies.body import WholeMesh
from flankload.bodies.tip_modes import TIP_MODES
from flankload.cost import Account
from flankload.elasticity.compliance.body_compliance import (
    BodyCompliance,
    RootResponse,
    no_compliance,
)
from flankload.elasticity.compliance.laps import Laps
from flankload.elasticity.compliance.modes import ModeLoads
from flankload.elasticity.compliance.nodes import node_loads
from flankload.elasticity.compliance.response import Job, Response, of_sector, of_whole
from flankload.elasticity.compliance.turned import (
    has_turned_forces,
    turned_coefficients,
    turned_columns,
)
from flankload.elasticity.expansion_loads import growth_loads, growth_of_flanks
from flankload.elasticity.fe_error import missed_compliance
from flankload.elasticity.finite_elements import linear_cells, linear_edges, stiffness

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import NDArray
    from scipy.sparse import csc_array

    from flankload.bodies.body import Body, SectorMesh
    from flankload.bodies.root_fillet import RootFillets
    from flankload.pairing.expansion import Growth

    Floats = NDArray[np.float64]


def flank_compliance(
    body: Body,
    *,
    n_modes: int,
    plane: str,
    friction: bool = False,
    along: bool = False,
    nodal: bool = False,
    coast_flanks: bool = False,
    fillets: RootFillets | None = None,
    sectors: int | None = None,
    growth: Growth | None = None,
    matrix: csc_array | None = None,
    estimate: bool = False,
) -> BodyCompliance:
    """Compliance of a body's flanks from one finite-element job.

    Parameters
    ----------
    body : Body
        With a mesh, or rigid.
    n_modes : int
        Pressure modes of a flank; their degree should be at most half the number of flank elements.
        A tip rounding or chamfer has two more.
    plane : {"strain", "stress"}
    friction : bool
        As many modes of load along the flank are solved, too.
    along : bool
        Their displacements along the flank are wanted, too.
    nodal : bool
        Unit forces at the nodes of the flank in place of modes; n_modes is not asked for then.
    coast_flanks : bool
        Displacements of the coast flanks are read, too; of a sector alone.
    fillets : RootFillets, optional
        Where stress is wanted, too.
    sectors : int, optional
        Only a segment of so many equal sectors, an odd number, its two ends held; 1: a single
        tooth. A body meshed as a whole has none.
    growth : Growth, optional
        By what the body grows; of a single tooth only as a whole.
    matrix : csc_array, optional
        Stiffness of its mesh, where it is there already.
    estimate : bool
        What the elements miss is estimated, too; not of nodes.

    Returns
    -------
    BodyCompliance
    """
    (found,) = flank_compliances(
        body,
        ((sectors, growth),),
        n_modes=n_modes,
        plane=plane,
        friction=friction,
        along=along,
        nodal=nodal,
        coast_flanks=coast_flanks,
        fillets=fillets,
        matrix=matrix,
        estimate=estimate,
    )
    return found


def flank_compliances(
    body: Body,
    variants: Sequence[tuple[int | None, Growth | None]],
    *,
    n_modes: int,
    plane: str,
    friction: bool = False,
    along: bool = False,
    nodal: bool = False,
    coast_flanks: bool = False,
    fillets: RootFillets | None = None,
    matrix: csc_array | None = None,
    estimate: bool = False,
    linear: bool = False,
) -> tuple[BodyCompliance, ...]:
    """Compliances of a body that differ in what is built of one sector, from one job.

    Parameters
    ----------
    body : Body
    variants : sequence of (int or None, Growth or None)
        `sectors` and `growth` of each, as of `flank_compliance`.
    n_modes, plane, friction, along, nodal, coast_flanks, fillets, matrix, estimate
        As of `flank_compliance`.
    linear : bool
        Edges stay straight: a quarter of the unknowns, some percent too stiff.

    Returns
    -------
    tuple of BodyCompliance
        The counters, bytes and seconds of each are those of the whole job.
    """
    if body.rigid or body.mesh is None:
        return tuple(no_compliance(body, growth) for _, growth in variants)
    laps, mesh, onto = Laps(), body.mesh, None
    loads = (
        node_loads(body, plane)
        if nodal
        else ModeLoads(body, n_modes + TIP_MODES * (body.tip is not None), plane, friction=friction)
    )
    n_modes = loads.count
    if matrix is None:
        cells = linear_cells(mesh.cells) if linear else mesh.cells
        matrix = stiffness(mesh.nodes, cells, body.material, plane)
    if linear:
        laps("assembly")
        onto = linear_edges(mesh.nodes, mesh.cells)
        mesh = _of_corners(mesh, onto)
    account = Account(workspace_bytes=_sparse_bytes(matrix))
    missed: list[Floats] = []

    def look(moved: Floats) -> None:
        missed.append(missed_compliance(mesh.nodes, mesh.cells, body.material, plane, moved))
        laps("estimate")

    growing = {growth: growth_loads(matrix, mesh, growth, lumped=linear) for _, growth in variants}
    forces = [load for named in growing.values() for load in named.values()]
    job = Job(
        body=body,
        matrix=matrix,
        loads=loads,
        friction=friction,
        stress=_stress_columns(fillets, body, plane, matrix.shape[0]),
        corner=None if nodal or not has_turned_forces(body) else partial(turned_columns, body),
        forces=np.stack(forces, axis=1) if forces else None,
        account=account,
        laps=laps,
        look=look if estimate and not nodal else None,
        onto=onto,
    )
    if isinstance(mesh, WholeMesh):
        responses = dict.fromkeys((sectors for sectors, _ in variants), of_whole(job, mesh))
    else:
        responses = of_sector(job, mesh, [n for n, _ in variants], coast_flanks=coast_flanks)
    settled = {
        n: _settled(job, found, fillets, plane, along=along) for n, found in responses.items()
    }
    known = [(growth, name) for growth, named in growing.items() for name in named]
    compliances = []
    for sectors, growth in variants:
        by_growth = responses[sectors].by_growth.swapaxes(0, 1)
        moved = {
            name: part
            for (cause, name), part in zip(known, by_growth, strict=True)
            if cause == growth
        }
        expansion, shifts = growth_of_flanks(body, growth, loads.count, moved)
        compliances.append(replace(settled[sectors], shifts=shifts, expansion=expansion))
    laps("ring")
    miss = loads.missed(np.stack(missed)) if isinstance(loads, ModeLoads) and missed else None
    seconds = laps.whole()
    return tuple(replace(each, missed=miss, seconds=seconds) for each in compliances)


def _settled(
    job: Job, found: Response, fillets: RootFillets | None, plane: str, *, along: bool
) -> BodyCompliance:
    """What is left of a response without the near field, as mode coefficients."""
    body, loads, friction = job.body, job.loads, job.friction
    response, root, n_modes = found.response, None, loads.count
    turned, below = None, response.shape[2]
    if fillets is not None:
        places = fillets.points.arc_length_mm.size
        root = RootResponse(fillets.points, response[:, below : below + places])
        below += places
    if job.corner is not None:
        turned = turned_coefficients(body, response[:, below, :n_modes], found.own, plane)
    response = response[:, : response.shape[2]]
    loads.settle(response, found.own, job.account)
    # the response the other way is the transposed one (Betti); the halves of rounding are shared
    mirrored = response[found.across].transpose(0, 2, 1)
    asymmetry = float(np.abs(response - mirrored).max() / np.abs(response).max())
    response = 0.5 * (response + mirrored)
    crossing = found.crossing
    return BodyCompliance(
        smooth=response[:, :n_modes, :n_modes],
        kernel=loads.kernel,
        wedge=loads.wedge,
        turned=turned,
        wedge_along=loads.wedge_along,
        tip=loads.tip,
        mode_range_mm=body.mode_range_mm,
        flanks=found.flanks,
        tangential=response[:, :n_modes, n_modes:] if friction else None,
        jump=loads.jump,
        along=response[:, n_modes:, n_modes:] if along and friction else None,
        crossing=None if crossing is None else crossing[..., :n_modes],
        crossing_tangential=crossing[..., n_modes:] if crossing is not None and friction else None,
        closed=body.curve.closed,
        nodes=loads.nodes,
        asymmetry=asymmetry,
        degrees_of_freedom=found.degrees_of_freedom,
        counters=job.account.counters,
        workspace_bytes=job.account.workspace_bytes,
        root=root,
    )


def _of_corners(mesh: SectorMesh | WholeMesh, onto: csc_array) -> SectorMesh | WholeMesh:
    """The mesh with its corners alone free to move."""
    middles = np.flatnonzero(np.diff(onto.indptr)[::2] == 0)
    fixed = np.union1d(mesh.fixed_nodes, middles)
    if isinstance(mesh, WholeMesh):
        return replace(mesh, fixed_nodes=fixed)
    left, right = (side[~np.isin(side, middles)] for side in (mesh.left_nodes, mesh.right_nodes))
    return replace(mesh, fixed_nodes=fixed, left_nodes=left, right_nodes=right)


def _sparse_bytes(matrix: csc_array) -> int:
    return int(matrix.data.nbytes + matrix.indices.nbytes + matrix.indptr.nbytes)


def _stress_columns(
    fillets: RootFillets | None, body: Body, plane: str, size: int
) -> Callable[[int], NDArray[np.float64]] | None:
    """Columns that read stress at a flank: the strain times the modulus of a free surface."""
    if fillets is None:
        return None
    modulus = body.material.young_modulus_MPa
    if plane == "strain":
        modulus /= 1 - body.material.poisson_ratio**2
    return lambda flank: modulus * fillets.columns(flank, size)
