"""The rotation is continuous in the position, on corners and roundings too.

A jump has no physical reason: flanks are elastic, so forces grow from zero. It comes from cells,
zones or normals that change at once. Steps between neighbouring positions are followed by halving
the interval with the larger step until only a jump would be left.
"""

from __future__ import annotations

from copy import deepcopy

import numpy as np
import pytest

from tests.support.blind_cells import Job

#: Part of the largest rotation by which it may jump.
JUMP = 2e-4
#: By how much the largest step must shrink where the positions double.
SHRINKS = 1.8
#: Intervals that are followed, and how often they are halved: to 1e-8 of a period.
FOLLOWED, HALVINGS = 6, 16

FZG = {
    "body_1": {
        **{"kind": "gear", "teeth": 16, "module_mm": 4.5, "profile_shift": 0.182},
        **{"tip_diameter_mm": 82.46, "bore_diameter_mm": 30.0},
    },
    "body_2": {
        **{"kind": "gear", "teeth": 24, "module_mm": 4.5, "profile_shift": 0.171},
        **{"tip_diameter_mm": 118.36, "bore_diameter_mm": 40.0},
    },
    "pair": {"center_distance_mm": 91.5, "face_width_mm": 14.0},
    "load": {"torque_Nm": 302.0},
    "accuracy": {"estimate": False, "tangents": False},
}
#: A pinion inside a ring: flanks that nearly conform, one over the sharp edge of the other.
INTERNAL = {
    "body_1": {
        **{"kind": "gear", "teeth": 24, "module_mm": 3.0, "profile_shift": 0.3},
        **{"tip_diameter_mm": 79.8, "bore_diameter_mm": 35.0},
    },
    "body_2": {
        **{"kind": "ring", "teeth": 60, "module_mm": 3.0, "profile_shift": 0.3},
        **{"tip_diameter_mm": 176.2, "root_diameter_mm": 189.3, "outer_diameter_mm": 220.0},
    },
    "pair": {"center_distance_mm": 53.93, "face_width_mm": 20.0},
    "load": {"torque_Nm": 450.0},
    "accuracy": {"estimate": False, "tangents": False},
}
#: Two undercut gears: the sharp tip of one slides over the sharp end of the other's involute.
UNDERCUT = {
    "body_1": {
        **{"kind": "gear", "teeth": 12, "module_mm": 3.0, "profile_shift": 0.27197},
        **{"tip_diameter_mm": 42.8234, "bore_diameter_mm": 17.1},
    },
    "body_2": {
        **{"kind": "gear", "teeth": 12, "module_mm": 3.0, "profile_shift": -0.12626},
        **{"tip_diameter_mm": 40.8635, "bore_diameter_mm": 17.1},
    },
    "pair": {"center_distance_mm": 36.4394, "face_width_mm": 20.0},
    "load": {"torque_Nm": 72.0},
    "accuracy": {"estimate": False, "tangents": False},
}
#: A tip at a distance from the contact of the same flanks, but nearer than the rotation.
TIP_BESIDE = {
    "body_1": {
        **{"kind": "gear", "teeth": 42, "module_mm": 5.4587318, "profile_shift": -0.056647},
        **{"tip_diameter_mm": 239.6169, "bore_diameter_mm": 141.12},
    },
    "body_2": {
        **{"kind": "gear", "teeth": 29, "module_mm": 5.4587318, "profile_shift": -0.123059},
        **{"tip_diameter_mm": 167.9283, "bore_diameter_mm": 80.94},
    },
    "pair": {"center_distance_mm": 192.8296, "face_width_mm": 16.376},
    "load": {"torque_Nm": 3123.5},
    "accuracy": {"estimate": False, "tangents": False},
}


def changed(scene: dict, times_torque: float = 1.0, **tips: object) -> dict:
    """The scene with other tips on both bodies, under another torque."""
    scene = deepcopy(scene)
    scene["load"]["torque_Nm"] *= times_torque
    for body in ("body_1", "body_2"):
        scene[body] |= tips
    return scene


def relieved(scene: dict) -> dict:
    """The scene with linear relief on both bodies."""
    scene = changed(scene, 0.1, tip_relief_um=20.0, tip_relief_shape="linear")
    for body in ("body_1", "body_2"):
        tip = scene[body]["tip_diameter_mm"]
        scene[body]["tip_relief_start_diameter_mm"] = tip - 4.0
    return scene


SCENES = {
    "sharp tips": FZG,
    "rounded tips, high torque": changed(FZG, 3.0, tip_radius_mm=0.2),
    "small rounding": changed(FZG, tip_radius_mm=0.05),
    "linear relief, low torque": relieved(FZG),
    "ring": INTERNAL,
    "undercut": UNDERCUT,
    "tip beside the contact": TIP_BESIDE,
}


def largest_jump(job: Job, where: np.ndarray, rotation: np.ndarray) -> float:
    """Largest step left of the intervals in which the step differs most from its neighbours'."""
    step = np.diff(rotation)
    uneven = np.abs(step[1:-1] - 0.5 * (step[2:] + step[:-2]))
    first = 1 + np.argsort(uneven)[-FOLLOWED:]
    (low, high), (at_low, at_high) = (
        [values[first], values[first + 1]] for values in (where, rotation)
    )
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        at = job.run(middle).rotation_rad
        left = np.abs(at - at_low) > np.abs(at_high - at)
        low, at_low = np.where(left, low, middle), np.where(left, at_low, at)
        high, at_high = np.where(left, middle, high), np.where(left, at, at_high)
    return float(np.abs(at_high - at_low).max())


@pytest.mark.parametrize("name", SCENES)
def test_rotation_does_not_jump(name: str) -> None:
    job = Job(SCENES[name])
    where = job.period * np.arange(513) / 512
    rotation = job.run(where).rotation_rad
    assert largest_jump(job, where, rotation) < JUMP * np.abs(rotation).max()
    coarse, fine = (np.abs(np.diff(rotation[::part])).max() for part in (2, 1))
    assert coarse / fine > SHRINKS
