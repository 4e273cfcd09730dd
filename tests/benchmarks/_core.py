"""Core times of the contact loop, from the compiled bench (tests/fortran/bench_contact.f90)."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from tests.support.cylinder_problem import Problem
from tests.support.paths import BUILD

TARGET = "tests/fortran/bench_contact"


@dataclass(frozen=True)
class CoreTimes:
    """Shortest times of one problem [ms]; NaN where a way fails or ends with other forces.

    Attributes
    ----------
    n, k : int
        Pairs, and how many of them are in contact.
    limit : float
        L: one factorisation of the pairs in contact, two right-hand sides, one gap check.
    bare, auto, proven : float
        Our loop without a certificate; with it, the matrix known to be definite; with uniqueness
        proven from the whole matrix.
    single, warm : float
        One pair at a time; `auto` begun with the final pairs.
    bordered, dgesv : float
        The paper's loop without a certificate: with its kept factor; (32) solved anew every step.
    """

    n: int
    k: int
    limit: float
    bare: float
    auto: float
    proven: float
    single: float
    warm: float
    bordered: float
    dgesv: float


def core_times(problems: Sequence[Problem]) -> list[CoreTimes]:
    """Build the compiled bench and let it solve the problems."""
    ninja = Path(sys.executable).parent / "ninja"
    subprocess.run([ninja, "-C", BUILD, TARGET], check=True, capture_output=True)
    with TemporaryDirectory() as folder:
        paths = [Path(folder) / str(i) for i in range(len(problems))]
        for path, problem in zip(paths, problems, strict=True):
            write_problem(path, problem)
        output = subprocess.run(
            [BUILD / TARGET, *paths], check=True, capture_output=True, text=True
        ).stdout
    rows = [line.split() for line in output.splitlines()]
    return [
        CoreTimes(int(n), int(k), *(float(ms) if float(ms) > 0.0 else np.nan for ms in times))
        for n, k, *times in rows
    ]


def write_problem(path: Path, problem: Problem) -> None:
    """Write a problem as the compiled bench reads it: n, M, K by columns, g0, b, m."""
    parts = (problem.compliance.ravel(order="F"), problem.gaps, problem.levers, problem.row)
    with path.open("wb") as file:
        file.write(np.int32(problem.gaps.size).tobytes())
        file.write(np.concatenate([[problem.torque], *parts]).tobytes())
