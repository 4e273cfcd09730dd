"""The public functions of flankload."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any

from flankload.cost import Account
from flankload.mechanisms import mechanism_of, run_once
from flankload.studies.tolerance import solve_to_tolerance

if TYPE_CHECKING:
    from collections.abc import Callable

    from flankload.mechanisms.duration import Duration
    from flankload.mechanisms.stage_clock import Kept, Progress
    from flankload.result import Result
    from flankload.scene import Scene
    from flankload.studies.plan import Plan


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
    if not scene.steers:
        return _solve_chosen(scene, {}, progress, plan, on_duration)
    firsts = iter([(plan, on_duration)])  # they concern the first run

    def solve_once(
        scene: Scene, kept: Kept, progress: Progress | None
    ) -> Result | tuple[Result, ...]:
        return _solve_chosen(scene, kept, progress, *next(firsts, (None, None)))

    return solve_to_tolerance(scene, solve_once, progress)


def _solve_chosen(
    scene: Scene,
    kept: Kept,
    progress: Progress | None,
    plan: Plan | None,
    on_duration: Callable[[Duration], None] | None,
) -> Result | tuple[Result, ...]:
    """Solve a scene once; the effects that it leaves to the plan are chosen before."""
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
        stages=stages,
        notes=notes,
    )


def _report_duration(scene: Scene, on_duration: Callable[[Duration], None], assembly: Any) -> None:
    duration = mechanism_of(scene).duration(scene, assembly)
    if duration is not None:
        on_duration(duration)
