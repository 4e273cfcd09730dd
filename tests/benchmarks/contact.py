"""The contact loop against the paper's method and against the practical limit L.

L is what the final state alone costs in compiled code: one Cholesky factorisation of the pairs in
contact, two right-hand sides, one gap check. `auto` carries its certificate, the matrix known to be
positive definite; `proven` factors the whole matrix for it. The paper's method is measured with its
kept factor (compiled) and as printed, (32) solved anew at every step (LAPACK's dgesv from Python).
All on one thread; best of several runs; core times but for the columns of Python and dgesv.
"""

from __future__ import annotations

import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from scipy.linalg.lapack import dgesv

from flankload import solve_contact

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
    force = 0.69 * np.pi * half_width**2 * curvature / (8.0 * kernel)
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


def core_times() -> dict[int, list[float]]:
    """Core times [ms] by number of pairs, from the compiled bench.

    Pairs in contact; L, auto (matrix known to be definite), auto (uniqueness proven), single, auto
    from the final set, paper.
    """
    folder = Path("build")
    ninja = Path(sys.executable).parent / "ninja"
    subprocess.run(
        [ninja, "-C", folder, "tests/fortran/bench_contact"], check=True, capture_output=True
    )
    output = subprocess.run(
        [folder / "tests/fortran/bench_contact"], check=True, capture_output=True, text=True
    ).stdout
    rows = [line.split() for line in output.splitlines() if not line.startswith("#")]
    return {int(row[0]): [float(part) for part in row[1:]] for row in rows}


def measure(n: int, core: list[float]) -> str:
    """One line of the table."""
    compliance, gaps, torque = hertz_problem(n)
    levers = np.full(n, ARM)
    influence = np.asfortranarray(compliance / ARM)
    state = solve_contact(influence, levers, gaps / ARM, torque)
    forces = paper_dgesv(compliance, gaps, torque)
    if not np.allclose(forces, state.normal_forces, rtol=0, atol=1e-8 * forces.max()):
        raise ValueError("the paper's method and the loop disagree")
    k, bound, fast, proven, single, warm, paper = core
    python = 1e3 * best_time(
        lambda: solve_contact(influence, levers, gaps / ARM, torque, positive_definite=True)
    )
    dense = 1e3 * best_time(lambda: paper_dgesv(compliance, gaps, torque))
    return (
        f"{n:5d} {int(k):4d} {bound:8.4f} {fast:8.4f} {fast / bound:7.1f} {warm / bound:7.1f} "
        f"{proven / bound:7.1f} {single / bound:9.1f} {paper / fast:11.1f} {dense / fast:11.1f} "
        f"{python:9.3f} {state.info.backward_error / np.finfo(float).eps:8.1f}"
    )


def run() -> str:
    """Table of times and ratios."""
    head = (
        "    n    k     L ms  auto ms  auto/L  warm/L proven/L single/L  paper/auto"
        "  dgesv/auto Python ms  error/eps"
    )
    core = core_times()
    return "\n".join([head, *(measure(n, core[n]) for n in sorted(core))])
