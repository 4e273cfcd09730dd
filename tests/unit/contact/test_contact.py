"""The contact loop: identities, brute force over all contact sets, limits of the load."""

from __future__ import annotations

import numpy as np
import pytest

import flankload as fl
from flankload import _core, errors
from tests.support.contact_problems import FOUR, THREE, brute_force, random_problem
from tests.support.tolerances import ROUND_OFF, SOLVER

EPS = float(np.finfo(float).eps)


@pytest.mark.parametrize("unsymmetric", [False, True])
def test_brute_force_over_all_contact_sets(unsymmetric: bool) -> None:
    rng = np.random.default_rng(20 + unsymmetric)
    in_contact = set()
    for _ in range(100):
        matrix, row, levers, gaps, torque = random_problem(rng, unsymmetric=unsymmetric)
        state = fl.solve_contact(matrix, row, gaps, torque, normal_lever_arms=levers)
        found = brute_force(levers[:, None] * matrix, levers * gaps, levers, row, torque)
        assert len(found) == 1
        forces, rotation = found[0]
        np.testing.assert_allclose(state.normal_forces, forces, rtol=0, atol=1e-12 * forces.max())
        np.testing.assert_allclose(state.rotation, rotation, rtol=1e-12, atol=0)
        assert state.info.unique
        assert state.info.backward_error <= 10 * EPS
        assert state.active_pairs.tolist() == np.flatnonzero(forces).tolist()
        in_contact.add(state.active_pairs.size)
    assert in_contact >= {1, 2, 3, 4}


def test_three_pairs_where_one_must_leave() -> None:
    state = fl.solve_contact(THREE, np.ones(3), [1, 0, 1], 10.0)
    np.testing.assert_allclose(state.normal_forces, [5, 0, 5], rtol=ROUND_OFF, atol=ROUND_OFF)
    np.testing.assert_allclose(state.final_gap_angles, [0, 3, 0], rtol=0, atol=91 * ROUND_OFF)
    np.testing.assert_allclose(state.rotation, 91.0, rtol=ROUND_OFF, atol=0)
    assert state.active_pairs.tolist() == [0, 2]
    assert state.status == 0


def test_method_paper_reports_its_negative_force() -> None:
    with pytest.raises(errors.NegativeForce, match="-15 N at pair 1") as caught:
        fl.solve_contact(THREE, np.ones(3), [1, 0, 1], 10.0, method="paper")
    state = caught.value.state
    np.testing.assert_allclose(state.normal_forces, [12.5, -15, 12.5], rtol=SOLVER, atol=0)
    assert caught.value.code == state.status == -6


@pytest.mark.parametrize("warm_pairs", [None, [0], [3], [3, 1], [0, 1, 2, 3]])
def test_four_pairs(warm_pairs: list[int] | None) -> None:
    state = fl.solve_contact(FOUR, np.ones(4), [3, 0, 0, 9], 5.0, warm_pairs=warm_pairs)
    np.testing.assert_allclose(
        state.normal_forces,
        [1.6285714285714286, 1.1428571428571428, 2.2285714285714286, 0],
        rtol=ROUND_OFF,
        atol=0,
    )
    np.testing.assert_allclose(state.rotation, 38.42857142857143, rtol=ROUND_OFF, atol=0)


def test_paper_and_single_agree_where_no_pair_must_leave() -> None:
    rng = np.random.default_rng(7)
    agreed = 0
    for _ in range(100):
        matrix, row, _, gaps, torque = random_problem(rng, unsymmetric=False)
        single = fl.solve_contact(matrix, row, gaps, torque)
        try:
            paper = fl.solve_contact(matrix, row, gaps, torque, method="paper")
        except errors.NegativeForce:
            continue
        agreed += 1
        scale = single.normal_forces.max()
        np.testing.assert_allclose(
            paper.normal_forces, single.normal_forces, rtol=0, atol=SOLVER * scale
        )
        np.testing.assert_allclose(paper.rotation, single.rotation, rtol=SOLVER, atol=0)
        np.testing.assert_allclose(paper.tangent, single.tangent, rtol=SOLVER, atol=0)
        assert paper.info.rung == "paper"
    assert agreed > 50


