"""Optimisation of a scene: search from all starts, rounding, comparison at the scene's settings."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from flankload.scene import Scene, SceneLike, scene_of
from flankload.scene.form import read_table
from flankload.scene.refusal import refuse, shown
from flankload.studies.optimisation.evaluation import Evaluator
from flankload.studies.optimisation.optimum import Limit, OptimisedVariable, Optimum
from flankload.studies.optimisation.problem import (
    Constraint,
    Objective,
    Options,
    Variable,
    changes_of,
    read_list,
    value_at,
    variables_of,
)
from flankload.studies.optimisation.search import Descent, best_of, descend, gradient_norm, rounded
from flankload.studies.settings import settings_for

if TYPE_CHECKING:
    from flankload.base.arrays import Floats
    from flankload.mechanisms.stage_clock import Progress
    from flankload.result import Result
    from flankload.studies.optimisation.local_model import Point


def optimise(
    scene: SceneLike,
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
    scene : Scene, path or mapping
        As for `solve`.
    variables : sequence of mappings
        Each with `paths` (one or several, as for `Scene.replace`) and their `factors`, `lower`,
        `upper`, `start` (default: the value of the scene) and `step` (the value ends as a multiple
        of it).
    objective : str or mapping
        Name of a number in `Result.summary`; or `quantity` (one or several names) and `weights`,
        `over` ("worst" or "sum" of all torques) and `torque_weights`.
    constraints : sequence of mappings, optional
        Each with `quantity` and `at_most`, its limit at every torque. Estimates and tangents that
        no quantity needs are left out of the search, unless the scene has `accuracy.estimate` or
        `accuracy.tangents`.
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
    scene, asked = scene_of(scene), read_table(Options, options, "")
    of_scene = variables_of(variables)
    table = {"quantity": objective} if isinstance(objective, str) else objective
    goal = read_table(Objective, table, "objective")
    goal.check(len(scene.torques_Nm))
    limits = read_list(Constraint, constraints, "constraints")
    inside, settings = search_scene(scene, [*goal.names, *(one.quantity for one in limits)])
    starts = [v.start_in(scene, f"variables[{k}]") for k, v in enumerate(of_scene)]
    evaluator = Evaluator(inside, of_scene, goal, limits, asked, progress)
    return _optimum(scene, evaluator, _searched(evaluator, starts), settings)


def search_scene(scene: Scene, quantities: Sequence[str]) -> tuple[Scene, dict[str, Any]]:
    """The scene of the search for these quantities, and the keys by which it differs.

    Computations that the quantities do not need are left out; discretization and positions are
    fixed.

    Raises SceneError if the scene leaves the choice of its effects to the plan.
    """
    if scene.effects.choose is not None:
        expected = "no such key in an optimisation (name the effects)"
        refuse("effects.choose", expected, shown(scene.effects.choose), scene.file)
    settings: dict[str, Any] = {}
    if scene.names_tolerance:
        settings["accuracy.tolerance"] = None
    if scene.positions.adaptive:
        settings |= {"positions.adaptive": None, "positions.max_count": None}
    fixed = scene.replace(settings)
    lean = settings_for(fixed, quantities)
    return fixed.replace(lean), lean | settings


def hypercube(n_points: int, n_variables: int, seed: int) -> Floats:
    """(n_points, n_variables) Latin hypercube in the unit cube: one point in each layer."""
    generator = np.random.default_rng(seed)
    layers = generator.permuted(np.tile(np.arange(n_points), (n_variables, 1)), axis=1).T
    return np.asarray((layers + generator.random(layers.shape)) / n_points)


def _searched(evaluator: Evaluator, values: Sequence[float]) -> list[Descent | None]:
    """Ends of the searches from all starts; None where the first point has no solution."""
    start, options = evaluator.parts_of(values), evaluator.options
    first = evaluator.solve_surely(start)
    ends: list[Descent | None] = [descend(evaluator.solve, first, evaluator.goals, options)]
    for x in hypercube(options.starts - 1, start.size, options.seed):
        evaluator.start += 1
        point = evaluator.solve(x)
        found = None if point is None else descend(evaluator.solve, point, evaluator.goals, options)
        ends.append(found)
    return ends


def _optimum(
    scene: Scene, evaluator: Evaluator, ends: Sequence[Descent | None], settings: Mapping[str, Any]
) -> Optimum:
    """Choose the best end, round it, and compare it with the given scene."""
    searched = [end for end in ends if end is not None]
    goals = max((end.goals for end in searched), key=lambda goals: goals.penalty)
    optimum = best_of([end.point for end in searched], goals)
    assert optimum is not None
    end = next(end for end in searched if end.point is optimum)
    point, loss = optimum, None
    if any(variable.step is not None for variable in evaluator.variables):
        point = rounded(evaluator, optimum, goals) or optimum
        loss = goals.objective(point) - goals.objective(optimum)
    values = evaluator.values_of(point.x)
    best = scene.replace(changes_of(evaluator.variables, values))
    before, after = evaluator.results_of(scene), evaluator.results_of(best)
    return Optimum(
        scene=best,
        results=after,
        variables=tuple(_compared(scene, evaluator.variables, values)),
        objective_name=_name(evaluator.objective, len(after)),
        objective_before=evaluator.objective_of(before),
        objective=evaluator.objective_of(after),
        constraints=tuple(_limits(evaluator, point, before, after)),
        gradient_norm=gradient_norm(optimum, goals),
        reason=end.reason,
        rounding_loss=loss,
        settings=settings,
        states=evaluator.states,
        continued_states=evaluator.continued_states,
        ends=tuple(None if end is None else goals.objective(end.point) for end in ends),
        history=tuple(evaluator.history),
    )


def _compared(
    scene: Scene, variables: Sequence[Variable], values: Sequence[float]
) -> Iterator[OptimisedVariable]:
    """Variables before and after."""
    for v, value in zip(variables, values, strict=True):
        known = value_at(scene, v.keys[0])
        before = None if known is None else known / v.scales[0]
        yield OptimisedVariable(", ".join(v.keys), before, value, v.lower, v.upper, v.step)


def _name(objective: Objective, n_torques: int) -> str:
    """The objective in words."""
    weights = objective.weights or (1.0,) * len(objective.names)
    factors = ("" if weight == 1.0 else f"{weight:g} " for weight in weights)
    name = " + ".join(map("".join, zip(factors, objective.names, strict=True)))
    if n_torques == 1:
        return name
    over = "worst of" if objective.over == "worst" else "sum over"
    return f"{name}, {over} {n_torques}{' weighted' * bool(objective.torque_weights)} torques"


def _limits(
    evaluator: Evaluator, point: Point, before: Sequence[Result], after: Sequence[Result]
) -> Iterator[Limit]:
    """Constraints before and after."""
    constraints = evaluator.constraints
    figures = evaluator.figures[len(evaluator.objective.names) :]
    excess = evaluator.goals.excess(point).reshape(len(constraints), len(after))
    for constraint, figure, beyond in zip(constraints, figures, excess, strict=True):
        yield Limit(
            constraint.quantity,
            constraint.at_most,
            max(figure.value(result) for result in before),
            max(figure.value(result) for result in after),
            # within two margins of the limit
            active=bool(beyond.max() > -evaluator.options.tolerance),
        )
