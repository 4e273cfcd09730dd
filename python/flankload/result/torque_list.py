"""Join of the results of a list of torques: arrays with an axis of torques in front."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from flankload.base.read_only import frozen
from flankload.result.notes import warning_lines
from flankload.result.quantities import UNLOADED

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from flankload.base.arrays import Numbers
    from flankload.result.result import Result

    Results = Sequence[Result]

#: Entries of the cost that each torque has for itself.
COST_OF_TORQUE = ("of_this_torque", "largest_backward_error", "largest_condition")


def joined(results: Results, name: str) -> Any:
    """An attribute over all torques, as `Result` describes."""
    if name in OF_ALL:
        return OF_ALL[name](results)
    values = [getattr(one, name) for one in results]
    known = [one for one in values if one is not None]
    if not known:
        return None
    if isinstance(known[0], Mapping):
        return _merged(values)
    if isinstance(known[0], np.ndarray):
        return _stacked(results, name, values)
    if isinstance(known[0], int | float):
        return frozen(np.array(values, dtype=float))
    return tuple(values)


def _stacked(results: Results, name: str, values: Sequence[NDArray[Any] | None]) -> NDArray[Any]:
    """Arrays of all torques in one, of which those of the single results become views."""
    sites = _sites(results)
    shape = next((one.shape for one in values if one is not None and one.ndim == 1), ())
    every = [
        np.full(shape, np.nan) if value is None else _at_sites(value, one.sites, sites, name)
        for one, value in zip(results, values, strict=True)
    ]
    whole = frozen(np.stack(every))
    for one, value, part in zip(results, values, whole, strict=True):
        if value is not None and value.ndim < 2:
            vars(one)[name] = part
        elif value is not None:
            first = int(np.searchsorted(sites, one.sites[0]))
            run = slice(first, first + one.sites.size)
            if np.array_equal(sites[run], one.sites):
                vars(one)[name] = part[:, run]
    return whole


def _at_sites(values: NDArray[Any], own: Numbers, sites: Numbers, name: str) -> NDArray[Any]:
    """Array of one torque at the sites of all torques."""
    if values.ndim < 2 or np.array_equal(own, sites):
        return np.asarray(values)
    shape = (values.shape[0], sites.size, *values.shape[2:])
    whole = np.full(shape, UNLOADED.get(name, np.nan), dtype=values.dtype)
    whole[:, np.searchsorted(sites, own)] = values
    return whole


def _merged(values: Sequence[Mapping[str, Any] | None]) -> dict[str, Any]:
    """One mapping with a tuple of values, one per torque, for each key; inner mappings alike."""
    given = [{} if value is None else value for value in values]
    merged = {}
    for key in dict.fromkeys(key for value in given for key in value):
        found = [value.get(key) for value in given]
        nested = any(isinstance(one, Mapping) for one in found)
        merged[key] = _merged(found) if nested else tuple(found)
    return merged


def _sites(results: Results) -> Numbers:
    """(S,) Pair numbers of all torques."""
    return frozen(np.unique(np.concatenate([one.sites for one in results])))


def _cost(results: Results) -> dict[str, Any]:
    """Cost of the run; its parts of each torque are tuples."""
    cost = results[0].cost
    each = {key: tuple(one.cost.get(key) for one in results) for key in COST_OF_TORQUE}
    return {**cost, **{key: values for key, values in each.items() if key in cost}}


#: Attributes that are not joined torque by torque.
OF_ALL: Mapping[str, Callable[[Results], Any]] = {
    "sites": _sites,
    "warnings": lambda results: tuple(warning_lines(results)),
    "outside_limits": lambda results: tuple(
        dict.fromkeys(name for one in results for name in one.outside_limits)
    ),
    "accuracy": lambda results: results[0].accuracy,
    "cost": _cost,
}
