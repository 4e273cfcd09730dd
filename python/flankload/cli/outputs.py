"""Outputs: checks of their paths before the computation, and texts that are written or printed."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING

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


def check_folder(key: str, folder: Path, *, content: str) -> None:
    """Refuse a folder (of an option) that cannot be written to, or that has the name of a file."""
    there = next(part for part in (folder, *folder.parents) if part.exists())
    if not there.is_dir():
        raise SceneError(key=key, expected="a folder", found=f"the file {there}")
    if there != folder and folder.suffix.lower() in OF_FILES:
        raise SceneError(
            key=key,
            expected=f"a folder for {content}, such as {folder.with_suffix('')}",
            found=f"{folder}, the name of a file",
        )
    if not os.access(there, os.W_OK):
        raise SceneError(
            key=key, expected="a folder to write in", found=f"{there}, which is read-only"
        )


def check_file(key: str, path: Path) -> None:
    """Refuse a file that cannot be written."""
    if path.is_dir():
        raise SceneError(key=key, expected="a file", found=f"the folder {path}")
    if not path.parent.is_dir():
        raise SceneError(
            key=key, expected="a file in a folder that exists", found=f"no folder {path.parent}"
        )
    if path.exists() and not path.is_file():
        return  # a device or a pipe
    if not os.access(path.parent, os.W_OK):
        raise SceneError(
            key=key, expected="a folder to write in", found=f"{path.parent}, which is read-only"
        )


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
                raise SceneError(key=key, expected=f"a file other than {owner}", found=path)
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
