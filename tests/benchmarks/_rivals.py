"""Other packages on the problems of the benchmark: time, ratio to the core's, accuracy."""

from __future__ import annotations

import importlib
import time
from collections.abc import Sequence
from dataclasses import dataclass
from importlib.metadata import version

import numpy as np

from tests.benchmarks._packages import PACKAGES, Found, Package, Scaled, scale
from tests.support.cylinder_problem import Problem, residual

#: An answer counts up to this error of a row.
EXACT_ENOUGH = 1e-9
#: Runs of one problem end after this long [s].
BUDGET_S = 2.0
#: A size is left out where the size before, times the cube of their ratio, takes longer [s].
PATIENCE_S = 60.0


@dataclass(frozen=True)
class Measured:
    """Measured values of a package on one problem.

    Attributes
    ----------
    ms : float
        Shortest time [ms]; NaN where there is none.
    residual : float
        Largest error of a row.
    remark : str
        Why there is no time.
    """

    ms: float = np.nan
    residual: float = np.inf
    remark: str = ""

    @property
    def counts(self) -> bool:
        """The answer is exact enough to be compared."""
        return self.residual <= EXACT_ENOUGH


def measure_packages(problems: Sequence[Problem]) -> dict[str, list[Measured]]:
    """Let every package solve the problems, small ones first.

    Parameters
    ----------
    problems : sequence of Problem
        In ascending size.

    Returns
    -------
    dict
        For each package, by name and version, one answer for each problem.
    """
    return {name_of(package): measure_package(package, problems) for package in PACKAGES}


def name_of(package: Package) -> str:
    """Name and version of a package."""
    return f"{package.name} {version(package.name)}" if is_installed(package) else package.name


def is_installed(package: Package) -> bool:
    """Whether a package can be imported."""
    try:
        importlib.import_module(package.module)
    except ImportError:
        return False
    return True


def measure_package(package: Package, problems: Sequence[Problem]) -> list[Measured]:
    """One answer of a package for each problem."""
    if not is_installed(package):
        return [Measured(remark="not installed")] * len(problems)
    found: list[Measured] = []
    before, size_before = 0.0, 1
    for problem in problems:
        size = problem.gaps.size
        scaled = scale(problem)
        if not (scaled.symmetric or package.friction):
            found.append(Measured(remark="-"))
            continue
        if before * (size / size_before) ** 3 > PATIENCE_S:
            found.append(Measured(remark="too slow"))
            continue
        try:
            forces, before = shortest(package, scaled)
        except Exception as error:  # whatever a package raises is its answer
            found.append(Measured(remark=type(error).__name__))
            continue
        size_before = size
        found.append(Measured(1e3 * before, residual(problem, scaled.unit * forces)))
    return found


def shortest(package: Package, scaled: Scaled) -> Found:
    """Forces and the shortest time of several runs; the first one warms up if time allows more."""
    end = time.perf_counter() + BUDGET_S
    forces, first = package.solve(scaled)
    best = np.inf
    while time.perf_counter() < end:
        forces, seconds = package.solve(scaled)
        best = min(best, seconds)
    return forces, best if np.isfinite(best) else first


def table(measured: dict[str, list[Measured]], ours: Sequence[Measured]) -> str:
    """Lines of a table, for each size: time, ratio to ours, residual, a mark if it is too large."""
    lines = [line_of("flankload, auto", ours, ours)]
    lines += [line_of(name, answers, ours) for name, answers in measured.items()]
    return "\n".join(lines)


def line_of(name: str, answers: Sequence[Measured], ours: Sequence[Measured]) -> str:
    """One line of the table."""
    cells = "".join(cell(a, o) for a, o in zip(answers, ours, strict=True))
    return f"{name:18s}{cells}".rstrip()


def cell(answer: Measured, ours: Measured) -> str:
    """The part of a line that belongs to one size, 27 columns."""
    if answer.remark:
        return f"{answer.remark:>27s}"
    mark = " " if answer.counts else "!"
    ratio = number(answer.ms / ours.ms)
    return f"{number(answer.ms):>10s} {ratio:>7s} {answer.residual:7.0e}{mark}"


def number(value: float) -> str:
    """Four digits, of large numbers all before the point; "-" where there is no number."""
    if not np.isfinite(value):
        return "-"
    return f"{value:.4g}" if abs(value) < 1e4 else f"{value:.0f}"


def least_ratio(measured: dict[str, list[Measured]], ours: Sequence[Measured], i: int) -> float:
    """Time of the fastest package that counts over ours, for problem i; NaN if none does."""
    times = [answers[i].ms for answers in measured.values() if answers[i].counts]
    return min(times, default=np.nan) / ours[i].ms
