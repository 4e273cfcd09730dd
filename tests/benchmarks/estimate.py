"""How honest the error estimate is: what it says beside what a much finer solution shows.

FLANKLOAD_ESTIMATE=… sets another number of scenes than 42, FLANKLOAD_SEED=… draws others,
FLANKLOAD_DIMENSION=3 draws gears and rings in three dimensions, with other widths, shafts and webs;
their finer solutions have cells. They stay in out/bench_estimate_SEED, so that a changed estimate
costs the plain runs alone; a run that was stopped goes on from there. Errors of all scenes by
source are left there, too.
"""

from __future__ import annotations

import json
import os
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

from flankload.errors import PremiseError
from tests.support.finer_solutions import QUANTITIES, compared, kept_truth
from tests.support.random_scenes import SEED, scenes, spatial_scenes

STORE = "out/bench_estimate_{}"
#: Errors below are rounding; of load shares they are counted apart (one pair alone, all alike).
LEAST = 1e-9
LEAST_SHARE = 1e-7


def run() -> str:
    """A table: part of the scenes in which the error is below the estimate, and the like."""
    count = int(os.environ.get("FLANKLOAD_ESTIMATE", "42"))
    seed = int(os.environ.get("FLANKLOAD_SEED", SEED))
    found = []
    drawn, name = scenes(count, seed=seed), str(seed)
    if os.environ.get("FLANKLOAD_DIMENSION") == "3":
        drawn = list(spatial_scenes(count, seed=seed))
        name += "_spatial"
    folder = Path(STORE.format(name))
    for k, (kind, scene) in enumerate(drawn):
        with suppress(PremiseError):
            if truth := kept_truth(scene, folder / f"{k}.npz"):
                found.append({"kind": kind, "number": k, **compared(scene, truth)})
    (folder / "errors.json").write_text(json.dumps(found, indent=1))
    lines = table(found)
    if left_out := len(drawn) - len(found):
        lines.append(f"{left_out} left out: refused for their load, or solved too slowly")
    return "\n".join(lines)


def table(found: list[dict[str, Any]]) -> list[str]:
    """Lines of what was found."""
    lines = [
        f"{len(found)} scenes",
        f"{'':34}scenes  below estimate  estimate < 10 error  median of both, 90 % of the ratio",
    ]
    for quantity in QUANTITIES:
        errors = [(one["true"].get(quantity, np.nan), one["estimated"][quantity]) for one in found]
        both = np.array(errors, dtype=float)
        if np.isnan(both).all(axis=0).any():  # line loads of plane scenes
            continue
        least = LEAST_SHARE if quantity == "load_share" else LEAST
        true, estimated = both[np.isfinite(both).all(axis=1) & (both[:, 0] > least)].T
        lines.append(
            f"{quantity:34}{true.size:6}{100 * np.mean(true <= estimated):14.0f} %"
            f"{100 * np.mean(estimated < 10 * true):19.0f} %"
            f"{100 * np.median(true):10.3f} % {100 * np.median(estimated):.3f} %"
            f"{np.quantile(estimated / true, 0.9):10.1f}"
        )
    price = [one["price"] for one in found]
    lines.append(
        f"CPU time of the estimate, median and largest part of the run: "
        f"{np.median(price):.2f}, {max(price):.2f}"
    )
    return lines