@pytest.mark.parametrize("method", ["single", "paper"])
def test_without_torque_the_rotation_is_the_least_gap_angle(method: str) -> None:
    state = fl.solve_contact(FOUR, [1, 2, 3, 4], [3, 0.5, 1, 9], 0.0, method=method)
    assert state.rotation == 0.5
    assert not state.normal_forces.any()
    assert state.active_pairs.size == 0
    assert state.status == 0
    np.testing.assert_allclose(
        state.final_gap_angles, [2.5, 0, 0.5, 8.5], rtol=ROUND_OFF, atol=ROUND_OFF
    )


@pytest.mark.parametrize("torque", [1e-12, 1e12])
def test_tiny_and_huge_torque(torque: float) -> None:
    """At the small end the pairs with least gap share the torque, at the large end gaps vanish."""
    gaps = np.array([3, 0.5, 0.5, 9])
    state = fl.solve_contact(FOUR, np.ones(4), gaps, torque)
    pairs = [1, 2] if torque < 1 else [0, 1, 2, 3]
    assert state.active_pairs.tolist() == pairs
    matrix = np.ones((len(pairs) + 1, len(pairs) + 1))
    matrix[:-1, :-1] = FOUR[np.ix_(pairs, pairs)]
    matrix[:-1, -1] = -1.0
    matrix[-1, -1] = 0.0
    shares = np.linalg.solve(matrix, [0.0] * len(pairs) + [1.0])[:-1]
    atol = 1e-10 if torque > 1 else ROUND_OFF  # gaps of 9 beside 1e12
    np.testing.assert_allclose(state.normal_forces[pairs] / torque, shares, rtol=0, atol=atol)


def test_a_common_gap_offset_goes_into_the_rotation() -> None:
    rng = np.random.default_rng(3)
    matrix, row, _, gaps, torque = random_problem(rng, unsymmetric=False)
    for method in ("single", "paper"):
        plain = fl.solve_contact(matrix, row, gaps, torque, method=method)
        for offset in (0.75, -0.75):
            moved = fl.solve_contact(matrix, row, gaps + offset, torque, method=method)
            scale = plain.normal_forces.max()
            np.testing.assert_allclose(
                moved.normal_forces, plain.normal_forces, rtol=0, atol=ROUND_OFF * 1e3 * scale
            )
            np.testing.assert_allclose(
                moved.rotation - offset, plain.rotation, rtol=0, atol=ROUND_OFF
            )


def test_negative_single_lever() -> None:
    """A pair whose force turns body 1 back carries nothing while others can."""
    levers = np.array([30.0, -5.0, 31.0])
    state = fl.solve_contact(THREE, levers, [0, 0, 0], 100.0, normal_lever_arms=[30, 30, 30])
    found = brute_force(30 * THREE, np.zeros(3), np.full(3, 30.0), levers, 100.0)
    assert len(found) == 1
    np.testing.assert_allclose(
        state.normal_forces, found[0][0], rtol=0, atol=1e-12 * found[0][0].max()
    )


def test_zero_gaps_make_everything_linear_in_the_torque() -> None:
    one = fl.solve_contact(FOUR, [1, 2, 3, 2], np.zeros(4), 1.0)
    many = fl.solve_contact(FOUR, [1, 2, 3, 2], np.zeros(4), 1234.5)
    np.testing.assert_allclose(
        many.normal_forces, 1234.5 * one.normal_forces, rtol=ROUND_OFF, atol=ROUND_OFF
    )
    np.testing.assert_allclose(many.rotation, 1234.5 * one.rotation, rtol=ROUND_OFF, atol=0)
    np.testing.assert_allclose(one.tangent[0, 0], one.rotation, rtol=ROUND_OFF, atol=0)


def test_units_of_length_and_force_cancel() -> None:
    """Units change from mm and N to m and kN."""
    rng = np.random.default_rng(11)
    matrix, row, levers, gaps, torque = random_problem(rng, unsymmetric=True)
    plain = fl.solve_contact(matrix, row, gaps, torque, normal_lever_arms=levers)
    other = fl.solve_contact(
        matrix * 1e3, row * 1e-3, gaps, torque * 1e-6, normal_lever_arms=levers * 1e-3
    )
    scale = plain.normal_forces.max()
    np.testing.assert_allclose(
        other.normal_forces * 1e3, plain.normal_forces, rtol=0, atol=1e3 * ROUND_OFF * scale
    )
    np.testing.assert_allclose(other.rotation, plain.rotation, rtol=1e3 * ROUND_OFF, atol=0)


