"""A scene whose designs take some 20 ms each."""

from __future__ import annotations

import tomllib
from typing import Any

import flankload as fl
from tests.support.small_job import SCENE

#: Text of the scene without tolerance control and tangents, with coarse elements.
TEXT = SCENE.replace("tolerance = 0.1\n", "tangents = false\n").replace("_mm = 2\n", "_mm = 4\n")


def design_scene(**changes: Any) -> fl.Scene:
    """Make the scene."""
    return fl.Scene.from_dict(tomllib.loads(TEXT)).replace(changes)
