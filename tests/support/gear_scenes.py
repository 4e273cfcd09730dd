"""A gear pair as a scene with keys changed one by one, and checks of the error lines."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from copy import deepcopy
from typing import Any

import numpy as np
import pytest

from flankload.errors import SceneError
from flankload.pairing.body_pair import BodyPair
from flankload.scene import Scene
from tests.support.paths import SCENES

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


def example(name: str) -> dict[str, Any]:
    """Tables of a scene of the examples."""
    return tomllib.loads((SCENES / f"{name}.toml").read_text("utf-8"))


def changed(**changes: Any) -> dict[str, Any]:
    """The valid scene with keys (dots written as two underscores) set, or removed if ABSENT."""
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


#: Power of the size with which the values of a key grow, by the end of its name.
GROWTH = {"_mm": 1, "_um": 1, "torque_Nm": 3, "_N_per_um": 1, "_Nm_per_mrad": 3, "_um_per_mm": 0}


def resized(table: Mapping[str, Any], size: float) -> dict[str, Any]:
    """A scene, or a table of one, whose lengths are so many times as long."""
    found: dict[str, Any] = {}
    for key, value in table.items():
        power = next((GROWTH[end] for end in reversed(GROWTH) if key.endswith(end)), 0)
        if isinstance(value, Mapping):
            found[key] = resized(value, size)
        elif key == "friction_coefficient" and isinstance(value, list | tuple):
            found[key] = [[size * place, coefficient] for place, coefficient in value]
        elif isinstance(value, list | tuple):
            found[key] = [size**power * entry for entry in value] if power else value
        else:
            found[key] = size**power * value if power else value
    return found


def refusal(scene: Any) -> SceneError:
    with pytest.raises(SceneError) as caught:
        Scene.from_dict(scene, file="a.toml")
    return caught.value


def one_line(changes: dict[str, Any], key: str, expected: str, found: str) -> None:
    """Check that a changed scene gives this single error line."""
    error = refusal(changed(**changes))
    assert str(error) == f"a.toml: {key}: expected {expected}, found {found}"
    assert (error.key, error.expected, error.found) == (key, expected, found)
    assert "\n" not in str(error)


def usable_contact_ratio(pair: BodyPair) -> float:
    """Part of the path of contact at which both radii lie between form circle and tip rounding.

    Sampled along the path, to 1e-5 of it.
    """
    mesh, sense = pair.pairing.gear_geometry, pair.body_2.outward
    assert mesh is not None
    x = np.linspace(mesh.path_start_mm, mesh.path_end_mm, 100_001)
    on_both = np.ones(x.size, dtype=bool)
    for body, pitch_radius, along in (
        (pair.body_1, mesh.pitch_radius_1_mm, x),
        (pair.body_2, mesh.pitch_radius_2_mm, -sense * x),
    ):
        curve, involute = body.curve, body.involute
        assert involute is not None
        to_pitch_point = pitch_radius * np.sin(mesh.pressure_angle_rad)
        reach = to_pitch_point + along
        radius = np.hypot(involute.base_radius_mm, reach)
        last = max(k for k, label in enumerate(curve.labels) if label in ("flank", "relief"))
        end = float(np.linalg.norm(curve.point(curve.breaks[last + 1 : last + 2])[0]))
        low, high = sorted((involute.form_radius_mm, end))
        on_both &= (reach >= 0) & (radius >= low) & (radius <= high)
    return float(on_both.mean()) * mesh.contact_ratio
