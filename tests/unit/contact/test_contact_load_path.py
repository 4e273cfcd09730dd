"""Method `load_path`: the last rung, also for matrices without any structure."""

from __future__ import annotations

import numpy as np
import pytest

import flankload as fl
from flankload import errors
from tests.support.contact_problems import brute_force, flank_problem, random_problem
from tests.support.tolerances import ROUND_OFF, SOLVER

EPS = float(np.finfo(float).eps)


@pytest.mark.parametrize("unsymmetric", [False, True])
def test_load_path_against_brute_force(unsymmetric: bool) -> None:
    rng = np.random.default_rng(60 + unsymmetric)
    for _ in range(100):
        matrix, row, levers, gaps, torque = random_problem(rng, unsymmetric=unsymmetric)
        state = fl.solve_contact(
            matrix, row, gaps, torque, normal_lever_arms=levers, method="load_path"
        )
        forces, rotation = brute_force(
            levers[:, None] * matrix, levers * gaps, levers, row, torque
        )[0]
        np.testing.assert_allclose(state.normal_forces, forces, rtol=0, atol=1e-12 * forces.max())
        np.testing.assert_allclose(state.rotation, rotation, rtol=1e-12, atol=0)
        assert state.info.rung == "load_path"
        assert state.info.backward_error <= 10 * EPS


def test_largest_torque_that_can_be_held() -> None:
    """Self-locking lost: pair 1 turns back more than pair 0 holds as soon as it touches."""
    matrix = np.array([[1.0, 1.5], [0.5, 1.0]])
    row = np.array([1.0, -1.0])
    gaps = np.array([0.0, 0.2])
    # Pair 0 alone: φ = M, gap of pair 1 = 0.5 M + 0.2 - M, closed at M = 0.4.
    assert fl.solve_contact(matrix, row, gaps, 0.39).active_pairs.tolist() == [0]
    with pytest.raises(errors.NoContactState) as caught:
        fl.solve_contact(matrix, row, gaps, 1.0)
    assert not brute_force(matrix, gaps, np.ones(2), row, 1.0)
    np.testing.assert_allclose(caught.value.largest_torque, 0.4, rtol=1e-9, atol=0)


def test_gaps_that_all_tie() -> None:
    n = 30
    place = np.linspace(0, 1, n)
    matrix = np.exp(-np.abs(place[:, None] - place)) + 0.1 * np.eye(n)
    path = fl.solve_contact(matrix, np.ones(n), np.zeros(n), 2.0, method="load_path")
    single = fl.solve_contact(matrix, np.ones(n), np.zeros(n), 2.0, method="single")
    np.testing.assert_allclose(
        path.normal_forces, single.normal_forces, rtol=0, atol=1e3 * ROUND_OFF
    )


def test_several_motions_and_preload_along_the_path() -> None:
    rng = np.random.default_rng(9)
    for _ in range(60):
        n, q = 10, int(rng.integers(1, 4))
        root = rng.standard_normal((n, n))
        compliance = root @ root.T / n + 1e-2 * np.eye(n)
        levers = rng.standard_normal((n, q))
        loads = levers.T @ np.abs(rng.standard_normal(n))
        gaps = rng.uniform(-0.2, 1.0, n)
        path = fl.solve_contact_general(compliance, gaps, levers, loads, method="load_path")
        single = fl.solve_contact_general(compliance, gaps, levers, loads, method="single")
        scale = single.normal_forces.max()
        np.testing.assert_allclose(
            path.normal_forces, single.normal_forces, rtol=0, atol=1e-9 * scale
        )


@pytest.mark.parametrize("n", [60, 200, 500])
@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_long_paths_lose_no_digits(n: int, friction: float) -> None:
    """More pairs enter or leave than changes are kept with a factor."""
    matrix, row, gaps, torque = flank_problem(n, np.random.default_rng(n), friction=friction)
    levers = np.ones(n)
    path, single = (
        fl.solve_contact(matrix, row, gaps, torque, normal_lever_arms=levers, method=method)
        for method in ("load_path", "single")
    )
    assert path.active_pairs.tolist() == single.active_pairs.tolist()
    assert path.active_pairs.size > 20
    # The path itself ends at the state: nothing was left to decide.
    assert path.info.pivots == path.active_pairs.size - 1
    np.testing.assert_allclose(
        path.normal_forces, single.normal_forces, rtol=0, atol=SOLVER * single.normal_forces.max()
    )


