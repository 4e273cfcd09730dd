"""Scenes of cams and followers whose geometry is known in closed form."""

from __future__ import annotations

import numpy as np

CENTER_DISTANCE, WIDTH, TORQUE = 80.0, 12.0, 60.0
ECCENTRICITY, DISC = 8.0, 30.0
ARM, ROLLER = 70.0, 10.0
FLAT_OFFSET = -4.0

ROLLER_FOLLOWER = {
    "kind": "follower",
    "arm_mm": ARM,
    "roller_radius_mm": ROLLER,
    "bore_diameter_mm": 16.0,
}
FLAT_FOLLOWER = {
    "kind": "follower",
    "flat_offset_mm": FLAT_OFFSET,
    "flat_from_mm": 35.0,
    "flat_to_mm": 115.0,
    "arm_width_mm": 14.0,
    "bore_diameter_mm": 16.0,
}


def disc(step_deg: float = 5.0) -> list[list[float]]:
    """An eccentric circle; its centre lies in the direction of angle 0."""
    angle = np.arange(0.0, 360.0, step_deg)
    turn = np.radians(angle)
    chord = np.sqrt(DISC**2 - (ECCENTRICITY * np.sin(turn)) ** 2)
    return np.stack([angle, ECCENTRICITY * np.cos(turn) + chord], axis=1).tolist()


def waves(step_deg: float = 1.0) -> list[list[float]]:
    """Four lobes with hollows between them."""
    angle = np.arange(0.0, 360.0, step_deg)
    return np.stack([angle, 32.0 + 3.0 * np.cos(np.radians(4 * angle))], axis=1).tolist()


def lift_and_dwell(step_deg: float = 2.0) -> list[list[float]]:
    """A cycloidal rise of 100 deg, a dwell of 40, a return of 120, a dwell."""
    angle = np.arange(0.0, 360.0, step_deg)
    up, down = np.clip(angle / 100, 0, 1), np.clip((angle - 140) / 120, 0, 1)
    lift = [u - np.sin(2 * np.pi * u) / (2 * np.pi) for u in (up, down)]
    return np.stack([angle, 28.0 + 12.0 * (lift[0] - lift[1])], axis=1).tolist()


def cam_scene(
    profile: list[list[float]] | None = None,
    follower: dict | None = None,
    cam: dict | None = None,
    **keys: object,
) -> dict:
    """A scene; follower keys are added to those of the roller, or replace the whole table."""
    first = follower or {}
    return {
        "body_1": first if "kind" in first else {**ROLLER_FOLLOWER, **first},
        "body_2": {
            "kind": "cam",
            "bore_diameter_mm": 20.0,
            **({"profile": profile or disc()} if "profile_file" not in (cam or {}) else {}),
            **(cam or {}),
        },
        "pair": {"center_distance_mm": CENTER_DISTANCE, "face_width_mm": WIDTH},
        "load": {"torque_Nm": TORQUE},
        "accuracy": {"estimate": False, "tangents": False},
        **keys,
    }
