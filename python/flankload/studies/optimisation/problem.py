"""Variables, objective and constraints of an optimisation, as read from tables."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Annotated, Literal, TypeVar

from msgspec import Meta

from flankload.base.rounding import TIE, round_down, round_up
from flankload.errors import SceneError
from flankload.scene.form import read_table
from flankload.scene.refusal import refuse, shown
from flankload.scene.table import Table, Text
from flankload.scene.tree import number_at

if TYPE_CHECKING:
    from flankload.scene import Scene

Positive = Annotated[float, Meta(gt=0)]
Texts = Text | Annotated[tuple[Text, ...], Meta(min_length=1)]
Weights = Annotated[tuple[Positive, ...], Meta(min_length=1)]
T = TypeVar("T", bound=Table)
#: Largest number of variables with a step: their neighbours are listed in all combinations.
MOST_STEPPED = 8


class Variable(Table, frozen=True, kw_only=True):
    """One or several keys of a scene that follow one number.

    Its `paths` are as in `Scene.replace`; `factors` are the value of each key divided by the
    number, 1 by default; `start` is by default that of the first key of the scene; the number ends
    as a multiple of `step`.
    """

    paths: Texts
    factors: Annotated[tuple[float, ...], Meta(min_length=1)] | None = None
    lower: float
    upper: float
    start: float | None = None
    step: Positive | None = None

    @property
    def keys(self) -> tuple[str, ...]:
        """Paths of all keys."""
        return (self.paths,) if isinstance(self.paths, str) else self.paths

    @property
    def scales(self) -> tuple[float, ...]:
        """Factor of each key."""
        return self.factors or (1.0,) * len(self.keys)

    def check(self, key: str) -> None:
        """Refuse contradicting keys."""
        if len(self.scales) != len(self.keys):
            refuse(f"{key}.factors", f"{len(self.keys)} numbers, one per path", self.factors)
        if 0.0 in self.scales:
            refuse(f"{key}.factors", "numbers other than 0", self.factors)
        if not self.lower < self.upper:
            refuse(f"{key}.upper", f"a number above lower = {self.lower:g}", self.upper)
        if self.step is not None and not self.neighbours(self.lower):
            refuse(f"{key}.step", "a multiple of it between lower and upper", self.step)

    def neighbours(self, value: float) -> tuple[float, ...]:
        """Next multiples of the step within the bounds: below and above, or the value itself."""
        assert self.step is not None
        whole = {round_down(value / self.step), round_up(value / self.step)}
        # Twelve digits: 0.3 rather than 3 * 0.1
        found = (float(f"{self.step * k:.12g}") for k in sorted(whole))
        slack = TIE * self.step
        return tuple(x for x in found if self.lower - slack <= x <= self.upper + slack)

    def start_in(self, scene: Scene, key: str) -> float:
        """Number at which the search begins; refused outside the bounds."""
        value, start, found = value_at(scene, self.keys[0]), self.start, str(self.start)
        if start is None and value is not None:
            start, found = value / self.scales[0], f"{value}, the value of the scene"
        if start is None:
            found = "nothing, and the scene has no value"
        if start is None or not self.lower <= start <= self.upper:
            refuse(f"{key}.start", f"a number from {self.lower:g} to {self.upper:g}", found)
        return start


class Objective(Table, frozen=True, kw_only=True):
    """The number that is minimised: a key figure, or several that are added with weights.

    `over` says whether the largest of all torques counts, or their sum with `torque_weights`.
    """

    quantity: Texts
    weights: Weights | None = None
    over: Literal["worst", "sum"] = "worst"
    torque_weights: Weights | None = None

    @property
    def names(self) -> tuple[str, ...]:
        """All key figures."""
        return (self.quantity,) if isinstance(self.quantity, str) else self.quantity

    def check(self, n_torques: int) -> None:
        """Refuse lists of wrong lengths."""
        for key, given, count in (
            ("weights", self.weights, len(self.names)),
            ("torque_weights", self.torque_weights, n_torques),
        ):
            if given is not None and len(given) != count:
                refuse(f"objective.{key}", f"a list of {count} numbers", given)


class Constraint(Table, frozen=True, kw_only=True):
    """Limit of a key figure at every torque."""

    quantity: Text
    at_most: float


class Options(Table, frozen=True, kw_only=True):
    """How the optimum is searched for.

    The first of the `starts` is the given point, the others are a Latin hypercube within the
    bounds, by the seed. A search ends if the predicted decrease of the objective is a smaller part
    of it than the tolerance, if the steps are a smaller part of the ranges, or after
    `most_evaluations`.
    """

    starts: Annotated[int, Meta(ge=1, le=1000)] = 1
    seed: Annotated[int, Meta(ge=0)] = 0
    tolerance: Annotated[float, Meta(ge=1e-8, le=0.1)] = 1e-3
    most_evaluations: Annotated[int, Meta(ge=2, le=100000)] = 50


class OptimisationFile(Options, frozen=True, kw_only=True):
    """Keys of a file of the command; its tables are read by themselves."""

    scene: Text
    variables: tuple[str, ...] = ()
    objective: str = ""
    constraints: tuple[str, ...] = ()


def read_list(form: type[T], tables: object, key: str) -> tuple[T, ...]:
    """Read a list of tables."""
    if isinstance(tables, str | Mapping) or not isinstance(tables, Sequence):
        refuse(key, "a list of tables", shown(tables))
    return tuple(read_table(form, table, f"{key}[{k}]") for k, table in enumerate(tables))


def variables_of(tables: object) -> tuple[Variable, ...]:
    """Read and check the variables."""
    variables = read_list(Variable, tables, "variables")
    if not variables:
        refuse("variables", "at least one table", None)
    if sum(variable.step is not None for variable in variables) > MOST_STEPPED:
        refuse("variables", f"at most {MOST_STEPPED} variables with a step", "more")
    taken: set[str] = set()
    for k, variable in enumerate(variables):
        variable.check(f"variables[{k}]")
        for path in variable.keys:
            if path in taken:
                refuse(f"variables[{k}].paths", "paths that occur once", path)
            taken.add(path)
    return variables


def value_at(scene: Scene, path: str) -> float | None:
    """Number of a key, its default included; None if it has none."""
    try:
        return number_at(scene, path)
    except SceneError:
        return None


def changes_of(variables: Sequence[Variable], values: Sequence[float]) -> dict[str, float]:
    """Changes of the scene for numbers of the variables."""
    return {
        path: float(scale * value)
        for variable, value in zip(variables, values, strict=True)
        for path, scale in zip(variable.keys, variable.scales, strict=True)
    }
