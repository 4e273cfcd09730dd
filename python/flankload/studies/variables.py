"""Variables of a study: keys of a scene with values, or with a distribution."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
from msgspec import Meta

from flankload.scene.form import read_table
from flankload.scene.refusal import refuse, shown
from flankload.scene.table import Table
from flankload.studies.quality import JointNormal, Quality, of_quality

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from flankload.scene import Scene

#: Key of a table that makes it a distribution.
KIND = "distribution"
#: Quantiles of unbounded distributions are infinite at 0 and 1; probabilities are kept this far
#: from both, which is the spacing of doubles at 1.
LEAST_PROBABILITY = 2.0**-53


class Normal(Table, frozen=True, kw_only=True):
    """Normal distribution, in the unit of the key; values beyond the limits do not occur.

    Mean and standard deviation are those of the distribution that is not cut off.
    """

    mean: float
    standard_deviation: Annotated[float, Meta(gt=0)]
    lower: float | None = None
    upper: float | None = None

    def frozen(self) -> Any:
        """Return the distribution as scipy.stats has it."""
        from scipy import stats

        if self.lower is None and self.upper is None:
            return stats.norm(self.mean, self.standard_deviation)
        ends = (
            side if limit is None else (limit - self.mean) / self.standard_deviation
            for limit, side in ((self.lower, -np.inf), (self.upper, np.inf))
        )
        return stats.truncnorm(*ends, loc=self.mean, scale=self.standard_deviation)


class Uniform(Table, frozen=True, kw_only=True):
    """Uniform distribution, in the unit of the key."""

    lower: float
    upper: float

    def frozen(self) -> Any:
        """Return the distribution as scipy.stats has it."""
        from scipy import stats

        return stats.uniform(self.lower, self.upper - self.lower)


#: Tables of distributions by their names.
DISTRIBUTIONS: dict[str, type[Normal | Uniform]] = {"normal": Normal, "uniform": Uniform}
#: Distribution that follows from the tolerance class of a body, its only other key.
BY_CLASS, CLASS = "iso_1328", "class"


@dataclass(frozen=True)
class Variable:
    """One or several keys of a scene with the values that they take, or with a distribution.

    `name` is the path of a key as in `Scene.replace`; several paths separated by commas have the
    same value. A distribution is a frozen one of scipy.stats, a JointNormal, or a Quality.
    """

    name: str
    values: tuple[Any, ...] = ()
    distribution: Any = None

    @property
    def paths(self) -> tuple[str, ...]:
        """Paths of the keys."""
        return tuple(path.strip() for path in self.name.split(","))

    def changes(self, value: Any) -> dict[str, Any]:
        """Changes of a scene that give the keys a value, for `Scene.replace`."""
        return dict.fromkeys(self.paths, value)

    @property
    def follows_from_scene(self) -> bool:
        """Whether the distribution is known only by the body of a scene."""
        return isinstance(self.distribution, Quality)

    def in_scene(self, scene: Scene) -> Variable:
        """Return the variable with its distribution by the tolerance class of a body.

        Raises SceneError if the class does not describe the key or the body is beyond the standard.
        """
        if not isinstance(self.distribution, Quality):
            return self
        return replace(self, distribution=of_quality(scene, self.name, self.distribution))

    @property
    def numbers(self) -> int:
        """Number of uniform numbers that a draw needs."""
        return self.distribution.numbers if isinstance(self.distribution, JointNormal) else 1

    @property
    def bounds(self) -> list[Any]:
        """Least and largest value, as far as the distribution is bounded."""
        if isinstance(self.distribution, JointNormal) or not hasattr(self.distribution, "support"):
            return []
        ends = zip(self.distribution.support(), self.quantiles([[0.0], [1.0]]), strict=True)
        return [value for end, value in ends if np.isfinite(end)]

    def quantiles(self, probabilities: ArrayLike) -> list[Any]:
        """Values that the distribution does not exceed with probabilities (n, numbers) from 0 to 1.

        One number per draw may be (n,). Values are numbers or lists; integers if it is discrete.
        """
        from scipy.stats import rv_discrete

        inside = np.clip(probabilities, LEAST_PROBABILITY, 1.0 - LEAST_PROBABILITY)
        if isinstance(self.distribution, JointNormal):
            return self.distribution.quantiles(inside)
        inside = inside.reshape(len(inside))
        found = np.asarray(self.distribution.ppf(inside), dtype=float)
        if isinstance(getattr(self.distribution, "dist", None), rv_discrete):
            return [int(value) for value in found]
        return list(found.tolist())


def variables_of(tree: Mapping[str, Any]) -> tuple[Variable, ...]:
    """Read variables from a mapping by path.

    A value is a list of values, a table such as {"distribution": "uniform", "lower": 0,
    "upper": 30} or {"distribution": "iso_1328", "class": 7}, or a frozen distribution of
    scipy.stats. Tables of other keys are part of the path: {"load": {"torque_Nm": [100, 200]}}.

    Raises SceneError if there are none, if one has neither values nor a distribution, or if two
    have a path in common.
    """
    if not isinstance(tree, Mapping) or not tree:
        expected = "a table of paths with values or distributions"
        refuse("variables", expected, shown(tree) if tree else None)
    found = tuple(_variable(path, value) for path, value in paths_of(tree).items())
    taken: set[str] = set()
    for variable in found:
        for path in variable.paths:
            if path in taken:
                refuse(f"variables.{variable.name}", "paths that no other variable has", path)
            taken.add(path)
    return found


def paths_of(tree: Mapping[str, Any], before: str = "") -> dict[str, Any]:
    """Values of nested tables by dotted path; tables of distributions are values."""
    found: dict[str, Any] = {}
    for name, value in tree.items():
        path = f"{before}{name}"
        if isinstance(value, Mapping) and KIND not in value and value:
            found |= paths_of(value, f"{path}.")
        else:
            found[path] = value
    return found


def _variable(path: str, value: Any) -> Variable:
    """Read one variable."""
    value, key = _plain(value), f"variables.{path}"
    if isinstance(value, Mapping) and KIND in value:
        if value[KIND] == BY_CLASS:
            for name in set(value) - {KIND, CLASS}:
                refuse(f"{key}.{name}", f"a known key ({CLASS})", f"the unknown key '{name}'")
            return Variable(path, distribution=Quality(value.get(CLASS)))
        form = DISTRIBUTIONS.get(str(value[KIND]))
        if form is None:
            expected = " or ".join(f"'{name}'" for name in (*DISTRIBUTIONS, BY_CLASS))
            refuse(f"{key}.{KIND}", expected, shown(value[KIND]))
        table = read_table(form, {name: x for name, x in value.items() if name != KIND}, key)
        if table.lower is not None and table.upper is not None and not table.lower < table.upper:
            refuse(f"{key}.upper", f"a number above lower, {table.lower:g}", table.upper)
        return Variable(path, distribution=table.frozen())
    if hasattr(value, "ppf"):
        return Variable(path, distribution=value)
    if isinstance(value, str) or not isinstance(value, Sequence) or not len(value):
        refuse(key, "a non-empty list of values or a table with a distribution", shown(value))
    return Variable(path, values=tuple(_plain(x) for x in value))


def _plain(value: Any) -> Any:
    """Lists and numbers of Python in place of those of NumPy."""
    return value.tolist() if hasattr(value, "tolist") else value
