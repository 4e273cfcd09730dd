"""Statements about a problem hold: proofs beyond rounding, status 0 with rows met, states found."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import flankload as fl
from tests.support import contact_fuzz
from tests.support.contact_fuzz import METHODS, faults, fuzz_contact
from tests.support.oracle import EPS, Problem, judge_problem
from tests.support.random_problems import (
    KINDS,
    Trial,
    decades,
    narrow_cones,
    nearly_dependent,
)

DATA = Path(__file__).parent / "data"
ROW_TOLERANCE = 10 * EPS


def stored(name: str) -> Problem:
    """A stored problem with all its digits."""
    with np.load(DATA / f"{name}.npz") as file:
        return Problem(*(file[key] for key in ("K", "g0", "B", "R", "Q")))


def solve_and_judge(problem: Problem, method: str) -> fl.ContactState:
    """The state; its rows and its set of pairs hold in 60 digits."""
    state = contact_fuzz.solve(problem, method)
    verdict = judge_problem(problem, state)
    assert verdict.backward_error <= ROW_TOLERANCE
    assert verdict.exact_violation <= ROW_TOLERANCE
    return state


@pytest.mark.parametrize("method", METHODS)
def test_a_search_that_ran_out_of_work_proves_nothing(method: str) -> None:
    """70 pairs with friction and three motions: the last case that was looked at had no state, and
    those that were not counted as none."""
    solve_and_judge(stored("proven_but_exists"), method)


@pytest.mark.parametrize("method", METHODS)
def test_status_0_means_rows_met_to_rounding(method: str) -> None:
    """A turn and a shift on which nearly the same pairs work: the loads were off by 2e-9."""
    state = solve_and_judge(stored("loose_state"), method)
    assert state.status == 0
    assert state.info.backward_error <= ROW_TOLERANCE


def opposed(rng: np.random.Generator) -> Problem:
    """Two pairs that open others, but for 1e-14 … 1e-11, as much as their twins close them."""
    n = int(rng.integers(3, 7))
    matrix = rng.standard_normal((n, n))
    matrix[np.diag_indices(n)] = rng.uniform(0.2, 1.5, n)
    row, gaps = rng.uniform(-0.5, 1.0, n), rng.uniform(0.0, 1.0, n)
    row[0] = abs(row[0])
    pairs = np.concatenate([np.arange(n), rng.integers(0, n, 2)])
    apart = 10.0 ** -rng.uniform(11, 14)
    matrix = matrix[np.ix_(pairs, pairs)]
    for twin in (n, n + 1):
        matrix[:, twin] = -matrix[:, pairs[twin]] * rng.choice([1, -1])
        matrix[:, twin] += apart * rng.standard_normal(n + 2)
    matrix[np.diag_indices(n + 2)] = np.abs(matrix.diagonal())
    row = row[pairs]
    row[n:] *= -1.0
    gaps = gaps[pairs] + np.concatenate([np.zeros(n), rng.uniform(0.0, 0.3, 2)])
    ones = np.ones((n + 2, 1))
    return Problem(matrix, gaps, ones, row[:, None], np.ones(1))


@pytest.mark.parametrize("seed", [249, 280, 1027, 1057, 1347])
def test_sums_of_rounding_prove_nothing(seed: int) -> None:
    """A state exists with forces of up to 1e14; in double precision the sum that should show that
    there is none was off by 1e-12 of its terms, which was let pass."""
    solve_and_judge(opposed(np.random.default_rng(seed)), "auto")


@pytest.mark.parametrize("method", METHODS)
def test_the_sign_of_a_sum_is_that_of_the_given_numbers(method: str) -> None:
    """By hand: with both pairs in contact the force of the second is 0.3/(K21 - K12), which is a
    state above zero and none below, as little as the difference may be."""
    ones, rows = np.ones((2, 1)), np.array([[1.0], [-1.0]])
    above, below = (
        Problem(
            np.array([[1.0, 0.5 - apart], [0.5, 1.0]]), np.array([0.0, 0.2]), ones, rows, np.ones(1)
        )
        for apart in (1e-14, -1e-14)
    )
    assert solve_and_judge(above, method).active_pairs.tolist() == [0, 1]
    with pytest.raises(fl.errors.NoContactState) as refusal:
        contact_fuzz.solve(below, method)
    assert refusal.value.proven


@pytest.mark.parametrize("method", METHODS)
def test_a_lever_of_rounding_holds_a_load(method: str) -> None:
    """Only the lever of 1e-13 acts on the second load, with a force of 100 that pair 2 balances.
    Regression: it was reported as proven that no forces hold the loads."""
    levers = np.array([[1.0, 0.0], [1.0, 1e-13], [-1.0, 0.0], [0.0, -1.0]])
    problem = Problem(np.eye(4) + 0.1, np.zeros(4), levers, levers, np.array([1.0, 1e-11]))
    state = solve_and_judge(problem, method)
    np.testing.assert_allclose(state.normal_forces, [0, 100, 99, 0], rtol=1e-12, atol=0)


@pytest.mark.parametrize(
    ("make", "seed"),
    [
        # The loads nearly along each other's rows: singular for all levels.
        (nearly_dependent, [1, 225]),
        # Loads of 1e-13 of those that close the gaps: the forces had no digits.
        (nearly_dependent, [2, 1165]),
        (nearly_dependent, [2, 4825]),
        (decades, [1, 763]),
        (decades, [2, 533]),
        (narrow_cones, [1, 5]),
        (narrow_cones, [1, 6]),
        (narrow_cones, [1, 11]),
        (narrow_cones, [22, 2558]),
    ],
)
def test_levers_far_apart_are_solved(make: Callable[..., Trial], seed: list[int]) -> None:
    """With positive definite K and feasible loads, a state exists for any levers."""
    problem = make(np.random.default_rng(seed)).problem
    for method in METHODS:
        solve_and_judge(problem, method)


@pytest.mark.parametrize("method", METHODS)
def test_torque_minus_zero_is_torque_zero(method: str) -> None:
    """Regression: it was refused as an unconstrained motion."""
    matrix = np.array([[2.0, 1.0], [1.0, 2.0]])
    for gaps in ([0.1, 0.2], [-0.3, 0.2]):
        plus, minus = (
            fl.solve_contact_general(matrix, gaps, [1.0, 1.0], load, method=method)
            for load in (0.0, -0.0)
        )
        np.testing.assert_array_equal(minus.normal_forces, plus.normal_forces)
        np.testing.assert_array_equal(minus.motions, plus.motions)
    assert fl.solve_contact(matrix, [1.0, 1.0], [0.1, 0.2], -0.0).rotation == 0.1


def test_the_fuzz_finds_nothing_in_a_few_problems_of_each_kind() -> None:
    count = 5 * len(KINDS)
    tally = fuzz_contact(5, count)
    assert str(tally) == f"contact problems: {count} tried, 0 wrong, 0 silent, 0 tracebacks"


def test_the_fuzz_notices_wrong_answers(monkeypatch: pytest.MonkeyPatch) -> None:
    """Wrong refusals, forces wrong by 1e-12, wrong uniqueness and other exceptions are detected."""
    root = np.array([[2.0, 1.0, 0.0], [1.0, 2.0, 1.0], [0.0, 1.0, 2.0]])
    ones = np.ones((3, 1))
    trial = Trial(Problem(root, np.array([0.0, 0.1, 0.0]), ones, ones, np.array([1.0])), True)
    solve = contact_fuzz.solve
    assert faults(trial, "auto", None) == []

    def spoilt(problem: Problem, method: str, warm: object = None) -> fl.ContactState:
        state = solve(problem, method, warm)
        forces = state.normal_forces * (1 + 1e-12)
        return fl.ContactState(**{**vars(state), "normal_forces": forces})

    def refused(problem: Problem, method: str, warm: object = None) -> fl.ContactState:
        raise fl.errors.PivotLimit("none")

    def other(problem: Problem, method: str, warm: object = None) -> fl.ContactState:
        state = solve(problem, method, warm)
        if method == "auto":
            return state
        return fl.ContactState(**{**vars(state), "normal_forces": 2 * state.normal_forces})

    for wrong, fault in ((spoilt, "backward error"), (refused, "exists"), (other, "unique")):
        monkeypatch.setattr(contact_fuzz, "solve", wrong)
        assert any(fault in found for found in faults(trial, "auto", None))
    monkeypatch.setattr(contact_fuzz, "solve", lambda *_: 1 / 0)
    assert fuzz_contact(5, 3).traceback == 3
