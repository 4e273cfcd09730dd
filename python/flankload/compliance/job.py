"""The finite-element job of a body: unit loads on one sector, the ring closed by Fourier.

A body meshed as a whole takes the plain way (`whole_body`): all flanks loaded one after the other.
A body of z equal sectors needs the mesh of one (`sector_closure`). Its stiffness is factorised
once; on the right stand the pressure modes of the flank and the columns of the cut faces.
"""

from __future__ import annotations

from time import perf_counter, process_time
from typing import TYPE_CHECKING

import numpy as np

from flankload.bodies.body import WholeMesh
from flankload.compliance.body_compliance import BodyCompliance, RootResponse, no_compliance
from flankload.compliance.modes import ModeLoads
from flankload.compliance.nodes import node_loads
from flankload.compliance.response import Job, of_sector, of_whole
from flankload.cost import Account
from flankload.elasticity import stiffness
from flankload.element_error import missed_compliance
from flankload.growth_loads import growth_loads, growth_of_flanks
from flankload.tip_modes import TIP_MODES

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray
    from scipy.sparse import csc_matrix

    from flankload.bodies.body import Body
    from flankload.growth import Growth
    from flankload.root_fillet import RootFillets

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
    matrix: csc_matrix | None = None,
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
    matrix : csc_matrix, optional
        Stiffness of its mesh, where it is there already.
    estimate : bool
        What the elements miss is estimated, too; not of nodes.

    Returns
    -------
    BodyCompliance
    """
    if body.rigid or body.mesh is None:
        return no_compliance(body, growth)
    laps, mesh = _Laps(), body.mesh
    loads = (
        node_loads(body, plane)
        if nodal
        else ModeLoads(body, n_modes + TIP_MODES * (body.tip is not None), plane, friction=friction)
    )
    n_modes = loads.count
    if matrix is None:
        matrix = stiffness(mesh.nodes, mesh.cells, body.material, plane)
    account = Account(workspace_bytes=_sparse_bytes(matrix))
    missed: list[Floats] = []

    def look(moved: Floats) -> None:
        missed.append(missed_compliance(mesh.nodes, mesh.cells, body.material, plane, moved))
        laps("estimate")

    growing = growth_loads(matrix, mesh, growth)
    job = Job(
        body=body,
        matrix=matrix,
        loads=loads,
        friction=friction,
        stress=_stress_columns(fillets, body, plane, matrix.shape[0]),
        forces=np.stack(list(growing.values()), axis=1) if growing else None,
        account=account,
        laps=laps,
        look=look if estimate and not nodal else None,
    )
    if isinstance(mesh, WholeMesh):
        found = of_whole(job, mesh)
    else:
        found = of_sector(job, mesh, sectors=sectors, coast_flanks=coast_flanks)
    response, root = found.response, None
    if fillets is not None:
        count, places = response.shape[2], fillets.points.arc_length_mm.size
        root = RootResponse(fillets.points, response[:, count : count + places])
    response = response[:, : response.shape[2]]
    loads.settle(response, found.own, account)
    # the response the other way is the transposed one (Betti); the halves of rounding are shared
    mirrored = response[found.across].transpose(0, 2, 1)
    asymmetry = float(np.abs(response - mirrored).max() / np.abs(response).max())
    response = 0.5 * (response + mirrored)
    moved = dict(zip(growing, found.by_growth.swapaxes(0, 1), strict=True))
    expansion, shifts = growth_of_flanks(body, growth, n_modes, moved)
    laps("ring")
    crossing = found.crossing
    return BodyCompliance(
        smooth=response[:, :n_modes, :n_modes],
        kernel=loads.kernel,
        wedge=loads.wedge,
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
        counters=account.counters,
        workspace_bytes=account.workspace_bytes,
        seconds=laps.whole(),
        root=root,
        shifts=shifts,
        expansion=expansion,
        missed=loads.missed(np.stack(missed)) if isinstance(loads, ModeLoads) and missed else None,
    )


class _Laps:
    """CPU seconds of the steps of a job."""

    def __init__(self) -> None:
        self._seconds: dict[str, float] = {}
        self._wall, self._clock = perf_counter(), process_time()

    def __call__(self, step: str) -> None:
        """A step ends."""
        now = process_time()
        self._seconds[step] = self._seconds.get(step, 0.0) + now - self._clock
        self._clock = now

    def whole(self) -> dict[str, float]:
        """All steps, and the time on the wall."""
        return {**self._seconds, "wall": perf_counter() - self._wall}


def _sparse_bytes(matrix: csc_matrix) -> int:
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
