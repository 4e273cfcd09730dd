"""Atomic writing of files; every file that the package writes goes through this module."""

from __future__ import annotations

import os
import stat
from pathlib import Path


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
        Text is written as UTF-8.

    Raises
    ------
    OSError
        If the file cannot be written; the former content stays.
    """
    path = Path(path)
    data = content.encode("utf-8") if isinstance(content, str) else content
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
