"""Coarse elements of a three-dimensional body, and the predicted cost of those of its run.

Each number of a factor belongs to two nodes and two functions of z. The nodes meet in n log n pairs
as in the plane (`element_rates`), the functions in (p + 1)² pairs. On meshes of 530 to 4000 nodes
with degrees 4 to 8 the seconds follow that to a factor of 1.5. The closure of the ring solves as
many unknowns as the cuts have, one harmonic after the other. For stress in the roots, fronts are
kept and the nodes of the fillets substituted back.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import log
from typing import TYPE_CHECKING

from msgspec import structs

from flankload.bodies import SectorMesh
from flankload.cost import Account
from flankload.elasticity.prism import Prism, prism_compliance
from flankload.mechanisms.flank_pair.assembly import bodies_of
from flankload.mechanisms.flank_pair.stages import modes_of
from flankload.scene.axial import degrees_of
from flankload.scene.discretization import Discretization, Grid

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flankload.bodies import Body
    from flankload.elasticity.compliance import BodyCompliance
    from flankload.elasticity.job_log import JobCost
    from flankload.scene import Scene

#: Elements, modes and degrees along the axis of coarse bodies: a tenth of the seconds of the
#: default, within 0.5 % of its transmission error and 0.06 of its face load factor.
COARSE = Discretization(flank_element_parts=0.5, modes=3, grid=Grid())
DEGREE, LOAD_DEGREE, CUT_DEGREE = 4, 2, 3
#: Seconds of the back substitution for the fillets relative to those of the factorisation, and
#: bytes of the fronts relative to its workspace: 0.27 to 0.33 and 1.0 to 1.6, measured on gears of
#: 16 to 60 teeth, spur and helical.
RECOVERY_SECONDS, RECOVERY_BYTES = 0.3, 1.3


def coarse_compliance(
    scene: Scene, z: int, *, friction: bool = False
) -> tuple[Body, BodyCompliance]:
    """Body z (0, 1) of a three-dimensional scene on coarse elements, and its compliance.

    Elements that the scene names coarser, or a file gives, stay. `friction`: loads along the flank
    are solved, too.
    """
    spec, named_mm = (scene.body_1, scene.body_2)[z], scene.accuracy.flank_element_mm
    if named_mm is not None:
        named_mm = max(named_mm, COARSE.flank_element_parts * getattr(spec, "module_mm", 0.0))
    accuracy = structs.replace(scene.accuracy, flank_element_mm=named_mm, modes=None)
    scene = replace(scene, accuracy=accuracy)
    (body,) = bodies_of(scene, COARSE, (z,))
    assert body.axial is not None
    prism = Prism(
        body.axial.range_mm,
        body.axial.twist_rad_per_mm,
        degree=DEGREE,
        load_degree=LOAD_DEGREE,
        cut_degree=CUT_DEGREE,
        screening=True,
        regions=body.axial.regions,
        shaft=body.axial.carrying,
    )
    modes = modes_of(body, scene, COARSE)
    return body, prism_compliance(body, prism, n_modes=modes, friction=friction)


@dataclass(frozen=True)
class PrismRates:
    """Measured cost of coarse elements in three dimensions, of a body with the coarse mesh."""

    body: Body
    job: JobCost

    def price(self, scene: Scene, body: Body, counters: Mapping[str, int]) -> Account:
        """CPU seconds and bytes of the elements of a run, by the counters of the stage."""
        degree, _ = degrees_of(scene.accuracy)
        coarse, mesh = self.body.mesh, body.mesh
        assert isinstance(coarse, SectorMesh)
        assert isinstance(mesh, SectorMesh)
        steps = self.job.seconds
        modes, rubbing = (counters[f"unit_loads_{each}"] for each in ("normal", "tangential"))
        nodes, own = (
            unknowns / (p + 1)
            for unknowns, p in (
                (counters["fe_unknowns"], degree),
                (self.job.degrees_of_freedom, DEGREE),
            )
        )
        pairs = nodes * log(nodes) / (own * log(own)) * ((degree + 1) / (DEGREE + 1)) ** 2
        cuts = len(mesh.left_nodes) / len(coarse.left_nodes)
        cuts *= (min(Prism.cut_degree, degree) + 1) / (CUT_DEGREE + 1)
        places = counters["stress_recoveries"]
        more_s, more_bytes = (RECOVERY_SECONDS, RECOVERY_BYTES) if places else (0.0, 0.0)
        seconds = (
            steps["assembly"] * nodes / own
            + steps["factorisation"] * pairs * (1.0 + more_s)
            + steps["ring"] * cuts**3
            + steps["near field"] * (modes + rubbing) / self.job.counters["fe_solutions"]
        )
        return Account(
            cpu_s=seconds,
            bytes=8 * mesh.teeth * modes * (modes + rubbing + places * (degree + 1)),
            workspace_bytes=round(self.job.workspace_bytes * pairs * (1.0 + more_bytes)),
        )
