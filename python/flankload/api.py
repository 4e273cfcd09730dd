"""The public functions of flankload."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any

from flankload.cost import Account
from flankload.mechanisms import Earlier, Parts, mechanism_of, run_once
from flankload.mechanisms import prepare as prepare_parts
from flankload.studies import sensitivity as derivatives
from flankload.studies.tolerance import solve_to_tolerance

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from flankload.mechanisms.duration import Duration
    from flankload.mechanisms.stage_clock import Kept, Progress
    from flankload.result import Result
    from flankload.scene import Scene
    from flankload.studies.optimisation import Optimum
    from flankload.studies.plan import Plan
    from flankload.studies.sensitivity import Sensitivity


def solve(
    scene: Scene,
    progress: Progress | None = None,
    *,
    plan: Plan | None = None,
    on_duration: Callable[[Duration], None] | None = None,
) -> Result | tuple[Result, ...]:
    """Load distribution of a scene at all its positions.

    Parameters
    ----------
    scene : Scene
        From `read_scene` or `Scene.from_dict`.
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
    Result, or a tuple of Results where the scene has a list of torques

    Raises
    ------
    SceneError
        If the scene asks for something impossible; `PremiseError` if it breaks a premise of the
        model.
    FlankloadError
        If a position has no answer, or the plan is one of another scene.
    """
    return _solve(scene, progress, None, plan=plan, on_duration=on_duration)


class Prepared:
    """A scene with its bodies and compliances, for similar scenes; from `prepare`.

    Attributes
    ----------
    scene : Scene
    """

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        self._parts = Parts()
        if not scene.steers and scene.effects.choose is None:
            prepare_parts(scene, self._parts)

    def solve(
        self, changes: Mapping[str, Any] | None = None, progress: Progress | None = None
    ) -> Result | tuple[Result, ...]:
        """Load distribution of the scene with other values of some keys.

        Bodies and compliances are reused if all that they follow from has the same bits; new ones
        are kept for later calls, up to 64. The result has the same bits as
        `solve(scene.replace(changes))`, but for its cost: a compliance that is reused costs
        nothing, and its stage is missing. Belts and chains are solved anew, and so are scenes with
        `accuracy.tolerance`, whose discretization depends on what elements cost.

        Parameters
        ----------
        changes : mapping of str to object, optional
            As of `Scene.replace`.
        progress : callable, optional
            As of `solve`.

        Returns
        -------
        Result, or a tuple of Results where the scene has a list of torques

        Raises
        ------
        SceneError, FlankloadError
            As `Scene.replace` and `solve`.
        """
        scene = self.scene if not changes else self.scene.replace(changes)
        return _solve(scene, progress, self._parts)


def prepare(scene: Scene) -> Prepared:
    """Solve what most changes of a scene leave as it is: its bodies and their compliances.

    Parameters
    ----------
    scene : Scene
        With `effects.choose` the first run prepares, since it finds the effects.

    Returns
    -------
    Prepared

    Raises
    ------
    SceneError
        If the scene is impossible.
    """
    return Prepared(scene)


def sensitivity(scene: Scene | Prepared, paths: Sequence[str]) -> Sensitivity:
    """Derivatives of all results of a scene with respect to some of its keys.

    They are exact for the pairs in contact of each state: central differences over a step so small
    that its square is 1e-8, between systems of the same pairs on cells that follow the contact. No
    contact problem is solved again.

    Parameters
    ----------
    scene : Scene or Prepared
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
        return derivatives.sensitivity(scene.scene, paths, scene._parts)
    return derivatives.sensitivity(scene, paths)


def optimise(
    scene: Scene,
    variables: Sequence[Mapping[str, Any]],
    objective: str | Mapping[str, Any],
    constraints: Sequence[Mapping[str, Any]] = (),
    *,
    progress: Progress | None = None,
    **options: Any,
) -> Optimum:
    """Values of some keys of a scene for which a key figure is as small as possible.

    Parameters
    ----------
    scene : Scene
    variables : sequence of mappings
        Each with `paths` (one or several, as of `Scene.replace`) and their `factors`, `lower`,
        `upper`, `start` (default: the value of the scene) and `step` (the value ends as a multiple
        of it).
    objective : str or mapping
        Name of a number in `Result.summary`; or `quantity` (one or several names) and `weights`,
        `over` ("worst" or "sum" of all torques) and `torque_weights`.
    constraints : sequence of mappings, optional
        Each with `quantity` and `at_most`, its limit at every torque.
    progress : callable, optional
        Called as progress("optimise", done, total).
    **options
        `starts` (number of starting points, default 1), `seed` of the random ones (0), `tolerance`
        (relative decrease of the objective at which a search ends, 1e-3), `most_evaluations` of
        each start (50).

    Returns
    -------
    Optimum

    Raises
    ------
    SceneError
        If a table or the scene is impossible.
    FlankloadError
        If the first point has no solution. Later points without a solution are refused as steps,
        and counted.

    Examples
    --------
    >>> relief = {"paths": "body_1.tip_relief_um", "lower": 0, "upper": 80, "step": 1}
    >>> fl.optimise(scene, [relief], "transmission_error_peak_to_peak_um")
    """
    from flankload.studies.optimisation import optimise as search

    tables = {"variables": variables, "objective": objective, "constraints": constraints}
    return search(scene, tables, options, progress, prepare=prepare, sensitivity=sensitivity)


def _solve(
    scene: Scene,
    progress: Progress | None,
    parts: Parts | None,
    *,
    plan: Plan | None = None,
    on_duration: Callable[[Duration], None] | None = None,
) -> Result | tuple[Result, ...]:
    """Solve a scene, to its tolerance if it names one."""
    if not scene.steers:
        return _solve_chosen(scene, {}, progress, parts, (plan, on_duration))
    firsts = iter([(plan, on_duration)])  # they concern the first run

    def solve_once(
        scene: Scene, kept: Kept, progress: Progress | None
    ) -> Result | tuple[Result, ...]:
        return _solve_chosen(scene, kept, progress, None, next(firsts, (None, None)))

    return solve_to_tolerance(scene, solve_once, progress)


def _solve_chosen(
    scene: Scene,
    kept: Kept,
    progress: Progress | None,
    parts: Parts | None,
    first: tuple[Plan | None, Callable[[Duration], None] | None],
) -> Result | tuple[Result, ...]:
    """Solve a scene once; the effects that it leaves to the plan are chosen before."""
    plan, on_duration = first
    stages: dict[str, Account] = {}
    notes: tuple[str, ...] = ()
    if scene.effects.choose is not None:
        from flankload.studies.plan.choice import choose_effects, said_of

        if progress is not None:
            progress("plan", 0, 1)
        with stages.setdefault("plan", Account()):
            scene, choice = choose_effects(scene)
        notes = (said_of(choice, scene.accuracy.tolerance),) if choice else ()
    return run_once(
        scene,
        kept,
        progress,
        plan=None if plan is None else plan.predicted["stages"],
        on_assembly=None if on_duration is None else partial(_report_duration, scene, on_duration),
        earlier=Earlier(stages, notes, parts),
    )


def _report_duration(scene: Scene, on_duration: Callable[[Duration], None], assembly: Any) -> None:
    duration = mechanism_of(scene).duration(scene, assembly)
    if duration is not None:
        on_duration(duration)
