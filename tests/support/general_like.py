"""Seeded random problems of the general form, and whether any forces can hold their loads."""

from __future__ import annotations

import numpy as np
from scipy.optimize import linprog

from tests.support.oracle import Problem


def general_like(rng: np.random.Generator) -> tuple[Problem, bool]:
    """One to four motions, up to 59 pairs; also whether some forces >= 0 hold the loads.

    K is symmetric, or unsymmetric due to a skew part and row weights, with R different from B. Its
    symmetric part is positive definite, so that a unique state exists exactly if the loads can be
    held. Rows without lever, overlaps (preload), row scales from 1e-8 to 1e8, loads inside, on a
    face of and outside the cone of the load rows, zero load.
    """
    q = int(rng.integers(1, 5))
    n = int(rng.integers(q + 1, 60))
    root = rng.standard_normal((n, n))
    compliance = root @ root.T / n + 10.0 ** rng.uniform(-4, 0) * np.eye(n)
    levers = rng.standard_normal((n, q))
    if rng.random() < 0.5:
        levers[:, 0] = np.abs(levers[:, 0])
    levers[rng.permutation(n)[: int(rng.integers(0, n - q))]] *= rng.choice([0.0, 1.0])
    gaps = rng.uniform(rng.choice([0.0, -0.2]), 1.0, n) * 10.0 ** rng.uniform(-3, 2)
    rows = levers
    if rng.random() < 0.4:
        skew = rng.standard_normal((n, n)) / n
        weights = np.exp(rng.uniform(-0.5, 0.5, n))
        compliance = (compliance + rng.uniform(0, 3) * (skew - skew.T)) / weights[:, None]
        gaps, levers = gaps / weights, levers / weights[:, None]
    loads = _loads(rng, rows)
    # Neither row scales nor the size of the loads change the cone of the rows.
    unit = loads / (np.abs(loads).max() or 1.0)
    held = linprog(np.zeros(n), A_eq=rows.T, b_eq=unit, method="highs").status == 0
    if rng.random() < 0.3:
        scale = 10.0 ** rng.uniform(-8, 8, n)
        compliance = compliance * np.outer(scale, scale)
        gaps = gaps * scale
        same = rows is levers
        levers, rows = levers * scale[:, None], rows * scale[:, None]
        rows = levers if same else rows
    return Problem(compliance, gaps, levers, rows, loads), held


def _loads(rng: np.random.Generator, rows: np.ndarray) -> np.ndarray:
    """Loads that forces hold, arbitrary loads, or zero, on any scale."""
    kind = rng.random()
    size = 10.0 ** rng.uniform(-6, 6)
    if kind < 0.05:
        return np.zeros(rows.shape[1])
    if kind < 0.1:
        # At most q - 1 pairs: often on a face of the cone.
        few = rng.permutation(len(rows))[: int(rng.integers(1, rows.shape[1] + 1))]
        return size * rows[few].T @ np.abs(rng.standard_normal(few.size))
    if kind < 0.7:
        return size * rows.T @ np.abs(rng.standard_normal(len(rows)))
    return size * rng.standard_normal(rows.shape[1])
