"""Scenes: every example, and some that call for one thing more."""

from __future__ import annotations

import tomllib
from copy import deepcopy
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

import flankload as fl
from flankload.elasticity.compliance import BodyCompliance
from flankload.mechanisms import Earlier, Parts, run_once
from tests.support.cam_scenes import FLAT_FOLLOWER, disc
from tests.support.paths import SCENES

from .cases import Case
from .quantities import MORE, SCENE, quantity_beside

#: Positions of a period: enough to see every state of contact, and a second a scene at the most.
POSITIONS = 6

#: The tooth of pair 0 is ahead, that of pair -1 behind: both carry at these positions.
TWO_TEETH_OFF = [8.0, -5.0] + [0.0] * 14
#: Errors of all teeth, without a regular pattern.
TEETH_APART = [0.0, 3.0, -2.0, 4.0, -4.0, 1.0, 5.0, -3.0, 2.0, -1.0, 4.0, 0.0, -5.0, 3.0, 1.0, -2.0]
#: Under this torque the six positions have a pair on a tip corner.
ON_A_CORNER = {"load": {"torque_Nm": 900.0}}

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
    "pitch_errors": {"body_1": {"pitch_errors_um": TWO_TEETH_OFF}},
    "crowning": {
        "body_1": {"profile_crowning_um": 12.0},
        "body_2": {"profile_crowning_um": 5.0},
    },
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
    "tip_corner": ON_A_CORNER,
    "coarse_elements": {"accuracy": {"flank_element_mm": 0.6}},
    "finite": {"effects": {"influence": "finite"}, "positions": {"count": 2}},
    "root_stress": {"effects": {"root_stress": True}, "positions": {"count": 3}},
    "adaptive": {"positions": {"count": 8, "adaptive": True, "tolerance": 0.05}},
    "hunting": {
        "body_1": {"pitch_errors_um": TEETH_APART},
        "positions": {"count": 1, "pitches": "hunting"},
    },
    "harmonics": {"positions": {"count": 16}},
    "estimates": {"accuracy": {"estimate": True}, "positions": {"count": 4}},
    "coast_flank": {
        "effects": {"coast_flank": True, "friction_coefficient": 0.05},
        "pair": {"center_distance_mm": 91.49},
        "load": {"torque_Nm": 100.0},
    },
}

#: Changes of other cases: name of the case, tables; a table with a kind replaces the whole table.
OTHERS: dict[str, tuple[str, dict[str, dict[str, Any]]]] = {
    "internal_friction": (
        "scene_internal_gear",
        {"effects": {"friction_coefficient": 0.08}, "positions": {"driver": "body_2"}},
    ),
    "spline_apart": (
        "scene_spline",
        {"pair": {"center_offset_mm": 0.02}, "positions": {"count": 2}},
    ),
    "cam_flat": ("scene_cam", {"body_1": FLAT_FOLLOWER, "body_2": {"profile": disc(15.0)}}),
    "whole_body_friction": ("scene_toothed_sector", {"effects": {"friction_coefficient": 0.1}}),
    "nodes": (
        "variant_coarse_elements",
        {"effects": {"near_field": "nodes"}, "positions": {"count": 3}},
    ),
    "no_tip_contact": ("variant_tip_corner", {"effects": {"tip_contact": False}}),
    "friction_unlike": (
        "variant_friction",
        {"body_2": {"young_modulus_MPa": 105000.0, "poisson_ratio": 0.22}},
    ),
    "sliding": ("variant_friction", {"positions": {"count": 5}}),
    "chain_followed": (
        "scene_chain",
        {"effects": {"large_displacement": True}, "positions": {"count": 2}},
    ),
    "belt_land_friction": ("scene_belt", {"effects": {"land_friction": 0.1}}),
    "web_and_hub": (
        "scene_helical_gear",
        {
            "body_2": {
                "web_width_mm": 7.5,
                "rim_thickness_mm": 9.0,
                "web_offset_mm": 3.0,
                "hub_diameter_mm": 90.0,
                "hub_width_mm": 40.0,
            },
            "positions": {"count": 2},
        },
    ),
}

#: Quantities of some variants beside those of every scene.
BESIDE: dict[str, tuple[str, ...]] = {
    "root_stress": ("root_tension_MPa", "root_compression_MPa"),
    "harmonics": ("transmission_error_harmonics_um", "contact_ratio_under_load"),
    "estimates": ("error_estimates", "estimates_by_source"),
    "sliding": ("sliding_mm_per_rad", "specific_sliding", "friction_loss_J_per_rad"),
    "chain_followed": ("tension_behind_N", "roller_height_um", "jump_margin_N"),
    "belt_land_friction": ("tension_behind_N", "lands_N"),
}


