"""The contact loop against the paper's method and against the practical limit L.

L is what the final state alone costs: one Cholesky factorisation of the pairs in contact, two
right-hand sides, one gap check. The paper's method solves (32) anew at every step (LAPACK's dgesv).
All on one thread; best of several runs.
"""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np
from scipy.linalg.lapack import dgesv, dpotrf, dpotrs

from flankload import _core, solve_contact

SIZES = (100, 400, 1600)
ARM = 30.0


def hertz_problem(n: int) -> tuple[np.ndarray, np.ndarray, float]:
    """A cylinder on an elastic half-plane: compliance [mm/N], gaps [mm], torque [N mm].

    The load presses about a fifth of the n pairs into contact.
    """
    spacing = 2.0 / n
    place = (np.arange(n) - 0.5 * (n - 1)) * spacing
    kernel = 2.0 * (1.0 - 0.3**2) / (np.pi * 206000.0)

    def primitive(x: np.ndarray) -> np.ndarray:
        return x * np.log(np.abs(np.where(x == 0.0, 1.0, x)))

    distance = np.abs(place[:, None] - place[None, :])
    love = primitive(distance + 0.5 * spacing) - primitive(distance - 0.5 * spacing) - spacing
    compliance = -2.0 * kernel * love / spacing + 4e-5
    curvature, half_width = 0.2, 0.2
    force = np.pi * half_width**2 * curvature / (4.0 * np.pi * kernel) / 2.0 * np.pi
    return compliance, 0.5 * curvature * place**2, force * ARM


def best_time(call: Callable[[], object], seconds: float = 0.6) -> float:
    """Shortest of several runs [s]."""
    best = np.inf
    end = time.perf_counter() + seconds
    runs = 0
    while runs < 3 or (time.perf_counter() < end and runs < 2000):
        start = time.perf_counter()
        call()
        best = min(best, time.perf_counter() - start)
        runs += 1
    return best


def core_call(
    compliance: np.ndarray, gaps: np.ndarray, torque: float, *, method: int, warm: np.ndarray
) -> tuple:
    """The core alone, without the checks of the Python door."""
    levers = np.full((gaps.size, 1), ARM, order="F")
    return _core.flankload_solve_contact(
        compliance, gaps, levers, levers, np.array([torque]), 1, method, warm
    )


def paper_dgesv(compliance: np.ndarray, gaps: np.ndarray, torque: float) -> np.ndarray:
    """Fig. 6 as printed (with corrected (34)): (32) assembled and solved anew at every step."""
    n = gaps.size
    influence = compliance / ARM
    angles = gaps / ARM
    angles = angles - angles.min()
    pairs = [int(angles.argmin())]
    reduced = influence - influence[pairs[0]]
    while True:
        matrix = reduced[np.ix_(pairs, pairs)]
        matrix[0] = ARM
        right = -angles[pairs]
        right[0] = torque
        _, _, forces, info = dgesv(matrix, right)
        if info:
            raise ValueError("the equations (32) are singular")
        columns = influence[:, pairs] @ forces
        final = columns + angles - columns[pairs[0]]
        final[pairs] = 0.0
        joining = int(final.argmin())
        if final[joining] >= -1e-12 * np.abs(columns).max():
            result = np.zeros(n)
            result[pairs] = forces
            return result
        pairs.append(joining)


def limit(compliance: np.ndarray, gaps: np.ndarray, pairs: np.ndarray, torque: float) -> np.ndarray:
    """The practical limit L: the final set is known."""
    block = compliance[np.ix_(pairs, pairs)]
    factor, _ = dpotrf(block, lower=1, overwrite_a=1)
    right = np.empty((pairs.size, 2), order="F")
    right[:, 0] = ARM
    right[:, 1] = gaps[pairs]
    solution, _ = dpotrs(factor, right, lower=1, overwrite_b=1)
    v, u = solution.T
    rotation = (torque + ARM * u.sum()) / (ARM * v.sum())
    forces = rotation * v - u
    first, last = pairs[0], pairs[-1] + 1
    return compliance[:, first:last] @ forces + gaps - ARM * rotation


def measure(n: int) -> str:
    """One line of the table."""
    none = np.empty(0, dtype=np.int32)
    compliance, gaps, torque = hertz_problem(n)
    compliance = np.asfortranarray(compliance)
    levers = np.full(n, ARM)
    influence = np.asfortranarray(compliance / ARM)
    state = solve_contact(influence, levers, gaps / ARM, torque)
    pairs = state.active_pairs
    warm = (pairs + 1).astype(np.int32)
    forces = paper_dgesv(compliance, gaps, torque)
    if not np.allclose(forces, state.normal_forces, rtol=0, atol=1e-8 * forces.max()):
        raise ValueError("the paper's method and the loop disagree")
    single = best_time(lambda: core_call(compliance, gaps, torque, method=1, warm=none))
    from_warm = best_time(lambda: core_call(compliance, gaps, torque, method=1, warm=warm))
    python = best_time(lambda: solve_contact(influence, levers, gaps / ARM, torque))
    paper = best_time(lambda: core_call(compliance, gaps, torque, method=2, warm=none))
    dense = best_time(lambda: paper_dgesv(compliance, gaps, torque))
    bound = best_time(lambda: limit(compliance, gaps, pairs, torque))
    return (
        f"{n:5d} {pairs.size:4d} {1e3 * single:10.3f} {1e3 * from_warm:7.3f} "
        f"{1e3 * python:14.3f} {1e3 * paper:9.3f} {1e3 * dense:15.2f} {1e3 * bound:9.4f} "
        f"{dense / single:13.1f} {single / bound:9.1f} {from_warm / bound:7.1f} "
        f"{state.info.backward_error / np.finfo(float).eps:19.1f}"
    )


def run() -> str:
    """Table of times and ratios."""
    head = (
        "    n    k  single ms  (warm)  (with Python)  paper ms  paper+dgesv ms      L ms"
        "  dgesv/single  single/L  warm/L  backward error/eps"
    )
    return "\n".join([head, *(measure(n) for n in SIZES)])
