"""A pair of gears as a scene, its keys changed one by one, and what a refusal says."""

from __future__ import annotations

from copy import deepcopy
from pathlib import Path
from typing import Any

import pytest

from flankload.errors import SceneError
from flankload.scene import Scene

EXAMPLES = Path(__file__).parents[2] / "examples" / "scenes"

GEAR = {"kind": "gear", "teeth": 16, "module_mm": 4.5, "tip_diameter_mm": 82.46}
SCENE: dict[str, Any] = {
    "name": "pair",
    "body_1": {**GEAR, "bore_diameter_mm": 30},
    "body_2": {**GEAR, "bore_diameter_mm": 30},
    "pair": {"center_distance_mm": 72.0, "face_width_mm": 14},
    "load": {"torque_Nm": 302},
}
PROFILE = {"module_mm": 4.5, "tip_diameter_mm": 82.46}
ROUNDED = {**PROFILE, "tip_radius_mm": 0.3}
MESH = {"kind": "mesh", "file": "a.msh", "teeth": 16, "profile": PROFILE}
RING = {
    **{"kind": "ring", "teeth": 60, "module_mm": 4.5, "tip_diameter_mm": 262},
    **{"root_diameter_mm": 281, "outer_diameter_mm": 320},
}

ABSENT = object()


def changed(**changes: Any) -> dict[str, Any]:
    """The valid scene with keys (dots written as two underscores) set, or taken away if ABSENT."""
    scene = deepcopy(SCENE)
    for path, value in changes.items():
        *tables, key = path.split("__")
        table = scene
        for name in tables:
            table = table.setdefault(name, {})
        if value is ABSENT:
            del table[key]
        else:
            table[key] = value
    return scene


def refusal(scene: Any) -> SceneError:
    with pytest.raises(SceneError) as caught:
        Scene.from_dict(scene, file="a.toml")
    return caught.value


def one_line(changes: dict[str, Any], key: str, expected: str, found: str) -> None:
    """Check that a changed scene gets this one line."""
    error = refusal(changed(**changes))
    assert str(error) == f"a.toml: {key}: expected {expected}, found {found}"
    assert (error.key, error.expected, error.found) == (key, expected, found)
    assert "\n" not in str(error)
