"""Digest of data: equal for equal bits, different otherwise."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import fields, is_dataclass
from functools import partial
from hashlib import blake2b
from pathlib import PurePath
from typing import TYPE_CHECKING, Any

import numpy as np
from msgspec import Struct

if TYPE_CHECKING:
    from collections.abc import Iterator

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
    found = blake2b(digest_size=SIZE)
    for part in _parts(data):
        found.update(len(part).to_bytes(8, "little"))
        found.update(part)
    return found.digest()


def _parts(data: Any) -> Iterator[bytes]:
    """Bytes of data, each piece after its type."""
    if isinstance(data, np.ndarray) and data.dtype.kind in "biufcU":
        yield f"{data.dtype.str}{data.shape}".encode()
        yield data.tobytes()
    elif isinstance(data, PLAIN) or _is_plain(data):
        yield f"{type(data).__name__}{data!r}".encode("utf-8", "surrogatepass")
    elif is_dataclass(data) and not isinstance(data, type):
        yield type(data).__qualname__.encode()
        for item in fields(data):
            yield from _parts(getattr(data, item.name))
    elif isinstance(data, Struct):
        yield type(data).__qualname__.encode()
        for name in data.__struct_fields__:
            yield from _parts(getattr(data, name))
    elif isinstance(data, partial):
        yield f"call{data.func.__module__}.{data.func.__qualname__}".encode()
        yield from _parts((data.args, data.keywords))
    elif isinstance(data, Mapping):
        yield f"mapping{len(data)}".encode()
        for key, value in data.items():
            yield from _parts(key)
            yield from _parts(value)
    elif isinstance(data, Sequence):
        yield f"{type(data).__name__}{len(data)}".encode()
        for item in data:
            yield from _parts(item)
    else:
        raise TypeError(f"data: expected numbers, text, arrays and tables, found {type(data)}")


def _is_plain(data: object) -> bool:
    """Whether a sequence contains only numbers and text, so that its `repr` identifies it."""
    return isinstance(data, tuple | list) and all(isinstance(item, PLAIN) for item in data)
