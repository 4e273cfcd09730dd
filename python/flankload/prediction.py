"""Work of a run that can be counted before it is done: from bodies, positions and effects alone.

What each effect adds stands in the table of effects, in units of a body, of a load on a flank, of a
place in a fillet, of a state; how many of these there are, in the meshes and positions. Nothing is
solved, so that every run can have it.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from flankload.bodies.body import WholeMesh
from flankload.effects import work_in
from flankload.elasticity import MANY_KEPT
from flankload.estimate import N_SWEEPS, N_SWEEPS_LUMPED
from flankload.stages import modes_of
from flankload.tangent import SIDES

if TYPE_CHECKING:
    from flankload.assembly import BodyPair
    from flankload.bodies import Body
    from flankload.effects import Work
    from flankload.root_fillet import RootFillets
    from flankload.scene import Scene


def predicted_work(scene: Scene, pair: BodyPair) -> dict[str, dict[str, int]]:
    """Count what a run will do.

    Parameters
    ----------
    scene : Scene
    pair : BodyPair
        Its bodies, before the run has added positions.

    Returns
    -------
    dict of str to dict of str to int
        By stages, as `result.cost["stages"]` names them, then by counters: those that are known,
        zeros included. Exact, but for two things that nearly never happen: a state that found no
        room is solved again, and cuts whose factors need other pivots are solved for one by one.
        Of adaptive positions it is not known how many they will be.
    """
    stages = {"bodies": {"states": _standing_states(pair)}}
    for z, body in enumerate((pair.body_1, pair.body_2)):
        grows = pair.growth[z]
        growth = 0 if grows is None else grows.load_cases
        elastic = (pair.effects.elastic_body_1, pair.effects.elastic_body_2)[z]
        if elastic or growth:
            stage = f"compliance body {z + 1}"
            work = work_in(stage, pair.effects)
            if not elastic:  # its elements are there to grow
                work = replace(work, factorisations=1, normal_loads=1)
            modes = modes_of(body, scene, pair.resolution)
            found = _elements(body, work, modes, pair.fillets[z], growth)
            if pair.effects.single_tooth and "cut_columns" in found:
                found["fe_solutions"] -= found["cut_columns"]
                found["cut_columns"] = 0
            stages[stage] = found
    return stages | _sweeps(scene, pair)


def _standing_states(pair: BodyPair) -> int:
    """Bodies that stand by their files are looked at once without load."""
    return 0 if pair.body_1.flank_angle_known and pair.body_2.flank_angle_known else 1


def _elements(
    body: Body, work: Work, modes: int, fillets: RootFillets | None, growth: int
) -> dict[str, int]:
    """Work of the elements of a body; none where it brings its compliance along."""
    mesh = body.mesh
    flanks, cuts, places = 0, 0, 0
    if isinstance(mesh, WholeMesh):  # read where its loads are solved for: no recoveries
        flanks = len(mesh.flanks)
    elif mesh is not None:
        flanks, cuts = 1, 2 * (len(mesh.left_nodes) + len(mesh.right_nodes))
        places = 0 if fillets is None else int(fillets.points.arc_length_mm.size)
    many = cuts > MANY_KEPT
    solved_for = {
        "unit_loads_normal": round(work.normal_loads) * modes * flanks,
        "unit_loads_tangential": min(1, round(work.tangential_loads)) * modes * flanks,
        "coast_readings": round(work.coast_readings) * modes * flanks,
        "cut_columns": 0 if many else cuts,
        "stress_recoveries": round(work.recoveries) * places,
        "fe_load_cases_growth": 0 if mesh is None else growth,
    }
    return {
        "fe_factorisations": 0 if mesh is None else round(work.factorisations) + many,
        "fe_solutions": sum(solved_for.values()),
        **solved_for,
    }


def _sweeps(scene: Scene, pair: BodyPair) -> dict[str, dict[str, int]]:
    """States of the sweep, and of those that follow it where a torque loads the pair."""
    lumped = pair.effects.lumped_contact
    loaded = sum(torque > 0 for torque in scene.torques_Nm)
    torques = {"sweep": len(scene.torques_Nm)}
    if not lumped:
        torques["tangent"] = len(SIDES) * loaded
    if scene.accuracy.estimate:
        torques["estimate"] = (N_SWEEPS_LUMPED if lumped else N_SWEEPS) * loaded
    positions = {} if pair.adaptive else {"states": pair.position_rad.size}
    none: dict[str, int] = {}
    if lumped:
        none |= {"contact_passes": 0, "influence_columns": 0}
    if lumped or not pair.effects.friction:
        none |= {"influence_columns_tangential": 0}
    return {
        stage: none | {name: count * number for name, number in positions.items()}
        for stage, count in torques.items()
    }
