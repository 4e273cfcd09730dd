"""A hundred thousand seeded gear-like problems: how many answers are wrong or missing.

FLANKLOAD_STRESS=… sets another number of problems.
"""

from __future__ import annotations

import os
import time
from collections import Counter

import numpy as np

from tests.support.gear_like import METHODS, gear_like, outcome

BATCH = 1000


def run() -> str:
    """Counts of outcomes; a wrong one with the seed and place of its problem."""
    number = int(os.environ.get("FLANKLOAD_STRESS", "100000"))
    counts: Counter[str] = Counter()
    lines: list[str] = []
    start = time.perf_counter()
    for seed in range(-(-number // BATCH)):
        rng = np.random.default_rng(seed)
        for k in range(min(BATCH, number - seed * BATCH)):
            method = METHODS[k % len(METHODS)]
            name = outcome(gear_like(rng), method)
            counts[name] += 1
            if name.startswith("wrong") and len(lines) < 20:
                lines.append(f"  {name}: seed {seed}, problem {k}, method {method}")
    seconds = time.perf_counter() - start
    total = ", ".join(f"{counts[name]} {name}" for name in sorted(counts))
    return "\n".join([f"{number} problems in {seconds:.0f} s: {total}", *lines])
