"""The FZG type C pair as a scene."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import flankload as fl
from tests.support.solving import solve

GEAR = {"kind": "gear", "module_mm": 4.5}
ONE = {
    **GEAR,
    "teeth": 16,
    "profile_shift": 0.182,
    "tip_diameter_mm": 82.46,
    "bore_diameter_mm": 30,
}
TWO = {
    **GEAR,
    "teeth": 24,
    "profile_shift": 0.171,
    "tip_diameter_mm": 118.36,
    "bore_diameter_mm": 40,
}
GEARS = {
    "body_1": ONE,
    "body_2": TWO,
    "pair": {"center_distance_mm": 91.5, "face_width_mm": 14},
    "load": {"torque_Nm": 302},
}


def solved(
    one: dict | None = None,
    two: dict | None = None,
    *,
    by: Callable[..., Any] = solve,
    **tables: dict,
) -> fl.Result:
    """Result of the pair with changed keys of its bodies and other tables; its cost by fl.solve."""
    scene = {
        **GEARS,
        "body_1": {**ONE, **(one or {})},
        "body_2": {**TWO, **(two or {})},
        "positions": {"count": 16},
        "accuracy": {"estimate": False, "tangents": False},
        **tables,
    }
    found: fl.Result = by(fl.Scene.from_dict(scene))
    return found
