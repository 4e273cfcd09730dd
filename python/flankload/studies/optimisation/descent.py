"""Descent from one starting point: steps of a linear model within a trust radius."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from flankload.studies.optimisation.model import best_step

if TYPE_CHECKING:
    from collections.abc import Callable

    from flankload.studies.optimisation.model import Floats, Goals, Point
    from flankload.studies.optimisation.problem import Options

#: Trust radii as parts of the ranges: at first, and at the end of a search.
FIRST_RADIUS, LEAST_RADIUS = 0.25, 1e-3
#: Parts of the predicted decrease: a step with less is refused, the radius is halved below the
#: second and doubled above the third one.
REFUSED, POOR, GOOD = 0.01, 0.25, 0.75
#: Factor of the penalty if a search ends beyond a limit, and its largest value.
MORE_PENALTY, MOST_PENALTY = 10.0, 1e4
#: Radius of the first-order measure.
MEASURED = 0.01

CONVERGED = "the model predicts no further decrease"
SHORT = "short steps bring no further decrease"
USED_UP = "the evaluations are used up"


@dataclass(frozen=True)
class Descent:
    """End of a search.

    Attributes
    ----------
    point : Point
        The best one.
    goals : Goals
        With the last penalty.
    reason : str
    """

    point: Point
    goals: Goals
    reason: str


def descend(
    solve: Callable[[Floats], Point | None], first: Point, goals: Goals, options: Options
) -> Descent:
    """Minimise the merit from a point on.

    Steps minimise the first-order model of all maxima within a trust radius; the radius follows
    from the ratio of actual and predicted decrease (A. R. Conn, N. I. M. Gould, P. L. Toint,
    Trust-Region Methods, 2000, section 11.2: minimisation of composite functions).

    Parameters
    ----------
    solve : callable
        Point at given variables; None if the scene cannot be solved there.
    first : Point
    goals : Goals
    options : Options

    Returns
    -------
    Descent
    """
    best, radius, left = first, FIRST_RADIUS, options.most_evaluations - 1
    while True:
        step = best_step(best, goals, radius)
        predicted = goals.merit(best) - goals.merit(best, step)
        enough = options.tolerance * max(abs(goals.objective(best)) / goals.scale, options.tolerance)
        if predicted <= enough or radius < LEAST_RADIUS:
            beyond = np.any(goals.excess(best) > options.tolerance)
            if not beyond or goals.penalty >= MOST_PENALTY:
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

    Parameters
    ----------
    point : Point
    goals : Goals

    Returns
    -------
    float
    """
    step = best_step(point, goals, MEASURED)
    return goals.scale * (goals.merit(point) - goals.merit(point, step)) / MEASURED
