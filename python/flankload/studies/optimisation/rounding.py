"""Rounding of an optimum to steps of the machine."""

from __future__ import annotations

from itertools import product
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from flankload.studies.optimisation.evaluation import Evaluator
    from flankload.studies.optimisation.model import Goals, Point

#: Largest number of neighbours that are solved, and of variables with a step.
MOST_SOLVED, MOST_STEPPED = 16, 12


def rounded(evaluator: Evaluator, point: Point, goals: Goals) -> Point | None:
    """Find the best neighbour of a point on the steps of the variables.

    The neighbours have the next multiples below and above in all combinations. The linear model
    puts them in order, and the first ones are solved.

    Parameters
    ----------
    evaluator : Evaluator
    point : Point
    goals : Goals

    Returns
    -------
    Point or None
        Without a violated limit if there is one; None if no neighbour can be solved.
    """
    values = evaluator.values_of(point.x)
    choices = [
        (value,) if variable.step is None else variable.neighbours(value)
        for variable, value in zip(evaluator.variables, values, strict=True)
    ]
    places = [evaluator.parts_of(values) for values in product(*choices)]
    places.sort(key=lambda x: goals.merit(point, x - point.x))
    solved = [evaluator.solve(x) for x in places[:MOST_SOLVED]]
    return best_of([neighbour for neighbour in solved if neighbour is not None], goals)


def best_of(points: list[Point], goals: Goals) -> Point | None:
    """The point of the least merit, among those that keep all limits if there are any."""
    if not points:
        return None
    kept = [point for point in points if not np.any(goals.excess(point) > 0.0)]
    return min(kept or points, key=goals.merit)
