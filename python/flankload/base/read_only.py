"""A base class whose read-only arrays stay read-only in copies and after unpickling."""

from __future__ import annotations

from typing import Any

import numpy as np


class KeepsReadOnly:
    """Base of classes with read-only arrays; NumPy's pickles and deep copies lose that flag."""

    def __getstate__(self) -> tuple[dict[str, Any], tuple[str, ...]]:
        values = dict(vars(self))
        return values, tuple(key for key, value in values.items() if _is_read_only(value))

    def __setstate__(self, state: tuple[dict[str, Any], tuple[str, ...]]) -> None:
        values, read_only = state
        vars(self).update(values)
        for key in read_only:
            values[key].flags.writeable = False


def _is_read_only(value: object) -> bool:
    return isinstance(value, np.ndarray) and not value.flags.writeable
