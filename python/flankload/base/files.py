"""Writing of files, whole or not at all; whatever the package writes goes through here."""

from __future__ import annotations

import os
import stat
from pathlib import Path


def write_atomically(path: str | Path, content: str | bytes) -> None:
    """Write a file so that it is there whole or not at all.

    Threads and processes may write into one folder, even to one file: each writes a file of its
    own beside the target, which then takes the target's name in one step.

    Parameters
    ----------
    path : path
        The file to which a link points is written, and the link stays; a file that is replaced
        keeps its mode. A device or a pipe is written to and stays what it is.
    content : str or bytes
        Text is written as UTF-8.

    Raises
    ------
    OSError
        If it cannot be written; the former content stays.
    """
    path = Path(path)
    data = content.encode("utf-8") if isinstance(content, str) else content
    if is_stream(path):
        with path.open("ab") as stream:
            stream.write(data)
        return
    target = Path(os.path.realpath(path))
    # The name is known before the file is there: an interrupt at any moment finds what to remove.
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
            # The file that was asked for, not the one beside it.
            raise OSError(error.errno, error.strerror, str(path)) from None
        raise


def is_stream(path: Path) -> bool:
    """Whether a path names a device or a pipe: to be written to, never to be replaced."""
    if not path.exists() or path.is_dir():
        return False
    return not path.is_file() or str(path) in ("/dev/stdout", "/dev/stderr")


def _mode_of(path: Path) -> int | None:
    """Mode of the file at a path, through links; None where there is none."""
    try:
        return stat.S_IMODE(path.stat().st_mode)
    except FileNotFoundError:
        return None
