"""Work of a run, counted in advance from bodies, positions and effects alone.

The table of effects gives the work of each effect per body, per load on a flank, per evaluation
point in a fillet and per state; meshes and positions give the number of these. Nothing is solved,
so every run can have a prediction.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from flankload.analysis.estimate import n_sweeps
from flankload.analysis.tangent import SIDES
from flankload.bodies.body import SectorMesh, WholeMesh
from flankload.bodies.tip_modes import with_tip
from flankload.elasticity.compliance.turned import has_turned_forces
from flankload.elasticity.finite_elements import MANY_KEPT
from flankload.elasticity.prism import prism_unknowns
from flankload.mechanisms.flank_pair.stages import modes_of
from flankload.scene.axial import degrees_of
from flankload.scene.effects import work_in

if TYPE_CHECKING:
    from flankload.bodies import Body
    from flankload.bodies.root_fillet import RootFillets
    from flankload.pairing.body_pair import BodyPair
    from flankload.scene import Scene
    from flankload.scene.effects import Work

#: Further sweeps of the estimate of three-dimensional bodies: degrees along the axis, slices.
SLICE_VARIANTS = 2


def predicted_work(scene: Scene, pair: BodyPair) -> dict[str, dict[str, int]]:
    """Count the work of a run whose positions are not yet added.

    By stages, as `result.cost["stages"]` names them, then by counters: those that are known,
    including zeros. Exact, with two rare exceptions: a state that runs out of workspace is solved
    again, and cuts whose factors need other pivots are solved for one by one. The final number of
    adaptive positions is unknown.
    """
    stages = {"bodies": {"states": _standing_states(pair)}}
    for z, body in enumerate((pair.body_1, pair.body_2)):
        grows = pair.growth[z]
        growth = 0 if grows is None else grows.load_cases
        elastic = (pair.effects.elastic_body_1, pair.effects.elastic_body_2)[z]
        if elastic or growth:
            stage = f"compliance body {z + 1}"
            work = work_in(stage, pair.effects)
            if not elastic:  # elements are needed for the expansion only
                work = replace(work, factorisations=1, normal_loads=1)
            modes = modes_of(body, scene, pair.discretization)
            if body.tip is not None and not pair.effects.nodal_near_field:
                modes = with_tip(modes)
            if pair.effects.three_dimensions:
                estimated = scene.accuracy.estimate and z in elements_estimated(pair)
                places = _places(pair.fillets[z]) if work.recoveries else 0
                found = _prism(body, work, modes, degrees_of(scene.accuracy), estimated)
                stages[stage] = found | {"stress_recoveries": places}
                continue
            places = _places(pair.fillets[z])
            stages[stage] = (
                _whole(body, work, modes, growth)
                if pair.effects.single_tooth or not isinstance(body.mesh, SectorMesh)
                else _sector(
                    body.mesh, work, modes, growth, places, corners=int(_reads_corner(pair, body))
                )
            )
    return stages | _sweeps(scene, pair)


def elements_estimated(pair: BodyPair) -> tuple[int, ...]:
    """Bodies (0, 1) for which the estimate includes the discretization error of their elements.

    Empty for nodal tables: there, fewer nodes give the error of both bodies.
    """
    if pair.effects.nodal_near_field:
        return ()
    elastic = (pair.effects.elastic_body_1, pair.effects.elastic_body_2)
    bodies = (pair.body_1, pair.body_2)
    return tuple(z for z in (0, 1) if elastic[z] and bodies[z].mesh is not None)


def _standing_states(pair: BodyPair) -> int:
    """Number of states without load: one if files give the places of the flanks."""
    return 0 if pair.body_1.flank_angle_known and pair.body_2.flank_angle_known else 1


def _whole(body: Body, work: Work, modes: int, growth: int) -> dict[str, int]:
    """Work of elements without cuts, or with fixed cuts.

    Stresses come from the solutions of the load cases. Zero for a body with imported compliance.
    """
    if body.mesh is None:
        return _solved(0, 0, 0, growth=0)
    flanks = len(body.mesh.flanks) if isinstance(body.mesh, WholeMesh) else 1
    normal, tangential = (round(part) * modes * flanks for part in _loads(work))
    return _solved(round(work.factorisations), normal, tangential, growth=growth)


def _reads_corner(pair: BodyPair, body: Body) -> bool:
    """Whether a sector needs the displacement of its sharp tip along the flank."""
    return not pair.effects.nodal_near_field and has_turned_forces(body)


def _sector(
    mesh: SectorMesh, work: Work, modes: int, growth: int, places: int, *, corners: int
) -> dict[str, int]:
    """Work of a sector: a solution for each unknown of its cuts, or one factorisation for many."""
    cuts = 2 * (len(mesh.left_nodes) + len(mesh.right_nodes))
    many = cuts > MANY_KEPT
    normal, tangential = (round(part) * modes for part in _loads(work))
    return _solved(
        round(work.factorisations) + many,
        normal,
        tangential,
        growth=growth,
        cuts=0 if many else cuts,
        recoveries=round(work.recoveries) * places,
        coast=round(work.coast_readings) * modes,
        corners=corners,
    )


def _prism(
    body: Body, work: Work, modes: int, degrees: tuple[int, int], estimated: bool
) -> dict[str, int]:
    """Work of a three-dimensional sector; with a plane of symmetry two parts of half the size.

    An estimate of the error of its elements is one of the plane section.
    """
    assert body.axial is not None
    degree, load_degree = degrees
    of_profile = [round(part) * modes for part in _loads(work)]
    normal, tangential = (part * (load_degree + 1) for part in of_profile)
    factorisations = (2 if body.axial.symmetric else 1) + estimated
    found = _solved(factorisations, normal, tangential, growth=0)
    found["fe_solutions"] += sum(of_profile) * estimated
    return found | {"fe_unknowns": prism_unknowns(body, degree)}


def _loads(work: Work) -> tuple[float, float]:
    # friction and finite influence coefficients use the same loads along the flank
    return work.normal_loads, min(1.0, work.tangential_loads)


def _places(fillets: RootFillets | None) -> int:
    return 0 if fillets is None else int(fillets.points.arc_length_mm.size)


def _solved(
    factorisations: int,
    normal: int,
    tangential: int,
    *,
    growth: int,
    cuts: int = 0,
    recoveries: int = 0,
    coast: int = 0,
    corners: int = 0,
) -> dict[str, int]:
    """Counters of the finite elements."""
    return {
        "fe_factorisations": factorisations,
        "fe_solutions": normal + tangential + growth + cuts + recoveries + coast + corners,
        "unit_loads_normal": normal,
        "unit_loads_tangential": tangential,
        "fe_load_cases_growth": growth,
        "cut_columns": cuts,
        "stress_recoveries": recoveries,
        "coast_readings": coast,
        "corner_readings": corners,
    }


def _sweeps(scene: Scene, pair: BodyPair) -> dict[str, dict[str, int]]:
    """States of the sweep, and of later sweeps if a torque loads the pair."""
    lumped = pair.effects.lumped_contact
    loaded = sum(torque > 0 for torque in scene.torques_Nm)
    states = {"sweep": len(scene.torques_Nm)}
    if scene.accuracy.tangents and not lumped:
        states["tangent"] = len(SIDES) * loaded
    slices = {}
    if pair.slices is not None:
        slices["sweep"] = pair.slices.count * states["sweep"]
    if scene.accuracy.estimate:
        sweeps = n_sweeps(
            lumped=lumped,
            elements=bool(elements_estimated(pair)),
            variants=0 if pair.slices is None else SLICE_VARIANTS,
        )
        states["estimate"] = sweeps * loaded
        if pair.slices is not None:  # the last sweep has fewer
            count = (sweeps - 1) * pair.slices.count + pair.slices.coarser().count
            slices["estimate"] = count * loaded
    none: dict[str, int] = {}
    if lumped:
        none |= {"contact_passes": 0, "influence_columns": 0}
    if lumped or not pair.effects.friction:
        none |= {"influence_columns_tangential": 0}
    if pair.adaptive:
        return dict.fromkeys(states, none)
    positions = pair.position_rad.size
    return {
        stage: none
        | {"states": count * positions}
        | ({"slices": slices[stage] * positions} if stage in slices else {})
        for stage, count in states.items()
    }
