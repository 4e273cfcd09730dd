"""Scenes of an external pair, a gear in a ring and a spline, with few positions."""

from __future__ import annotations

from typing import Any

import flankload as fl
from flankload.result import Result
from tests.support.solving import solve

SMALL = {"kind": "gear", "teeth": 16, "module_mm": 4.5, "bore_diameter_mm": 30.0}
PINION = {**SMALL, "profile_shift": 0.182, "tip_diameter_mm": 82.46}
WHEEL = {**SMALL, "teeth": 24, "profile_shift": 0.171, "tip_diameter_mm": 118.36}
RING_PAIR = {
    "body_1": {
        "kind": "gear", "teeth": 24, "module_mm": 3.0, "tip_diameter_mm": 78.0,
        "bore_diameter_mm": 35.0,
    },
    "body_2": {
        "kind": "ring", "teeth": 60, "module_mm": 3.0, "tip_diameter_mm": 175.2,
        "root_diameter_mm": 187.5, "outer_diameter_mm": 220.0,
    },
    "pair": {"center_distance_mm": 53.93, "face_width_mm": 20.0},
}  # fmt: skip
EXTERNAL = {
    "body_1": PINION,
    "body_2": WHEEL,
    "pair": {"center_distance_mm": 91.5, "face_width_mm": 14.0},
}
SPLINE = {
    "body_1": {
        "kind": "spline_shaft", "teeth": 12, "module_mm": 2.0, "tip_diameter_mm": 25.6,
        "root_diameter_mm": 21.0, "bore_diameter_mm": 10.0, "profile_shift": -0.05,
    },
    "body_2": {
        "kind": "spline_hub", "teeth": 12, "module_mm": 2.0, "tip_diameter_mm": 22.0,
        "root_diameter_mm": 27.0, "outer_diameter_mm": 40.0,
    },
    "pair": {"face_width_mm": 20.0},
}  # fmt: skip


def scene_of(
    pair: dict, torque_Nm: float, *, count: int = 8, rigid: bool = False, **more: object
) -> fl.Scene:
    """Scene of a pair without estimate and tangents."""
    bodies = {key: {**pair[key], "rigid": rigid} for key in ("body_1", "body_2")}
    scene = {
        **pair,
        **bodies,
        "load": {"torque_Nm": torque_Nm},
        "positions": {"count": count},
        "accuracy": {"estimate": False, "tangents": False, "flank_element_mm": 1.0},
        **more,
    }
    return fl.Scene.from_dict(scene)


def solved(pair: dict, torque_Nm: float, **more: Any) -> Result:
    """Result of such a scene; its bodies may be those of earlier ones."""
    result = solve(scene_of(pair, torque_Nm, **more))
    assert isinstance(result, Result)
    return result
