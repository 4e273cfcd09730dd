"""Small contact problems, and their states by brute force over all contact sets."""

from __future__ import annotations

import itertools

import numpy as np

THREE = np.array([[10, 9.4, 8], [9.4, 10, 9.4], [8, 9.4, 10]])
FOUR = np.array([[10.0, 7, 5, 4], [7, 10, 7, 5], [5, 7, 10, 8], [4, 5, 8, 10]])


def brute_force(
    compliance: np.ndarray, gaps: np.ndarray, levers: np.ndarray, row: np.ndarray, load: float
) -> list[tuple[np.ndarray, float]]:
    """All states of contact, found by trying all contact sets."""
    n = gaps.size
    states = []
    for size in range(1, n + 1):
        sets = np.array(list(itertools.combinations(range(n), size)))
        matrix = np.zeros((len(sets), size + 1, size + 1))
        matrix[:, :size, :size] = compliance[sets[:, :, None], sets[:, None, :]]
        matrix[:, :size, size] = -levers[sets]
        matrix[:, size, :size] = row[sets]
        right = np.full((len(sets), size + 1), load)
        right[:, :size] = -gaps[sets]
        solutions = solutions_of(matrix, right)
        for k in np.flatnonzero((solutions[:, :size] > 0.0).all(axis=1)):
            pairs, solution = sets[k], solutions[k]
            forces = np.zeros(n)
            forces[pairs] = solution[:size]
            final = compliance @ forces + gaps - levers * solution[size]
            final[pairs] = 0.0
            if (final >= 0.0).all():
                states.append((forces, float(solution[size])))
    return states


def solutions_of(matrices: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Solutions (k, m) of k systems; NaN where a matrix is singular."""
    try:
        return np.linalg.solve(matrices, right[..., None])[..., 0]
    except np.linalg.LinAlgError:
        if len(matrices) == 1:
            return np.full(right.shape, np.nan)
        half = len(matrices) // 2
        parts = slice(None, half), slice(half, None)
        return np.concatenate([solutions_of(matrices[part], right[part]) for part in parts])


def random_problem(
    rng: np.random.Generator, *, unsymmetric: bool
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, float]:
    """A, m, b, gap angles and torque of a small gear-like problem."""
    n = int(rng.integers(1, 9))
    place = np.sort(rng.uniform(0.0, 1.0, n))
    compliance = np.exp(-3.0 * np.abs(place[:, None] - place)) + 0.05 * np.eye(n)
    levers = rng.uniform(20.0, 40.0, n)
    row = levers.copy()
    if unsymmetric:
        compliance *= 1.0 + 0.02 * rng.standard_normal((n, n))
        row *= 1.0 + 0.05 * rng.standard_normal(n)
    gaps = rng.uniform(0.0, 1.0, n) * rng.choice([0.01, 0.3, 3.0])
    torque = float(levers.mean() * 10.0 ** rng.uniform(-2, 2))
    return compliance / levers[:, None], row, levers, gaps / levers, torque


def flank_problem(
    n: int, rng: np.random.Generator, *, friction: float = 0.0, pairs_of_flanks: int = 2
) -> tuple[np.ndarray, np.ndarray, np.ndarray, float]:
    """A, m, gap angles and torque of a few flanks in contact like cylinders on half-planes."""
    flank = np.arange(n) * pairs_of_flanks // n
    place = (np.arange(n) * pairs_of_flanks / n) % 1.0
    step = pairs_of_flanks / n
    distance = np.abs(place[:, None] - place)
    upper, lower = distance + step / 2, distance - step / 2
    kernel = 1.0 - (upper * np.log(upper) - lower * np.log(np.abs(lower)) - step) / step
    matrix = np.where(flank[:, None] == flank, kernel, 0.0) + 0.5
    if friction:
        matrix = matrix * (1.0 + friction * 0.2 * np.sign(0.5 - place))
    gaps = 3.0 * (place - rng.uniform(0.3, 0.7, pairs_of_flanks)[flank]) ** 2
    gaps += 0.02 * rng.uniform(0, 1, pairs_of_flanks)[flank]
    row = 1.0 + friction * np.where(flank % 2, -0.3, 0.3)
    return matrix, row, gaps, float(10.0 ** rng.uniform(-2, 0.5))
