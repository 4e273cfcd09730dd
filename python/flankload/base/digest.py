"""Digest of data: equal for equal bits, different otherwise."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import fields, is_dataclass
from functools import cache, partial
from pathlib import PurePath
from typing import TYPE_CHECKING, Any

import numpy as np
from msgspec import Struct

if TYPE_CHECKING:
    from hashlib import blake2b

#: Types whose text identifies the value.
PLAIN = (str, float, int, type(None), bytes, PurePath, np.generic)
#: Bytes of a digest: among 1e12 digests, two are equal with a probability of 1e-24.
SIZE = 20


def digest_of(data: object) -> bytes:
    """Digest of data.

    Parameters
    ----------
    data : object
        Numbers, text, paths, arrays, tables, dataclasses, sequences and mappings of these, and
        partial calls of functions with such arguments. All fields and arguments are included.

    Returns
    -------
    bytes

    Raises
    ------
    TypeError
        If the data contain anything else.
    """
    from hashlib import blake2b

    found = blake2b(digest_size=SIZE)
    _add(data, found)
    return found.digest()


def _add(data: Any, found: blake2b) -> None:
    """Add the bytes of data to a digest, each piece after its type."""
    if isinstance(data, np.ndarray) and data.dtype.kind in "biufcU":
        _add_bytes(f"{data.dtype.str}{data.shape}".encode(), found)
        _add_bytes(data.tobytes(), found)
    elif isinstance(data, PLAIN) or _is_plain(data):
        _add_bytes(f"{type(data).__name__}{data!r}".encode("utf-8", "surrogatepass"), found)
    elif is_dataclass(data) and not isinstance(data, type):
        _add_bytes(type(data).__qualname__.encode(), found)
        for name in _field_names(type(data)):
            _add(getattr(data, name), found)
    elif isinstance(data, Struct):
        _add_bytes(type(data).__qualname__.encode(), found)
        for name in data.__struct_fields__:
            _add(getattr(data, name), found)
    elif isinstance(data, partial):
        _add_bytes(f"call{data.func.__module__}.{data.func.__qualname__}".encode(), found)
        _add((data.args, data.keywords), found)
    elif isinstance(data, Mapping):
        _add_bytes(f"mapping{len(data)}".encode(), found)
        for key, value in data.items():
            _add(key, found)
            _add(value, found)
    elif isinstance(data, Sequence):
        _add_bytes(f"{type(data).__name__}{len(data)}".encode(), found)
        for item in data:
            _add(item, found)
    else:
        raise TypeError(f"data: expected numbers, text, arrays and tables, found {type(data)}")


def _add_bytes(part: bytes, found: blake2b) -> None:
    found.update(len(part).to_bytes(8, "little"))
    found.update(part)


@cache
def _field_names(form: type[Any]) -> tuple[str, ...]:
    """Names of the fields of a dataclass."""
    return tuple(item.name for item in fields(form))


def _is_plain(data: object) -> bool:
    """Whether a sequence contains only numbers and text, so that its `repr` identifies it."""
    return isinstance(data, tuple | list) and all(isinstance(item, PLAIN) for item in data)
