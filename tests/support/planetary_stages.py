"""Scenes of planetary stages."""

from typing import Any

import flankload as fl


def gear(teeth: int, module: float, tip: float, bore: float) -> dict[str, Any]:
    return {
        "kind": "gear",
        "teeth": teeth,
        "module_mm": module,
        "tip_diameter_mm": module * (teeth + tip),
        "bore_diameter_mm": bore,
    }


def four(**changes: Any) -> dict[str, Any]:
    """Keys of the stage of four planets in turn, without errors; other tables by name.

    None removes a table or a key.
    """
    scene: dict[str, Any] = {
        "name": "four planets in turn",
        "body_1": gear(25, 3, 1.9, 30),
        "planet": gear(17, 3, 1.9, 24),
        "body_2": {
            "kind": "ring",
            "teeth": 59,
            "module_mm": 3,
            "tip_diameter_mm": 172.8,
            "root_diameter_mm": 184.5,
            "outer_diameter_mm": 204,
        },
        "stage": {"planets": 4, "floating": "sun"},
        "pair": {"center_distance_mm": 63, "face_width_mm": 20},
        "load": {"torque_Nm": 600},
        "positions": {"count": 8},
        "effects": {"contact": "lumped"},
        "accuracy": {"estimate": False},
    }
    for name, keys in changes.items():
        scene[name] = {**scene[name], **keys} if isinstance(keys, dict) else keys
    scene = {name: keys for name, keys in scene.items() if keys is not None}
    return {
        name: {key: value for key, value in keys.items() if value is not None}
        if isinstance(keys, dict)
        else keys
        for name, keys in scene.items()
    }


def scene_of(**changes: Any) -> fl.Scene:
    return fl.Scene.from_dict(four(**changes))
