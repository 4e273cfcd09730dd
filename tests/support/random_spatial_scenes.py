"""Seeded scenes in three dimensions with coarse bodies, and their mirror images."""

from __future__ import annotations

from typing import Any

import numpy as np

import flankload as fl
from flankload.errors import FlankloadError
from flankload.mechanisms.flank_pair.assembly import build_bodies
from tests.support.random_scenes import (
    Scene,
    draw_gears,
    draw_ring,
    draw_spline,
    extend,
    random_shaft,
)

KINDS = ("gears", "gears", "ring", "coupling")
#: Identities hold for any bodies: few elements, modes and slices.
COARSE = {"modes": 3, "axial_degree": 5, "load_degree_z": 1, "estimate": False, "tangents": False}
FEW_CELLS = {"strips_per_half_width": 3, "corner_strips_per_half_width": 4}
#: Keys whose sign changes if z becomes -z, and lists with an entry for each end.
NEGATED = (
    *("helix_slope_um", "tooth_helix_slope_um", "profile_twist_um", "axial_offset_mm"),
    *("inclination_um_per_mm", "deviation_um_per_mm"),
)
OF_ENDS = (
    *("end_relief_um", "end_relief_length_mm", "diameters_mm", "lengths_mm"),
    *("radial_stiffness_N_per_um", "axial_stiffness_N_per_um", "tilt_stiffness_Nm_per_mrad"),
)
OTHER_SIDE = {"right": "left", "left": "right", "I": "II", "II": "I", "even": "even"}


def spatial_scene(rng: np.random.Generator) -> Scene:
    """A valid scene: gears, a ring or a coupling, with errors, shafts, friction and cells."""
    while True:
        scene = _drawn(str(rng.choice(KINDS)), rng)
        if scene is None:
            continue
        try:
            build_bodies(fl.Scene.from_dict(scene))
        except FlankloadError:
            continue
        return scene


def _drawn(kind: str, rng: np.random.Generator) -> Scene | None:
    scene = {"gears": draw_gears, "ring": draw_ring, "coupling": draw_spline}[kind](rng)
    if scene is None:
        return None
    if kind == "coupling":
        _lean(scene, rng)
    else:
        extend(scene, rng)
        _add_effects(scene, rng)
    module = scene["body_1"]["module_mm"]
    scene["positions"] = {"count": int(rng.integers(1, 4))}
    scene["accuracy"] = COARSE | {
        "flank_element_mm": 0.8 * module,
        "slices": int(rng.integers(6, 12)),
        **(FEW_CELLS if scene["effects"].get("contact") == "pairs" else {}),
    }
    if rng.random() < 0.2:
        torque = scene["load"]["torque_Nm"]
        scene["load"]["torque_Nm"] = [0.0, torque * 10 ** rng.uniform(-4, -1), torque]
    return scene


def _lean(scene: Scene, rng: np.random.Generator) -> None:
    """Make a coupling: crowned teeth of different widths, axes at an angle."""
    pair = scene["pair"]
    width = pair["face_width_mm"] * float(rng.uniform(0.3, 1.0))
    pair["face_width_mm"] = width
    scene["body_1"] |= {"face_width_mm": width, "lead_crowning_um": float(rng.uniform(1, 30))}
    if rng.random() < 0.5:
        scene["body_2"]["face_width_mm"] = width * float(rng.uniform(1.0, 1.3))
    if rng.random() < 0.3:
        scene["body_1"]["helix_slope_um"] = float(rng.uniform(-10, 10))
    if rng.random() < 0.7:
        pair["misalignment_mrad"] = float(rng.uniform(0, 4))
        pair["misalignment_direction_deg"] = float(rng.uniform(0, 360))
    scene["effects"] = {"dimension": 3}


def _add_effects(scene: Scene, rng: np.random.Generator) -> None:
    effects = scene["effects"]
    if rng.random() < 0.25:
        effects["contact"] = "pairs"
    if rng.random() < 0.25:
        effects["friction_coefficient"] = float(rng.uniform(0.03, 0.12))
    for name in ("body_1", "body_2"):
        body = scene[name]
        if rng.random() < 0.2:
            body["profile_twist_um"] = float(rng.uniform(-8, 8))
        if rng.random() < 0.15:
            body["tooth_helix_slope_um"] = rng.uniform(-6, 6, body["teeth"]).tolist()
        if body["kind"] == "gear" and rng.random() < 0.25:
            body["shaft"] = random_shaft(scene, body, rng)


def mirrored(table: Scene) -> Scene:
    """The scene, or a table of it, with -z in place of z: the other hands, the other ends."""
    found: dict[str, Any] = {}
    length = sum(table.get("lengths_mm", ()))
    for key, value in table.items():
        if isinstance(value, dict):
            found[key] = mirrored(value)
        elif key in NEGATED:
            found[key] = [-entry for entry in value] if isinstance(value, list) else -value
        elif key in OF_ENDS:
            found[key] = value[::-1]
        elif key in ("hand", "torque_end"):
            found[key] = OTHER_SIDE[value]
        elif key == "gear_position_mm":
            found[key] = length - value
        elif key == "bearing_positions_mm":
            found[key] = [length - place for place in value[::-1]]
        elif key == "misalignment_direction_deg":
            found[key] = (value + 180.0) % 360.0
        else:
            found[key] = value
    return found
