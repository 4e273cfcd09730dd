"""Search from one starting point by steps of a linear model, and rounding of its end."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import product
from typing import TYPE_CHECKING

import numpy as np

from flankload.studies.optimisation.local_model import Goals, Point, best_step

if TYPE_CHECKING:
    from collections.abc import Callable

    from flankload.base.arrays import Floats
    from flankload.studies.optimisation.evaluation import Evaluator
    from flankload.studies.optimisation.problem import Options

#: First trust radius, as a part of the ranges.
FIRST_RADIUS = 0.25
#: Parts of the predicted decrease: a step with less is refused, the radius is halved below the
#: second and doubled above the third one.
REFUSED, POOR, GOOD = 0.01, 0.25, 0.75
#: Factor of the penalty if a search ends beyond a limit, and its largest value.
MORE_PENALTY, MOST_PENALTY = 10.0, 1e4
#: Radius of the first-order measure.
MEASURED = 0.01

#: Largest number of neighbours that are solved.
MOST_SOLVED = 16
#: Largest adjustment of the other variables, as a part of their ranges.
ADJUSTED = 0.1

CONVERGED = "the model predicts no further decrease"
SHORT = "short steps bring no further decrease"
USED_UP = "the evaluations are used up"


@dataclass(frozen=True)
class Descent:
    """End of a search: the best point, the goals with the last penalty, the reason."""

    point: Point
    goals: Goals
    reason: str


def descend(
    solve: Callable[[Floats], Point | None], first: Point, goals: Goals, options: Options
) -> Descent:
    """Minimise the merit from a point on; `solve` gives None where a scene cannot be solved.

    Steps minimise the first-order model of all maxima within a trust radius; the radius follows
    from the ratio of actual and predicted decrease (A. R. Conn, N. I. M. Gould, P. L. Toint,
    Trust-Region Methods, 2000, section 11.2: minimisation of composite functions).
    """
    best, radius, left = first, FIRST_RADIUS, options.most_evaluations - 1
    while True:
        step = best_step(best, goals, *best.within(radius))
        predicted = goals.merit(best) - goals.merit(best, step)
        enough = options.tolerance * max(
            abs(goals.objective(best)) / goals.scale, options.tolerance
        )
        if predicted <= enough or radius < options.tolerance:
            if goals.keeps_limits(best) or goals.penalty >= MOST_PENALTY:
                flat = gradient_norm(best, goals) * MEASURED <= enough * goals.scale
                return Descent(best, goals, CONVERGED if flat else SHORT)
            goals, radius = replace(goals, penalty=MORE_PENALTY * goals.penalty), FIRST_RADIUS
            continue
        if left == 0:
            return Descent(best, goals, USED_UP)
        left -= 1
        trial = solve(best.x + step)
        ratio = -1.0 if trial is None else (goals.merit(best) - goals.merit(trial)) / predicted
        if ratio < POOR:
            radius = 0.5 * float(np.abs(step).max())
        elif ratio > GOOD:
            radius = min(1.0, max(radius, 2.0 * float(np.abs(step).max())))
        if trial is not None and ratio > REFUSED:
            best = trial


def gradient_norm(point: Point, goals: Goals) -> float:
    """1-norm of the projected gradient of the Lagrangian, per range of the variables.

    Computed as the decrease of the model within a small radius, divided by the radius, which is
    the same by duality; in the unit of the objective.
    """
    step = best_step(point, goals, *point.within(MEASURED))
    return goals.scale * (goals.merit(point) - goals.merit(point, step)) / MEASURED


def rounded(evaluator: Evaluator, point: Point, goals: Goals) -> Point | None:
    """Find the best neighbour of a point on the steps of the variables.

    The neighbours have the next multiples below and above in all combinations. The linear model
    adjusts the variables without a step and puts the neighbours in order; the first ones are
    solved. None if no neighbour can be solved.
    """
    values = evaluator.values_of(point.x)
    free = np.array([variable.step is None for variable in evaluator.variables])
    low, high = point.within(ADJUSTED)
    choices = [
        (value,) if variable.step is None else variable.neighbours(value)
        for variable, value in zip(evaluator.variables, values, strict=True)
    ]
    steps = []
    for combination in product(*choices):
        step = evaluator.parts_of(combination) - point.x
        steps.append(best_step(point, goals, np.where(free, low, step), np.where(free, high, step)))
    steps.sort(key=lambda step: goals.merit(point, step))
    solved = [evaluator.solve(point.x + step) for step in steps[:MOST_SOLVED]]
    return best_of([neighbour for neighbour in solved if neighbour is not None], goals)


def best_of(points: list[Point], goals: Goals) -> Point | None:
    """The point of the least merit, among those that keep all limits if there are any."""
    if not points:
        return None
    kept = list(filter(goals.keeps_limits, points))
    return min(kept or points, key=goals.objective if kept else goals.merit)
