"""Condensation of plane meshes with columns by degree of freedom."""

from collections.abc import Mapping

from flankload.base.arrays import Floats
from flankload.bodies.body import SectorMesh, WholeMesh
from flankload.elasticity.condensed_sector import CondensedSector
from flankload.elasticity.finite_elements import SectionStiffness
from flankload.elasticity.job_log import JobLog
from flankload.elasticity.sector_closure import condense_sector, unknowns_of


def condense(
    stiffness: SectionStiffness,
    loads: Floats,
    mesh: SectorMesh | WholeMesh,
    readings: Mapping[str, Floats] | None = None,
    log: JobLog | None = None,
    reactions: Floats | None = None,
    *,
    held: bool = False,
) -> tuple[CondensedSector, int]:
    """Condense a plane mesh, with columns (2N, n), and count the work; returns the unknowns, too.

    `readings`: further readings by their counter (`cost.COUNTERS`); the kinds of readings are the
    loads, then these. Other arguments as of `condense_sector`.
    """
    log, further = JobLog() if log is None else log, dict(readings or {})
    log.account.count(fe_solutions=loads.shape[1])
    if reactions is not None:
        count = reactions.shape[-1]
        log.account.count(bore_reactions=count, fe_solutions=count)
    if not held:
        for name, part in further.items():
            log.account.count(fe_solutions=part.shape[1], **{name: part.shape[1]})
    by_node = [
        part.reshape(stiffness.nodes, 2, part.shape[-1]) for part in (loads, *further.values())
    ]
    sector = condense_sector(stiffness, mesh, by_node[0], by_node[1:], log, reactions, held=held)
    return sector, unknowns_of(mesh, held=held)
