"""Seeded scenes of all kinds of pairs, with geometry as on drawings.

Loads are 0.1 to 3 times those of a nominal Hertz pressure; a third of the scenes has friction.
"""

from __future__ import annotations

from functools import cache
from math import acos, atan, cos, degrees, pi, radians, sin, sqrt, tan
from typing import Any

import numpy as np

import flankload as fl
from flankload.errors import FlankloadError
from flankload.mechanisms.flank_pair.assembly import build_bodies

ANGLE = radians(20.0)
#: c0 in plane strain, mm²/N.
STEEL = 2 * (1 - 0.3**2) / (pi * 206000.0)
#: Seed of the scenes with which the factors of the estimate were determined.
SEED = 7
KINDS = ("gears", "ring", "gears", "spline", "gears", "cam")
#: Thickness of both sides of a rim with a web, in modules.
RIM = 4.0

Scene = dict[str, Any]


def scenes(count: int, *, seed: int = SEED) -> list[tuple[str, Scene]]:
    """The given number of valid scenes, each with its kind."""
    return list(_scenes(count, seed))


@cache
def _scenes(count: int, seed: int) -> tuple[tuple[str, Scene], ...]:
    found: list[tuple[str, Scene]] = []
    rng = np.random.default_rng(seed)
    draws = {"gears": draw_gears, "ring": draw_ring, "spline": draw_spline, "cam": _cam}
    while len(found) < count:
        kind = KINDS[len(found) % len(KINDS)]
        scene = draws[kind](rng)
        if scene is None:
            continue
        if kind != "cam" and rng.random() < 1 / 3:
            scene["effects"] = {"friction_coefficient": float(rng.uniform(0.03, 0.12))}
        try:
            build_bodies(fl.Scene.from_dict(scene))
        except FlankloadError:
            continue
        found.append((kind, scene))
    return tuple(found)


@cache
def spatial_scenes(count: int, *, seed: int = SEED) -> tuple[tuple[str, Scene], ...]:
    """The given number of valid pairs in three dimensions, every fourth with a ring."""
    found: list[tuple[str, Scene]] = []
    rng = np.random.default_rng(seed)
    while len(found) < count:
        kind = "solid ring" if len(found) % 4 == 3 else "solid gears"
        scene = draw_ring(rng) if kind == "solid ring" else draw_gears(rng)
        if scene is None:
            continue
        extend(scene, rng)
        for name in ("body_1", "body_2"):
            if scene[name]["kind"] == "gear":
                add_shaft_or_web(scene, scene[name], rng)
        try:
            build_bodies(fl.Scene.from_dict(scene))
        except FlankloadError:
            continue
        found.append((kind, scene))
    return tuple(found)


def add_shaft_or_web(scene: Scene, body: Scene, rng: np.random.Generator) -> None:
    """Give a fifth of the gears a shaft; of the others, a fifth of those with a rim a web."""
    draw = rng.random()
    if draw < 0.2:
        body["shaft"] = random_shaft(scene, body, rng)
    elif draw < 0.4:
        module = body["module_mm"]
        across = cos(radians(body.get("helix_angle_deg", 0.0)))
        root = module * (body["teeth"] / across + 2 * body["profile_shift"] - 2.5)
        inside = root - RIM * module
        if inside > 1.3 * body["bore_diameter_mm"]:
            body["web_width_mm"] = scene["pair"]["face_width_mm"] * float(rng.uniform(0.3, 0.8))
            body["web_outer_diameter_mm"] = inside


