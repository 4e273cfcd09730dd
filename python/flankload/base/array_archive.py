"""Read .npz archives of arrays; all checks are made before anything is unpacked.

An archive of a few kilobytes can unpack to gigabytes. Names, types, shapes and sizes are read from
the archive's directory and from the headers of its members.
"""

from __future__ import annotations

import io
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import prod
from pathlib import Path
from typing import Any, Literal
from zipfile import ZipFile, ZipInfo

import numpy as np
from numpy.lib import format as npy
from numpy.typing import NDArray

from flankload.base.files import LARGEST_TABLE, read_file

#: Largest total size of all arrays of a file, unpacked, in bytes.
MOST_BYTES = 2**31
MOST_ARRAYS = 100
SUFFIX = ".npy"


class BadArchive(Exception):  # noqa: N818 - internal; callers convert it to a public error
    """A file that is not an archive of arrays, or that contains something refused.

    Parameters
    ----------
    name : str or None
        Name of the array, if known.
    found : str
    """

    def __init__(self, name: str | None, found: str) -> None:
        super().__init__(name, found)
        self.name = name
        self.found = found


@dataclass(frozen=True)
class Member:
    """An array of a file, not read yet.

    Attributes
    ----------
    shape : tuple of int
    dtype : dtype
    read : callable
        Returns the array; raises `BadArchive`.
    """

    shape: tuple[int, ...]
    dtype: np.dtype[Any]
    read: Callable[[], NDArray[Any]]


def read_members(path: Path) -> dict[str, Member]:
    """Read names, types and shapes of the arrays in an archive, without their values.

    Parameters
    ----------
    path : Path

    Returns
    -------
    dict of str to Member

    Raises
    ------
    BadArchive
        If the file is not an archive, contains pickled objects, too many or too large arrays, or an
        array whose size does not match its shape.
    """
    name = None
    members: dict[str, Member] = {}
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            archive = ZipFile(io.BytesIO(read_file(path, LARGEST_TABLE)))  # opened once for all
            parts = archive.infolist()
            _check_size(parts)
            for part in parts:
                name = part.filename.removesuffix(SUFFIX)
                if name in members:
                    raise BadArchive(name, "two arrays of one name")
                members[name] = _member(archive, part, name)
    except BadArchive:
        raise
    except Exception as error:  # damaged zip files and headers raise many kinds of exception
        raise BadArchive(name, _reason(error)) from None
    return members


def archive_of(arrays: Mapping[str, NDArray[Any]]) -> bytes:
    """Content of a .npz file; the same arrays give the same bytes."""
    # numpy 2.0 would store the argument allow_pickle as an array of that name
    named: dict[str, Any] = dict(arrays)
    assert not any(array.dtype.hasobject for array in named.values())
    out = io.BytesIO()
    np.savez_compressed(out, **named)
    return out.getvalue()


def _check_size(parts: list[ZipInfo]) -> None:
    if len(parts) > MOST_ARRAYS:
        raise BadArchive(None, f"{len(parts)} arrays, more than {MOST_ARRAYS}")
    size = sum(part.file_size for part in parts)
    if size > MOST_BYTES:
        raise BadArchive(
            None, f"arrays of {size / 2**30:.3g} GiB, more than {MOST_BYTES / 2**30:g} GiB"
        )


def _member(archive: ZipFile, part: ZipInfo, name: str) -> Member:
    with archive.open(part) as stream:
        version = npy.read_magic(stream)
        if version not in ((1, 0), (2, 0)):
            raise BadArchive(name, f"version {version[0]}.{version[1]} of numpy's format")
        read_head = npy.read_array_header_1_0 if version == (1, 0) else npy.read_array_header_2_0
        shape, by_columns, dtype = read_head(stream)
        head = stream.tell()
    if dtype.hasobject:
        raise BadArchive(name, "pickled objects, which are never loaded")
    if min(shape, default=0) < 0 or head + prod(shape) * dtype.itemsize != part.file_size:
        raise BadArchive(name, f"{part.file_size} bytes, which are not of its shape {shape}")

    def read() -> NDArray[Any]:
        try:
            content = archive.read(part)
        except Exception as error:
            raise BadArchive(name, _reason(error)) from None
        order: Literal["F", "C"] = "F" if by_columns else "C"
        return np.ndarray(shape, dtype, content, head, order=order).copy(order)

    return Member(tuple(shape), dtype, read)


def _reason(error: Exception) -> str:
    reason = " ".join(str(error).split()) or type(error).__name__
    return f"{reason[0].lower()}{reason[1:120]}"
