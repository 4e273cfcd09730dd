"""Reading of whole files up to a limit, and atomic writing of files.

Every file that users name is read and every file is written through this module, except mesh files
that meshio reads.
"""

from __future__ import annotations

import os
import stat
from collections.abc import Iterable
from contextlib import suppress
from errno import EFBIG, EINVAL
from pathlib import Path, PurePath

from flankload.errors import readable

#: Largest file that is read, bytes, if its reader has no other limit: a scene with a measured
#: friction table has a million.
LARGEST = 64 * 10**6
#: Largest mesh or compliance file: a million nodes have 1e8.
LARGEST_TABLE = 2 * 10**9
NO_NAME = "a name that no file can have"
#: Bytes that are read at a time.
PART = 2**20


def path_of(name: str) -> Path:
    """Path of a name in a file in UTF-8, also if the locale does not know its letters."""
    try:
        os.fsencode(name)
    except UnicodeEncodeError:
        return Path(os.fsdecode(name.encode("utf-8")))
    return Path(name)


def read_file(path: Path, largest: int = LARGEST) -> bytes:
    """Content of a file, a pipe or a device with at most `largest` bytes.

    Raises
    ------
    OSError
        If it is larger, cannot be read, or its name is none that a file can have.
    """
    parts, size = [], 0
    try:
        with path.open("rb") as stream:
            if os.fstat(stream.fileno()).st_size <= largest:
                while size <= largest and (part := stream.read(PART)):
                    parts.append(part)
                    size += len(part)
            else:
                size = largest + 1
    except ValueError:
        raise OSError(EINVAL, NO_NAME, str(path)) from None
    if size > largest:
        raise OSError(EFBIG, f"a file larger than {largest / 1e6:g} million bytes", str(path))
    return b"".join(parts)


def same_file(one: Path, other: Path) -> bool:
    """Whether two paths name the same file, including hard and symbolic links."""
    if os.path.realpath(one) == os.path.realpath(other):
        return True
    return os.path.exists(one) and os.path.exists(other) and one.samefile(other)


def would_replace(folder: Path, names: Iterable[str], file: Path) -> bool:
    """Whether a file would be replaced by files with such names in a folder.

    The names are patterns such as "*.png" or "torque_*/body_*.vtu"; a link there leads to the file
    that would be written.
    """
    inside = PurePath(os.path.realpath(file))
    with suppress(ValueError):  # on another drive of Windows
        inside = PurePath(os.path.relpath(inside, os.path.realpath(folder)))
    for name in names:
        if len(inside.parts) == len(PurePath(name).parts) and inside.match(name):
            return True
        if any(same_file(written, file) for written in folder.glob(name)):
            return True
    return False


def write_atomically(path: str | Path, content: str | bytes) -> None:
    """Write a file atomically: completely or not at all.

    Several threads and processes may write into one folder, even to one file: each writes a
    temporary file next to the target and then renames it to the target in one step.

    Parameters
    ----------
    path : path
        If the path is a symbolic link, the file it points to is written and the link stays. A
        file that is replaced keeps its mode. A device or a pipe is written to, not replaced.
    content : str or bytes
        Text is written as UTF-8, also with the names of files that are not.

    Raises
    ------
    OSError
        If the file cannot be written; the former content stays.
    """
    path = Path(path)
    data = readable(content).encode() if isinstance(content, str) else content
    if "\0" in str(path):
        raise OSError(EINVAL, NO_NAME, str(path))
    if is_stream(path):
        with path.open("ab") as stream:
            stream.write(data)
        return
    target = Path(os.path.realpath(path))
    # The name is fixed before the file exists, so an interrupt at any time can remove the file.
    part = target.with_name(f".flankload.{os.urandom(8).hex()}.part")
    try:
        mode = _mode_of(path)
        part.write_bytes(data)
        if mode is not None:
            part.chmod(mode)
        os.replace(part, target)
    except BaseException as error:
        part.unlink(missing_ok=True)
        if isinstance(error, OSError) and error.errno is not None:
            # The error names the requested file, not the temporary one.
            raise OSError(error.errno, error.strerror, str(path)) from None
        raise


def is_stream(path: Path) -> bool:
    """Whether a path is a device or a pipe, which is written to but never replaced."""
    if not path.exists() or path.is_dir():
        return False
    return not path.is_file() or str(path) in ("/dev/stdout", "/dev/stderr")


def _mode_of(path: Path) -> int | None:
    """Mode of the file at a path, symbolic links followed; None if there is no file."""
    try:
        return stat.S_IMODE(path.stat().st_mode)
    except FileNotFoundError:
        return None
