"""The public functions of flankload."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from flankload.base.arguments import require
from flankload.base.optional import optional
from flankload.mechanisms.registry import modes_of
from flankload.scene import scene_of
from flankload.studies.prepared import Prepared, solve_scene

if TYPE_CHECKING:
    from flankload.analysis.stage_modes import StageModes
    from flankload.explorer import Explorer
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
) -> Result:
    """Load distribution of a scene at all its positions.

    Parameters
    ----------
    scene : Scene, typed pair, path or mapping
        A scene, a typed pair such as `GearPair`, the path of a scene file, or its keys as for
        `Scene.from_dict`.
    progress : callable, optional
        Called as progress(stage, done, total) at the beginning of a stage, during its positions and
        at the end; done increases to total. An exception that it raises ends the solution.
    plan : Plan, optional
        Plan of this scene, whose predictions `result.cost` shows beside the actual cost. Exact
        counters are always shown.

    Returns
    -------
    Result
        For a list of torques, arrays have a first axis of torques, and
        `result.at(torque_Nm)` is the result of one torque.

    Raises
    ------
    InputError
        If an argument has a wrong type.
    SceneError
        If the scene is impossible; `PremiseError` if it violates a premise of the model.
    FlankloadError
        If a position has no solution, or the plan belongs to another scene.
    """
    _check_calls(progress=progress)
    require("plan", plan, "a Plan", fits=plan is None or hasattr(plan, "predicted"))
    return solve_scene(scene_of(scene), progress, None, plan=plan)


def explore(
    scene: SceneLike, vary: Sequence[str] = (), *, open_browser: bool = True, port: int = 0
) -> Explorer:
    """Open a page in the browser on which sliders change a scene while its results follow.

    Parameters
    ----------
    scene : Scene, typed pair, path or mapping
        As for `solve`.
    vary : sequence of str, optional
        Keys with sliders: paths, or PATH=LOW:HIGH with the range of the slider. By default those
        that designers of such a drive adjust.
    open_browser : bool
        Whether the page is opened; otherwise at `Explorer.url`, or as the value of a notebook cell.
    port : int
        0: any free port.

    Returns
    -------
    Explorer
        It runs until `close`, or to the end of a `with` block.

    Raises
    ------
    SceneError
        If the scene is impossible, or a path is not a numeric key of it.
    ImportError
        Without the package bokeh (pip install 'flankload[explore]').
    OSError
        If the port is taken.

    Examples
    --------
    >>> with fl.explore("pair.toml", vary=["body_1.tip_relief_um"]) as explorer:
    ...     explorer.change({"body_1.tip_relief_um": 25})
    """
    optional("bokeh.server.server", "flankload.explore", extra="explore")
    fits = isinstance(vary, Sequence) and not isinstance(vary, str)
    require("vary", vary, "a sequence of paths", fits=fits)
    from flankload.explorer import Explorer

    found = Explorer(scene_of(scene), tuple(vary), port)
    if open_browser:
        import webbrowser

        webbrowser.open(found.url)
    return found


def prepare(scene: SceneLike) -> Prepared:
    """Solve bodies and compliances, which most changes of a scene do not affect.

    Parameters
    ----------
    scene : Scene, path or mapping
        As for `solve`. With `effects.choose`, the first run prepares, since it chooses the effects.

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

    They are exact for the pairs in contact of each state: central differences with a step whose
    square is 1e-8, between systems of the same pairs on cells that follow the contact. Only lumped
    contact and slices, which have no cells, are solved again on both sides (`solved_states` of the
    cost).

    Parameters
    ----------
    scene : Scene, path, mapping or Prepared
        Bodies and compliances of a prepared scene are reused. `accuracy.tolerance` and
        `effects.choose` are refused, since derivatives require one discretization.
    paths : sequence of str
        Keys with numbers, by path as in `Scene.replace`: "body_1.tip_relief_um",
        "body_2.pitch_errors_um[3]", "pair.center_distance_mm". A key that changes the elements of a
        body costs two solutions of these.

    Returns
    -------
    Sensitivity
        `derivative("transmission_error_peak_to_peak_um")`, also for each number of
        `Result.summary`, each array of `Result` and each function of a Result.

    Raises
    ------
    SceneError, FlankloadError
        As `solve`; also if a path leads to no number, or if no close value of it is possible.
    """
    from flankload.studies import sensitivity as derivatives

    if isinstance(scene, Prepared):
        return derivatives.sensitivity(scene.scene, paths, scene.parts)
    return derivatives.sensitivity(scene_of(scene), paths)


def natural_modes(scene: SceneLike) -> tuple[StageModes, ...]:
    """Natural modes of a planetary stage about its states, one entry per torque.

    Bodies are rigid between the contacts, whose tangent stiffness is the mean over a tooth pitch
    with lumped contact, and the pins and supports of the scene. Masses and moments of inertia are
    those of the shapes, or `stage.sun_mass_kg` and its like. The carrier turns only if it has
    `stage.carrier_inertia_kg_m2`.

    Parameters
    ----------
    scene : Scene, PlanetaryStage, path or mapping
        As for `solve`.

    Returns
    -------
    tuple of StageModes

    Raises
    ------
    SceneError
        If the scene is impossible or no planetary stage, or a torque is 0.
    """
    return modes_of(scene_of(scene))


def _check_calls(**calls: object) -> None:
    """Refuse arguments that cannot be called."""
    for name, call in calls.items():
        require(name, call, "a function", fits=call is None or callable(call))
