"""Scenes: every example, and some that call for one thing more."""

from __future__ import annotations

import tomllib
from copy import deepcopy
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from cam_scenes import FLAT_FOLLOWER, disc

import flankload as fl

from .cases import Case
from .quantities import SCENE

SCENES = Path(__file__).resolve().parents[2] / "examples" / "scenes"
#: Positions of a period: enough to see every state of contact, and a second a scene at the most.
POSITIONS = 6

#: Changes of the external gear, a name each.
VARIANTS: dict[str, dict[str, dict[str, Any]]] = {
    "no_torque": {"load": {"torque_Nm": 0.0}},
    "two_torques": {"load": {"torque_Nm": [30.0, 302.0]}},
    "plane_stress": {"accuracy": {"plane": "stress"}},
    "fine": {
        "accuracy": {"flank_element_mm": 0.5, "modes": 6, "strips_per_half_width": 16.0},
    },
    "tip_radius": {"body_1": {"tip_radius_mm": 0.3}, "body_2": {"tip_radius_mm": 0.3}},
    "tip_relief": {
        "body_1": {"tip_relief_um": 25.0, "tip_relief_start_diameter_mm": 79.0},
    },
    "pitch_errors": {"body_1": {"pitch_errors_um": [0.0] * 8 + [8.0] + [0.0] * 7}},
    "friction": {"effects": {"friction_coefficient": 0.1}},
    "friction_driven": {
        "effects": {"friction_coefficient": 0.3},
        "positions": {"driver": "body_2"},
    },
    "lumped": {"effects": {"contact": "lumped"}},
    "lumped_friction": {"effects": {"contact": "lumped", "friction_coefficient": 0.1}},
    "rigid_wheel": {"body_2": {"rigid": True}},
    "segment": {"effects": {"body": "segment", "segment_teeth": 3}},
    "single_tooth": {"effects": {"body": "tooth"}},
    "without_coupling": {"effects": {"tooth_coupling": False}},
    "warm_on_cold_shafts": {
        "effects": {
            "temperature_rise_K": [60.0, 40.0],
            "support_expansion_per_K": 0.0,
            "speed_rpm": 12000.0,
            "beyond_limits": True,  # growth takes up the backlash
        },
    },
    "no_tip_contact": {"effects": {"tip_contact": False}},
    "coast_flank": {
        "effects": {"coast_flank": True, "friction_coefficient": 0.05},
        "pair": {"center_distance_mm": 91.49},
        "load": {"torque_Nm": 100.0},
    },
}

#: Changes of other examples: which one, and what; a table that names its kind stands for itself.
OTHERS: dict[str, tuple[str, dict[str, dict[str, Any]]]] = {
    "internal_friction": (
        "internal_gear",
        {"effects": {"friction_coefficient": 0.08}, "positions": {"driver": "body_2"}},
    ),
    "spline_apart": ("spline", {"pair": {"center_offset_mm": 0.02}}),
    "cam_flat": ("cam", {"body_1": FLAT_FOLLOWER, "body_2": {"profile": disc(15.0)}}),
    "whole_body_friction": ("toothed_sector", {"effects": {"friction_coefficient": 0.1}}),
}


def _paths_made_whole(tree: dict[str, Any], folder: Path) -> dict[str, Any]:
    """The scene without the folder of its file."""
    for body in ("body_1", "body_2"):
        if "file" in tree[body]:
            tree[body]["file"] = str((folder / tree[body]["file"]).resolve())
    return tree


def _quantities(tree: dict[str, Any]) -> dict[str, Any]:
    solved = fl.solve(fl.Scene.from_dict(_paths_made_whole(deepcopy(tree), SCENES)))
    results = solved if isinstance(solved, tuple) else (solved,)
    several = len(results) > 1
    found: dict[str, Any] = {}
    for result in results:
        mark = f" at {result.torque_Nm:g} Nm" if several else ""
        for key in SCENE:
            if key == "fe_factorisations":
                value: Any = result.cost[key]
            elif key == "pairs":
                value = [len(result.pairs(p)) for p in range(result.position_rad.size)]
            elif key == "coast_force_N" and result.coast is None:
                continue
            else:
                value = np.ravel(getattr(result, key))
            # without torque there is no stiffness
            if np.isfinite(np.asarray(value, dtype=float)).all():
                found[key + mark] = value
    return found


def _case(tree: dict[str, Any], provenance: str) -> Case:
    tree = deepcopy(tree)
    driver = {k: v for k, v in tree.get("positions", {}).items() if k == "driver"}
    if tree["body_2"]["kind"] != "belt":  # which has one
        tree["positions"] = {"count": POSITIONS} | driver
    tree.setdefault("accuracy", {})["estimate"] = False
    return Case(
        inputs={"scene": tree},
        provenance=provenance,
        solve=partial(_quantities, tree),
        known=SCENE,
    )


def _positions(tree: dict[str, Any]) -> str:
    return "as it stands" if tree["body_2"]["kind"] == "belt" else f"{POSITIONS} positions"


def scene_cases() -> dict[str, Case]:
    """All of them by name."""
    cases = {}
    for path in sorted(SCENES.glob("*.toml")):
        tree = tomllib.loads(path.read_text(encoding="utf-8"))
        cases[f"scene_{path.stem}"] = _case(
            tree, f"examples/scenes/{path.name}, {_positions(tree)}"
        )
    gears = {name: ("external_gear", changes) for name, changes in VARIANTS.items()}
    for name, (stem, changes) in (gears | OTHERS).items():
        tree = tomllib.loads((SCENES / f"{stem}.toml").read_text(encoding="utf-8"))
        for table, keys in changes.items():
            tree[table] = {**({} if "kind" in keys else tree.get(table, {})), **keys}
        said = {table: list(keys) for table, keys in changes.items()} if stem == "cam" else changes
        cases[f"variant_{name}"] = _case(tree, f"examples/scenes/{stem}.toml with {said}")
    return cases