def random_shaft(scene: Scene, body: Scene, rng: np.random.Generator) -> Scene:
    """Two steps on two bearings, the teeth between or beside them."""
    length = scene["pair"]["face_width_mm"] * float(rng.uniform(2.5, 6))
    step, bore = float(rng.uniform(0.3, 0.7)), body["bore_diameter_mm"]
    shaft: Scene = {
        "diameters_mm": [bore, bore * float(rng.uniform(0.7, 1.0))],
        "lengths_mm": [step * length, (1 - step) * length],
        "gear_position_mm": length * float(rng.uniform(0.2, 0.8)),
        "bearing_positions_mm": (length * np.sort(rng.uniform(0, 1, 2))).tolist(),
        "radial_stiffness_N_per_um": rng.uniform(50, 1000, 2).tolist(),
    }
    if rng.random() < 0.5:
        shaft["axial_stiffness_N_per_um"] = [float(rng.uniform(50, 500)), 0.0]
    if rng.random() < 0.3:
        shaft |= {"under_teeth": "flexible", "torque_end": str(rng.choice(["I", "II", "even"]))}
    return shaft


def extend(scene: Scene, rng: np.random.Generator) -> None:
    """Give a pair of gears widths, mostly a helix of the same transverse section, and errors."""
    helix = radians(rng.uniform(0, 30)) * (rng.random() < 0.75)
    module, c, pair = scene["body_1"]["module_mm"], cos(helix), scene["pair"]
    width = module * float(rng.uniform(2, 12))
    scene["load"]["torque_Nm"] *= width / pair["face_width_mm"]
    pair["face_width_mm"] = width
    for name, hand in (("body_1", "right"), ("body_2", "left")):
        body = scene[name]
        inside = body["kind"] == "ring"
        if helix:
            body |= {
                "module_mm": module * c,
                "pressure_angle_deg": degrees(atan(tan(ANGLE) * c)),
                "profile_shift": body["profile_shift"] / c,
                "helix_angle_deg": degrees(helix),
                "hand": "right" if inside else hand,
                **({} if inside else {"dedendum_factor": 1.25 / c}),
            }
        if rng.random() < 0.5:
            body["lead_crowning_um"] = float(rng.uniform(1, 4 + module))
        if rng.random() < 0.4:
            body["helix_slope_um"] = float(rng.uniform(-1, 1) * (4 + 2 * module))
        if rng.random() < 0.2:
            body["end_relief_um"] = rng.uniform(2, 10, 2).tolist()
            body["end_relief_length_mm"] = [0.15 * width, 0.2 * width]
    if rng.random() < 0.4:
        scene["body_2"]["face_width_mm"] = width * float(rng.uniform(0.85, 0.98))
        scene["body_2"]["axial_offset_mm"] = width * float(rng.uniform(-0.1, 0.1))
    if rng.random() < 0.3:
        pair["deviation_um_per_mm"] = float(rng.uniform(-0.4, 0.4))
    scene["positions"] = {"count": 16}
    scene["effects"] = {"dimension": 3}


def inv(angle: float) -> float:
    return tan(angle) - angle


def _load_part(rng: np.random.Generator) -> float:
    """Load relative to the nominal one."""
    return float(np.exp(rng.uniform(np.log(0.1), np.log(3.0))))


def _modified(rng: np.random.Generator, module: float, tip: float, outward: int) -> Scene:
    """Tip relief, crowning, tip rounding or chamfer of a flank."""
    keys: Scene = {}
    if rng.random() < 0.5:
        keys["tip_relief_um"] = float(rng.uniform(2, 3 + 3 * module))
        reach = module * float(rng.uniform(0.5, 1.3))
        keys["tip_relief_start_diameter_mm"] = 2 * tip - outward * reach
        keys["tip_relief_shape"] = str(rng.choice(["linear", "parabolic"]))
    if rng.random() < 0.3:
        keys["profile_crowning_um"] = float(rng.uniform(1, 8))
    end = rng.choice(["tip_radius_mm", "tip_chamfer_mm", "", ""])
    if end:
        keys[str(end)] = module * float(rng.uniform(0.04, 0.1))
    return keys


