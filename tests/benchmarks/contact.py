"""The contact loop against the practical limit L, the paper's method, and packages.

L is what the final state alone costs in compiled code: one factorisation of the pairs in contact,
two right-hand sides, one gap check. Everything runs on one thread, one after another, so that the
ratios of one run can be compared; times are the best of several runs.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from flankload import ContactState, solve_contact, solve_contact_general
from tests.benchmarks._core import CoreTimes, core_times
from tests.benchmarks._packages import PACKAGES
from tests.benchmarks._rivals import Measured, least_ratio, measure_packages, number, table
from tests.support.cylinder_problem import Problem, Vector, cylinder, residual

SIZES = (100, 400, 1600)
FRICTIONS = (0.0, 0.1)

OURS = """\
A cylinder on a half-plane: n pairs, k of them in contact, friction mu. Times in ms.
  L        one factorisation of the k pairs, two right-hand sides, one gap check
  bare     our loop without its certificate; auto: with it, K known to be positive definite
  proven   auto, uniqueness proven from all of K; warm: auto begun with the final pairs
  single   one pair at a time
  angles   solve_contact called from Python, one row scale for all pairs; scaled: row scales that
           differ, so that diag(b) A has to be made; general: solve_contact_general"""
OVER_LIMIT = """\
The same over L; the largest error of a row on its own scale."""
PAPER = """\
The paper's growing loop, compiled and without a certificate: ms, and over ours.
  kept     with a factor that is bordered from step to step
  dgesv    as printed, (32) solved anew at every step"""
PACKAGE = """\
Packages, mu = {:g}: ms, over auto, largest error of a row on its own scale (the same measure for
all; "!" where it exceeds 1e-9, which does not count)."""
TIMED = "Timed of each is the call that solves, not what sets its data up:"
WANTED = "What is wanted, and what this run has measured: mu = {:g}, then mu = {:g}."


@dataclass(frozen=True)
class Row:
    """Measured values of one problem solved by the core; times in ms."""

    friction: float
    core: CoreTimes
    angles: float
    scaled: float
    general: float
    residual: float

    @property
    def ours(self) -> Measured:
        """The core's answer in the form of those of packages."""
        return Measured(self.core.auto, self.residual)


Columns = Mapping[str, Callable[[Row], float]]

TIMES: Columns = {
    "L": lambda row: row.core.limit,
    "bare": lambda row: row.core.bare,
    "auto": lambda row: row.core.auto,
    "proven": lambda row: row.core.proven,
    "warm": lambda row: row.core.warm,
    "single": lambda row: row.core.single,
    "angles": lambda row: row.angles,
    "scaled": lambda row: row.scaled,
    "general": lambda row: row.general,
}
RATIOS: Columns = {
    "bare/L": lambda row: row.core.bare / row.core.limit,
    "auto/L": lambda row: row.core.auto / row.core.limit,
    "proven/L": lambda row: row.core.proven / row.core.limit,
    "warm/L": lambda row: row.core.warm / row.core.limit,
    "single/L": lambda row: row.core.single / row.core.limit,
    "angles/L": lambda row: row.angles / row.core.limit,
    "scaled/L": lambda row: row.scaled / row.core.limit,
    "general/L": lambda row: row.general / row.core.limit,
    "error": lambda row: row.residual,
}
PAPERS: Columns = {
    "kept": lambda row: row.core.bordered,
    "dgesv": lambda row: row.core.dgesv,
    "kept/bare": lambda row: row.core.bordered / row.core.bare,
    "dgesv/bare": lambda row: row.core.dgesv / row.core.bare,
    "kept/auto": lambda row: row.core.bordered / row.core.auto,
    "dgesv/auto": lambda row: row.core.dgesv / row.core.auto,
}
#: What is wanted where: number of pairs, what, at most or at least, limit.
LIMITS = (
    (400, "bare/L", "<=", 3.0),
    (400, "auto/L", "<=", 5.0),
    (400, "angles/L", "<=", 4.0),
    (400, "general/L", "<=", 4.0),
    (400, "kept/auto", ">=", 3.0),
    (400, "dgesv/auto", ">=", 12.0),
    (1600, "bare/L", "<=", 2.0),
    (1600, "auto/L", "<=", 3.0),
    (1600, "angles/L", "<=", 3.0),
    (1600, "general/L", "<=", 3.0),
    (1600, "kept/auto", ">=", 10.0),
    (1600, "dgesv/auto", ">=", 80.0),
    (100, "package/auto", ">=", 4.0),
    (400, "package/auto", ">=", 25.0),
    (1600, "package/auto", ">=", 400.0),
)


