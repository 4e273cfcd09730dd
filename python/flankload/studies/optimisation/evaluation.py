"""Solution of points: results and gradients at values of the variables, counted."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from flankload.errors import FlankloadError
from flankload.mechanisms import Parts
from flankload.studies.optimisation.figures import Figure, figure_of
from flankload.studies.optimisation.local_model import Goals, Maximum, Point
from flankload.studies.optimisation.problem import (
    Constraint,
    Objective,
    Options,
    Variable,
    changes_of,
)
from flankload.studies.prepared import solve_scene
from flankload.studies.sensitivity import Sensitivity, sensitivity

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from flankload.base.arrays import Floats
    from flankload.mechanisms.stage_clock import Progress
    from flankload.result import Result
    from flankload.scene import Scene


@dataclass(frozen=True)
class Evaluation:
    """One point of the search: values of the variables from a starting point, by its number.

    `objective` is None if the scene could not be solved; `excess` is the largest relative amount by
    which a limit is exceeded, 0 if all are kept.
    """

    start: int
    values: tuple[float, ...]
    objective: float | None
    excess: float = 0.0


@dataclass
class Evaluator:
    """Solves a scene at values of the variables.

    The tolerance of the options is the relative distance that is kept from the limits. `parts` are
    bodies and compliances of all points; `figures` are those of the objective, then of the
    constraints, known after the first point, like `goals`; `start` is the number of the starting
    point. `states` counts solved states (positions times torques), `continued_states` those that
    derivatives continue from known contacts.
    """

    scene: Scene
    variables: Sequence[Variable]
    objective: Objective
    constraints: Sequence[Constraint]
    options: Options
    progress: Progress | None = None
    parts: Parts = field(default_factory=Parts)
    figures: tuple[Figure, ...] = ()
    goals: Goals = field(init=False)
    history: list[Evaluation] = field(default_factory=list)
    states: int = 0
    continued_states: int = 0
    start: int = 0

    def __post_init__(self) -> None:
        self._lower = np.array([variable.lower for variable in self.variables])
        self._upper = np.array([variable.upper for variable in self.variables])

    def values_of(self, x: Floats) -> tuple[float, ...]:
        """Values of the variables at parts of their ranges."""
        values = self._lower + (self._upper - self._lower) * x
        return tuple(np.clip(values, self._lower, self._upper).tolist())

    def parts_of(self, values: Sequence[float]) -> Floats:
        """Parts of the ranges at values of the variables."""
        return np.asarray((np.array(values) - self._lower) / (self._upper - self._lower))

    def solve(self, x: Floats) -> Point | None:
        """Solve a point; None if it is impossible."""
        try:
            return self.solve_surely(x)
        except FlankloadError:
            self._add(Evaluation(self.start, self.values_of(x), None))
            return None

    def solve_surely(self, x: Floats) -> Point:
        """Solve a point; raises FlankloadError if it is impossible."""
        values = self.values_of(x)
        changes = changes_of(self.variables, values)
        found = sensitivity(
            self.scene.replace(changes), tuple(changes), self.parts, first_order=True
        )
        n = len(found.results)
        if not self.figures:
            names = [(name, "objective.quantity") for name in self.objective.names]
            limited = enumerate(self.constraints)
            names += [(one.quantity, f"constraints[{k}].quantity") for k, one in limited]
            self.figures = tuple(figure_of(name, found.results[0], key) for name, key in names)
            self.goals = self._goals_of(n)
        point = Point(x, tuple(self._maxima_of(found)), n * len(self.figures))
        if not self.history:
            self.goals = replace(self.goals, scale=abs(self.goals.objective(point)) or 1.0)
        self.states += sum(result.position_rad.size for result in found.results)
        self.states += int(found.cost["solved_states"])
        self.continued_states += int(found.cost["continued_states"])
        excess = float(self.goals.excess(point).max(initial=0.0))
        self._add(Evaluation(self.start, values, self.goals.objective(point), excess))
        return point

    def results_of(self, scene: Scene) -> tuple[Result, ...]:
        """Results of a similar scene at its own settings, one per torque."""
        return solve_scene(scene, None, self.parts).by_torque

    def objective_of(self, results: Sequence[Result]) -> float:
        """Objective of results, as their summaries have it."""
        n, k = len(self.objective.names), self.goals.n_objectives
        figures = [[figure.value(result) for result in results] for figure in self.figures[:n]]
        return float((self.goals.factors[:k, : n * len(results)] @ np.ravel(figures)).max())

    def _add(self, evaluation: Evaluation) -> None:
        self.history.append(evaluation)
        if self.progress is not None:
            most = self.options.starts * self.options.most_evaluations
            self.progress("optimise", min(len(self.history), most), most)

    def _maxima_of(self, found: Sensitivity) -> Iterator[Maximum]:
        """All maxima; figure f at torque t is added to row f n_torques + t."""
        n, paths = len(found.results), [v.scales for v in self.variables]
        # d path / d part of the range, a row for each variable
        chain = np.zeros((len(paths), sum(map(len, paths))))
        owner = np.repeat(np.arange(len(paths)), [len(scales) for scales in paths])
        chain[owner, np.arange(owner.size)] = np.concatenate(paths)
        chain *= (self._upper - self._lower)[:, None]
        for f, figure in enumerate(self.figures):
            for numbers in figure.maxima:
                derivative = found.derivative(numbers)
                for t, result in enumerate(found.results):
                    values = numbers(result).ravel()
                    gradients = (chain @ derivative[:, t].reshape(owner.size, -1)).T
                    known = np.isfinite(values)
                    if not (known.any() and np.isfinite(gradients[known]).all()):
                        raise FlankloadError(f"{figure.name} has no value or no derivative")
                    yield Maximum(f * n + t, values[known], gradients[known])

    def _goals_of(self, n_torques: int) -> Goals:
        """Objectives and limits as linear functions of the rows."""
        objective, n = self.objective, n_torques
        weights = np.ones(len(objective.names)) if objective.weights is None else objective.weights
        of_torques = np.ones(n) if objective.torque_weights is None else objective.torque_weights
        lines = np.kron(weights, np.diag(of_torques))
        if objective.over == "sum":
            lines = lines.sum(axis=0, keepdims=True)
        c = len(self.constraints) * n
        factors = np.zeros((len(lines) + c, lines.shape[1] + c))
        factors[: len(lines), : lines.shape[1]] = lines
        factors[len(lines) :, lines.shape[1] :] = np.eye(c)
        limits = np.repeat([float(constraint.at_most) for constraint in self.constraints], n)
        margin = self.options.tolerance
        return Goals(factors, len(lines), limits - margin * np.abs(limits), margin)
