"""Fuzz of the contact loop: random problems, every result checked against its equations."""

from __future__ import annotations

import itertools
from collections.abc import Iterator

import numpy as np

import flankload as fl
from flankload import errors
from tests.support.random_problems import KINDS, Problem, Trial
from tests.support.tally import Tally

EPS = float(np.finfo(float).eps)
ROW_TOLERANCE = 10 * EPS
METHODS = ("auto", "single", "block", "load_path", "cascade", "primal")
#: Up to this number of pairs, an error is checked against all contact sets.
FEW_PAIRS = 9
#: Relative difference of forces (to the largest) up to which two states are equal.
SAME = 1e-6
#: Terms that are negligible relative to the largest, rows over sqrt(K_ii).
REMAINS = 1e-28
#: Minimum distance from a change of contact for a state found by trial.
CERTAIN = 1e-9


def fuzz_contact(seed: int, count: int) -> Tally:
    """Try `count` random problems; trial k of a seed uses ``default_rng([seed, k])``."""
    tally = Tally("contact problems")
    for k in range(count):
        rng = np.random.default_rng([seed, k])
        name = list(KINDS)[k % len(KINDS)]
        trial = KINDS[name](rng)
        method = METHODS[int(rng.integers(len(METHODS)))]
        warm = rng.permutation(trial.problem.gaps.size)[: int(rng.integers(0, 6))]
        tally.tried += 1
        try:
            found = faults(trial, method, warm if rng.random() < 0.3 else None)
        except Exception as error:
            tally.fault("traceback", f"seed {seed}, trial {k}, {name}, {method}: {error!r}")
            continue
        for fault in found[:1]:
            tally.fault("wrong", f"seed {seed}, trial {k}, {name}, {method}: {fault}")
    return tally


def faults(trial: Trial, method: str, warm: np.ndarray | None) -> list[str]:
    """The fault in the result of a problem."""
    problem = trial.problem
    try:
        state = solve(problem, method, warm)
    except (errors.NoContactState, errors.PivotLimit, errors.SingularContact) as error:
        return faults_of_refusal(trial, method, error)
    found = faults_of_state(problem, state)
    if state.info.unique and not found and problem.gaps.size < 40:
        found = faults_of_uniqueness(problem, state, method)
    return found


def solve(problem: Problem, method: str, warm: np.ndarray | None = None) -> fl.ContactState:
    """Solve through the Python interface."""
    return fl.solve_contact_general(
        problem.compliance,
        problem.gaps,
        problem.motions,
        problem.loads,
        load_rows=problem.load_rows,
        method=method,
        warm_pairs=warm,
    )


def faults_of_state(problem: Problem, state: fl.ContactState) -> list[str]:
    """Rows, loads and signs of a state, and the reported status."""
    lacking = backward_error(problem, state.normal_forces, state.motions)
    said = state.info.backward_error
    wrong = {
        "a force or a gap is negative": state.normal_forces.min() < 0
        or state.final_gap_angles.min() < 0,
        f"status 0 with a backward error of {lacking:.1e}": state.status == 0
        and not lacking <= ROW_TOLERANCE,
        f"status {state.status} with {said:.1e}": state.status != 1 and not said <= ROW_TOLERANCE,
        f"backward error {lacking:.1e}, said {said:.1e}": not lacking
        <= max(ROW_TOLERANCE, 2 * said),
        "a gap that is none of these forces": not gaps_agree(problem, state),
    }
    return [what for what, there in wrong.items() if there]


def backward_error(problem: Problem, forces: np.ndarray, motions: np.ndarray) -> float:
    """Largest residual of a row or load, relative to the sum of its terms, in extended precision.

    Terms below `REMAINS` of the largest of their kind are rounding of rounding: a row with no other
    terms would have a residual of its full size.
    """
    gap, size = rows_of(problem, forces, motions)
    root = np.sqrt(problem.compliance.diagonal())
    size = np.maximum(size, REMAINS * root * (size / root).max())
    wrong = np.where(forces > 0, np.abs(gap), np.maximum(-gap, 0))
    terms = problem.load_rows.T.astype(np.longdouble) * forces
    lack = np.abs(terms.sum(axis=1) - problem.loads)
    of = np.abs(terms).sum(axis=1) + np.abs(problem.loads)
    parts = np.concatenate([wrong, lack]), np.concatenate([size, of])
    return float(np.max(parts[0] / np.maximum(parts[1], np.finfo(float).tiny)))


