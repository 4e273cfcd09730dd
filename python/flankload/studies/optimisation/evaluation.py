"""Solution of points: results and gradients at values of the variables, counted."""

from __future__ import annotations

from copy import copy
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from flankload.errors import FlankloadError
from flankload.studies.optimisation.figures import Figure, figure_of
from flankload.studies.optimisation.model import Goals, Maximum, Point
from flankload.studies.optimisation.problem import changes_of

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from flankload.result import Result
    from flankload.studies.optimisation.model import Floats
    from flankload.studies.optimisation.problem import Constraint, Objective, Variable


@dataclass(frozen=True)
class Evaluation:
    """One solved point of the search.

    Attributes
    ----------
    start : int
        Number of the starting point.
    values : tuple of float
        Of the variables.
    objective : float or None
        None if the scene could not be solved.
    excess : float
        Largest relative amount by which a limit is exceeded; 0 if all are kept.
    """

    start: int
    values: tuple[float, ...]
    objective: float | None
    excess: float = 0.0


class Evaluator:
    """Solves a scene at values of the variables.

    Parameters
    ----------
    prepared : Prepared
    sensitivity : callable
        As `flankload.sensitivity`.
    variables : sequence of Variable
    objective : Objective
    constraints : sequence of Constraint
    margin : float
        Relative distance that is kept from the limits.
    on_evaluation : callable
        Called with the number of evaluations.

    Attributes
    ----------
    figures : tuple of Figure
        Of the objective, then of the constraints; known after the first point, like `goals`.
    goals : Goals or None
    history : list of Evaluation
    states : int
        Solved states: positions times torques.
    start : int
        Number of the starting point.
    """

    def __init__(
        self,
        prepared: Any,
        sensitivity: Callable[..., Any],
        variables: Sequence[Variable],
        objective: Objective,
        constraints: Sequence[Constraint],
        *,
        margin: float,
        on_evaluation: Callable[[int], None],
    ) -> None:
        self._prepared, self._sensitivity = prepared, sensitivity
        self.variables, self.objective, self.constraints = variables, objective, constraints
        self.margin, self._on_evaluation = margin, on_evaluation
        self.lower = np.array([variable.lower for variable in variables])
        self.ranges = np.array([variable.upper for variable in variables]) - self.lower
        # factors of the paths of each variable
        self._chain = np.zeros((len(variables), sum(len(v.keys) for v in variables)))
        column = 0
        for row, variable in enumerate(variables):
            self._chain[row, column : column + len(variable.keys)] = variable.scales
            column += len(variable.keys)
        self.figures: tuple[Figure, ...] = ()
        self.goals: Goals | None = None
        self.history: list[Evaluation] = []
        self.states = 0
        self.start = 0

    def values_of(self, x: Floats) -> tuple[float, ...]:
        """Values of the variables at parts of their ranges, within the bounds."""
        upper = np.array([variable.upper for variable in self.variables])
        return tuple(np.clip(self.lower + self.ranges * x, self.lower, upper).tolist())

    def parts_of(self, values: Sequence[float]) -> Floats:
        """Parts of the ranges at values of the variables."""
        return np.asarray((np.array(values) - self.lower) / self.ranges)

    def solve(self, x: Floats) -> Point | None:
        """Solve a point; None if it is impossible."""
        try:
            return self.solve_surely(x)
        except FlankloadError:
            self._add(Evaluation(self.start, self.values_of(x), None))
            return None

    def solve_surely(self, x: Floats) -> Point:
        """Solve a point.

        Raises
        ------
        FlankloadError
            If it is impossible.
        """
        changes = changes_of(self.variables, self.values_of(x))
        prepared = copy(self._prepared)  # it holds the same parts
        prepared.scene = self._prepared.scene.replace(changes)
        found = self._sensitivity(prepared, tuple(changes))
        results: tuple[Result, ...] = found.results
        if not self.figures:
            self.figures = self._figures_of(results[0])
        point = Point(x, tuple(self._maxima(found)), len(self.figures) * len(results))
        if self.goals is None:
            goals = self._goals(len(results))
            self.goals = replace(goals, scale=abs(goals.objective(point)) or 1.0)
        self.states += sum(result.position_rad.size for result in results)
        excess = float(self.goals.excess(point).max(initial=0.0))
        self._add(Evaluation(self.start, self.values_of(x), self.goals.objective(point), excess))
        return point

    def objective_of(self, results: Sequence[Result]) -> float:
        """Objective of results, as their summaries have it."""
        n, objective = len(self.objective.names), self.objective
        weights = np.ones(n) if objective.weights is None else np.array(objective.weights)
        sums = [weights @ [figure.value(r) for figure in self.figures[:n]] for r in results]
        factors = objective.torque_weights or (1.0,) * len(sums)
        numbers = [factor * number for factor, number in zip(factors, sums, strict=True)]
        return float(max(numbers) if objective.over == "worst" else sum(numbers))

    def _add(self, evaluation: Evaluation) -> None:
        self.history.append(evaluation)
        self._on_evaluation(len(self.history))

    def _figures_of(self, result: Result) -> tuple[Figure, ...]:
        key = "objective.quantities" if self.objective.quantities else "objective.quantity"
        keys = [(name, key) for name in self.objective.names]
        keys += [(c.quantity, f"constraints[{k}].quantity") for k, c in enumerate(self.constraints)]
        return tuple(figure_of(name, result, key) for name, key in keys)

    def _maxima(self, found: Any) -> Any:
        """All maxima; figure f at torque t is added to row f n_torques + t."""
        for f, figure in enumerate(self.figures):
            for numbers in figure.maxima:
                slopes = self._chain @ np.moveaxis(found.derivative(numbers), 0, 1)
                for t, (result, slope) in enumerate(zip(found.results, slopes, strict=True)):
                    values = numbers(result)
                    gradients = (slope * self.ranges[:, None]).T
                    known = np.isfinite(values)
                    if not np.isfinite(gradients[known]).all():
                        raise FlankloadError(f"{figure.name} has no derivative")
                    row = f * len(found.results) + t
                    yield Maximum(row, 1.0, values[known], gradients[known])

    def _goals(self, n_torques: int) -> Goals:
        """Objectives and limits as linear functions of the rows."""
        objective, n = self.objective, n_torques
        weights = np.ones(len(objective.names)) if objective.weights is None else objective.weights
        of_torques = np.ones(n) if objective.torque_weights is None else objective.torque_weights
        by_torque = np.kron(weights, np.diag(of_torques))
        if objective.over == "sum":
            by_torque = by_torque.sum(axis=0, keepdims=True)
        c = len(self.constraints) * n
        factors = np.zeros((len(by_torque) + c, by_torque.shape[1] + c))
        factors[: len(by_torque), : by_torque.shape[1]] = by_torque
        factors[len(by_torque) :, by_torque.shape[1] :] = np.eye(c)
        limits = np.repeat([float(constraint.at_most) for constraint in self.constraints], n)
        limits -= self.margin * np.abs(limits)
        return Goals(factors, len(by_torque), limits)
