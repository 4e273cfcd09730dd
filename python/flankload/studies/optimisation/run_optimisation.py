"""Optimisation of a scene: search from all starts, rounding, comparison at the scene's settings."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from flankload.errors import SceneError
from flankload.scene.form import read_table
from flankload.scene.refusal import refuse
from flankload.studies.optimisation.descent import Descent, descend, gradient_norm
from flankload.studies.optimisation.evaluation import Evaluator
from flankload.studies.optimisation.optimum import Limit, OptimisedVariable, Optimum
from flankload.studies.optimisation.problem import (
    Constraint,
    Objective,
    Options,
    changes_of,
    read_tables_of,
    start_of,
    value_at,
    variables_of,
)
from flankload.studies.optimisation.rounding import MOST_STEPPED, best_of, rounded

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from flankload.mechanisms.stage_clock import Progress
    from flankload.result import Result
    from flankload.scene import Scene
    from flankload.studies.optimisation.model import Floats, Point
    from flankload.studies.optimisation.problem import Variable


@dataclass(frozen=True)
class Tools:
    """Public functions on which an optimisation is built."""

    solve: Callable[[Scene], Any]
    prepare: Callable[[Scene], Any]
    sensitivity: Callable[..., Any]


def optimise(
    scene: Scene,
    tables: Mapping[str, Any],
    tools: Tools,
    options: Mapping[str, Any],
    progress: Progress | None,
) -> Optimum:
    """Minimise an objective of a scene; see `flankload.optimise`.

    Parameters
    ----------
    scene : Scene
    tables : mapping
        "variables", "objective", "constraints".
    tools : Tools
    options : mapping
        Keys of `Options`.
    progress : callable or None

    Returns
    -------
    Optimum

    Raises
    ------
    SceneError, FlankloadError
    """
    asked = read_table(Options, options, "")
    variables = variables_of(tables["variables"])
    objective = tables["objective"]
    objective = {"quantity": objective} if isinstance(objective, str) else objective
    objective = read_table(Objective, objective, "objective")
    objective.check(len(scene.torques_Nm))
    constraints = read_tables_of(Constraint, tables["constraints"], "constraints", least=0)
    if sum(variable.step is not None for variable in variables) > MOST_STEPPED:
        refuse("variables", f"at most {MOST_STEPPED} variables with a step", "more")
    inside, settings = search_scene(scene)
    starts = [start_of(v, scene, f"variables[{k}]") for k, v in enumerate(variables)]
    most = asked.starts * asked.most_evaluations
    evaluator = Evaluator(
        tools.prepare(inside.replace(changes_of(variables, starts))),
        tools.sensitivity,
        variables,
        objective,
        constraints,
        margin=asked.tolerance,
        on_evaluation=lambda n: None if progress is None else progress("optimise", min(n, most), most),
    )
    ends = _searched(evaluator, evaluator.parts_of(starts), asked)
    return _optimum(scene, evaluator, ends, settings, tools)


def search_scene(scene: Scene) -> tuple[Scene, dict[str, Any]]:
    """The scene of the search, and the keys by which it differs.

    Error estimates and tangents are left out, elements do not follow the modifications, and the
    discretization and the positions are fixed.

    Raises
    ------
    SceneError
        If the scene leaves the choice of its effects to the plan.
    """
    if scene.effects.choose is not None:
        expected = "no such key in an optimisation (name the effects)"
        found = f"'{scene.effects.choose}'"
        raise SceneError(file=scene.file, key="effects.choose", expected=expected, found=found)
    settings: dict[str, Any] = {}
    for key, value in (("estimate", False), ("tangents", False), ("unmodified_elements", True)):
        if getattr(scene.accuracy, key) is not value:
            settings[f"accuracy.{key}"] = value
    if scene.steers:
        settings["accuracy.tolerance"] = None
    if scene.positions.adaptive:
        settings |= {"positions.adaptive": None, "positions.max_count": None}
    return scene.replace(settings), settings


def hypercube(n_points: int, n_variables: int, seed: int) -> Floats:
    """(n_points, n_variables) Latin hypercube in the unit cube: one point in each layer."""
    generator = np.random.default_rng(seed)
    layers = generator.permuted(np.tile(np.arange(n_points), (n_variables, 1)), axis=1).T
    return np.asarray((layers + generator.random(layers.shape)) / n_points)


def _searched(evaluator: Evaluator, start: Floats, options: Options) -> list[Descent | None]:
    """Ends of the searches from all starts; None where the first point has no solution."""
    first = evaluator.solve_surely(start)
    assert evaluator.goals is not None
    ends: list[Descent | None] = [descend(evaluator.solve, first, evaluator.goals, options)]
    for x in hypercube(options.starts - 1, start.size, options.seed):
        evaluator.start += 1
        point = evaluator.solve(x)
        search = None if point is None else descend(evaluator.solve, point, evaluator.goals, options)
        ends.append(search)
    return ends


def _optimum(
    scene: Scene,
    evaluator: Evaluator,
    ends: Sequence[Descent | None],
    settings: Mapping[str, Any],
    tools: Tools,
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
        loss = goals.objective(point) / goals.objective(optimum) - 1.0
    values = evaluator.values_of(point.x)
    best = scene.replace(changes_of(evaluator.variables, values))
    before, after = _results(tools.solve(scene)), _results(tools.solve(best))
    return Optimum(
        scene=best,
        results=after,
        variables=tuple(
            _variable(scene, *pair) for pair in zip(evaluator.variables, values, strict=True)
        ),
        objective_name=_name(evaluator.objective, len(after)),
        objective_before=evaluator.objective_of(before),
        objective=evaluator.objective_of(after),
        constraints=_limits(evaluator, point, before, after),
        gradient_norm=gradient_norm(optimum, goals),
        reason=end.reason,
        rounding_loss=loss,
        settings=settings,
        states=evaluator.states,
        ends=tuple(None if end is None else goals.objective(end.point) for end in ends),
        history=tuple(evaluator.history),
    )


def _results(found: Result | tuple[Result, ...]) -> tuple[Result, ...]:
    return found if isinstance(found, tuple) else (found,)


def _variable(scene: Scene, variable: Variable, value: float) -> OptimisedVariable:
    before = value_at(scene, variable.keys[0])
    before = None if before is None else before / variable.scales[0]
    return OptimisedVariable(
        variable.name, before, value, variable.lower, variable.upper, variable.step
    )


def _name(objective: Objective, n_torques: int) -> str:
    """The objective in words."""
    weights = objective.weights or (1.0,) * len(objective.names)
    parts = [
        name if weight == 1.0 else f"{weight:g} {name}"
        for name, weight in zip(objective.names, weights, strict=True)
    ]
    weighted = "weighted " if objective.torque_weights else ""
    over = {"worst": f", worst of {n_torques} {weighted}torques", "sum": f", {weighted}sum over {n_torques} torques"}
    return " + ".join(parts) + (over[objective.over] if n_torques > 1 else "")


def _limits(
    evaluator: Evaluator, point: Point, before: Sequence[Result], after: Sequence[Result]
) -> tuple[Limit, ...]:
    """Constraints before and after."""
    assert evaluator.goals is not None
    constraints = evaluator.constraints
    figures = evaluator.figures[len(evaluator.objective.names) :]
    excess = evaluator.goals.excess(point).reshape(len(constraints), len(after))
    return tuple(
        Limit(
            constraint.quantity,
            constraint.at_most,
            max(figure.value(result) for result in before),
            max(figure.value(result) for result in after),
            # within two margins of the limit
            active=bool(excess[c].max() > -evaluator.margin),
        )
        for c, (constraint, figure) in enumerate(zip(constraints, figures, strict=True))
    )
