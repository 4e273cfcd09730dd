"""Outputs: checks of their paths before the computation, and texts that are written or printed."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, NoReturn

from flankload.base.files import is_stream, write_atomically
from flankload.errors import SceneError

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from flankload.scene import Scene

STDOUT = "-"
#: Suffixes of files: a path that ends in one of these is not a folder.
OF_FILES = (
    ".csv", ".eps", ".fmu", ".gif", ".html", ".inp", ".jpeg", ".jpg", ".json", ".msh", ".npz",
    ".pdf", ".png", ".ps", ".pvd", ".svg", ".tif", ".tiff", ".toml", ".txt", ".vtu", ".webp",
    ".xlsx",
)  # fmt: skip


def refuse(key: str, expected: str, found: object, file: Path | None = None) -> NoReturn:
    """Raise the error of an option, or of a key of a file."""
    raise SceneError(file=file, key=key, expected=expected, found=found)


def check_outputs(
    files: Iterable[tuple[str, str | Path | None]],
    folders: Iterable[tuple[str, Path | None, str]] = (),
) -> list[tuple[str, Path]]:
    """Refuse outputs that could not be written; return their paths without stdout, by option.

    Files and folders follow their options; None: not wanted. A folder has its content in words.
    """
    wanted = [(key, path) for key, path in files if path is not None]
    printed = [key for key, path in wanted if str(path) == STDOUT]
    if len(printed) > 1:
        refuse(printed[1], f"a file, since {printed[0]} uses stdout", STDOUT)
    places = [(key, Path(path)) for key, path in wanted if str(path) != STDOUT]
    for key, path in places:
        check_file(key, path)
    for key, folder, content in folders:
        if folder is not None:
            check_folder(key, folder, content)
            places.append((key, folder))
    return places


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
    outputs: Iterable[tuple[str, Path]], scene: Scene | None, read: Mapping[str, Path] | None = None
) -> None:
    """Refuse an output that would replace the scene, a file that it reads or another output.

    Each file or folder follows its command-line option; `read` are further inputs by their names.
    """
    taken = dict(read or {})
    if scene is not None:
        taken |= {"the scene": scene.file} if scene.file is not None else {}
        taken |= {f"that of {key}": path for key, path in scene.files.items()}
    for key, path in outputs:
        if is_stream(path):
            continue
        for owner, other in taken.items():
            if _same(path, other):
                refuse(key, f"a file other than {owner}", path)
        taken[f"that of {key}"] = path


def write_text(path: str | Path, text: str) -> None:
    """Write a text, or print it."""
    if str(path) == STDOUT:
        print(text, end="")
    else:
        write_atomically(path, text)


def _same(one: Path, other: Path) -> bool:
    """Whether two paths name the same file, including hard and symbolic links."""
    if os.path.realpath(one) == os.path.realpath(other):
        return True
    return os.path.exists(one) and os.path.exists(other) and one.samefile(other)
