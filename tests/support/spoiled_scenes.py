"""Randomly invalid scenes: keys removed, misspelled, of wrong type, out of range."""

from __future__ import annotations

import copy
import tomllib
from functools import cache
from typing import Any

import numpy as np

from tests.support.paths import SCENES
from tests.support.random_scenes import scenes
from tests.support.random_spatial_scenes import COARSE, spatial_scene

Tree = dict[str, Any]
KINDS = (
    "gear", "ring", "spline_shaft", "spline_hub", "follower", "cam", "sprocket", "chain", "pulley",
    "belt", "mesh", "compliance",
)  # fmt: skip
NUMBERS = (
    0, -1, 1, 2, 3, 0.5, 1e-3, 1e3, 1e5, 1e9, 1e12, 1e-12, 1e300, -1e300, 1e-300, 5e-324, 10**400,
)  # fmt: skip
WORDS = ("", " ", "日本語", "$\\frac{1$", "a" * 5000, "\x00", "gear", "../nothing.msh", "−1")
#: Seed of the base scenes in three dimensions, and their number.
SPATIAL = (7, 6)
#: Examples in three dimensions, which take seconds as they are.
SPATIAL_EXAMPLES = ("helical_gear", "internal_helical", "crowned_coupling", "pinion_shaft")
#: Effects as a user may request them, individually and combined.
EFFECTS: tuple[Tree, ...] = (
    {"friction_coefficient": 0.08},
    {"friction_coefficient": [[-5.0, 0.05], [5.0, 0.1]]},
    {"near_field": "nodes"},
    {"influence": "finite"},
    {"root_stress": True},
    {"contact": "lumped"},
    {"body": "tooth"},
    {"body": "segment", "segment_teeth": 5},
    {"tooth_coupling": False},
    {"temperature_rise_K": 60.0},
    {"temperature_rise_K": [40.0, 80.0], "support_expansion_per_K": 0.0},
    {"speed_rpm": 3000.0},
    {"large_displacement": True},
    {"coast_flank": True},
    {"tip_contact": False},
    {"land_friction": 0.2},
    {"land_lift": True},
    {"choose": "auto"},
)
OTHER: tuple[tuple[str, Tree], ...] = (
    ("positions", {"angles_deg": [0.0, 3.7, -400.0]}),
    ("positions", {"pitches": 2}),
    ("positions", {"driver": "body_2"}),
    ("positions", {"adaptive": True, "max_count": 6}),
    ("accuracy", {"plane": "stress"}),
    ("accuracy", {"modes": 8}),
    ("accuracy", {"estimate": True}),
    ("accuracy", {"tolerance": 0.05}),
    ("load", {"torque_Nm": [0.0, 10.0, 300.0]}),
    ("load", {"torque_Nm": [1e12, 1e-9]}),
    ("load", {"torque_Nm": 0}),
)


@cache
def bases() -> tuple[Tree, ...]:
    """Scenes of examples, at random and from a drawing, with few positions and coarse elements."""
    trees, spatial = [], []
    for file in sorted(SCENES.glob("*.toml")):
        tree = tomllib.loads(file.read_text(encoding="utf-8"))
        for body in ("body_1", "body_2"):
            if "file" in tree[body]:
                tree[body]["file"] = str((SCENES / tree[body]["file"]).resolve())
        (spatial if file.stem in SPATIAL_EXAMPLES else trees).append(tree)
    trees += [copy.deepcopy(scene) for _, scene in scenes(6)]
    gear = {"kind": "gear", "module_mm": 4.5, "addendum_factor": 1.0, "bore_diameter_mm": 30}
    gear |= {"tip_relief_um": 20, "tip_relief_length": "long"}
    derived = {"body_1": {**gear, "teeth": 16}, "body_2": {**gear, "teeth": 24}}
    pair = {"normal_backlash_um": 80, "face_width_mm": 14}
    trees.append({**derived, "pair": pair, "load": {"torque_Nm": 302}})
    spatial = [_coarse(tree) for tree in spatial]
    for tree in spatial:
        tree["accuracy"] |= COARSE | {"slices": 8}
    seed, count = SPATIAL
    rng = np.random.default_rng(seed)
    spatial += [spatial_scene(rng) for _ in range(count)]
    return (*map(_coarse, trees), *spatial)


