"""What unit loads move: from the elements of a whole body, or of one sector and its likes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flankload.elasticity.compliance.coast import coast_readings
from flankload.elasticity.compliance.modes import ModeLoads
from flankload.elasticity.sector_closure import (
    CondensedSector,
    alike_response,
    close_ring,
    condense,
    segment_response,
    tooth_response,
)
from flankload.elasticity.whole_body import count_loads, unit_loads, whole_response

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import NDArray
    from scipy.sparse import csc_array

    from flankload.bodies.body import Body, SectorMesh, WholeMesh
    from flankload.cost import Account
    from flankload.elasticity.compliance.nodes import NodeLoads

    Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Job:
    """What both ways of a job need: a body as a whole, or one sector of it.

    Attributes
    ----------
    body : Body
    matrix : csc_array
        Stiffness of its mesh.
    loads : ModeLoads or NodeLoads
    friction : bool
    stress : callable or None
        Number of a flank to columns that read stress in the roots.
    corner : callable or None
        Number of a flank to the column that reads its sharp tip along the flank.
    forces : array or None
        Loads of growth.
    account : Account
    laps : callable
        Told the name of a step that ends.
    look : callable or None
        Shown displacements under unit loads.
    onto : (2N, 2N) csc_array or None
        Displacements of all nodes from those that are unknown, where these are fewer.
    """

    body: Body
    matrix: csc_array
    loads: ModeLoads | NodeLoads
    friction: bool
    stress: Callable[[int], Floats] | None
    corner: Callable[[int], Floats] | None
    forces: Floats | None
    account: Account
    laps: Callable[[str], None]
    look: Callable[[Floats], None] | None
    onto: csc_array | None = None

    def carried(self, columns: Floats) -> Floats:
        """Loads as the unknown nodes carry them."""
        return columns if self.onto is None else self.onto.T @ columns

    def readings(self, flank: int) -> tuple[Floats | None, Floats | None]:
        """Columns that only read at a flank: of stress, and of its sharp tip."""
        stress = None if self.stress is None else self.stress(flank)
        corner = None if self.corner is None else self.carried(self.corner(flank))
        return stress, corner

    @property
    def without_growth(self) -> Floats:
        """What the modes read under known loads, where there are none or they are not solved."""
        known = 0 if self.forces is None else self.forces.shape[1]
        return np.zeros((0, known, self.loads.count))


@dataclass(frozen=True, eq=False)
class Response:
    """What comes out of the elements.

    Attributes
    ----------
    response : (k, r, p) array
        Block by block as in `BodyCompliance.smooth`; readings of stress stand below.
    own, across : arrays
        Blocks of flanks loaded themselves; for each block the one the other way.
    by_growth : (f, q, p) array
    degrees_of_freedom : int
    flanks : tuple of int
    crossing : (z, n, p) array or None
        To the coast flanks, as coefficients.
    """

    response: Floats
    own: NDArray[np.int64]
    across: NDArray[np.int64]
    by_growth: Floats
    degrees_of_freedom: int
    flanks: tuple[int, ...] = ()
    crossing: Floats | None = None


def of_whole(job: Job, mesh: WholeMesh) -> Response:
    """All flanks of a body loaded, one after the other.

    Parameters
    ----------
    job : Job
    mesh : WholeMesh

    Returns
    -------
    Response
    """
    job.laps("assembly")
    response, by_growth, free = whole_response(
        job.matrix,
        mesh,
        job.body.mode_range_mm,
        job.loads.count,
        job.laps,
        friction=job.friction,
        closed=job.body.curve.closed,
        readings=job.readings,
        forces=None if job.forces is None else job.carried(job.forces),
        account=job.account,
        nodes=job.loads.nodes,
        look=job.look,
        carried=job.carried,
    )
    f = len(mesh.flanks)
    return Response(
        response,
        own=np.arange(f) * (f + 1),
        across=np.arange(len(response)).reshape(f, -1).T.ravel(),
        by_growth=by_growth,
        degrees_of_freedom=free,
        flanks=tuple(flank.tooth for flank in mesh.flanks),
    )


def of_sector(
    job: Job, mesh: SectorMesh, sectors: Sequence[int | None], *, coast_flanks: bool
) -> dict[int | None, Response]:
    """One tooth loaded, by itself or with its likes beside it.

    Parameters
    ----------
    job : Job
    mesh : SectorMesh
    sectors : sequence of int or None
        Of a segment, an odd number; 1: a single tooth; None: the whole ring. Several are built of
        one sector.
    coast_flanks : bool
        Displacements of the coast flanks are read, too.

    Returns
    -------
    dict of int or None to Response
    """
    n = job.loads.count
    loads = unit_loads(
        mesh,
        job.body.mode_range_mm,
        n,
        friction=job.friction,
        nodes=job.loads.nodes,
        tip=job.loads.tip,
    )
    coast = coast_readings(job.body, mesh, loads[:, :n]) if coast_flanks else None
    columns = None if coast is None else job.carried(coast.columns)
    loads = job.carried(loads)
    job.laps("assembly")
    stress, corner = job.readings(0)
    count_loads(job.account, loads.shape[1], friction=job.friction)
    found: dict[int | None, tuple[Floats, Floats]] = {}
    if set(sectors) == {1}:
        response, free = tooth_response(
            job.matrix,
            loads,
            mesh,
            job.laps,
            readings=[part for part in (columns, stress, corner) if part is not None],
            account=job.account,
            look=job.look,
        )
        found[1] = (response, job.without_growth)
    else:
        sector, free = condense(
            job.matrix,
            loads,
            mesh,
            job.laps,
            coast=columns,
            readings=stress,
            corner=corner,
            forces=None if job.forces is None else job.carried(job.forces),
            account=job.account,
            look=job.look,
        )
        for number in dict.fromkeys(sectors):
            found[number] = _built(job, sector, mesh, number)
    responses: dict[int | None, Response] = {}
    for number, (response, by_growth) in found.items():
        crossing = None
        if coast is not None:
            assert isinstance(job.loads, ModeLoads)
            response, crossing = coast.taken_from(response, job.loads)
        responses[number] = Response(
            response,
            own=np.zeros(1, dtype=np.int64),
            across=-np.arange(mesh.teeth) % mesh.teeth,
            by_growth=by_growth,
            degrees_of_freedom=free,
            crossing=crossing,
        )
    return responses


def _built(
    job: Job, sector: CondensedSector, mesh: SectorMesh, sectors: int | None
) -> tuple[Floats, Floats]:
    """Response of so many condensed sectors, and what the modes read under growth."""
    if sectors == 1:  # the cuts are held: of what is condensed nothing moves
        own = np.concatenate(sector.local)
        response = np.zeros((mesh.teeth, *own.shape))
        response[0] = own
        return response, job.without_growth
    by_growth = job.without_growth
    if job.forces is not None:
        by_growth = alike_response(sector, mesh.teeth)[None, -job.forces.shape[1] :]
    if sectors is None:
        return close_ring(sector, mesh.teeth), by_growth
    return segment_response(sector, mesh.teeth, sectors), by_growth