def draw_gears(rng: np.random.Generator) -> Scene | None:
    """Two external gears; None if the drawn keys give no pair."""
    teeth = [int(rng.integers(14, 40)), int(rng.integers(14, 90))]
    module, working = float(rng.uniform(1, 8)), radians(rng.uniform(18, 25))
    pitch_radius = [module * z / 2 * cos(ANGLE) / cos(working) for z in teeth]
    distance, backlash = sum(pitch_radius), module * rng.uniform(0.01, 0.05)
    filled = (2 * pi * pitch_radius[0] - teeth[0] * backlash) / (2 * pitch_radius[0])
    total = (filled - pi - sum(teeth) * (inv(ANGLE) - inv(working))) / (2 * tan(ANGLE))
    low, high = max(-0.2, total - 0.6), min(0.6, total + 0.2)
    if low >= high:
        return None
    first = float(rng.uniform(low, high))
    shift = [first, float(total) - first]
    root = [module * (z / 2 + x - 1.25) for z, x in zip(teeth, shift, strict=True)]
    base = [module * z / 2 * cos(ANGLE) for z in teeth]
    tip = [distance - r - 0.25 * module for r in reversed(root)]
    path = -distance * sin(working)
    bodies: Scene = {}
    for k in (0, 1):
        if tip[k] <= base[k]:
            return None
        half = (pi / 2 + 2 * shift[k] * tan(ANGLE)) / teeth[k] + inv(ANGLE)
        if 2 * tip[k] * (half - inv(acos(base[k] / tip[k]))) < 0.25 * module:
            return None
        path += sqrt(tip[k] ** 2 - base[k] ** 2)
        bodies[f"body_{k + 1}"] = {
            "kind": "gear",
            "teeth": teeth[k],
            "module_mm": module,
            "profile_shift": shift[k],
            "tip_diameter_mm": 2 * tip[k],
            "bore_diameter_mm": root[k] * float(rng.uniform(0.5, 1.5)),
            **_modified(rng, module, tip[k], 1),
        }
    if not 1.1 < path / (pi * module * cos(ANGLE)) < 2.2:
        return None
    rho = sin(working) * pitch_radius[0] * pitch_radius[1] / distance
    width = float(rng.uniform(5, 15)) * module
    nominal = 1000.0**2 * pi**2 * rho * STEEL * width * base[0] / 1000
    return {
        **bodies,
        "pair": {"center_distance_mm": distance, "face_width_mm": width},
        "load": {"torque_Nm": nominal * _load_part(rng)},
        "positions": {"count": 32},
    }


def draw_ring(rng: np.random.Generator) -> Scene:
    """A pinion in a ring on their reference circles, with equal profile shifts."""
    module = float(rng.uniform(1.5, 6))
    pinion = int(rng.integers(17, 34))
    ring = pinion + int(rng.integers(26, 70))
    shift = float(rng.uniform(0.1, 0.4))
    reference = [0.5 * module * z for z in (pinion, ring)]
    tip = [reference[0] + (shift + 0.9) * module, reference[1] + (shift - 0.85) * module]
    root = reference[1] + (shift + 1.25) * module
    width = float(rng.uniform(5, 12)) * module
    rho = sin(ANGLE) * reference[0] * reference[1] / (reference[1] - reference[0])
    lever = reference[0] * cos(ANGLE)
    nominal = 800.0**2 * pi**2 * rho * STEEL * width * lever / 1000
    return {
        "body_1": {
            "kind": "gear",
            "teeth": pinion,
            "module_mm": module,
            "profile_shift": shift,
            "tip_diameter_mm": 2 * tip[0],
            "bore_diameter_mm": reference[0] * float(rng.uniform(0.6, 1.3)),
            **_modified(rng, module, tip[0], 1),
        },
        "body_2": {
            "kind": "ring",
            "teeth": ring,
            "module_mm": module,
            "profile_shift": shift,
            "tip_diameter_mm": 2 * tip[1],
            "root_diameter_mm": 2 * root,
            "outer_diameter_mm": 2 * root + module * float(rng.uniform(6, 16)),
            **_modified(rng, module, tip[1], -1),
        },
        "pair": {
            "center_distance_mm": reference[1] - reference[0] - 0.02 * module,
            "face_width_mm": width,
        },
        "load": {"torque_Nm": nominal * _load_part(rng)},
        "positions": {"count": 32},
    }