def _paths_made_whole(tree: dict[str, Any], folder: Path) -> dict[str, Any]:
    """The scene without the folder of its file."""
    for body in ("body_1", "body_2"):
        if "file" in tree[body]:
            tree[body]["file"] = str((folder / tree[body]["file"]).resolve())
    return tree


class _CountedParts(Parts):
    """Bodies and elements of other cases, and the factorisations of those that a run reuses."""

    def __init__(self) -> None:
        super().__init__(256)
        self._reused: list[bytes] = []
        self._made: list[bytes] = []
        self._factorisations: dict[bytes, int] = {}

    def find(self, call: partial[Any]) -> tuple[bytes, Any]:
        key, found = super().find(call)
        if found is not None:
            self._reused.append(key)
        return key, found

    def add(self, key: bytes, part: object) -> None:
        super().add(key, part)
        if isinstance(part, BodyCompliance):
            self._made.append(key)

    def solve(self, scene: fl.Scene) -> tuple[tuple[fl.Result, ...], int]:
        """Results, and the factorisations of a run that reuses nothing."""
        self._reused, self._made = [], []
        results = run_once(scene, earlier=Earlier(parts=self))
        stages = results[0].cost["stages"]
        counted = [
            stage["counters"].get("fe_factorisations", 0)
            for name, stage in stages.items()
            if name.startswith("compliance ")
        ]
        if self._made:
            self._factorisations.update(zip(self._made, counted, strict=True))
        reused = sum(self._factorisations.get(key, 0) for key in self._reused)
        return results, results[0].cost["fe_factorisations"] + reused


_PARTS = _CountedParts()


def _quantities(tree: dict[str, Any], beside: tuple[str, ...]) -> dict[str, Any]:
    scene = fl.Scene.from_dict(_paths_made_whole(deepcopy(tree), SCENES))
    assert not scene.names_tolerance
    results, factorisations = _PARTS.solve(scene)
    several = len(results) > 1
    found: dict[str, Any] = {}
    for result in results:
        mark = f" at {result.torque_Nm:g} Nm" if several else ""
        for key in SCENE:
            if key == "fe_factorisations":
                value: Any = factorisations
            elif key == "pairs":
                value = [len(result.pairs(p)) for p in range(result.position_rad.size)]
            elif key == "coast_force_N" and result.coast is None:
                continue
            else:
                value = np.ravel(getattr(result, key))
            # without torque there is no stiffness
            if np.isfinite(np.asarray(value, dtype=float)).all():
                found[key + mark] = value
        found |= {key + mark: quantity_beside(key, result) for key in beside}
    return found


def _case(tree: dict[str, Any], provenance: str, beside: tuple[str, ...] = ()) -> Case:
    return Case(
        inputs={"scene": tree},
        provenance=provenance,
        solve=partial(_quantities, tree, beside),
        known=SCENE | MORE,
    )


def _example(path: Path) -> dict[str, Any]:
    """An example at few positions."""
    tree = tomllib.loads(path.read_text(encoding="utf-8"))
    driver = {k: v for k, v in tree.get("positions", {}).items() if k == "driver"}
    if tree["body_2"]["kind"] != "belt":  # which has one
        tree["positions"] = {"count": POSITIONS} | driver
    tree.setdefault("accuracy", {})["estimate"] = False
    if path.stem == "helical_gear":  # three seconds with its own elements
        tree["accuracy"]["flank_element_mm"] = 3.0
    return tree


def _positions(tree: dict[str, Any]) -> str:
    return "unchanged" if tree["body_2"]["kind"] == "belt" else f"{POSITIONS} positions"


def parents() -> dict[str, str]:
    """Name of the parent of each variant, by its name."""
    gears = dict.fromkeys(VARIANTS, "scene_external_gear")
    others = {name: parent for name, (parent, _) in OTHERS.items()}
    return {f"variant_{name}": parent for name, parent in (gears | others).items()}


def scene_cases() -> dict[str, Case]:
    """All cases by name, parents first."""
    cases = {}
    for path in sorted(SCENES.glob("*.toml")):
        tree = _example(path)
        cases[f"scene_{path.stem}"] = _case(
            tree, f"examples/scenes/{path.name}, {_positions(tree)}"
        )
    gears = {name: ("scene_external_gear", changes) for name, changes in VARIANTS.items()}
    for name, (parent, changes) in (gears | OTHERS).items():
        tree = deepcopy(cases[parent].inputs["scene"])
        for table, keys in changes.items():
            tree[table] = {**({} if "kind" in keys else tree.get(table, {})), **keys}
        said = {k: list(keys) for k, keys in changes.items()} if parent == "scene_cam" else changes
        cases[f"variant_{name}"] = _case(tree, f"{parent} with {said}", BESIDE.get(name, ()))
    return cases
