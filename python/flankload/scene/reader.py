"""Reading of a scene from a TOML file."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from os import PathLike
from pathlib import Path
from typing import Any

from flankload.base.arguments import refuse_argument, require
from flankload.base.files import read_file
from flankload.errors import SceneError, reason_of
from flankload.scene.refusal import in_file
from flankload.scene.scene import Scene
from flankload.scene.tree import with_changes
from flankload.scene.typed_pairs import AsScene

#: Forms of a scene that the public functions accept.
SceneLike = Scene | AsScene | Mapping[str, Any] | str | PathLike[str]


def scene_of(given: object) -> Scene:
    """The scene from any form that the public functions accept.

    These are a scene, a typed pair such as `GearPair`, the path of a scene file, or the mapping for
    `Scene.from_dict`.

    Raises
    ------
    InputError
        If the argument is none of these.
    SceneError
        As `read_scene` and `Scene.from_dict`.
    """
    if isinstance(given, Scene):
        return given
    if isinstance(given, AsScene):
        return given.to_scene()
    if isinstance(given, str | PathLike):
        return read_scene(given)
    if not isinstance(given, Mapping):
        expected = "a Scene, a GearPair or its like, the path of a scene file, or a dictionary"
        refuse_argument("scene", given, expected)
    return Scene.from_dict(given)


def read_scene(path: str | PathLike[str], *, changes: Mapping[str, Any] | None = None) -> Scene:
    """Read a scene file.

    Parameters
    ----------
    path : path
        TOML file; paths of mesh files in it are relative to its folder.
    changes : mapping of str to object, optional
        Keys in place of those of the file, by path, as `Scene.replace` takes them. The file alone
        need not be a valid scene.

    Returns
    -------
    Scene

    Raises
    ------
    SceneError
        If the file cannot be read, is not valid TOML, or contains an invalid scene.
    """
    require("path", path, "the path of a scene file", fits=isinstance(path, str | PathLike))
    path = Path(path)
    with in_file(path):
        tree = with_changes(read_tables(path, "a scene file"), changes or {})
    return Scene.from_dict(tree, file=path)


def read_tables(path: Path, kind: str) -> dict[str, Any]:
    """Read a TOML file; `kind` names it in the error message, such as "a scene file".

    Raises
    ------
    SceneError
        If the file cannot be read or is not valid TOML.
    """
    try:
        return tomllib.loads(read_file(path).decode("utf-8-sig"))
    except OSError as error:
        expected, found = f"{kind} to read", reason_of(error)
    except UnicodeDecodeError as error:
        expected, found = "text in UTF-8", _invalid_byte(error)
    except tomllib.TOMLDecodeError as error:
        expected, found = "valid TOML", _syntax_error(str(error))
    # exceptions of Python that tomllib does not convert
    except RecursionError:
        expected, found = "lists of a few levels", "too many levels"
    except ValueError:
        expected, found = "numbers of a few digits", "one of thousands of digits"
    raise SceneError(file=path, key="file", expected=expected, found=found)


def _invalid_byte(error: UnicodeDecodeError) -> str:
    line = error.object.count(b"\n", 0, error.start) + 1
    return f"line {line}: byte 0x{error.object[error.start]:02x}"


def _syntax_error(message: str) -> str:
    """Message of tomllib behind its position: "line 3, column 7: unclosed string"."""
    text, _, place = message.partition(" (at ")
    return f"{place.rstrip(')')}: {text.lower()}" if place else text.lower()
