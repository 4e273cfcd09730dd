"""Matrices without structure: a state, the proof that there is none, or it is open."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

import flankload as fl
from flankload import errors
from tests.support.contact_problems import brute_force
from tests.support.tolerances import SOLVER

EPS = float(np.finfo(float).eps)
METHODS = ["auto", "single", "block", "load_path"]
Problem = tuple[np.ndarray, np.ndarray, np.ndarray]


def without_structure(rng: np.random.Generator, fewest: int, most: int) -> Problem:
    """Matrix, torque row of both signs and gaps, at least one lever above zero."""
    n = int(rng.integers(fewest, most + 1))
    matrix = rng.standard_normal((n, n))
    matrix[np.diag_indices(n)] = rng.uniform(0.2, 1.5, n)
    row = rng.uniform(-0.5, 1.0, n)
    row[0] = abs(row[0])
    return matrix, row, rng.uniform(0.0, 1.0, n)


def jamming(n: int) -> Problem:
    """Pair 1 turns back more than pair 0 holds once it touches; the others do so much later."""
    matrix = np.eye(n)
    matrix[:2, :2] = [[1.0, 1.5], [0.5, 1.0]]
    row = np.full(n, -1.0)
    row[0] = 1.0
    gaps = np.full(n, 1e3)
    gaps[:2] = [0.0, 0.2]
    return matrix, row, gaps


def solve(problem: Problem, method: str) -> fl.ContactState:
    matrix, row, gaps = problem
    return fl.solve_contact(
        matrix, row, gaps, 1.0, normal_lever_arms=np.ones(gaps.size), method=method
    )


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(
    ("fewest", "most", "number", "least_solved", "least_none"),
    [(2, 6, 300, 200, 30), (7, 12, 150, 100, 5)],
)
def test_a_state_or_the_proof_that_there_is_none(
    method: str, fewest: int, most: int, number: int, least_solved: int, least_none: int
) -> None:
    rng = np.random.default_rng(5)
    solved = none = proven = missed = 0
    for _ in range(number):
        matrix, row, gaps = problem = without_structure(rng, fewest, most)
        try:
            state = solve(problem, method)
        except errors.NoContactState as error:
            none += 1
            proven += error.proven
            missed += len(brute_force(matrix, gaps, np.ones(gaps.size), row, 1.0))
            continue
        solved += 1
        forces = state.normal_forces
        final = matrix @ forces + gaps - state.rotation
        size = np.abs(matrix) @ forces + gaps + abs(state.rotation)
        assert (forces >= 0).all()
        assert (final >= -20 * EPS * size).all()
        assert (np.abs(final) <= 20 * EPS * size)[forces > 0].all()
        assert abs(row @ forces - 1.0) <= 20 * EPS * (np.abs(row) @ forces + 1.0)
        assert state.info.backward_error <= 10 * EPS
    assert solved >= least_solved
    assert proven == none >= least_none
    assert missed == 0


def test_fourteen_pairs() -> None:
    rng = np.random.default_rng(14)
    none = proven = missed = 0
    for _ in range(60):
        matrix, row, gaps = problem = without_structure(rng, 13, 14)
        try:
            assert solve(problem, "load_path").info.backward_error <= 10 * EPS
        except errors.NoContactState as error:
            none += 1
            proven += error.proven
            missed += len(brute_force(matrix, gaps, np.ones(gaps.size), row, 1.0))
    assert proven == none >= 2
    assert missed == 0


def all_states(
    compliance: np.ndarray,
    gaps: np.ndarray,
    motions: np.ndarray,
    rows: np.ndarray,
    loads: np.ndarray,
) -> list[np.ndarray]:
    """Forces of every state with several motions, by trying all contact sets."""
    n, q = motions.shape
    states = []
    for size in range(q, n + 1):
        sets = np.array(list(itertools.combinations(range(n), size)))
        matrices = np.zeros((len(sets), size + q, size + q))
        matrices[:, :size, :size] = compliance[sets[:, :, None], sets[:, None, :]]
        matrices[:, :size, size:] = -motions[sets]
        matrices[:, size:, :size] = rows[sets].transpose(0, 2, 1)
        right = np.concatenate([-gaps[sets], np.tile(loads, (len(sets), 1))], axis=1)
        solutions = np.linalg.solve(matrices, right[..., None])[..., 0]
        for k in np.flatnonzero((solutions[:, :size] >= 0.0).all(axis=1)):
            pairs, solution = sets[k], solutions[k]
            forces = np.zeros(n)
            forces[pairs] = solution[:size]
            final = compliance @ forces + gaps - motions @ solution[size:]
            final[pairs] = 0.0
            if (final >= 0.0).all():
                states.append(forces)
    return states


@pytest.mark.parametrize("method", ["auto", "load_path"])
def test_several_motions(method: str) -> None:
    """Levers of both signs, overlap at the start, load rows that differ from the motions."""
    rng = np.random.default_rng(3)
    solved = none = proven = missed = 0
    for _ in range(200):
        q = int(rng.integers(1, 4))
        n = int(rng.integers(q + 1, 8))
        compliance, _, _ = without_structure(rng, n, n)
        motions = rng.standard_normal((n, q))
        rows = motions + 0.3 * rng.standard_normal((n, q))
        loads = rows.T @ np.abs(rng.standard_normal(n))
        gaps = rng.uniform(-0.3, 1.0, n)
        states = all_states(compliance, gaps, motions, rows, loads)
        try:
            state = fl.solve_contact_general(
                compliance, gaps, motions, loads, load_rows=rows, method=method
            )
        except errors.NoContactState as error:
            none += 1
            proven += error.proven
            missed += len(states)
            continue
        solved += 1
        distances = [np.abs(forces - state.normal_forces).max() for forces in states]
        assert min(distances) <= SOLVER * state.normal_forces.max()
        assert state.info.backward_error <= 10 * EPS
    assert solved >= 150
    assert proven == none >= 10
    assert missed == 0


@pytest.mark.parametrize("method", METHODS)
def test_two_pairs_without_a_state_are_proven(method: str) -> None:
    matrix = np.array([[2.0, 1.0], [1.0, 1.5]])
    with pytest.raises(
        errors.NoContactState, match="no contact state is in equilibrium with these loads"
    ) as caught:
        solve((matrix, np.array([1.0, -1.0]), np.zeros(2)), method)
    assert caught.value.proven


def test_loads_that_no_forces_hold_are_proven() -> None:
    with pytest.raises(errors.NoContactState) as caught:
        fl.solve_contact_general(np.eye(3), np.zeros(3), np.ones(3), -1.0)
    assert caught.value.proven


@pytest.mark.parametrize(("n", "proven"), [(2, True), (40, True), (300, False)])
def test_an_unproven_answer_is_called_open(n: int, proven: bool) -> None:
    """The same jammed problem in two sizes; for 300 pairs the proof would take too long."""
    found = "is in equilibrium with these loads" if proven else "was found; that none exists"
    message = f"no contact state {found}"
    with pytest.raises(errors.NoContactState, match=message) as caught:
        solve(jamming(n), "auto")
    assert caught.value.proven == proven
    np.testing.assert_allclose(caught.value.largest_torque, 0.4, rtol=1e-9, atol=0)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("seed", range(3))
def test_loops_that_would_go_in_circles_step_down_early(seed: int, method: str) -> None:
    n = 60
    rng = np.random.default_rng(seed)
    root = rng.standard_normal((n, n))
    state = solve((root - root.T + 1e-8 * np.eye(n), np.ones(n), rng.uniform(0, 1, n)), method)
    assert state.info.rung == "load_path"
    assert state.info.backward_error <= 10 * EPS
    # One at a time goes in circles here; it used to take 20 pivots a pair to say so.
    assert state.info.pivots <= 8 * n


@pytest.mark.parametrize("method", METHODS)
def test_a_symmetric_matrix_that_is_not_definite_among_its_pairs(method: str) -> None:
    matrix = np.array(
        [
            [3.0, -4.0, -4.0, -3.0, -3.0],
            [-4.0, 4.0, -3.0, -1.0, -1.0],
            [-4.0, -3.0, 2.0, 1.0, 4.0],
            [-3.0, -1.0, 1.0, 1.0, 5.0],
            [-3.0, -1.0, 4.0, 5.0, 1.0],
        ]
    )
    state = fl.solve_contact_general(
        matrix, [1.0, 0.0, 2.0, 1.0, 0.0], [1.0, 1.0, 2.0, 2.0, 1.0], 1.0, method=method
    )
    np.testing.assert_allclose(
        state.normal_forces, np.array([19.0, 17.0, 0.0, 0.0, 33.0]) / 69.0, rtol=SOLVER, atol=SOLVER
    )


def test_a_pair_that_leaves_singular_pairs_behind() -> None:
    matrix = [[2, 0, 4, 1], [1, 2, 4, 0], [1, 2, 2, 3], [2, 2, 1, 3]]
    motions = np.array([[3.0, -4.0], [4.0, 0.0], [4.0, 3.0], [3.0, 4.0]])
    state = fl.solve_contact_general(matrix, [1.0, 6.0, 5.0, 1.0], motions, [2.0, 1.0])
    assert state.info.backward_error <= 10 * EPS
    np.testing.assert_allclose(state.normal_forces @ motions, [2.0, 1.0], rtol=SOLVER)
