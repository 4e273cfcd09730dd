"""Result of a list of torques: the quantities of one torque with an axis of torques in front."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from flankload.base.read_only import frozen
from flankload.result.loaded_positions import PairPositions
from flankload.result.notes import warning_lines
from flankload.result.quantities import UNLOADED
from flankload.result.result import Result
from flankload.result.summary import Summary

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from flankload.base.arrays import Numbers
    from flankload.result.pairs import PairTable

#: Entries of the cost that each torque has for itself.
COST_OF_TORQUE = ("of_this_torque", "largest_backward_error", "largest_condition")


def _attributes(kind: type) -> Iterator[str]:
    """Public names of fields and properties of a class."""
    for name in dict.fromkeys([*kind.__dataclass_fields__, *dir(kind)]):  # type: ignore[attr-defined]
        value = getattr(kind, name, None)
        is_field = name in kind.__dataclass_fields__  # type: ignore[attr-defined]
        if not name.startswith("_") and (is_field or isinstance(value, property | cached_property)):
            yield name


#: Attributes that all torques have in common.
SHARED = frozenset(
    {*_attributes(PairPositions), "engagement", "words_for_sites", "slice_z_mm", "accuracy"}
)


class TorqueSeries(Result):
    """Result of a scene with a list of T torques; `solve` makes it.

    It has the attributes of `Result` by these rules:

    - An array (P,) or (P, S) of one torque becomes (T, P) or (T, P, S), a number (T,). `sites` are
      those of all torques; a pair that a torque never loads has the values of an open pair there.
    - `position_rad`, the dimensions of the bodies and all else that no torque changes remain as
      they are.
    - `summary`, `key_figures` and `estimate` have the keys of one torque, with a tuple of T values
      each (None: no value).
    - `friction`, `slices`, `shafts`, `coast`, `drive`, `root_stress` and `pair_tables` are tuples
      of T objects, or None if there are none.
    - `warnings` are those of all torques without repetition; a warning that does not concern all of
      them names its torques. `cost` is that of the run, `outside_limits` are those of any torque.

    Parameters
    ----------
    results : sequence of Result
        One per torque, at the same positions.

    Raises
    ------
    ValueError
        If there is no result, or the positions differ.
    """

    def __init__(self, results: Sequence[Result]) -> None:
        self.__dict__["_results"] = tuple(results)
        if not results:
            raise ValueError("results: expected one per torque, found none")
        for one in results:
            if not np.array_equal(one.position_rad, results[0].position_rad):
                raise ValueError("results: expected the same positions for all torques")

    @property
    def by_torque(self) -> tuple[Result, ...]:
        """The result of each torque."""
        found: tuple[Result, ...] = self.__dict__["_results"]
        return found

    @property
    def has_torque_list(self) -> bool:
        """True: arrays have an axis of torques."""
        return True

    @cached_property
    def sites(self) -> Numbers:
        """(S,) Pair numbers of all torques."""
        return frozen(np.unique(np.concatenate([one.sites for one in self.by_torque])))

    @cached_property
    def warnings(self) -> tuple[str, ...]:
        """Warnings of all torques without repetition."""
        return tuple(warning_lines(self.by_torque))

    @cached_property
    def outside_limits(self) -> tuple[str, ...]:
        """Premises that any torque violates."""
        return tuple(dict.fromkeys(name for one in self.by_torque for name in one.outside_limits))

    @cached_property
    def cost(self) -> Mapping[str, Any]:
        """Cost of the run; its parts of each torque are tuples."""
        each = {
            key: tuple(one.cost.get(key) for one in self.by_torque)
            for key in COST_OF_TORQUE
            if key in self.by_torque[0].cost
        }
        return {**self.by_torque[0].cost, **each}

    def pairs(self, p: int) -> tuple[PairTable, ...]:  # type: ignore[override]
        """Contact pairs of position p, a table for each torque."""
        return tuple(one.pairs(p) for one in self.by_torque)


def result_of_torques(results: Sequence[Result], *, listed: bool) -> Result:
    """Join the results of a scene; `listed`: it has a list of torques, even of a single one."""
    return TorqueSeries(results) if listed else results[0]


def _of_all_torques(name: str) -> Callable[[TorqueSeries], Any]:
    """Getter of an attribute over all torques."""

    def value(self: TorqueSeries) -> Any:
        if name in SHARED:
            return getattr(self.by_torque[0], name)
        values = [getattr(one, name) for one in self.by_torque]
        known = [one for one in values if one is not None]
        if not known:
            return None
        if isinstance(known[0], Mapping):
            return _merged(values)
        if isinstance(known[0], np.ndarray):
            return frozen(np.stack([_at_sites(self, one, name) for one in self.by_torque]))
        if isinstance(known[0], int | float):
            return frozen(np.array(values, dtype=float))
        return tuple(values)

    value.__doc__ = f"`{name}` of all torques, as the class describes."
    return value


def _at_sites(series: TorqueSeries, one: Result, name: str) -> NDArray[Any]:
    """Array of one torque at the sites of all torques; NaN if this torque has none."""
    values = getattr(one, name)
    if values is None:
        every = (getattr(other, name) for other in series.by_torque)
        return np.full(next(other.shape for other in every if other is not None), np.nan)
    if values.ndim < 2 or np.array_equal(one.sites, series.sites):
        return np.asarray(values)
    shape = (values.shape[0], series.sites.size, *values.shape[2:])
    whole = np.full(shape, UNLOADED.get(name, np.nan), dtype=values.dtype)
    whole[:, np.searchsorted(series.sites, one.sites)] = values
    return whole


def _merged(values: Sequence[Mapping[str, Any] | None]) -> dict[str, Any]:
    """One mapping with a tuple of values, one per torque, for each key; inner mappings alike."""
    given = [{} if value is None else value for value in values]
    merged = Summary() if isinstance(values[0], Summary) else {}
    for key in dict.fromkeys(key for value in given for key in value):
        found = [value.get(key) for value in given]
        nested = any(isinstance(one, Mapping) for one in found)
        merged[key] = _merged(found) if nested else tuple(found)
    return merged


# every attribute of one torque, also one that a later version adds, has its form for several,
# except those that are for all torques
for _name in _attributes(Result):
    if _name not in vars(TorqueSeries) and _name not in ("torques_Nm", "plot"):
        _found = cached_property(_of_all_torques(_name))
        _found.__set_name__(TorqueSeries, _name)
        setattr(TorqueSeries, _name, _found)
