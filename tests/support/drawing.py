"""A helical pair with the data of its drawing."""

from __future__ import annotations

from typing import Any

BODIES: dict[str, dict[str, Any]] = {
    "body_1": {
        "kind": "gear",
        "teeth": 23,
        "module_mm": 2.5,
        "helix_angle_deg": 18,
        "hand": "right",
        "profile_shift": 0.25,
        "tip_diameter_mm": 66.70,
        "tip_radius_mm": 0.3,
        "bore_diameter_mm": 25,
    },
    "body_2": {
        "kind": "gear",
        "teeth": 71,
        "module_mm": 2.5,
        "helix_angle_deg": 18,
        "hand": "left",
        "profile_shift": -0.05,
        "tip_diameter_mm": 191.37,
        "tip_radius_mm": 0.3,
        "bore_diameter_mm": 50,
    },
}


def drawing(
    body_1: dict[str, Any] | None = None, body_2: dict[str, Any] | None = None, **pair: Any
) -> dict[str, Any]:
    """Tables of its scene with other keys; those that are None are left out."""
    tables = {
        "body_1": BODIES["body_1"] | (body_1 or {}),
        "body_2": BODIES["body_2"] | (body_2 or {}),
        "pair": {"center_distance_mm": 124.04, "face_width_mm": 30} | pair,
        "load": {"torque_Nm": 320},
    }
    return {
        name: {key: value for key, value in table.items() if value is not None}
        for name, table in tables.items()
    }
