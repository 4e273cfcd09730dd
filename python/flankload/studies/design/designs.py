"""Designs of a study: which values the variables have in each run."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from itertools import chain, islice, product
from math import prod
from typing import TYPE_CHECKING, Any

import numpy as np

from flankload.base.files import path_of
from flankload.result.quantities import by_path
from flankload.scene.refusal import refuse, shown
from flankload.scene.scene import FILE_KEYS

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping
    from pathlib import Path

    from numpy.typing import NDArray

    from flankload.scene import Scene
    from flankload.studies.variables import Variable

#: Kinds that need a list of values for each variable, and those that draw from distributions.
OF_VALUES, OF_DRAWS = ("factorial", "list", "one-at-a-time"), ("sobol", "random")
#: Points of a Sobol sequence in double precision.
MOST_DRAWS = 2**30
#: Points drawn at a time; a power of 2, for which Sobol sequences are made.
BLOCK = 1024


@dataclass(frozen=True)
class Designs:
    """Designs of a study in their order.

    The kind is "factorial": all combinations, the last variable changes first; "list": design i has
    the i-th value of each variable; "one-at-a-time": the scene itself, then each value of each
    variable alone; "sobol": n points of a scrambled Sobol sequence; or "random": n independent
    points. More points of the same seed begin with the same ones. `fixed` are changes that all
    designs have.
    """

    variables: tuple[Variable, ...]
    kind: str = "factorial"
    n: int | None = None
    seed: int = 0
    fixed: Mapping[str, Any] = field(default_factory=dict)

    def check(self) -> None:
        """Refuse designs that their variables do not define.

        The SceneError names the argument or key: `design`, `n`, `seed` or `variables.PATH`.
        """
        kinds = (*OF_VALUES, *OF_DRAWS)
        if self.kind not in kinds:
            refuse("design", " or ".join(f"'{kind}'" for kind in kinds), shown(self.kind))
        draws = self.kind in OF_DRAWS
        for variable in self.variables:
            key = f"variables.{variable.name}"
            if draws and variable.distribution is None:
                refuse(key, f"a distribution, since the design is '{self.kind}'", variable.values)
            if not draws and variable.distribution is not None:
                expected = f"a list of values, since the design is '{self.kind}'"
                refuse(key, expected, "a distribution")
        if draws and not _is_number(self.n, 1, MOST_DRAWS):
            refuse("n", f"an integer from 1 to {MOST_DRAWS}: the number of designs", self.n)
        if not draws and self.n is not None:
            refuse("n", f"no such key, since the design is '{self.kind}'", self.n)
        if not _is_number(self.seed, 0, 2**63):
            refuse("seed", "an integer from 0 to 2^63", self.seed)
        if self.kind == "list":
            for variable in self.variables[1:]:
                expected = f"{self._counts[0]} values, as many as {self.variables[0].name}"
                if len(variable.values) != self._counts[0]:
                    refuse(f"variables.{variable.name}", expected, f"{len(variable.values)}")

    def files(self, folder: Path) -> dict[str, Path]:
        """Files that variables and changes name, by words for them; relative to the folder."""
        given = [(path, x) for one in self.variables for path in one.paths for x in one.values]
        found: dict[str, Path] = {}
        for path, value in [*given, *self.fixed.items()]:
            for key, name in by_path({path: value}, lambda n: f"[{n}]"):
                if key.rpartition(".")[2] in FILE_KEYS and isinstance(name, str):
                    found[f"{name} of {key}"] = folder / path_of(name)
        return found

    @property
    def _counts(self) -> list[int]:
        """Number of values of each variable."""
        return [len(variable.values) for variable in self.variables]

    def __len__(self) -> int:
        """Return the number of designs."""
        if self.kind == "factorial":
            return prod(self._counts)
        if self.kind == "one-at-a-time":
            return 1 + sum(self._counts)
        return self._counts[0] if self.kind == "list" else int(self.n or 0)

    def __iter__(self) -> Iterator[dict[str, Any]]:
        """Iterate over the values by name of the variable, without those that keep the scene's."""
        names = [variable.name for variable in self.variables]
        if self.kind == "one-at-a-time":
            yield {}
            for variable in self.variables:
                yield from ({variable.name: value} for value in variable.values)
            return
        rows: Any
        if self.kind == "factorial":
            rows = product(*(variable.values for variable in self.variables))
        elif self.kind == "list":
            rows = zip(*(variable.values for variable in self.variables), strict=True)
        else:
            rows = islice(chain.from_iterable(map(self._drawn, self._blocks())), self.n)
        for row in rows:
            yield dict(zip(names, row, strict=True))

    def first(self) -> Iterator[dict[str, Any]]:
        """Iterate over the fewest designs that change every variable; draws: and their bounds."""
        if self.kind == "one-at-a-time":
            yield from ({variable.name: variable.values[0]} for variable in self.variables)
            return
        yield (one := next(iter(self)))
        for variable in self.variables:
            yield from ({**one, variable.name: bound} for bound in variable.bounds)

    def in_scene(self, scene: Scene) -> Designs:
        """Return the designs with the distributions that follow from a scene.

        Raises SceneError if a tolerance class does not describe its variable.
        """
        if not any(variable.follows_from_scene for variable in self.variables):
            return self  # the fixed changes alone may contradict each other
        scene = scene.replace(self.fixed) if self.fixed else scene
        return replace(self, variables=tuple(one.in_scene(scene) for one in self.variables))

    @property
    def paths(self) -> set[str]:
        """Paths of the keys that designs change."""
        return {*self.fixed, *(path for variable in self.variables for path in variable.paths)}

    def changes(self, values: dict[str, Any]) -> dict[str, Any]:
        """Changes of the scene in a design, for `Scene.replace`."""
        found = dict(self.fixed)
        for variable in self.variables:
            if variable.name in values:
                found |= variable.changes(values[variable.name])
        return found

    @property
    def _numbers(self) -> int:
        """Uniform numbers that all variables of a draw need."""
        return sum(variable.numbers for variable in self.variables)

    def _drawn(self, points: NDArray[np.float64]) -> Iterator[tuple[Any, ...]]:
        """Iterate over the values at points (n, numbers) of the unit cube."""
        ends = np.cumsum([variable.numbers for variable in self.variables])
        columns = np.split(points, ends[:-1], axis=1)
        drawn = (v.quantiles(u) for v, u in zip(self.variables, columns, strict=True))
        return zip(*drawn, strict=True)

    def _blocks(self) -> Iterator[NDArray[np.float64]]:
        """Iterate endlessly over blocks of points of the unit cube (BLOCK, numbers)."""
        if self.kind == "random":
            random = np.random.default_rng(self.seed)
            while True:
                yield random.random((BLOCK, self._numbers))
        from scipy.stats import qmc

        sequence = qmc.Sobol(self._numbers, scramble=True, seed=self.seed)
        while True:
            yield sequence.random(BLOCK)


@dataclass(frozen=True)
class ChosenDesigns:
    """Some of the designs of a study, by their values."""

    designs: Designs
    values: tuple[dict[str, Any], ...]

    def __len__(self) -> int:
        return len(self.values)

    def __iter__(self) -> Iterator[dict[str, Any]]:
        return iter(self.values)

    def changes(self, values: dict[str, Any]) -> dict[str, Any]:
        """Changes of the scene in a design, for `Scene.replace`."""
        return self.designs.changes(values)


def _is_number(value: object, least: int, most: int) -> bool:
    """Whether a value is an integer in a range."""
    return isinstance(value, int) and not isinstance(value, bool) and least <= value <= most