@pytest.mark.parametrize("n", [40, 120])
def test_paths_on_which_pairs_leave_and_come_back(n: int) -> None:
    rng = np.random.default_rng(n)
    root = rng.standard_normal((n, n))
    gaps = rng.uniform(0.0, 1.0, n)
    state = fl.solve_contact(
        root - root.T + 0.3 * np.eye(n), np.ones(n), gaps, 1.0, method="load_path"
    )
    assert state.info.rung == "load_path"
    # Every pair in contact joined once; each return costs two more.
    assert state.info.pivots >= state.active_pairs.size + 10
    assert state.info.backward_error <= 10 * EPS
    assert state.info.unique


def without_motion(matrix: np.ndarray, gaps: np.ndarray, method: str) -> fl.ContactState:
    """g = M F + g0 alone; a pair of its own carries the load and no other has a lever."""
    n = gaps.size
    compliance = np.eye(n + 1)
    compliance[:n, :n] = matrix
    motions = np.zeros(n + 1)
    motions[n] = 1.0
    return fl.solve_contact_general(compliance, np.r_[gaps, 0.0], motions, 1.0, method=method)


@pytest.mark.parametrize("method", ["single", "block", "load_path"])
def test_three_pairs_on_which_exchange_one_by_one_goes_in_circles(method: str) -> None:
    """Murty's circulant example: every pair asks for the next one."""
    matrix = np.array([[1.0, 2.0, 0.0], [0.0, 1.0, 2.0], [2.0, 0.0, 1.0]])
    state = without_motion(matrix, np.full(3, -1.0), method)
    np.testing.assert_allclose(state.normal_forces[:3], 1 / 3, rtol=ROUND_OFF, atol=0)


@pytest.mark.parametrize("method", ["single", "block", "load_path"])
def test_ties_of_beale(method: str) -> None:
    """Beale's linear program, on which the simplex method goes in circles among ties at zero:
    minimise c x with A x <= b, x >= 0; as a contact problem with a diagonal of rounding's size."""
    c = np.array([-0.75, 150.0, -0.02, 6.0])
    a = np.array([[0.25, -60.0, -0.04, 9.0], [0.5, -90.0, -0.02, 3.0], [0.0, 0.0, 1.0, 0.0]])
    b = np.array([0.0, 0.0, 1.0])
    diagonal = 1e-9 * np.eye(7)
    matrix = np.block([[np.zeros((4, 4)), a.T], [-a, np.zeros((3, 3))]]) + diagonal
    state = without_motion(matrix, np.r_[c, b], method)
    assert state.info.backward_error <= 10 * EPS
    # Its least value is -1/20.
    np.testing.assert_allclose(c @ state.normal_forces[:4], -0.05, rtol=1e-5, atol=0)


@pytest.mark.parametrize("method", ["single", "block", "load_path"])
@pytest.mark.parametrize("n", [2, 5, 8])
def test_all_gaps_zero_without_structure(n: int, method: str) -> None:
    """Matrices with the P property (diagonally dominant), every gap tied with every other."""
    rng = np.random.default_rng(n)
    for _ in range(20):
        matrix = rng.standard_normal((n, n))
        matrix[np.diag_indices(n)] = np.abs(matrix).sum(axis=1)
        state = fl.solve_contact(matrix, np.ones(n), np.zeros(n), 1.0, method=method)
        forces, _ = brute_force(matrix, np.zeros(n), np.ones(n), np.ones(n), 1.0)[0]
        np.testing.assert_allclose(state.normal_forces, forces, rtol=0, atol=SOLVER * forces.max())


@pytest.mark.parametrize("method", ["single", "block", "load_path"])
@pytest.mark.parametrize("gap", [0.0, 0.3])
def test_every_pair_twice(gap: float, method: str) -> None:
    """The split between twins is open, their sum is that of the single pair."""
    n = 6
    place = np.linspace(0.0, 1.0, n)
    matrix = np.exp(-np.abs(place[:, None] - place))
    gaps = gap * place**2
    twins = np.repeat(np.arange(n), 2)
    alone = fl.solve_contact(matrix, np.ones(n), gaps, 2.0, method=method)
    twice = fl.solve_contact(
        matrix[np.ix_(twins, twins)], np.ones(2 * n), gaps[twins], 2.0, method=method
    )
    sums = twice.normal_forces.reshape(n, 2).sum(axis=1)
    np.testing.assert_allclose(sums, alone.normal_forces, rtol=0, atol=SOLVER * sums.max())
    assert twice.info.backward_error <= 10 * EPS
