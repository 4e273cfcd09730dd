"""Solution of scenes: to a tolerance, with chosen effects, with parts of earlier runs."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

from msgspec import structs

from flankload.cost import Account
from flankload.errors import ContactError
from flankload.mechanisms import Earlier, Parts, run_once
from flankload.mechanisms import prepare as prepare_parts
from flankload.result import Result

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flankload.mechanisms.stage_clock import Kept, Progress
    from flankload.scene import Scene
    from flankload.studies.plan import Plan


class Prepared:
    """A scene with its bodies and compliances, its parts, for similar scenes; from `prepare`."""

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        self.parts = Parts(estimate=scene.accuracy.estimate)
        if not scene.names_tolerance and scene.effects.choose is None:
            prepare_parts(scene, self.parts)

    def __repr__(self) -> str:
        return f"Prepared\n{self.scene!r}"

    def solve(
        self, changes: Mapping[str, Any] | None = None, progress: Progress | None = None
    ) -> Result:
        """Load distribution of the scene with other values of some keys.

        Bodies and compliances are reused if all that they follow from has the same bits; new ones
        are kept for later calls, up to 64. The result has the same bits as
        `solve(scene.replace(changes))`, but for its cost: a compliance that is reused costs
        nothing, and its stage is missing. Belts and chains are solved anew, and so are scenes with
        `accuracy.tolerance`, whose runs reuse elements of each other only.

        Parameters
        ----------
        changes : mapping of str to object, optional
            As for `Scene.replace`, as are its errors.
        progress : callable, optional
            As for `solve`, as are its errors.

        Returns
        -------
        Result
        """
        scene = self.scene if not changes else self.scene.replace(changes)
        return solve_scene(scene, progress, self.parts)


def scene_of_one_run(scene: Scene) -> Scene:
    """The scene of one run: with chosen effects, and the first discretization of a tolerance."""
    if scene.names_tolerance:
        from flankload.studies.tolerance import first_scene

        scene = first_scene(scene)
    if scene.effects.choose is None:
        return scene
    from flankload.studies.plan.choice import choose_effects

    return choose_effects(scene)[0]


def solve_scene(
    scene: Scene,
    progress: Progress | None,
    parts: Parts | None,
    *,
    plan: Plan | None = None,
    unloaded: bool = True,
) -> Result:
    """Solve a scene, to its tolerance if it names one; errors are those of `flankload.solve`.

    Bodies and compliances of earlier runs are `parts`, and those of this run are added. `progress`
    is called as progress(stage, done, total); an exception that it raises ends the solution. `plan`
    is one of this scene, whose predictions are shown beside what is spent. Without `unloaded` the
    state without torque is not solved, from which deflections are measured. The result has an axis
    of torques if the scene has a list.
    """
    if not scene.names_tolerance:
        found = _solve_chosen(scene, {}, progress, parts, plan, unloaded=unloaded)
        return Result.of_torques(found) if scene.has_torque_list else found[0]
    from flankload.studies.tolerance import solve_to_tolerance

    firsts = iter([plan])  # it concerns the first run

    def solve_once(scene: Scene, kept: Kept, progress: Progress | None) -> tuple[Result, ...]:
        return _solve_chosen(scene, kept, progress, None, next(firsts, None))

    found = solve_to_tolerance(scene, solve_once, progress)
    return Result.of_torques(found) if scene.has_torque_list else found[0]


def _solve_chosen(
    scene: Scene,
    kept: Kept,
    progress: Progress | None,
    parts: Parts | None,
    plan: Plan | None,
    *,
    unloaded: bool = True,
) -> tuple[Result, ...]:
    """Solve a scene once; the effects that it leaves to the plan are chosen before.

    In slices, contacts that are short along the axis may have no state; cells are then used.
    """
    stages: dict[str, Account] = {}
    notes: tuple[str, ...] = ()
    if scene.effects.choose is not None:
        from flankload.studies.plan.choice import choose_effects, said_of

        if progress is not None:
            progress("plan", 0, 1)
        with stages.setdefault("plan", Account()):
            scene, choice = choose_effects(scene)
        notes = (said_of(choice, scene.accuracy.tolerance),) if choice else ()
    predicted = None if plan is None else plan.predicted["stages"]
    earlier = Earlier(stages, notes, parts, unloaded=unloaded)
    try:
        return run_once(scene, kept, progress, plan=predicted, earlier=earlier)
    except ContactError as error:
        cells = _with_cells(scene)
        if cells is None:
            raise
        notes = (*notes, f"{error}: solved with cells instead (effects.contact = 'pairs')")
    return run_once(cells, kept, progress, earlier=replace(earlier, notes=notes))


def _with_cells(scene: Scene) -> Scene | None:
    """The scene with cells, if its slices have lumped contacts without being asked for them."""
    if scene.effects.contact != "lumped" or "contact" in scene.named_effects:
        return None
    return replace(scene, effects=structs.replace(scene.effects, contact="pairs"))
