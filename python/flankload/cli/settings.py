"""Scenes of a command: the file, with the keys that --set changes."""

from __future__ import annotations

import tomllib
from typing import TYPE_CHECKING, Any

from flankload.cli.outputs import refuse

if TYPE_CHECKING:
    from argparse import Namespace
    from collections.abc import Iterable

    from flankload.scene import Scene


def scene_of(arguments: Namespace) -> Scene:
    """The scene of a command."""
    changes = settings_of(arguments.settings)
    from flankload.scene import read_scene

    return read_scene(arguments.scene, changes=changes)


def settings_of(given: Iterable[str]) -> dict[str, Any]:
    """Keys of a scene with their values, which are those of TOML or plain words; "": no key."""
    found: dict[str, Any] = {}
    for text in given:
        key, equals, value = (part.strip() for part in text.partition("="))
        if not (key and equals):
            refuse("--set", "KEY=VALUE", text)
        if value.startswith("."):  # no number of TOML
            value = f"0{value}"
        try:
            found[key] = tomllib.loads(f"value = {value}")["value"] if value else None
        except tomllib.TOMLDecodeError:
            found[key] = value
    return found
