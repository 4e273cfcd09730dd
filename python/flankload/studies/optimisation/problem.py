"""Variables, objective and constraints of an optimisation, as read from tables."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Annotated, Any, Literal, TypeVar

import numpy as np
from msgspec import Meta

from flankload.scene.form import read_table
from flankload.scene.refusal import refuse, shown
from flankload.scene.table import Table, Text

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from flankload.scene import Scene

    Floats = NDArray[np.float64]

Positive = Annotated[float, Meta(gt=0)]
T = TypeVar("T", bound=Table)
#: Numbers closer than this part of a step are equal.
SAME = 1e-9


class Variable(Table, frozen=True, kw_only=True):
    """One or several keys of a scene that follow one number.

    Attributes
    ----------
    path, paths : str, tuple of str
        As in `Scene.replace`; one of both.
    factors : tuple of float or None
        Value of each key divided by the number; 1 by default.
    lower, upper : float
        Bounds of the number.
    start : float or None
        Default: that of the first key of the scene.
    step : float or None
        The number ends as a multiple of it.
    """

    path: Text | None = None
    paths: Annotated[tuple[Text, ...], Meta(min_length=1)] | None = None
    factors: Annotated[tuple[float, ...], Meta(min_length=1)] | None = None
    lower: float
    upper: float
    start: float | None = None
    step: Positive | None = None

    @property
    def keys(self) -> tuple[str, ...]:
        """Paths of all keys."""
        return self.paths or (self.path or "",)

    @property
    def name(self) -> str:
        """Paths in one line."""
        return ", ".join(self.keys)

    @property
    def scales(self) -> tuple[float, ...]:
        """Factor of each key."""
        return self.factors or (1.0,) * len(self.keys)

    def check(self, key: str) -> None:
        """Refuse contradicting keys.

        Raises
        ------
        SceneError
        """
        if (self.path is None) == (self.paths is None):
            refuse(f"{key}.path", "either path or paths", "both" if self.path else "nothing")
        if len(self.scales) != len(self.keys):
            refuse(f"{key}.factors", f"{len(self.keys)} numbers, one per path", len(self.scales))
        if 0.0 in self.scales:
            refuse(f"{key}.factors", "numbers other than 0", self.factors)
        if not self.lower < self.upper:
            refuse(f"{key}.upper", f"a number above lower = {self.lower:g}", self.upper)
        if self.start is not None and not self.lower <= self.start <= self.upper:
            refuse(f"{key}.start", f"a number from {self.lower:g} to {self.upper:g}", self.start)
        if self.step is not None and not self.neighbours(self.lower):
            refuse(f"{key}.step", "a multiple of it between lower and upper", self.step)

    def neighbours(self, value: float) -> tuple[float, ...]:
        """Next multiples of the step within the bounds: below, then above; one if it is one."""
        assert self.step is not None
        near = value / self.step
        whole = {np.floor(near + SAME), np.ceil(near - SAME)}
        # Twelve digits: 0.3 rather than 3 * 0.1
        found = (float(f"{self.step * k:.12g}") for k in sorted(whole))
        slack = SAME * self.step
        return tuple(x for x in found if self.lower - slack <= x <= self.upper + slack)


class Objective(Table, frozen=True, kw_only=True):
    """The number that is minimised.

    Attributes
    ----------
    quantity, quantities : str, tuple of str
        Key figure, or several that are added.
    weights : tuple of float or None
        Of the key figures.
    over : str
        "worst": the largest of all torques; "sum": their sum.
    torque_weights : tuple of float or None
    """

    quantity: Text | None = None
    quantities: Annotated[tuple[Text, ...], Meta(min_length=1)] | None = None
    weights: Annotated[tuple[Positive, ...], Meta(min_length=1)] | None = None
    over: Literal["worst", "sum"] = "worst"
    torque_weights: Annotated[tuple[Positive, ...], Meta(min_length=1)] | None = None

    @property
    def names(self) -> tuple[str, ...]:
        """All key figures."""
        return self.quantities or (self.quantity or "",)

    def check(self, n_torques: int) -> None:
        """Refuse contradicting keys.

        Raises
        ------
        SceneError
        """
        if (self.quantity is None) == (self.quantities is None):
            found = "both" if self.quantity else "nothing"
            refuse("objective.quantity", "either quantity or quantities", found)
        for key, given, count in (
            ("weights", self.weights, len(self.names)),
            ("torque_weights", self.torque_weights, n_torques),
        ):
            if given is not None and len(given) != count:
                refuse(f"objective.{key}", f"a list of {count} numbers", len(given))


class Constraint(Table, frozen=True, kw_only=True):
    """Limit of a key figure at every torque."""

    quantity: Text
    at_most: float


class Options(Table, frozen=True, kw_only=True):
    """How the optimum is searched for.

    Attributes
    ----------
    starts : int
        Number of starting points: the given one, then a Latin hypercube within the bounds.
    seed : int
        Of the hypercube.
    tolerance : float
        Relative decrease of the objective below which a search ends.
    most_evaluations : int
        For each start.
    """

    starts: Annotated[int, Meta(ge=1, le=1000)] = 1
    seed: Annotated[int, Meta(ge=0)] = 0
    tolerance: Annotated[float, Meta(ge=1e-8, le=0.1)] = 1e-3
    most_evaluations: Annotated[int, Meta(ge=2, le=100000)] = 50


class OptimisationFile(Options, frozen=True, kw_only=True):
    """Keys of a file of the command; the tables are read by themselves."""

    scene: Text
    variables: tuple[str, ...] = ()
    objective: str = ""
    constraints: tuple[str, ...] = ()


def read_tables_of(form: type[T], tables: object, key: str, *, least: int) -> tuple[T, ...]:
    """Read a list of tables.

    Raises
    ------
    SceneError
    """
    if isinstance(tables, str | Mapping) or not isinstance(tables, Sequence):
        refuse(key, "a list of tables", shown(tables))
    if len(tables) < least:
        refuse(key, "at least one table", "nothing")
    return tuple(read_table(form, table, f"{key}[{k}]") for k, table in enumerate(tables))


def variables_of(tables: object) -> tuple[Variable, ...]:
    """Read and check the variables.

    Raises
    ------
    SceneError
    """
    variables = read_tables_of(Variable, tables, "variables", least=1)
    taken: set[str] = set()
    for k, variable in enumerate(variables):
        variable.check(f"variables[{k}]")
        for path in variable.keys:
            if path in taken:
                refuse(f"variables[{k}].path", "paths that occur once", path)
            taken.add(path)
    return variables


def value_at(scene: Scene, path: str) -> float | None:
    """Number of a key, its default included; None if it has none."""
    found: Any = scene
    for part in re.findall(r"\w+", path):
        if part.isdigit():
            found = found[int(part)] if isinstance(found, tuple) and int(part) < len(found) else None
        else:
            found = getattr(found, part, None)
    is_number = isinstance(found, int | float) and not isinstance(found, bool)
    return float(found) if is_number else None


def start_of(variable: Variable, scene: Scene, key: str) -> float:
    """Number at which the search begins.

    Raises
    ------
    SceneError
        If the scene has none within the bounds.
    """
    if variable.start is not None:
        return variable.start
    value = value_at(scene, variable.keys[0])
    start = None if value is None else value / variable.scales[0]
    if start is None or not variable.lower <= start <= variable.upper:
        expected = (
            f"a number from {variable.lower:g} to {variable.upper:g}, since {variable.keys[0]} of "
            f"the scene is {'absent' if value is None else format(value, 'g')}"
        )
        refuse(f"{key}.start", expected, None)
    return start


def changes_of(variables: Sequence[Variable], values: Floats) -> dict[str, float]:
    """Changes of the scene for numbers of the variables."""
    return {
        path: float(scale * value)
        for variable, value in zip(variables, values, strict=True)
        for path, scale in zip(variable.keys, variable.scales, strict=True)
    }
