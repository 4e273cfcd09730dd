"""What the elements of a body will take: the steps of a job with linear ones, scaled as they grow.

A sparse factor of a plane mesh takes seconds by the power 3/2 of its unknowns, and memory by their
number times its logarithm (nested dissection: George, SIAM J. Numer. Anal. 10, 1973); a solution
as long as the factor is large. Stiffness is assembled as the run does it, once.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import log
from typing import TYPE_CHECKING

from flankload.bodies.body import WholeMesh
from flankload.cost import Account

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flankload.bodies import Body
    from flankload.compliance import BodyCompliance

#: A smoothing of stresses takes this part of an assembly for each flank, and for so many columns:
#: it takes the same gradients, but no products of them.
SMOOTHING_PART, SMOOTHED_COLUMNS = 1 / 3, 12


def unknowns_of(body: Body) -> int:
    """Degrees of freedom of a body's elements that are not held."""
    assert body.mesh is not None
    return 2 * (len(body.mesh.nodes) - len(body.mesh.fixed_nodes))


@dataclass(frozen=True)
class ElementRates:
    """What the job of a body with linear elements took.

    Attributes
    ----------
    body : Body
    assembly_s : float
        CPU seconds of its stiffness, whose elements are those of the run.
    job : BodyCompliance
    closures : int
        Compliances that were built of one factorisation.
    """

    body: Body
    assembly_s: float
    job: BodyCompliance
    closures: int

    def price(self, counters: Mapping[str, int], *, places: int = 0, finer: float = 1.0) -> Account:
        """CPU seconds and bytes of elements.

        Parameters
        ----------
        counters : mapping of str to int
            Of the stage.
        places : int
            In the root fillets of a tooth.
        finer : float
            So many times the unknowns of the run's mesh.

        Returns
        -------
        Account
        """
        job, steps = self.job, self.job.seconds
        unknowns = finer * unknowns_of(self.body)
        more = unknowns / max(1, job.degrees_of_freedom)
        larger = more * log(unknowns) / log(max(3, job.degrees_of_freedom))
        cuts = counters.get("cut_columns", 0)
        columns = counters["fe_solutions"] - cuts
        mine = job.counters["fe_solutions"] - job.counters.get("cut_columns", 0)
        seconds = finer * self.assembly_s
        if counters["fe_factorisations"]:
            seconds += steps.get("factorisation", 0.0) * more**1.5
        seconds += steps.get("solution", 0.0) * larger * columns / max(1, mine)
        # matrices of the cuts, of which there are twice as many unknowns
        seconds += steps.get("ring", 0.0) / self.closures * (4.0 if cuts else 1.0)
        mesh = self.body.mesh
        flanks = len(mesh.flanks) if isinstance(mesh, WholeMesh) else 1
        blocks = flanks**2 if isinstance(mesh, WholeMesh) else mesh.teeth  # type: ignore[union-attr]
        response = (counters["unit_loads_normal"] + counters.get("unit_loads_tangential", 0)) // (
            flanks
        )
        return Account(
            cpu_s=seconds,
            bytes=8 * blocks * response * (response + (response + places if places else 0)),
            workspace_bytes=round(job.workspace_bytes * larger),
        )

    def smoothing_s(self, counters: Mapping[str, int]) -> float:
        """CPU seconds in which the estimate smooths stresses."""
        columns = counters["unit_loads_normal"] + counters.get("unit_loads_tangential", 0)
        mesh = self.body.mesh
        flanks = len(mesh.flanks) if isinstance(mesh, WholeMesh) else 1
        return SMOOTHING_PART * self.assembly_s * (flanks + columns / SMOOTHED_COLUMNS)
