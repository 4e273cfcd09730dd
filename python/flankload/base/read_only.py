"""A base class whose arrays are read-only, also in copies and after unpickling."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray


class KeepsReadOnly:
    """Base of classes with read-only arrays; pickles and deep copies by NumPy lose that flag."""

    def __post_init__(self) -> None:
        """Make the arrays of a dataclass read-only."""
        for value in vars(self).values():
            if isinstance(value, np.ndarray):
                frozen(value)

    def __getstate__(self) -> tuple[dict[str, Any], tuple[str, ...]]:
        values = dict(vars(self))
        return values, tuple(key for key, value in values.items() if _is_read_only(value))

    def __setstate__(self, state: tuple[dict[str, Any], tuple[str, ...]]) -> None:
        values, read_only = state
        vars(self).update(values)
        for key in read_only:
            values[key].flags.writeable = False


def frozen(array: NDArray[Any]) -> NDArray[Any]:
    """Make an array read-only and return it."""
    array.setflags(write=False)
    return array


def _is_read_only(value: object) -> bool:
    return isinstance(value, np.ndarray) and not value.flags.writeable
