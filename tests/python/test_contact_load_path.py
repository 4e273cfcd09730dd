"""Method `load_path`: the last rung, also for matrices without any structure."""

from __future__ import annotations

import numpy as np
import pytest
from test_contact import brute_force, random_problem
from tolerances import ROUND_OFF

import flankload as fl
from flankload import errors

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


@pytest.mark.parametrize("method", ["single", "block", "load_path"])
def test_any_matrix_gives_a_state_or_none(method: str) -> None:
    """Random matrices without the P property, torque rows of both signs: what is answered is a
    state, and without any state nothing is answered."""
    rng = np.random.default_rng(5)
    solved = none = missed = 0
    for _ in range(300):
        n = int(rng.integers(2, 7))
        matrix = rng.standard_normal((n, n))
        matrix[np.diag_indices(n)] = rng.uniform(0.2, 1.5, n)
        row = rng.uniform(-0.5, 1.0, n)
        gaps = rng.uniform(0.0, 1.0, n)
        if row.max() <= 0:
            continue
        states = brute_force(matrix, gaps, np.ones(n), row, 1.0)
        try:
            state = fl.solve_contact(
                matrix, row, gaps, 1.0, normal_lever_arms=np.ones(n), method=method
            )
        except errors.NoContactState:
            none += not states
            missed += bool(states)
            continue
        solved += 1
        distances = [np.abs(forces - state.normal_forces).max() for forces, _ in states]
        assert min(distances) <= 1e-9 * state.normal_forces.max()
        assert state.info.backward_error <= 10 * EPS
    assert solved > 150
    assert none > 20
    # A ray of the path is no proof without the P property.
    assert missed <= 10


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
