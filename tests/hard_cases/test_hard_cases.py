"""Problems on which solvers break: each asserts an answer, judged in 60 digits, or its error."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

import flankload as fl
from flankload import _core, errors
from tests.support.contact_problems import FOUR, THREE, brute_force
from tests.support.oracle import EPS, Verdict, judge, judge_general
from tests.support.tolerances import SOLVER

METHODS = ("auto", "single", "block", "cascade", "primal", "load_path")
TWINS = np.array([[2, 1, 1, 0.5], [1, 2, 2, 1], [1, 2, 2, 1], [0.5, 1, 1, 2]])

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
    """Solve cold and from several guesses; hold every state against 60-digit arithmetic."""
    row = np.ones(len(gaps)) if row is None else np.asarray(row, dtype=float)
    cold = None
    for warm in guesses(len(gaps)):
        state = fl.solve_contact(
            matrix, row, gaps, torque, normal_lever_arms=levers, method=method, warm_pairs=warm
        )
        hold(judge(matrix, row, gaps, torque, state), state)
        cold = state if cold is None else cold
    # The pairs that were found, as a guess of themselves.
    again = fl.solve_contact(
        matrix,
        row,
        gaps,
        torque,
        normal_lever_arms=levers,
        method=method,
        warm_pairs=cold.active_pairs,
    )
    hold(judge(matrix, row, gaps, torque, again), again)
    return cold


def guesses(n: int) -> list[list[int] | None]:
    """First guesses: none, all pairs in reverse order, the last pair, every second pair."""
    return [None, list(range(n))[::-1], [n - 1], list(range(0, n, 2))]


def hold(verdict: Verdict, state: fl.ContactState) -> None:
    """The hard promises of one state."""
    assert verdict.backward_error <= BACKWARD
    assert state.info.backward_error <= BACKWARD
    assert verdict.exact_violation <= BACKWARD
    assert verdict.forward_error <= FORWARD * state.info.condition
    assert verdict.motion_error <= FORWARD * state.info.condition
    if 1e8 < state.info.condition < 1e13:
        assert verdict.forward_error <= EXTENDED_FORWARD
    assert (state.normal_forces >= 0).all()
    assert (state.final_gap_angles >= 0).all()


def no_state(
    matrix: np.ndarray, row: list[float], gaps: list[float], torque: float, method: str
) -> errors.NoContactState:
    """The same refusal from any guess, confirmed by trying all sets of pairs."""
    levers = np.ones(len(gaps))
    assert not brute_force(matrix, np.asarray(gaps), levers, np.asarray(row), torque)
    for warm in guesses(len(gaps)):
        with pytest.raises(errors.NoContactState) as caught:
            fl.solve_contact(
                matrix,
                row,
                gaps,
                torque,
                normal_lever_arms=levers,
                method=method,
                warm_pairs=warm,
            )
    return caught.value


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
@pytest.mark.parametrize("stiffer", [1e-6, 1e6])
def test_one_body_a_million_times_as_stiff(method: str, stiffer: float) -> None:
    """A local kernel of one body on the smooth bending of the other."""
    place = np.linspace(0, 1, 20)
    local = np.exp(-20 * np.abs(place[:, None] - place))
    bending = 1.0 + np.minimum.outer(place, place) ** 2 * (3 - np.abs(place[:, None] - place))
    for torque in (1e-3, 1.0, 1e3):
        solve(stiffer * local + bending, 0.1 * (place - 0.3) ** 2, torque, method)


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
def test_the_three_pair_failure_of_a_growing_loop(method: str) -> None:
    state = solve(THREE, [1, 0, 1], 10.0, method)
    np.testing.assert_allclose(state.normal_forces, [5, 0, 5], rtol=1e-14, atol=0)
    np.testing.assert_allclose(state.rotation, 91.0, rtol=1e-14, atol=0)


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
@pytest.mark.parametrize(
    ("width", "decade"),
    [(0.23, 7), (0.26, 8), (0.28, 9), (0.31, 10), (0.34, 11), (0.38, 12), (0.4, 13), (0.44, 14)],
)
def test_smooth_kernels(method: str, width: float, decade: int) -> None:
    """Gaps that let every pair carry, so that the final equations have the whole condition."""
    place = np.linspace(0, 1, 14)
    matrix = np.exp(-(((place[:, None] - place) / width) ** 2)) + 1e-14 * np.eye(14)
    shape = 1 + 0.5 * np.cos(3 * place)
    state = solve(matrix, 10 - matrix @ shape, shape.sum(), method)
    assert state.active_pairs.size == 14
    assert 10.0**decade <= state.info.condition < 10.0 ** (decade + 1)
    assert state.status == (1 if decade >= 8 else 0)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("width", [0.05, 0.1, 0.15, 0.2, 0.3, 0.4])
def test_smooth_kernels_of_which_few_pairs_are_left(method: str, width: float) -> None:
    """Nearly equal neighbours leave again during the solution."""
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
def test_many_pairs_with_neither_force_nor_gap(method: str) -> None:
    """Pairs 4 … 9 just touch under the load of the first four; whole numbers leave no rounding."""
    rng = np.random.default_rng(12)
    for _ in range(10):
        root = rng.integers(-2, 3, (10, 10))
        matrix = (root @ root.T + 8 * np.eye(10)).astype(float)
        forces = np.where(np.arange(10) < 4, rng.integers(1, 9, 10), 0)
        order = rng.permutation(10)
        matrix, forces = matrix[np.ix_(order, order)], forces[order]
        state = solve(matrix, 300 - matrix @ forces, float(forces.sum()), method)
        np.testing.assert_allclose(state.normal_forces, forces, rtol=0, atol=1e-13)
        np.testing.assert_allclose(state.rotation, 300, rtol=1e-14, atol=0)
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


def least_minor(matrix: np.ndarray) -> float:
    """The least principal minor: positive where the matrix has the P property."""
    sets = [list(c) for k in range(len(matrix)) for c in itertools.combinations(range(8), k + 1)]
    return min(np.linalg.det(matrix[np.ix_(c, c)]) for c in sets)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(
    ("friction", "coupling", "p_property"),
    [
        (0.5, 1.2, True),
        (0.8, 0.2, True),
        (0.8, 1.2, False),
        (2.0, 0.2, True),
        (2.0, 1.2, False),
        (3.0, 1.2, False),
    ],
)
def test_friction_with_and_without_the_p_property(
    method: str, friction: float, coupling: float, p_property: bool
) -> None:
    """Friction of a pair presses its neighbours more than itself; torque arms lose their sign."""
    place = np.linspace(-1, 1, 8)
    kernel = 2.0 - np.log(np.abs(place[:, None] - place) + 0.05)
    row = 1.0 - 0.9 * friction * place
    for sense in (1, -1):
        sliding = sense * friction * np.where(place < 0, 1.0, -1.0)
        across = np.where(np.eye(8) > 0, 0.2, coupling)
        matrix = kernel * (1.0 + sliding * across)
        assert (least_minor(matrix) > 0) == p_property
        for torque in (0.1, 1.0, 10.0):
            gaps = 0.3 * place**2
            state = solve(matrix, gaps, torque, method, row=row, levers=np.ones(8))
            states = brute_force(matrix, gaps, np.ones(8), row, torque)
            away = min(np.abs(forces - state.normal_forces).max() for forces, _ in states)
            assert away <= 1e-12 * state.normal_forces.max()
            assert state.status == 3 or len(states) == 1
    assert (row.min() < 0) == (friction > 1.5)


@pytest.mark.parametrize("method", METHODS)
def test_levers_that_change_sign_and_no_state(method: str) -> None:
    refusal = no_state(np.array([[2, 1], [1, 1.5]]), [1, -1], [0, 0], 1.0, method)
    assert refusal.largest_torque == 0.0


@pytest.mark.parametrize("method", METHODS)
def test_self_locking_at_any_torque(method: str) -> None:
    """Pair 0 drives and presses pair 1 shut by more than it turns: its friction holds it all."""
    matrix = np.array([[1.0, 0.2, 0.1], [-1.5, 1.0, 0.1], [0.1, 0.1, 1.0]])
    for torque in (1e-9, 1.0, 1e9):
        refusal = no_state(matrix, [0.5, -1.2, -0.1], [0, 0, 1e10], torque, method)
        assert refusal.largest_torque <= 1e-6 * torque


@pytest.mark.parametrize("method", METHODS)
def test_levers_through_zero(method: str) -> None:
    row = np.array([1.0, 0.5, 0.0, -0.2])
    solve(FOUR, [0.1, 0.0, 0.1, 3.0], 1.0, method, row=row, levers=np.ones(4))


@pytest.mark.parametrize("method", METHODS)
def test_jamming_carries_the_largest_torque(method: str) -> None:
    matrix = np.array([[1.0, 1.5], [0.5, 1.0]])
    refusal = no_state(matrix, [1, -1], [0, 0.2], 1.0, method)
    np.testing.assert_allclose(refusal.largest_torque, 0.4, rtol=1e-9, atol=0)
    solve(matrix, [0, 0.2], 0.3999, method, row=np.array([1.0, -1.0]), levers=np.ones(2))


@pytest.mark.parametrize("method", METHODS)
def test_several_states(method: str) -> None:
    assert solve(np.array([[1.0, 2], [2, 1]]), [0, 0], 1.0, method).status == 3
    # Three states although K is positive definite: torque row and row levers differ.
    matrix = np.array([[1, 1.3, 1.3], [0.6, 1, 1.8], [-0.4, -0.4, 1]])
    row, gaps = np.array([1, 3.1, 0.7]), np.array([0.9, 0.4, 1.1])
    assert len(brute_force(matrix, gaps, np.ones(3), row, 1.0)) == 3
    assert solve(matrix, gaps, 1.0, method, row=row, levers=np.ones(3)).status == 3


def growth_without_exchange(matrix: np.ndarray) -> float:
    """Largest entry on the way of elimination, relative to the largest at its start."""
    left = matrix.copy()
    largest = 0.0
    while len(left) > 1:
        left = left[1:, 1:] - np.outer(left[1:, 0], left[0, 1:]) / left[0, 0]
        largest = max(largest, np.abs(left).max())
    return largest / np.abs(matrix).max()


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("n", [10, 30])
def test_skew_matrices_where_elimination_without_exchange_grows(method: str, n: int) -> None:
    rng = np.random.default_rng(0)
    root = rng.standard_normal((n, n))
    matrix = root - root.T + 1e-8 * np.eye(n)
    state = solve(matrix, np.zeros(n), 1.0, method)
    active = state.active_pairs
    bordered = np.ones((active.size + 1, active.size + 1))
    bordered[:-1, :-1] = matrix[np.ix_(active, active)]
    bordered[:-1, -1] = -1.0
    bordered[-1, -1] = 0.0
    assert growth_without_exchange(bordered) > 1e8
    assert state.info.growth > 1e8


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
def test_murty_and_fathi_problems_that_cost_exponentially_many_pivots(method: str) -> None:
    """The published problems F >= 0, M F + q >= 0; all unknowns but one have no lever.

    A last pair, which no other one moves, holds the motion.
    """
    n = 14
    lower = np.eye(n) + 2.0 * np.tril(np.ones((n, n)), -1)
    rising = 2.0 ** np.arange(n)
    whole = np.eye(n + 1)
    levers = np.r_[np.zeros(n), 1.0]
    for matrix in (lower, lower.T, lower @ lower.T):
        whole[:n, :n] = matrix
        for right in (-np.ones(n), -rising, -rising[::-1], -np.cumsum(rising), -rising[::-1] / 3):
            gaps = np.r_[right, 0.0]
            for warm in guesses(n + 1):
                state = fl.solve_contact_general(
                    whole, gaps, levers, 1.0, method=method, warm_pairs=warm
                )
                hold(judge_general(whole, gaps, levers, 1.0, state), state)
                assert state.normal_forces[n] == 1.0


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


@pytest.mark.parametrize("number", range(8))
@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_the_core_answers_no_numbers_that_are_none(number: int, bad: float) -> None:
    """NaN or infinity in any entry, at the flat interface, with every method.

    Columns of K are read as they are needed: that of pair 3, which stays open, may stay unread,
    but then nothing is proven.
    """
    good = [FOUR, np.array([3.0, 0, 0, 9]), np.ones((4, 1)), np.ones((4, 1)), np.array([5.0])]
    nothing = np.empty(0, dtype=np.int32)
    clean = _core.flankload_solve_contact(*map(np.asfortranarray, good), 0, number, nothing)
    for spoilt, part in enumerate(good):
        for place in np.ndindex(part.shape):
            arguments = [np.array(each, order="F") for each in good]
            arguments[spoilt][place] = bad
            outcome = _core.flankload_solve_contact(*arguments, 0, number, nothing)
            if spoilt == 0 and place[1] == 3 and outcome[-1] >= 0:
                np.testing.assert_allclose(outcome[0], clean[0], rtol=SOLVER, atol=0)
                assert outcome[-1] == 3
                continue
            assert outcome[-1] == -4
            assert np.isnan(outcome[0]).all()