def _coarse(tree: Tree) -> Tree:
    tree["positions"] = {"count": 3}
    tree["accuracy"] = {"estimate": False}
    module = tree["body_1"].get("module_mm")
    if module is not None and tree["body_1"]["kind"] in ("gear", "spline_shaft"):
        tree["accuracy"]["flank_element_mm"] = 0.5 * module
    return tree


def spoiled(rng: np.random.Generator) -> tuple[Tree, str | None]:
    """A scene and, if it must be rejected in any case, the reason."""
    tree = copy.deepcopy(bases()[rng.integers(len(bases()))])
    for _ in range(rng.integers(0, 3)):
        _change(tree, rng)
    why = None
    if rng.random() < 0.4:
        why = _invalidate(tree, rng)
    return tree, why


def _change(tree: Tree, rng: np.random.Generator) -> None:
    """Another scene, which may be valid."""
    table, key = _place(tree, rng)
    value = table[key]
    match rng.integers(7):
        case 0:
            del table[key]
        case 1 | 2:
            if _is_number(value):
                table[key] = _number(value, rng)
        case 3:
            body = tree.get(f"body_{rng.integers(1, 3)}")
            if isinstance(body, dict):
                body["kind"] = str(rng.choice(KINDS))
        case 4 | 5:
            effects = tree.setdefault("effects", {})
            for k in rng.choice(len(EFFECTS), int(rng.integers(1, 4)), replace=False):
                effects |= copy.deepcopy(EFFECTS[k])
        case 6:
            name, keys = OTHER[rng.integers(len(OTHER))]
            tree.setdefault(name, {}).update(copy.deepcopy(keys))


def _number(value: float, rng: np.random.Generator) -> float:
    if rng.random() < 0.4:
        return NUMBERS[rng.integers(len(NUMBERS))]
    factor = rng.choice([-1.0, 0.1, 0.5, 0.9, 0.99, 1 - 1e-9, 1 + 1e-9, 1.01, 1.1, 2.0, 10.0, 1e3])
    changed = value * float(factor)
    return round(changed) if isinstance(value, int) and rng.random() < 0.5 else changed


def _invalidate(tree: Tree, rng: np.random.Generator) -> str | None:
    """Make a scene that must be rejected; the reason, or None if a word happens to be allowed."""
    table, key = _place(tree, rng)
    value = table[key]
    match rng.integers(6):
        case 0:
            table[key + "x"] = table.pop(key)
            return f"unknown key {key}x"
        case 1 if _is_number(value):
            table[key] = float(rng.choice([np.nan, np.inf, -np.inf]))
            return f"{key} = {table[key]}"
        case 2 if _is_number(value):
            table[key] = rng.choice(WORDS).item()
            return f"{key} = {table[key]!r}"
        case 3:
            table[key] = [{}, [], [[[]]], {"x": 1}, None, b"x", 1j][rng.integers(7)]
            emptied = isinstance(value, dict) and table[key] == {}
            return None if emptied or table[key] in ([], None) else f"{key} = {table[key]!r}"
        case 4 if _is_number(value):
            table[key] = True
            return f"{key} = true"
        case 5 if isinstance(value, list) and value:
            table[key] = [*value, float("nan")]
            return f"{key} with nan"
    table[key] = WORDS[rng.integers(len(WORDS))]
    return None


def _place(tree: Tree, rng: np.random.Generator) -> tuple[Tree, str]:
    """A key anywhere, with its table."""
    table = tree
    while True:
        key = list(table)[rng.integers(len(table))]
        if not isinstance(table[key], dict) or not table[key] or rng.random() < 0.03:
            return table, key
        table = table[key]


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)