def test_tangent_is_the_change_of_rotation_with_torque() -> None:
    state = fl.solve_contact(FOUR, np.ones(4), [3, 0, 0, 9], 5.0)
    more = fl.solve_contact(FOUR, np.ones(4), [3, 0, 0, 9], 5.01)
    slope = (more.rotation - state.rotation) / 0.01
    np.testing.assert_allclose(state.tangent[0, 0], slope, rtol=SOLVER, atol=0)


def test_near_twins_share_an_uncertain_split_and_a_certain_sum() -> None:
    matrix = np.array([[2, 1, 1, 0.5], [1, 2, 2, 1], [1, 2, 2, 1], [0.5, 1, 1, 2]])
    alone = np.delete(np.delete(matrix, 2, 0), 2, 1)
    reference = fl.solve_contact(alone, np.ones(3), np.zeros(3), 5.0)
    matrix[2, 2] += 1e-10
    matrix[1, 1] += 1e-10
    state = fl.solve_contact(matrix, np.ones(4), np.zeros(4), 5.0, warm_pairs=[0, 1, 2, 3])
    assert state.status == 1
    assert state.info.condition > 1e8
    assert state.info.undetermined == ((1, 2),)
    np.testing.assert_allclose(
        state.normal_forces[1] + state.normal_forces[2],
        reference.normal_forces[1],
        rtol=SOLVER,
        atol=0,
    )
    np.testing.assert_allclose(state.rotation, reference.rotation, rtol=SOLVER, atol=0)


def test_exact_twins_are_solved_and_said_to_be_not_unique() -> None:
    matrix = np.array([[2, 1, 1, 0.5], [1, 2, 2, 1], [1, 2, 2, 1], [0.5, 1, 1, 2]])
    for gaps in ([0, 0, 0, 0], [0, 1e-3, 0, 0], [0, 0, 1e-3, 0]):
        for warm in (None, [0, 1], [0, 2], [0, 1, 2, 3]):
            state = fl.solve_contact(matrix, np.ones(4), gaps, 5.0, warm_pairs=warm)
            assert state.status == 3
            assert not state.info.unique
            np.testing.assert_allclose(state.normal_forces.sum(), 5.0, rtol=ROUND_OFF, atol=0)
            np.testing.assert_allclose(
                state.normal_forces[[0, 3]], [2.0, 2.0], rtol=ROUND_OFF, atol=0
            )


def test_degenerate_pair_has_neither_force_nor_gap() -> None:
    """Pair 1 just touches without load: F1 = 2 closes its gap of 10 to zero."""
    state = fl.solve_contact([[10, 5], [5, 10]], np.ones(2), [0, 10], 2.0)
    np.testing.assert_allclose(state.normal_forces, [2, 0], rtol=0, atol=ROUND_OFF)
    assert state.status == 2
    assert state.info.unique


def test_one_of_three_states_is_flagged() -> None:
    state = fl.solve_contact([[1, 2], [2, 1]], np.ones(2), [0, 0], 1.0)
    states = brute_force(np.array([[1, 2], [2, 1.0]]), np.zeros(2), np.ones(2), np.ones(2), 1.0)
    assert len(states) == 3
    assert min(np.abs(forces - state.normal_forces).max() for forces, _ in states) <= ROUND_OFF
    assert state.status == 3


def test_a_problem_without_state_is_not_answered() -> None:
    """An unsymmetric problem, b = (1, 1), m = (1, -1); brute force finds no state."""
    matrix = np.array([[2, 1], [1, 1.5]])
    assert not brute_force(matrix, np.zeros(2), np.ones(2), np.array([1.0, -1.0]), 1.0)
    for method in ("single", "block", "load_path"):
        with pytest.raises(errors.NoContactState) as caught:
            fl.solve_contact(matrix, [1, -1], [0, 0], 1.0, method=method)
        assert caught.value.largest_torque == 0.0


