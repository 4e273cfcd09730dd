"""The result of an optimisation, and its text."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from flankload.base.text_table import NONE, text_table
from flankload.studies.settings import estimated_error

if TYPE_CHECKING:
    from flankload.result import Result
    from flankload.scene import Scene
    from flankload.studies.optimisation.evaluation import Evaluation


@dataclass(frozen=True)
class OptimisedVariable:
    """A variable before and after; `name` is the path of its key, or several.

    `before` is None if the key is absent in the scene.
    """

    name: str
    before: float | None
    after: float
    lower: float
    upper: float
    step: float | None


@dataclass(frozen=True)
class Limit:
    """A constraint before and after, each the largest of all torques.

    `active`: whether the limit is reached at the optimum, in the discretization of the search.
    """

    name: str
    at_most: float
    before: float
    after: float
    active: bool

    @property
    def state(self) -> str:
        """Whether the limit is exceeded or reached, in a word."""
        return "exceeded" if self.after > self.at_most else "active" * self.active


@dataclass(frozen=True, eq=False, repr=False)
class Optimum:
    """The best scene that was found.

    Attributes
    ----------
    scene : Scene
        The given one with the optimal values.
    results : tuple of Result
        Results of this scene, one per torque.
    variables : tuple of OptimisedVariable
    objective_name : str
    objective_before, objective : float
        Objectives of the given and of the optimal scene, both solved with their own settings.
    constraints : tuple of Limit
    gradient_norm : float
        1-norm of the projected gradient of the Lagrangian with respect to the variables as parts
        of their ranges, in the unit of the objective, before rounding.
    reason : str
        Why the search ended.
    rounding_loss : float or None
        Increase of the objective by rounding to steps; None without steps.
    settings : mapping
        Keys that were set during the search, and their values.
    states, continued_states : int
        Solved states of the search (positions times torques), those for derivatives included, and
        states that derivatives continue from known contacts.
    ends : tuple of (float or None)
        Objective at the end of each start; None if its first point could not be solved.
    history : tuple of Evaluation
        All points of the search in their order.
    """

    scene: Scene
    results: tuple[Result, ...]
    variables: tuple[OptimisedVariable, ...]
    objective_name: str
    objective_before: float
    objective: float
    constraints: tuple[Limit, ...]
    gradient_norm: float
    reason: str
    rounding_loss: float | None
    settings: Mapping[str, Any]
    states: int
    continued_states: int
    ends: tuple[float | None, ...]
    history: tuple[Evaluation, ...]

    @property
    def values(self) -> dict[str, float]:
        """Optimal values of the variables, by name."""
        return {variable.name: variable.after for variable in self.variables}

    @property
    def active(self) -> tuple[str, ...]:
        """Names of the constraints whose limits are reached."""
        return tuple(limit.name for limit in self.constraints if limit.active)

    @property
    def keeps_limits(self) -> bool:
        """Whether the optimal scene keeps all limits."""
        return all(limit.after <= limit.at_most for limit in self.constraints)

    @property
    def evaluations(self) -> int:
        """Number of points of the search."""
        return len(self.history)

    @property
    def failed(self) -> int:
        """Number of these that could not be solved."""
        return sum(evaluation.objective is None for evaluation in self.history)

    @property
    def estimated_errors(self) -> dict[str, float]:
        """Largest estimated relative error of each quantity at the optimum, over all torques."""
        found: dict[str, float] = {}
        limited = [limit.name for limit in self.constraints]
        for name in dict.fromkeys([*self.objective_name.replace(",", " ").split(), *limited]):
            errors = [estimated_error(result.estimate, name) for result in self.results]
            known = [error for error in errors if error is not None]
            if known:
                found[name] = max(known)
        return found

    def __repr__(self) -> str:
        change = f"{self.objective_before:.4g} -> {self.objective:.4g}"
        return f"Optimum({self.objective_name}: {change}, {self.evaluations} evaluations)"

    def __str__(self) -> str:
        return self.table()

    def table(self) -> str:
        """Return the optimum as text."""
        rows = [(v.name, v.before, v.after, v.lower, v.upper, v.step) for v in self.variables]
        blocks = [
            [
                f"{self.scene.name}: {self.objective_name}",
                f"before {self.objective_before:.4g}, after {self.objective:.4g}",
            ],
            _aligned(("variable", "before", "after", "lower", "upper", "step"), rows),
        ]
        if self.constraints:
            limits = [(c.name, c.before, c.after, c.at_most, c.state) for c in self.constraints]
            blocks.append(_aligned(("constraint", "before", "after", "at most", ""), limits))
        return "\n\n".join("\n".join(block) for block in [*blocks, self._lines()])

    def _lines(self) -> list[str]:
        """How the optimum was found."""
        count = f"{self.evaluations} evaluations"
        if self.failed:
            count += f", {self.failed} of them without a solution"
        percent = 100.0 / (abs(self.objective_before) or 1.0)
        end = f"gradient norm {percent * self.gradient_norm:.1f} % of the objective before"
        states = f"{self.states} solved states, {self.continued_states} continued for derivatives"
        lines = [f"{count}; {states}", f"end of the search: {self.reason}; {end}"]
        if len(self.ends) > 1:
            ends = sorted(end for end in self.ends if end is not None)
            numbers = ", ".join(f"{end:.4g}" for end in ends)
            lines.append(f"ends of the {len(self.ends)} starts: {numbers}")
        if self.rounding_loss is not None:
            loss = percent * self.rounding_loss
            lines.append(f"loss by rounding to steps: {loss:.2f} % of the objective before")
        if self.settings:
            words = {True: "true", False: "false", None: "absent"}
            named = (f"{key} = {words[value]}" for key, value in self.settings.items())
            lines.append(f"set during the search: {', '.join(named)}")
        if self.estimated_errors:
            errors = (
                f"{name} {100 * error:.1f} %" for name, error in self.estimated_errors.items()
            )
            lines.append(f"estimated errors of the optimum: {', '.join(errors)}")
        if not self.keeps_limits:
            lines.append("limits are exceeded")
        return lines


def _aligned(heading: Sequence[str], rows: Sequence[Sequence[str | float | None]]) -> list[str]:
    """A table of names, numbers and absent numbers."""
    cells = [
        [NONE if x is None else x if isinstance(x, str) else f"{x:.6g}" for x in row]
        for row in rows
    ]
    return text_table([heading, *cells], left=1)
