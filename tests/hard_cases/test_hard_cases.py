"""Problems on which solvers break: each asserts an answer, judged in 60 digits, or its error."""

from __future__ import annotations

import numpy as np
import pytest
from oracle import EPS, judge

import flankload as fl
from flankload import errors

METHODS = ("single", "block", "load_path")
TWINS = np.array([[2, 1, 1, 0.5], [1, 2, 2, 1], [1, 2, 2, 1], [0.5, 1, 1, 2]])
FOUR = np.array([[10.0, 7, 5, 4], [7, 10, 7, 5], [5, 7, 10, 8], [4, 5, 8, 10]])

# The sum of the hard promises: each row on its own scale, forces as good as the condition allows.
BACKWARD = 10 * EPS
FORWARD = 20 * EPS
EXTENDED_FORWARD = 4 * EPS


def solve(
    matrix: np.ndarray,
    gaps: np.ndarray | list[float],
    torque: float,
    method: str,
    *,
    row: np.ndarray | None = None,
    levers: np.ndarray | None = None,
) -> fl.ContactState:
    """Solve and hold the state against 60-digit arithmetic."""
    row = np.ones(len(gaps)) if row is None else np.asarray(row, dtype=float)
    state = fl.solve_contact(matrix, row, gaps, torque, normal_lever_arms=levers, method=method)
    verdict = judge(matrix, row, gaps, torque, state)
    assert verdict.backward_error <= BACKWARD
    assert state.info.backward_error <= BACKWARD
    assert verdict.exact_violation <= BACKWARD
    assert verdict.forward_error <= FORWARD * state.info.condition
    if 1e8 < state.info.condition < 1e13:
        assert verdict.forward_error <= EXTENDED_FORWARD
    assert (state.normal_forces >= 0).all()
    return state


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("distance", [1e-10, 1e-13])
def test_near_twins(method: str, distance: float) -> None:
    matrix = TWINS + np.diag([0, distance, distance, 0])
    state = solve(matrix, np.zeros(4), 5.0, method)
    assert state.status == 1
    assert state.info.undetermined == ((1, 2),)
    # One pair in the place of both: two springs side by side on a common base.
    alone = np.array([[2, 1, 0.5], [1, 2 + 0.5 * distance, 1], [0.5, 1, 2]])
    single = solve(alone, np.zeros(3), 5.0, method)
    np.testing.assert_allclose(
        state.normal_forces[1:3].sum(), single.normal_forces[1], rtol=1e-12, atol=0
    )


@pytest.mark.parametrize("method", METHODS)
def test_exact_twins(method: str) -> None:
    assert solve(TWINS, np.zeros(4), 5.0, method).status == 3


@pytest.mark.parametrize("method", METHODS)
def test_conforming_flanks_where_all_gaps_tie(method: str) -> None:
    place = np.linspace(0, 1, 20)
    state = solve(np.exp(-np.abs(place[:, None] - place)), np.zeros(20), 1.0, method)
    assert state.active_pairs.size == 20
    assert state.status == 0


@pytest.mark.parametrize("method", METHODS)
def test_stiffness_ratio_of_a_million(method: str) -> None:
    place = np.linspace(0, 1, 20)
    root = np.where(np.arange(20) % 2, 1e-3, 1.0)
    solve(np.exp(-np.abs(place[:, None] - place)) * np.outer(root, root), np.zeros(20), 1.0, method)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("torque", [1e-12, 1e12])
def test_tiny_and_huge_torque(method: str, torque: float) -> None:
    state = solve(FOUR, [3, 0.5, 0.5, 9], torque, method)
    assert state.active_pairs.tolist() == ([1, 2] if torque < 1 else [0, 1, 2, 3])


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("scale", [1e-20, 1e20])
def test_scaled_torque_row(method: str, scale: float) -> None:
    row = np.full(4, scale)
    state = solve(FOUR, [3, 0, 0, 9], 5.0 * scale, method, row=row, levers=row)
    np.testing.assert_allclose(state.rotation, 38.42857142857143, rtol=1e-14, atol=0)


@pytest.mark.parametrize("method", METHODS)
def test_the_four_pair_failure_of_a_growing_loop(method: str) -> None:
    state = solve(FOUR, [3, 0, 0, 9], 5.0, method)
    np.testing.assert_allclose(
        state.normal_forces, [57 / 35, 8 / 7, 78 / 35, 0], rtol=1e-14, atol=0
    )


@pytest.mark.parametrize("method", METHODS)
def test_least_gap_that_is_not_zero(method: str) -> None:
    plain = solve(FOUR, [3, 0, 0, 9], 5.0, method)
    moved = solve(FOUR, [103, 100, 100, 109], 5.0, method)
    np.testing.assert_allclose(moved.rotation - 100, plain.rotation, rtol=1e-13, atol=0)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("width", [0.05, 0.1, 0.15, 0.2, 0.3, 0.4])
def test_smooth_kernels_with_condition_up_to_1e15(method: str, width: float) -> None:
    place = np.linspace(0, 1, 30)
    matrix = np.exp(-(((place[:, None] - place) / width) ** 2)) + 1e-14 * np.eye(30)
    solve(matrix, 0.1 * (place - 0.4) ** 2, 1.0, method)