def rows_of(
    problem: Problem, forces: np.ndarray, motions: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Gaps and the sums of the magnitudes of their terms."""
    pressed = problem.compliance.astype(np.longdouble) * forces
    moved = problem.motions.astype(np.longdouble) * motions
    gap = pressed.sum(axis=1) + problem.gaps - moved.sum(axis=1)
    size = np.abs(pressed).sum(axis=1) + np.abs(problem.gaps) + np.abs(moved).sum(axis=1)
    return gap, size


def gaps_agree(problem: Problem, state: fl.ContactState) -> bool:
    """Whether the returned gaps are those of the returned forces and motions.

    A motion has only the digits that the largest rows give it: a closed gap is still zero.
    """
    gap, size = rows_of(problem, state.normal_forces, state.motions)
    root = np.sqrt(problem.compliance.diagonal())
    allowed = max(100 * EPS, 2 * state.info.backward_error) * size
    allowed = allowed + EPS * root * (size / root).max()
    return bool((np.abs(np.maximum(gap, 0) - state.final_gap_angles) <= allowed).all())


def faults_of_uniqueness(problem: Problem, state: fl.ContactState, method: str) -> list[str]:
    """Another method with another state disproves uniqueness, except for effects of rounding."""
    if state.status != 0:
        return []
    other = next(name for name in ("load_path", "single") if name != method)
    try:
        second = solve(problem, other)
    except errors.ContactError:
        return []
    if second.status != 0:
        return []
    root = np.sqrt(problem.compliance.diagonal())
    apart = np.abs(root * (state.normal_forces - second.normal_forces)).max()
    largest = (root * state.normal_forces).max()
    if apart > SAME * max(largest, np.abs(problem.gaps / root).max()):
        return [f"called unique, {other} finds another state, {apart / largest:.1e} away"]
    return []


def faults_of_refusal(trial: Trial, method: str, error: errors.ContactError) -> list[str]:
    """An error is wrong if a state exists: known, found by another method or by brute force."""
    problem = trial.problem
    name = type(error).__name__
    if getattr(error, "proven", False):
        name += " (proven)"
    if trial.exists:
        return [f"{name}, but a state exists"]
    for other in METHODS:
        if other == method:
            continue
        try:
            state = solve(problem, other)
        except errors.ContactError:
            continue
        if backward_error(problem, state.normal_forces, state.motions) <= ROW_TOLERANCE:
            return [f"{name}, but {other} finds a state"]
    if problem.gaps.size <= FEW_PAIRS and any(True for _ in certain_states(problem)):
        return [f"{name}, but brute force finds a state"]
    return []


def certain_states(problem: Problem) -> Iterator[np.ndarray]:
    """Forces of the states found by trying all contact sets, far from any change.

    Forces that only rounding tells from zero are no such states: without loads, no pair may carry.
    """
    n, q = problem.motions.shape
    least = CERTAIN * np.abs(problem.gaps / problem.compliance.diagonal()).max()
    for size in range(q, n + 1):
        for pairs in map(list, itertools.combinations(range(n), size)):
            matrix = np.block(
                [
                    [problem.compliance[np.ix_(pairs, pairs)], -problem.motions[pairs]],
                    [problem.load_rows[pairs].T, np.zeros((q, q))],
                ]
            )
            if not np.linalg.cond(matrix) < 1e10:
                continue
            solution = np.linalg.solve(matrix, np.r_[-problem.gaps[pairs], problem.loads])
            forces = np.zeros(n)
            forces[pairs] = solution[:size]
            gap, terms = rows_of(problem, forces, solution[size:])
            others = np.delete(np.arange(n), pairs)
            if (
                forces[pairs].min() > max(least, CERTAIN * np.abs(forces).max())
                and (gap[others] > CERTAIN * terms[others]).all()
            ):
                yield forces
