"""Predicted cost of the finite elements of a body, scaled from a job with linear elements.

A factor of a plane mesh with n unknowns has n log n entries (George, SIAM J. Numer. Anal. 10,
1973). On meshes of 600 to 16000 unknowns the factorisation time grows in proportion to that, not
yet as n^(3/2); the time of a solution grows in proportion to n. The assembly time is proportional
to the number of entries of the element matrices.
"""

from __future__ import annotations

from dataclasses import dataclass
from importlib import import_module
from math import log
from typing import TYPE_CHECKING

from flankload.bodies.body import SectorMesh
from flankload.cost import Account
from flankload.elasticity.compliance.turned import has_turned_forces
from flankload.elasticity.finite_elements import linear_cells

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flankload.bodies import Body
    from flankload.elasticity.job_log import JobCost

#: Cost of smoothing stresses relative to an assembly, for each flank and for each group of this
#: many columns: smoothing evaluates the same gradients, but not their products.
SMOOTHING_PART, SMOOTHED_COLUMNS = 1 / 3, 12


def load_packages() -> None:
    """Import the packages that elements need before they are timed."""
    import_module("skfem")


def unknowns_of(body: Body) -> int:
    """Number of free degrees of freedom of a body's elements."""
    assert body.mesh is not None
    return 2 * (len(body.mesh.nodes) - len(body.mesh.fixed_nodes))


@dataclass(frozen=True)
class ElementRates:
    """Measured cost of a job.

    Attributes
    ----------
    assembly_s : float
        CPU seconds for the stiffness matrix of its own elements.
    job : JobCost
        On linear elements, or its own.
    """

    body: Body
    assembly_s: float
    job: JobCost

    @classmethod
    def of_linear(cls, body: Body, linear_s: float, job: JobCost) -> ElementRates:
        """Rates from the seconds for the stiffness matrix of linear elements."""
        assert body.mesh is not None
        linear, quadratic = (
            sum(cells.size * cells.shape[1] for _, cells in blocks)
            for blocks in (linear_cells(body.mesh.cells), body.mesh.cells)
        )
        return cls(body, linear_s * quadratic / linear, job)

    def price(self, counters: Mapping[str, int], *, places: int = 0, finer: float = 1.0) -> Account:
        """CPU seconds and bytes of the finite elements, from the counters of the stage.

        `places` is the number of evaluation points in the root fillets of a tooth, `finer` that of
        the unknowns relative to the mesh of the body.
        """
        job, steps = self.job, self.job.seconds
        unknowns = finer * unknowns_of(self.body)
        more = unknowns / max(1, job.degrees_of_freedom)
        larger = more * log(unknowns) / log(max(3, job.degrees_of_freedom))
        cuts, mine = counters.get("cut_columns", 0), job.counters.get("cut_columns", 0)
        columns, own = counters["fe_solutions"] - cuts, job.counters["fe_solutions"] - mine
        seconds = finer * self.assembly_s + steps.get("ring", 0.0)
        # if there are cuts, half of that step are the solutions for them
        work = counters["fe_factorisations"] + (cuts / mine if mine else 0.0)
        seconds += steps.get("factorisation", 0.0) * larger * work / (2.0 if mine else 1.0)
        seconds += steps.get("solution", 0.0) * more * columns / max(1, own)
        mesh = self.body.mesh
        assert mesh is not None
        flanks = len(mesh.flanks)
        blocks = mesh.teeth if isinstance(mesh, SectorMesh) else flanks**2
        loads = counters["unit_loads_normal"] + counters.get("unit_loads_tangential", 0)
        response = loads // flanks
        modes = counters["unit_loads_normal"] // flanks
        turned = modes if has_turned_forces(self.body) else 0
        # the stresses are part of an array with the readings of the tip
        stressed = response + places + (1 if turned else 0) if places else 0
        return Account(
            cpu_s=seconds,
            bytes=8 * blocks * (response * (response + stressed) + turned),
            workspace_bytes=round(job.workspace_bytes * larger),
        )

    def smoothing_s(self, counters: Mapping[str, int]) -> float:
        """CPU seconds that the error estimate needs to smooth stresses."""
        columns = counters["unit_loads_normal"] + counters.get("unit_loads_tangential", 0)
        assert self.body.mesh is not None
        flanks = len(self.body.mesh.flanks)
        return SMOOTHING_PART * self.assembly_s * (flanks + columns / SMOOTHED_COLUMNS)