@pytest.mark.parametrize("method", METHODS)
def test_hilbert_12(method: str) -> None:
    i = np.arange(12)
    matrix = 1.0 / (i[:, None] + i + 1.0)
    solve(matrix, np.zeros(12), 1.0, method)
    # Gaps that let nearly every pair carry.
    solve(matrix, 10.0 - matrix @ np.ones(12), 12.0, method)


@pytest.mark.parametrize("method", METHODS)
def test_degenerate_vertex(method: str) -> None:
    state = solve(np.array([[10.0, 5], [5, 10]]), [0, 10], 2.0, method)
    assert state.status == 2


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("friction", [0.1, 0.8, 2.0])
def test_friction(method: str, friction: float) -> None:
    """Torque arms of both signs where friction is strong."""
    place = np.linspace(-1, 1, 15)
    kernel = 2.0 - np.log(np.abs(place[:, None] - place) + 0.05)
    matrix = kernel * (1.0 + 0.2 * friction * np.sign(place))
    row = 1.0 - friction * place
    levers = np.ones(15)
    state = solve(matrix, 0.3 * place**2, 1.0, method, row=row, levers=levers)
    assert state.active_pairs.size > 0


@pytest.mark.parametrize("method", METHODS)
def test_levers_that_change_sign_and_no_state(method: str) -> None:
    with pytest.raises(errors.NoContactState) as caught:
        fl.solve_contact(np.array([[2, 1], [1, 1.5]]), [1, -1], [0, 0], 1.0, method=method)
    assert caught.value.largest_torque == 0.0


@pytest.mark.parametrize("method", METHODS)
def test_levers_through_zero(method: str) -> None:
    row = np.array([1.0, 0.5, 0.0, -0.2])
    solve(FOUR, [0.1, 0.0, 0.1, 3.0], 1.0, method, row=row, levers=np.ones(4))


@pytest.mark.parametrize("method", METHODS)
def test_jamming_carries_the_largest_torque(method: str) -> None:
    matrix = np.array([[1.0, 1.5], [0.5, 1.0]])
    with pytest.raises(errors.NoContactState) as caught:
        fl.solve_contact(matrix, [1, -1], [0, 0.2], 1.0, normal_lever_arms=[1, 1], method=method)
    np.testing.assert_allclose(caught.value.largest_torque, 0.4, rtol=1e-9, atol=0)
    solve(matrix, [0, 0.2], 0.3999, method, row=np.array([1.0, -1.0]), levers=np.ones(2))


@pytest.mark.parametrize("method", METHODS)
def test_several_states(method: str) -> None:
    assert solve(np.array([[1.0, 2], [2, 1]]), [0, 0], 1.0, method).status == 3


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("n", [10, 30])
def test_skew_matrices_where_elimination_without_exchange_grows(method: str, n: int) -> None:
    rng = np.random.default_rng(0)
    root = rng.standard_normal((n, n))
    solve(root - root.T + 1e-8 * np.eye(n), np.zeros(n), 1.0, method)


@pytest.mark.parametrize("method", METHODS)
def test_murty_and_fathi_matrices(method: str) -> None:
    n = 14
    murty = np.eye(n) + 2.0 * np.triu(np.ones((n, n)), 1)
    root = np.eye(n) + 2.0 * np.tril(np.ones((n, n)), -1)
    rising = 2.0 ** np.arange(n)
    for matrix in (murty, murty.T, root @ root.T):
        for gaps in (rising / rising.max(), -rising / rising.max(), rising[::-1] / rising.max()):
            for torque in (1e-3, 1.0, 1e3):
                solve(matrix, gaps, torque, method)


@pytest.mark.parametrize("method", METHODS)
def test_one_pair(method: str) -> None:
    state = solve(np.array([[3.0]]), [0.5], 4.0, method, row=np.array([2.0]))
    assert state.normal_forces.tolist() == [2.0]
    assert state.rotation == 6.5


@pytest.mark.parametrize("method", METHODS)
def test_two_pairs(method: str) -> None:
    assert solve(np.diag([1.0, 1.0]), [0, 1], 0.5, method).active_pairs.tolist() == [0]
    assert solve(np.diag([1.0, 1.0]), [0, 1], 1.5, method).normal_forces.tolist() == [1.25, 0.25]


@pytest.mark.parametrize("method", METHODS)
def test_all_open_and_all_closed(method: str) -> None:
    assert not fl.solve_contact(
        FOUR, np.ones(4), [1, 2, 3, 4], 0.0, method=method
    ).active_pairs.size
    assert solve(np.eye(4) + 1.0, np.zeros(4), 1.0, method).active_pairs.size == 4


@pytest.mark.parametrize("order", ["C", "F"])
def test_layouts_and_kinds_of_arrays(order: str) -> None:
    wide = np.zeros((8, 8), order=order)
    wide[::2, ::2] = FOUR
    for matrix in (wide[::2, ::2], FOUR.astype(np.float32), FOUR[::-1, ::-1][::-1, ::-1]):
        state = fl.solve_contact(matrix, np.ones(4), [3, 0, 0, 9], 5)
        np.testing.assert_allclose(state.rotation, 38.42857142857143, rtol=1e-14, atol=0)
