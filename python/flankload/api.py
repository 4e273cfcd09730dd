"""The public functions of flankload."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flankload.base.arguments import require
from flankload.scene import scene_of
from flankload.studies import sensitivity as derivatives
from flankload.studies.prepared import Prepared, solve_scene

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from flankload.mechanisms.duration import Duration
    from flankload.mechanisms.stage_clock import Progress
    from flankload.result import Result
    from flankload.scene import SceneLike
    from flankload.studies.plan import Plan
    from flankload.studies.sensitivity import Sensitivity


def solve(
    scene: SceneLike,
    progress: Progress | None = None,
    *,
    plan: Plan | None = None,
    on_duration: Callable[[Duration], None] | None = None,
) -> Result:
    """Load distribution of a scene at all its positions.

    Parameters
    ----------
    scene : Scene, typed pair, path or mapping
        A scene, a `GearPair` or its like, the path of a scene file, or its keys as
        `Scene.from_dict` takes them.
    progress : callable, optional
        Called as progress(stage, done, total) when a stage begins, on the way through its
        positions, and at the end; done grows up to total. An exception that it raises ends the
        solution.
    plan : Plan, optional
        Of this scene: `result.cost` shows its predictions beside what is spent. Exact counters are
        shown in any case.
    on_duration : callable, optional
        Called once with the predicted duration of the run, before its elements are solved.

    Returns
    -------
    Result
        If the scene has a list of torques, its arrays have an axis of torques in front
        (`result.TorqueSeries`); `result.at(torque_Nm)` is the result of one of them.

    Raises
    ------
    InputError
        If an argument is of a wrong type.
    SceneError
        If the scene asks for something impossible; `PremiseError` if it breaks a premise of the
        model.
    FlankloadError
        If a position has no answer, or the plan is one of another scene.
    """
    _check_calls(progress=progress, on_duration=on_duration)
    require("plan", plan, "a Plan", fits=plan is None or hasattr(plan, "predicted"))
    return solve_scene(scene_of(scene), progress, None, plan=plan, on_duration=on_duration)


def prepare(scene: SceneLike) -> Prepared:
    """Solve bodies and compliances, which most changes of a scene do not affect.

    Parameters
    ----------
    scene : Scene, path or mapping
        As of `solve`. With `effects.choose` the first run prepares, since it finds the effects.

    Returns
    -------
    Prepared

    Raises
    ------
    SceneError
        If the scene is impossible.
    """
    return Prepared(scene_of(scene))


def sensitivity(scene: SceneLike | Prepared, paths: Sequence[str]) -> Sensitivity:
    """Derivatives of all results of a scene with respect to some of its keys.

    They are exact for the pairs in contact of each state: central differences over a step so small
    that its square is 1e-8, between systems of the same pairs on cells that follow the contact.
    Contact on cells is not solved again; lumped contact and slices, which have no cells, are solved
    again on both sides (`solved_states` of the cost).

    Parameters
    ----------
    scene : Scene, path, mapping or Prepared
        A prepared scene lends its bodies and compliances. `accuracy.tolerance` and
        `effects.choose` are refused, since derivatives need one discretization.
    paths : sequence of str
        Keys with numbers, by path as in `Scene.replace`: "body_1.tip_relief_um",
        "body_2.pitch_errors_um[3]", "pair.center_distance_mm". A key that reaches the elements of
        a body costs two solutions of these.

    Returns
    -------
    Sensitivity
        `derivative("transmission_error_peak_to_peak_um")`, and so on for each number of
        `Result.summary`, each array of `Result`, and each function of a Result.

    Raises
    ------
    SceneError, FlankloadError
        As `solve`; if a path leads to no number, or no scene beside its value is possible.
    """
    if isinstance(scene, Prepared):
        return derivatives.sensitivity(scene.scene, paths, scene.parts)
    return derivatives.sensitivity(scene_of(scene), paths)


def _check_calls(**calls: object) -> None:
    """Refuse what cannot be called, before anything is solved."""
    for name, call in calls.items():
        require(name, call, "a function", fits=call is None or callable(call))
