"""Outputs: checks of their paths before the computation, and texts that are written or printed."""

from __future__ import annotations

import os
import sys
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple, NoReturn, TextIO

from flankload.base.files import is_stream, same_file, would_replace, write_atomically
from flankload.errors import SceneError

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from flankload.scene import Scene

STDOUT = "-"
#: Names of files in a folder for plots.
PNG = ("*.png",)
#: Suffixes of files: a path that ends in one of these is not a folder.
OF_FILES = (
    ".csv", ".eps", ".fmu", ".gif", ".html", ".inp", ".jpeg", ".jpg", ".json", ".msh", ".npz",
    ".pdf", ".png", ".ps", ".pvd", ".svg", ".tif", ".tiff", ".toml", ".txt", ".vtu", ".webp",
    ".xlsx",
)  # fmt: skip


def refuse(key: str, expected: str, found: object, file: Path | None = None) -> NoReturn:
    """Raise the error of an option, or of a key of a file."""
    raise SceneError(file=file, key=key, expected=expected, found=found)


class Output(NamedTuple):
    """A file or folder that an option wants; of a folder, patterns of the names in it."""

    key: str
    path: Path
    names: tuple[str, ...] = ()


def check_outputs(
    files: Iterable[tuple[str, str | Path | None]],
    folders: Iterable[tuple[str, Path | None, str, tuple[str, ...]]] = (),
) -> list[Output]:
    """Refuse outputs that could not be written; return them without stdout.

    Files and folders follow their options; None: not wanted. A folder has its content in words, and
    patterns of the names in it.
    """
    wanted = [(key, path) for key, path in files if path is not None]
    printed = [key for key, path in wanted if str(path) == STDOUT]
    if len(printed) > 1:
        refuse(printed[1], f"a file, since {printed[0]} uses stdout", STDOUT)
    outputs = [Output(key, Path(path)) for key, path in wanted if str(path) != STDOUT]
    for output in outputs:
        check_file(output.key, output.path)
    for key, folder, content, names in folders:
        if folder is not None:
            check_folder(key, folder, content)
            outputs.append(Output(key, folder, names))
    return outputs


def check_folder(key: str, folder: Path, content: str) -> None:
    """Refuse a folder (of an option) that cannot be written to, or that has the name of a file."""
    there = next(part for part in (folder, *folder.parents) if part.exists())
    if not there.is_dir():
        refuse(key, "a folder", f"the file {there}")
    if there != folder and folder.suffix.lower() in OF_FILES:
        expected = f"a folder for {content}, such as {folder.with_suffix('')}"
        refuse(key, expected, f"{folder}, the name of a file")
    if not os.access(there, os.W_OK):
        refuse(key, "a folder to write in", f"{there}, which is read-only")


def check_file(key: str, path: Path) -> None:
    """Refuse a file that cannot be written."""
    if path.is_dir():
        refuse(key, "a file", f"the folder {path}")
    if not path.parent.is_dir():
        refuse(key, "a file in a folder that exists", f"no folder {path.parent}")
    if not is_stream(path) and not os.access(path.parent, os.W_OK):
        refuse(key, "a folder to write in", f"{path.parent}, which is read-only")


def check_apart(
    outputs: Iterable[Output], scene: Scene | None, read: Mapping[str, Path] | None = None
) -> None:
    """Refuse an output that would replace the scene, a file that it reads or another output.

    `read` are further inputs by their names.
    """
    taken = dict(read or {})
    if scene is not None:
        taken |= {"the scene": scene.file} if scene.file is not None else {}
        taken |= {f"that of {key}": path for key, path in scene.files.items()}
    for output in outputs:
        if is_stream(output.path):
            continue
        for owner, other in taken.items():
            if same_file(output.path, other):
                refuse(output.key, f"a file other than {owner}", output.path)
            if would_replace(output.path, output.names, other):
                expected = f"a folder whose files do not replace {other} ({owner})"
                refuse(output.key, expected, output.path)
        taken[f"that of {output.key}"] = output.path


def write_text(path: str | Path, text: str) -> None:
    """Write a text, or print it; other outputs follow if nobody reads this one to its end."""
    if str(path) != STDOUT:
        write_atomically(path, text)
        return
    try:
        print(text, end="", flush=True)
    except BrokenPipeError:
        drop(sys.stdout)


def say(line: object) -> None:
    """Print a line on stderr; the work goes on if nobody can read it."""
    try:
        print(line, file=sys.stderr, flush=True)
    except OSError:
        drop(sys.stderr)


def drop(stream: TextIO) -> None:
    """Discard all that a stream has and gets, which Python would otherwise write at exit."""
    with suppress(OSError, ValueError, AttributeError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())
