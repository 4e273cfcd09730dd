"""Reading of a scene from a TOML file."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from os import PathLike
from pathlib import Path
from typing import Any

from flankload.errors import InputError, SceneError
from flankload.scene.refusal import shown
from flankload.scene.scene import Scene

#: What the public functions accept as a scene.
SceneLike = Scene | Mapping[str, Any] | str | PathLike[str]


def scene_of(given: object) -> Scene:
    """Return a scene in one of the forms that the public functions accept.

    Parameters
    ----------
    given : Scene, path or mapping
        A scene, the path of a scene file, or the keys of a scene as `Scene.from_dict` takes them.

    Returns
    -------
    Scene

    Raises
    ------
    InputError
        If the argument is none of these.
    SceneError
        As `read_scene` and `Scene.from_dict`.
    """
    if isinstance(given, Scene):
        return given
    if isinstance(given, str | PathLike):
        return read_scene(given)
    if isinstance(given, Mapping):
        return Scene.from_dict(given)
    expected = "a Scene, the path of a scene file, or a dictionary with its keys"
    raise InputError(f"scene: expected {expected}, found {_named(given)}")


def _named(value: object) -> str:
    """A value of a wrong type in a few words."""
    plain = value is None or isinstance(value, bool | int | float)
    return str(value) if plain else f"{shown(value)} ({type(value).__name__})"


def read_scene(path: str | PathLike[str]) -> Scene:
    """Read a scene file.

    Parameters
    ----------
    path : path
        TOML file; paths of mesh files in it are relative to its folder.

    Returns
    -------
    Scene

    Raises
    ------
    SceneError
        If the file cannot be read, is not valid TOML, or contains an invalid scene.
    """
    if not isinstance(path, str | PathLike):
        raise InputError(f"path: expected the path of a scene file, found {_named(path)}")
    path = Path(path)
    return Scene.from_dict(read_tables(path, "a scene file"), file=path)


def read_tables(path: Path, kind: str) -> dict[str, Any]:
    """Read a TOML file.

    Parameters
    ----------
    path : Path
    kind : str
        "a scene file", for the error message.

    Returns
    -------
    dict

    Raises
    ------
    SceneError
        If the file cannot be read or is not valid TOML.
    """
    try:
        return tomllib.loads(path.read_bytes().decode("utf-8-sig"))
    except OSError as error:
        raise SceneError(
            file=path, key="file", expected=f"{kind} to read", found=_reason(error)
        ) from None
    except UnicodeDecodeError as error:
        raise SceneError(
            file=path,
            key="file",
            expected="text in UTF-8",
            found=_strange_byte(error),
        ) from None
    except tomllib.TOMLDecodeError as error:
        raise SceneError(
            file=path, key="file", expected="valid TOML", found=_syntax_error(str(error))
        ) from None
    except (RecursionError, ValueError) as error:
        # Exceptions of Python itself that tomllib passes on.
        expected, found = (
            ("numbers of a few digits", "one of thousands of digits")
            if isinstance(error, ValueError)
            else ("lists of a few levels", "too many levels")
        )
        raise SceneError(file=path, key="file", expected=expected, found=found) from None


def _reason(error: OSError) -> str:
    return (error.strerror or type(error).__name__).lower()


def _strange_byte(error: UnicodeDecodeError) -> str:
    line = error.object.count(b"\n", 0, error.start) + 1
    return f"line {line}: byte 0x{error.object[error.start]:02x}"


def _syntax_error(message: str) -> str:
    """Message of tomllib with the position in front: "line 3, column 7: unclosed string"."""
    text, _, place = message.partition(" (at ")
    return f"{place.rstrip(')')}: {text.lower()}" if place else text.lower()