def test_uniqueness_is_judged_with_the_torque_row() -> None:
    """diag(b) A is positive definite, yet there are three states: m is not b."""
    matrix = np.array([[1, 1.3, 1.3], [0.6, 1, 1.8], [-0.4, -0.4, 1]])
    levers, row, gaps = np.ones(3), np.array([1, 3.1, 0.7]), np.array([0.9, 0.4, 1.1])
    assert np.linalg.eigvalsh(0.5 * (matrix + matrix.T)).min() > 0
    assert len(brute_force(matrix, gaps, levers, row, 1.0)) == 3
    state = fl.solve_contact(matrix, row, gaps, 1.0, normal_lever_arms=levers)
    assert state.status == 3
    assert fl.solve_contact(matrix, levers, gaps, 1.0).info.unique


def test_a_skew_problem_is_solved_with_exchange_of_rows() -> None:
    matrix = np.array([[1e-6, 1, 0], [-1, 1e-6, 0.5], [0, -0.5, 1e-6]])
    state = fl.solve_contact(matrix, np.ones(3), np.zeros(3), 1.0)
    assert state.info.growth > 1e3
    assert state.info.refactorisations > 0
    assert state.info.backward_error <= 10 * EPS
    found = brute_force(matrix, np.zeros(3), np.ones(3), np.ones(3), 1.0)
    assert len(found) == 1
    np.testing.assert_allclose(state.normal_forces, found[0][0], rtol=0, atol=1e-9)


def test_hundreds_of_pairs_meet_every_row() -> None:
    """A cylinder on a half-plane: the certificate, and any warm start leads to the same state."""
    n = 300
    place = np.linspace(-1, 1, n)
    step = place[1] - place[0]
    distance = np.abs(place[:, None] - place)
    upper, lower = distance + step / 2, distance - step / 2
    matrix = 2.0 - (upper * np.log(upper) - lower * np.log(np.abs(lower)) - step) / step
    gaps = 20 * place**2
    state = fl.solve_contact(matrix, np.ones(n), gaps, 1.0)
    assert 10 < state.active_pairs.size < n
    assert state.status == 0
    assert state.info.backward_error <= 10 * EPS
    forces = state.normal_forces
    residual = matrix @ forces + gaps - state.rotation
    assert np.abs(residual[state.active_pairs]).max() <= 100 * ROUND_OFF
    assert np.delete(residual, state.active_pairs).min() >= 0
    np.testing.assert_allclose(forces, forces[::-1], rtol=0, atol=SOLVER * forces.max())
    rng = np.random.default_rng(5)
    for size in (1, 20, 200):
        warm = rng.permutation(n)[:size]
        again = fl.solve_contact(matrix, np.ones(n), gaps, 1.0, warm_pairs=warm)
        np.testing.assert_allclose(again.normal_forces, forces, rtol=0, atol=SOLVER * forces.max())
    # with friction no energy falls: the loop takes fewer open pairs as progress
    rubs = {"load_rows": (1.0 + 0.1 * place)[:, None], "method": "primal"}
    rubbed = fl.solve_contact_general(matrix, gaps, np.ones((n, 1)), 1.0, **rubs)
    assert rubbed.info.rung == "single"
    assert rubbed.info.pivots > 50
    assert rubbed.info.backward_error <= 10 * EPS


def test_the_door_doubles_a_vector() -> None:
    """A wrong interface, with reals as C float, would not."""
    vector = np.array([np.pi, 1e-300, -7.25])
    doubled, info = _core.flankload_double_vector(vector)
    assert info == 0
    assert doubled.tolist() == (2 * vector).tolist()


def test_the_door_doubles_integers() -> None:
    doubled, info = _core.flankload_integer_vector(np.array([-1, -7, 1000], dtype=np.int32))
    assert info == 0
    assert doubled.tolist() == [-2, -14, 2000]


def test_the_version_is_defined_in_one_place() -> None:
    assert ".".join(map(str, _core.flankload_version()[:3])) == fl.__version__


def test_numbers_near_the_smallest_have_their_groups() -> None:
    state = fl.solve_contact(1e-310 * np.eye(3), np.ones(3), np.zeros(3), 1e10)
    np.testing.assert_allclose(state.normal_forces, np.full(3, 1e10 / 3), rtol=SOLVER)
    # Under 1e-10 N mm the rotation would be 3.3e-321, of which a double keeps three digits.
    with pytest.raises(errors.InputError, match="units"):
        fl.solve_contact(1e-310 * np.eye(3), np.ones(3), np.zeros(3), 1e-10)
