"""How honest the error estimate is: what it says beside what a much finer solution shows.

FLANKLOAD_ESTIMATE=… sets another number of scenes than 42, FLANKLOAD_SEED=… draws others. The finer
solutions stay in out/bench_estimate_SEED, so that a changed estimate costs the plain runs alone;
a run that was stopped goes on from there.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np
from tests.benchmarks._scenes import SEED, scenes
from tests.benchmarks._truth import FINER, MODES, Truth, finer_solution, kept_truth

import flankload as fl
from flankload.analysis.estimate import OVERALL, POINTWISE

STORE = "out/bench_estimate_{}/{}.npz"
#: Errors below are rounding; of load shares they are counted apart (one pair alone, all alike).
LEAST = 1e-9
LEAST_SHARE = 1e-7

Errors = dict[str, float]


def run() -> str:
    """A table: part of the scenes in which the error is below the estimate, and the like."""
    count = int(os.environ.get("FLANKLOAD_ESTIMATE", "42"))
    seed = int(os.environ.get("FLANKLOAD_SEED", SEED))
    found, left_out = [], 0
    for k, (kind, scene) in enumerate(scenes(count, seed=seed)):
        truth = kept_truth(scene, Path(STORE.format(seed, k)))
        if truth is None:
            left_out += 1
        else:
            found.append({"kind": kind, **compared(scene, truth)})
    lines = table(found)
    if left_out:
        lines.append(f"{left_out} left out: the finer solution takes too long")
    return "\n".join(lines)


def table(found: list[dict[str, Any]]) -> list[str]:
    """Lines of what was found."""
    lines = [
        f"{len(found)} scenes; elements, cells, positions {FINER} times as fine, {MODES} modes",
        f"{'':34}scenes  below estimate  estimate < 10 error  median of both",
    ]
    for quantity in (*POINTWISE, *OVERALL):
        both = np.array([(one["true"][quantity], one["told"][quantity]) for one in found])
        least = LEAST_SHARE if quantity == "load_share" else LEAST
        true, told = both[np.isfinite(both).all(axis=1) & (both[:, 0] > least)].T
        lines.append(
            f"{quantity:34}{true.size:6}{100 * np.mean(true <= told):14.0f} %"
            f"{100 * np.mean(told < 10 * true):19.0f} %"
            f"{100 * np.median(true):10.3f} % {100 * np.median(told):.3f} %"
        )
    price = [one["price"] for one in found]
    lines.append(
        f"CPU time of the estimate, median and largest part of the run: "
        f"{np.median(price):.2f}, {max(price):.2f}"
    )
    return lines


def compared(scene: dict[str, Any], truth: Truth | None = None) -> dict[str, Any]:
    """What the estimate tells of a scene, what is true, and its part of the run's CPU time."""
    result = fl.solve(fl.Scene.from_dict(scene))
    assert isinstance(result, fl.Result)
    assert result.estimate is not None
    stages = {name: stage["cpu_s"] for name, stage in result.cost["stages"].items()}
    return {
        "true": true_errors(result, truth or finer_solution(scene)),
        "told": {name: result.estimate.get(name, np.nan) for name in (*POINTWISE, *OVERALL)},
        "price": stages["estimate"] / sum(stages.values()),
    }


def true_errors(result: fl.Result, finer: fl.Result | Truth) -> Errors:
    """Errors of all quantities by a finer solution at more positions."""
    at = np.abs(finer.position_rad - result.position_rad[:, None]).argmin(axis=1)
    rotation, true = result.rotation_rad, finer.rotation_rad
    sites = np.union1d(result.sites, finer.sites)

    def placed(one: fl.Result | Truth, values: np.ndarray) -> np.ndarray:
        wide = np.zeros((len(values), sites.size))
        wide[:, np.searchsorted(sites, one.sites)] = values
        return wide

    share = placed(result, result.load_share) - placed(finer, finer.load_share[at])
    peak = placed(result, result.peak_pressure_MPa)
    true_peak = placed(finer, finer.peak_pressure_MPa[at])
    corner = placed(result, result.corner_contact) + placed(finer, finer.corner_contact[at])
    smooth = (corner == 0) & (peak > 0)
    variation = np.ptp(true)
    return {
        "transmission_error": float(np.abs(rotation - true[at]).max() / np.abs(true).max()),
        "load_share": float(np.abs(share).max()),
        "peak_pressure": float(
            np.abs(peak - true_peak)[smooth].max(initial=0.0) / true_peak[smooth].max(initial=1.0)
        ),
        "transmission_error_mean": float(abs(rotation.mean() / true.mean() - 1)),
        "transmission_error_peak_to_peak": float(abs(np.ptp(rotation) / variation - 1))
        if variation > 0
        else 0.0,
        "stiffness_secant": _of_mean(
            result.stiffness_secant_Nm_per_rad, finer.stiffness_secant_Nm_per_rad
        ),
        "stiffness_tangent": _of_mean(
            result.stiffness_tangent_Nm_per_rad, finer.stiffness_tangent_Nm_per_rad
        ),
    }


def _of_mean(values: np.ndarray, true: np.ndarray) -> float:
    return float(abs(values.mean() / true.mean() - 1))
