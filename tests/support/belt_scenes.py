"""The belt of the examples as a scene with changed keys, table by table."""

from __future__ import annotations

from typing import Any

from tests.support.gear_scenes import example
from tests.support.paths import SCENES

EXAMPLE = SCENES / "belt.toml"
#: Large elements on few teeth, for short run times.
SMALL: dict[str, Any] = {
    "body_2": {"wrapped_teeth": 5},
    "accuracy": {"flank_element_mm": 1.25, "estimate": False},
}


def tables(**changes: dict[str, Any]) -> dict[str, Any]:
    scene = example("belt")
    for table, keys in changes.items():
        kept = {**scene.get(table, {}), **keys}
        scene[table] = {key: value for key, value in kept.items() if value is not None}
    return scene


POSITIONS = {"positions": {"angles_deg": [0, 2, 6, 7, 8, 9, 13, 15]}}
