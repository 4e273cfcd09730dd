"""Work of a run, counted in advance from bodies, positions and effects alone.

The table of effects gives the work of each effect per body, per load on a flank, per evaluation
point in a fillet and per state; meshes and positions give the number of these. Nothing is solved,
so every run can have a prediction.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from flankload.analysis.deciding_positions import n_deciding
from flankload.analysis.estimate import MOST_SWEEPS
from flankload.bodies.body import SectorMesh, WholeMesh
from flankload.bodies.tip_modes import with_tip
from flankload.cost import held_bytes
from flankload.elasticity.compliance.plane_extent import PlaneExtent
from flankload.elasticity.sector_closure import unknowns_of
from flankload.mechanisms.elements import (
    asks_tangential,
    counted_loads,
    has_tangential_loads,
    holds_tangential,
    modes_of,
    prism_of,
)
from flankload.mechanisms.stage_clock import elements_stage
from flankload.scene.effects import work_in

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flankload.elasticity.prism import Prism
    from flankload.mechanisms.elements import ElasticBodies
    from flankload.pairing.body_pair import BodyPair
    from flankload.scene import Scene
    from flankload.scene.effects import Effects

#: Bytes of a number.
WORD = 8
#: Further counters of the elements of a body.
FURTHER = ("fe_load_cases_growth", "bore_reactions", "stress_recoveries", "coast_readings")
#: Unit forces on a rim for each polynomial over the width, counted as normal loads.
RIM_LOADS = 2
#: Further sweeps of the estimate of three-dimensional bodies: degrees along the axis, slices.
SLICE_VARIANTS = 2


def predicted_work(scene: Scene, pair: BodyPair) -> dict[str, dict[str, int]]:
    """Count the work of a run whose positions are not yet added.

    By stages, as `result.cost["stages"]` names them, then by counters: those that are known,
    including zeros. Exact, with a rare exception: a state that runs out of workspace is solved
    again. The final number of adaptive positions is unknown.
    """
    known = pair.body_1.flank_angle_known and pair.body_2.flank_angle_known
    # files that give the places of the flanks take a state without load
    stages = {"bodies": {"states": 0 if known else 1}}
    for z, (name, job) in enumerate(zip(pair.names, pair.jobs, strict=True)):
        if job.needs_elements:
            stages[elements_stage(name)] = work_of_elements(scene, pair, z, name)
    return stages | _sweeps(scene, pair)


def work_of_elements(scene: Scene, pair: ElasticBodies, z: int, name: str) -> dict[str, int]:
    """Work of the elements of body z; effects act on it as on the body with this name."""
    body, job = pair.bodies[z], pair.jobs[z]
    work = work_in(elements_stage(name), pair.effects)
    if job.coast_flanks:
        work = replace(work, coast_readings=1)
    if not job.elastic:  # elements are needed for the expansion only
        work = replace(work, factorisations=1, normal_loads=1)
    # all purposes of tangential loads use the same ones
    work = replace(work, tangential_loads=has_tangential_loads(body, job, pair.effects))
    growth = 0 if job.body_load is None else job.body_load.load_cases
    modes = modes_of(body, scene, pair.discretization)
    if body.tip is not None and not pair.effects.nodal_near_field:
        modes = with_tip(modes)
    fillets = job.fillets
    places = 0 if fillets is None else int(fillets.points.arc_length_mm.size)
    if body.mesh is None:
        return _solved(0, 0, 0)
    extent = prism_of(body, scene) or PlaneExtent()
    columns = _Columns(
        of_profile=tuple(
            round(part) * modes for part in (work.normal_loads, work.tangential_loads)
        ),
        extent=extent,
        growth=growth,
        places=places,
        coast=round(work.coast_readings),
        rim=RIM_LOADS * (extent.load_degree + 1) if job.rim else 0,
    )
    tooth = pair.effects.single_tooth
    found = columns.work(body.mesh, tooth=tooth)
    estimated = scene.accuracy.estimate and _is_estimated(pair, z)
    if estimated and not extent.recovers_stress:  # of the plane section
        found["fe_factorisations"] += 1
        found["fe_solutions"] += columns.of_profile[0]
        if extent.regions:  # another degree along the axis
            found["fe_factorisations"] += extent.factorisations
            found["fe_solutions"] += columns.of_profile[0] * (extent.load_degree + 1)
    per_node = extent.components * extent.axial.count
    found["fe_unknowns"] = unknowns_of(body.mesh, held=tooth, per_node=per_node)
    asked = body.elements is not None or asks_tangential(pair.effects) is not None
    named = counted_loads(found, asked=asked)
    if job.rim:  # its response is part of larger arrays
        return named
    # responses to the tangential loads of modified flanks are not held
    counted = found
    if not holds_tangential(job, pair.effects):
        counted = found | {"unit_loads_tangential": 0}
    friction = asks_tangential(pair.effects) is not None
    along = pair.effects.friction and pair.effects.finite_influence
    held = columns.bytes(body.mesh, counted, along=along, friction=friction)
    points = 0 if fillets is None else held_bytes(fillets.points)
    return named | {"bytes": held + points}


def _is_estimated(pair: ElasticBodies, z: int) -> bool:
    """Whether the discretization error of the elements of a body is estimated.

    Not with nodal tables: there, fewer nodes give the error of both bodies.
    """
    elastic = pair.jobs[z].elastic and pair.bodies[z].mesh is not None
    return elastic and not pair.effects.nodal_near_field


@dataclass(frozen=True)
class _Columns:
    """Loads and readings of the elements of a body.

    Attributes
    ----------
    of_profile : (int, int)
        Normal and tangential loads of a flank, each over all of the width.
    extent : PlaneExtent or Prism
        Extent of the body along its axis.
    growth, places : int
        Body loads, and places of stress.
    coast : int
        1 with coast flanks.
    rim : int
        Loads of a rim.
    """

    of_profile: tuple[int, ...]
    extent: PlaneExtent | Prism
    growth: int
    places: int
    coast: int
    rim: int

    def work(self, mesh: SectorMesh | WholeMesh, *, tooth: bool) -> dict[str, int]:
        """Counters of the elements; `tooth`: with fixed cuts.

        Without cuts or with fixed ones, readings come from the solutions of the load cases.
        """
        factorisations, along = self.extent.factorisations, self.extent.load_degree + 1
        normal, tangential = (part * along * len(mesh.flanks) for part in self.of_profile)
        if not isinstance(mesh, SectorMesh):
            return _solved(factorisations, normal, tangential, fe_load_cases_growth=self.growth)
        coast = self.coast * (normal + tangential)
        if tooth:
            return _solved(factorisations, normal, tangential, coast_readings=coast)
        found = _solved(
            factorisations,
            normal + self.rim,
            tangential,
            fe_load_cases_growth=self.growth,
            bore_reactions=mesh.has_free_bore * self.extent.rigid_motions,
            stress_recoveries=self.places,
            coast_readings=coast,
        )
        # one for each function of z
        found["fe_solutions"] += self.places * self.extent.axial.degree
        return found

    def bytes(
        self,
        mesh: SectorMesh | WholeMesh,
        counted: Mapping[str, int],
        *,
        along: bool,
        friction: bool,
    ) -> int:
        """Bytes of the compliance of a body, with tangential loads that are held if counted.

        Those of root stress are held with friction only.
        """
        flanks = len(mesh.flanks)
        blocks = mesh.teeth if isinstance(mesh, SectorMesh) else flanks**2
        normal, tangential = (
            counted[f"unit_loads_{each}"] // flanks for each in ("normal", "tangential")
        )
        both = normal + tangential
        own = normal * both + along * tangential**2
        recovered = self.places * self.extent.axial.count
        own += recovered * (both if friction else normal) * (1 + self.coast)
        return WORD * blocks * (own + 3 * self.coast * normal * both)


def _solved(factorisations: int, normal: int, tangential: int, **further: int) -> dict[str, int]:
    """Counters of the finite elements; each of `FURTHER` is a column of the elimination."""
    more = dict.fromkeys(FURTHER, 0) | further
    return {
        "fe_factorisations": factorisations,
        "fe_solutions": normal + tangential + sum(more.values()),
        "unit_loads_normal": normal,
        "unit_loads_tangential": tangential,
        **more,
    }


def slice_variants(effects: Effects) -> int:
    """Number of sweeps of an estimate that bodies with a width have besides."""
    return SLICE_VARIANTS if effects.three_dimensions else 0


def estimate_sweeps(pair: BodyPair) -> int:
    """Number of sweeps of the error estimate."""
    elements = any(_is_estimated(pair, z) for z in (0, 1))
    sweeps = MOST_SWEEPS - pair.effects.lumped_contact - (not elements)
    return sweeps + slice_variants(pair.effects)


def _sweeps(scene: Scene, pair: BodyPair) -> dict[str, dict[str, int]]:
    """States of the sweep, and of later sweeps if a torque loads the pair."""
    sweeps, loaded = estimate_sweeps(pair), sum(torque > 0 for torque in scene.torques_Nm)
    states = {"sweep": len(scene.torques_Nm)}  # at each position
    if scene.accuracy.estimate:
        states["estimate"] = sweeps * loaded
    slices = {}
    if not pair.slices.plane:
        slices["sweep"] = pair.slices.count * states["sweep"]
        # one of the sweeps of the estimate has others
        count = (sweeps - 1) * pair.slices.count + pair.slices.compared().count
        slices["estimate"] = count * loaded
    lumped = pair.effects.lumped_contact
    none: dict[str, int] = {}
    if lumped:
        none |= {"contact_passes": 0, "influence_columns": 0}
    if lumped or not pair.effects.friction:
        none |= {"influence_columns_tangential": 0}
    if pair.adaptive:
        return dict.fromkeys(states, none)
    positions = dict.fromkeys(states, pair.position_rad.size)
    if "estimate" in states:
        positions["estimate"] = min(n_deciding(plane=pair.slices.plane), pair.position_rad.size)
    return {
        stage: none
        | {"states": count * positions[stage]}
        | ({"slices": slices[stage] * positions[stage]} if stage in slices else {})
        for stage, count in states.items()
    }
