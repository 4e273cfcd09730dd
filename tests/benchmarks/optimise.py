"""Optimisation with gradients beside differential evolution: states until the same objective.

Both search the same scene within the same bounds. Differential evolution (SciPy, default settings)
ends as soon as its objective is at most 0.5 % above that of the optimisation with gradients, or by
its own criterion.
"""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass
from time import process_time
from typing import Any

from threadpoolctl import threadpool_limits

import flankload as fl
from tests.support.paths import SCENES

PEAK_TO_PEAK = "transmission_error_peak_to_peak_um"
#: Relative distance from the other objective at which differential evolution ends.
SAME = 0.005
#: Wanted: ratio of states.
WANTED = 20.0
RELIEF = {
    "body_1.tip_relief_um": 20.0,
    "body_2.tip_relief_um": 20.0,
    "body_1.tip_relief_start_diameter_mm": 78.0,
    "body_2.tip_relief_start_diameter_mm": 114.0,
}
MISALIGNED = {
    "pair.deviation_um_per_mm": 0.4,
    "body_1.helix_slope_um": 0.0,
    "load.torque_Nm": [100, 150, 200, 250, 300],
}
BOTH = {"paths": ["body_1.tip_relief_um", "body_2.tip_relief_um"], "lower": 0, "upper": 80}
START_1 = {"paths": ["body_1.tip_relief_start_diameter_mm"], "lower": 73, "upper": 81}
START_2 = {"paths": ["body_2.tip_relief_start_diameter_mm"], "lower": 109, "upper": 117}
LEAD = [
    {"paths": ["body_1.lead_crowning_um"], "lower": 0, "upper": 20},
    {"paths": ["body_1.helix_slope_um"], "lower": -20, "upper": 20},
]


@dataclass(frozen=True)
class Case:
    """A scene, its variables and its objective."""

    scene: str
    changes: dict[str, Any]
    variables: list[dict[str, Any]]
    objective: str


CASES = {
    "relief, amount and start": Case("external_gear", RELIEF, [BOTH, START_1], PEAK_TO_PEAK),
    "relief, two starts": Case("external_gear", RELIEF, [BOTH, START_1, START_2], PEAK_TO_PEAK),
    "3D, five torques, K_Hbeta": Case("helical_gear", MISALIGNED, LEAD, "face_load_factor"),
    "3D, five torques, p2p": Case("helical_gear", MISALIGNED, LEAD, PEAK_TO_PEAK),
}


class _ReachedError(Exception):
    pass


def run() -> str:
    """Measure and return the table."""
    with threadpool_limits(limits=1):
        return "\n".join(_lines())


def _lines() -> list[str]:
    lines = [
        f"{'':>27}{'gradients':>24}{'differential evolution':>24}{'ratio of':>14}",
        f"{'search':>27}"
        + f"{'objective':>10}{'states':>8}{'s':>6}" * 2
        + f"{'states':>8}{'s':>6}",
    ]
    ratios = []
    for name, case in CASES.items():
        scene = fl.read_scene(SCENES / f"{case.scene}.toml").replace(case.changes)
        fl.solve(scene)  # imports
        begin = process_time()
        optimum = fl.optimise(scene, case.variables, case.objective)
        spent = process_time() - begin
        best, states, spent_by_other = _evolution(
            scene.replace(optimum.settings), case, optimum.objective
        )
        ratios.append(states / optimum.states)
        lines.append(
            f"{name:>27}{optimum.objective:10.4g}{optimum.states:8d}{spent:6.1f}"
            f"{best:10.4g}{states:8d}{spent_by_other:6.1f}"
            f"{ratios[-1]:8.1f}{spent_by_other / spent:6.1f}"
        )
    lines.append(f"least ratio of states {min(ratios):.1f}; wanted >= {WANTED:g}")
    return lines


def _evolution(scene: fl.Scene, case: Case, wanted: float) -> tuple[float, int, float]:
    """Best objective of differential evolution, its states and CPU seconds."""
    from scipy.optimize import differential_evolution

    best, states = float("inf"), 0
    begin = process_time()
    prepared = fl.prepare(scene)

    def objective(x: Any) -> float:
        nonlocal best, states
        changes = {
            path: float(value)
            for variable, value in zip(case.variables, x, strict=True)
            for path in variable["paths"]
        }
        results = prepared.solve(changes).by_torque
        states += sum(result.position_rad.size for result in results)
        value = max(float(result.summary[case.objective]) for result in results)
        best = min(best, value)
        if best <= wanted * (1.0 + SAME):
            raise _ReachedError
        return value

    bounds = [(variable["lower"], variable["upper"]) for variable in case.variables]
    with suppress(_ReachedError):
        differential_evolution(objective, bounds, seed=1, polish=False)
    return best, states, process_time() - begin