def best_ms(call: Callable[[], object], seconds: float = 0.6) -> float:
    """Shortest of several runs [ms]."""
    best = np.inf
    end = time.perf_counter() + seconds
    runs = 0
    while runs < 3 or time.perf_counter() < end:
        start = time.perf_counter()
        call()
        best = min(best, time.perf_counter() - start)
        runs += 1
    return 1e3 * best


def measure(friction: float, problem: Problem, core: CoreTimes) -> Row:
    """Add what Python sees to the core times of a problem."""
    n = problem.gaps.size

    def angle_form(levers: Vector) -> Callable[[], ContactState]:
        influence = np.asfortranarray(problem.compliance / levers[:, None])
        angles = problem.gaps / levers
        return lambda: solve_contact(
            influence,
            problem.row,
            angles,
            problem.torque,
            normal_lever_arms=levers,
            positive_definite=True,
        )

    def call_general() -> ContactState:
        return solve_contact_general(
            problem.compliance,
            problem.gaps,
            problem.levers,
            problem.torque,
            load_rows=problem.row,
            positive_definite=True,
        )

    state = call_general()
    exact = residual(problem, state.normal_forces, state.rotation)
    unlike = problem.levers * np.linspace(0.99, 1.01, n)
    calls = (angle_form(problem.levers), angle_form(unlike), call_general)
    angles, scaled, general = best_of_rounds(calls)
    return Row(friction, core, angles, scaled, general, exact)


def best_of_rounds(calls: Sequence[Callable[[], object]], rounds: int = 3) -> list[float]:
    """Shortest time of each call [ms]: what disturbs the machine for a while spoils none."""
    return np.min([[best_ms(call, 0.3) for call in calls] for _ in range(rounds)], axis=0).tolist()


def lines(heading: str, columns: Columns, rows: Sequence[Row]) -> str:
    """A table with one line for each problem."""
    head = " mu     n    k" + "".join(f"{name:>13s}" for name in columns)
    return "\n".join([heading, head, *(line(columns, row) for row in rows)])


def line(columns: Columns, row: Row) -> str:
    """One line of a table."""
    start = f"{row.friction:3.1f} {row.core.n:5d} {row.core.k:4d}"
    return start + "".join(f"{number(value(row)):>13s}" for value in columns.values())


def wanted(rows: Sequence[Row], packages: Mapping[tuple[float, int], float]) -> str:
    """Wanted figures beside the measured ones."""
    text = [WANTED.format(*FRICTIONS)]
    known = {**RATIOS, **PAPERS}
    for n, what, sense, limit in LIMITS:
        found = [
            packages[row.friction, n] if what == "package/auto" else known[what](row)
            for row in rows
            if row.core.n == n
        ]
        missed = [value > limit if sense == "<=" else value < limit for value in found]
        parts = "".join(
            f"{number(value):>10s} {'missed' if miss else '':6s}"
            for value, miss in zip(found, missed, strict=True)
        )
        text.append(f"  n = {n:4d}  {what:13s} {sense} {limit:4g}  {parts}".rstrip())
    return "\n".join(text)


def package_tables(rows: Sequence[Row], problems: Sequence[Problem]) -> tuple[list[str], dict]:
    """Tables of the packages, and how much faster ours is than the fastest that counts."""
    text = []
    faster = {}
    sizes = "".join(f"{f'n = {n}':>27s}" for n in SIZES)
    for friction in FRICTIONS:
        chosen = [i for i, row in enumerate(rows) if row.friction == friction]
        ours = [rows[i].ours for i in chosen]
        measured = measure_packages([problems[i] for i in chosen])
        text.append(f"{PACKAGE.format(friction)}\n{'':18s}{sizes}\n{table(measured, ours)}")
        for place, i in enumerate(chosen):
            faster[friction, rows[i].core.n] = least_ratio(measured, ours, place)
    text.append("\n".join([TIMED, *(f"  {p.name:10s} {p.timed}" for p in PACKAGES)]))
    return text, faster


def run() -> str:
    """Tables of times and ratios, then what is wanted beside them."""
    cases = [(friction, n) for friction in FRICTIONS for n in SIZES]
    problems = [cylinder(n, friction) for friction, n in cases]
    rows = [
        measure(friction, problem, core_times([problem])[0])
        for (friction, _), problem in zip(cases, problems, strict=True)
    ]
    tables = [
        lines(OURS, TIMES, rows),
        lines(OVER_LIMIT, RATIOS, rows),
        lines(PAPER, PAPERS, rows),
    ]
    packages, faster = package_tables(rows, problems)
    return "\n\n".join([*tables, *packages, wanted(rows, faster)])
