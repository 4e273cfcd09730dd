"""Variations of a scene: CPU seconds per design, prepared beside single runs.

One thread, without error estimates and tangents. A machine that others use shows in the seconds
more than in the ratios.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from time import process_time
from typing import Any

import numpy as np
from threadpoolctl import threadpool_limits

import flankload as fl
from tests.support.paths import SCENES

#: Wanted: CPU seconds of 50 reliefs at 32 positions of the external pair.
WANTED_S, RELIEFS = 1.0, 50
QUIET = {"accuracy.estimate": False, "accuracy.tangents": False}
RELIEF = {"body_1.tip_relief_um": 20.0, "body_1.tip_relief_start_diameter_mm": 80.0}
#: Changes of each design by name: scene, keys beside, key, smallest and largest value, designs.
STUDIES: dict[str, tuple[str, dict[str, Any], str, float, float, int]] = {
    "relief": ("external_gear", QUIET | RELIEF, "body_1.tip_relief_um", 2.0, 50.0, RELIEFS),
    "crowning": ("external_gear", QUIET, "body_2.profile_crowning_um", 1.0, 20.0, 20),
    "torque": ("external_gear", QUIET, "load.torque_Nm", 50.0, 400.0, 20),
    "centre distance": ("external_gear", QUIET, "pair.center_distance_mm", 91.5, 91.8, 20),
    "bore of one body": ("external_gear", QUIET, "body_1.bore_diameter_mm", 20.0, 40.0, 10),
    "ring, relief": ("internal_gear", QUIET, "body_2.tip_relief_um", 2.0, 20.0, 10),
    "3D, lead crowning": ("helical_gear", QUIET, "body_1.lead_crowning_um", 1.0, 10.0, 10),
    "3D, misalignment": ("helical_gear", QUIET, "pair.deviation_um_per_mm", 0.1, 1.0, 10),
    "3D, relief": ("helical_gear", QUIET, "body_1.tip_relief_um", 5.0, 30.0, 10),
}
#: Single runs per study: their mean is beside that of all prepared ones.
SINGLES = 3


def run() -> str:
    """Measure and return the table."""
    with threadpool_limits(limits=1):
        return "\n".join(_lines())


def _lines() -> list[str]:
    lines = [
        f"{'study':>18}{'designs':>9}{'single':>11}{'prepared':>11}{'ratio':>8}{'FE solved':>11}",
        f"{'':>18}{'':>9}{'ms each':>11}{'ms each':>11}",
    ]
    of_reliefs = 0.0
    for name, (file, beside, key, low, high, count) in STUDIES.items():
        scene = fl.read_scene(SCENES / f"{file}.toml").replace(beside)
        values = np.linspace(low, high, count)
        fl.solve(scene)  # imports
        singles = [_seconds(partial(_solve_single, scene, {key: x})) for x in values[:SINGLES]]
        prepared = fl.prepare(scene)
        solved, spent = 0, 0.0
        for x in values:
            begin = process_time()
            result = prepared.solve({key: x})
            spent += process_time() - begin
            assert isinstance(result, fl.Result)
            solved += result.cost["fe_factorisations"]
        if name == "relief":
            of_reliefs = spent
        single, each = float(np.mean(singles)), spent / count
        lines.append(
            f"{name:>18}{count:9d}{1e3 * single:11.1f}{1e3 * each:11.1f}{single / each:8.1f}"
            f"{solved:11d}"
        )
    lines.append(f"{RELIEFS} reliefs: {of_reliefs:.2f} s CPU; wanted <= {WANTED_S:g}")
    return lines


def _solve_single(scene: fl.Scene, changes: dict[str, float]) -> None:
    fl.solve(scene.replace(changes))


def _seconds(call: Callable[[], None]) -> float:
    begin = process_time()
    call()
    return process_time() - begin