def draw_spline(rng: np.random.Generator) -> Scene:
    """A toothed coupling with rounded tips; half of them with offset axes."""
    module, teeth = float(rng.uniform(1, 4)), int(rng.integers(12, 31))
    diameter, width = module * teeth, float(rng.uniform(8, 18)) * module
    reach = float(rng.uniform(0.8, 0.9)) * module
    rounding = {"tip_radius_mm": float(rng.uniform(0.08, 0.12)) * module}
    errors = {}
    if rng.random() < 0.6:
        errors["pitch_errors_um"] = rng.uniform(-5, 5, teeth).round(1).tolist()
    pair: Scene = {"face_width_mm": width}
    offset = rng.random() < 0.5
    if offset:
        pair["center_offset_mm"] = float(rng.uniform(0.002, 0.006)) * module
    nominal = 20.0 * teeth * reach * width * 0.5 * diameter / 1000
    return {
        "body_1": {
            "kind": "spline_shaft",
            "teeth": teeth,
            "module_mm": module,
            "pressure_angle_deg": 30,
            "tip_diameter_mm": diameter + reach,
            "root_diameter_mm": diameter - 1.4 * module,
            "bore_diameter_mm": diameter * float(rng.uniform(0.2, 0.6)),
            **rounding,
            **errors,
        },
        "body_2": {
            "kind": "spline_hub",
            "teeth": teeth,
            "module_mm": module,
            "pressure_angle_deg": 30,
            "profile_shift": 0.02,
            "tip_diameter_mm": diameter - 0.95 * reach,
            "root_diameter_mm": diameter + 1.4 * module,
            "outer_diameter_mm": diameter * float(rng.uniform(1.3, 1.7)),
            **rounding,
        },
        "pair": pair,
        "load": {"torque_Nm": nominal * _load_part(rng)},
        "positions": {"count": 8},
    }


def _cam(rng: np.random.Generator) -> Scene:
    """A disc cam and a follower with a roller, or with a flat if the cam has no hollow."""
    angle = np.arange(0.0, 360.0, 2.0)
    turn = np.radians(angle)
    radius = float(rng.uniform(22, 34))
    flat = rng.random() < 0.3
    if flat:
        off = float(rng.uniform(3, 8))
        chord = np.sqrt(radius**2 - (off * np.sin(turn)) ** 2) + off * np.cos(turn)
    else:
        rise, fall = rng.uniform(90, 130, 2)
        up, down = np.clip(angle / rise, 0, 1), np.clip((angle - rise - 40) / fall, 0, 1)
        lift = [u - np.sin(2 * np.pi * u) / (2 * np.pi) for u in (up, down)]
        chord = radius + float(rng.uniform(3, 8)) * (lift[0] - lift[1])
    follower = (
        {"flat_offset_mm": -4.0, "flat_from_mm": 35.0, "flat_to_mm": 115.0, "arm_width_mm": 14.0}
        if flat
        else {"arm_mm": 70.0, "roller_radius_mm": float(rng.uniform(8, 14))}
    )
    return {
        "body_1": {"kind": "follower", "bore_diameter_mm": 16.0, **follower},
        "body_2": {
            "kind": "cam",
            "bore_diameter_mm": 20.0,
            "profile": np.stack([angle, chord], axis=1).tolist(),
        },
        "pair": {"center_distance_mm": 80.0, "face_width_mm": float(rng.uniform(8, 20))},
        "load": {"torque_Nm": 60.0 * _load_part(rng)},
        "positions": {"count": 36},
    }
