"""Method `block`: the same states as one pair at a time, and promises about the matrix."""

from __future__ import annotations

import numpy as np
import pytest

import flankload as fl
from flankload import errors
from tests.support.contact_problems import FOUR, THREE, brute_force, flank_problem, random_problem
from tests.support.tolerances import ROUND_OFF, SOLVER

EPS = float(np.finfo(float).eps)


@pytest.mark.parametrize("unsymmetric", [False, True])
def test_block_against_brute_force(unsymmetric: bool) -> None:
    rng = np.random.default_rng(40 + unsymmetric)
    for _ in range(100):
        matrix, row, levers, gaps, torque = random_problem(rng, unsymmetric=unsymmetric)
        state = fl.solve_contact(
            matrix, row, gaps, torque, normal_lever_arms=levers, method="block"
        )
        forces, rotation = brute_force(
            levers[:, None] * matrix, levers * gaps, levers, row, torque
        )[0]
        np.testing.assert_allclose(state.normal_forces, forces, rtol=0, atol=1e-12 * forces.max())
        np.testing.assert_allclose(state.rotation, rotation, rtol=1e-12, atol=0)
        assert state.info.backward_error <= 10 * EPS


@pytest.mark.parametrize("friction", [0.0, 0.1, 0.3])
@pytest.mark.parametrize("n", [70, 300, 900])
def test_block_and_single_agree(n: int, friction: float) -> None:
    """Above 500 pairs in flank order a coarser problem gives the start, asked for at any size;
    shuffled pairs have no order to use."""
    rng = np.random.default_rng(n)
    matrix, row, gaps, torque = flank_problem(n, rng, friction=friction)
    levers = np.ones(n)
    single = fl.solve_contact(matrix, row, gaps, torque, normal_lever_arms=levers, method="single")
    block = fl.solve_contact(matrix, row, gaps, torque, normal_lever_arms=levers)
    cascade = fl.solve_contact(
        matrix, row, gaps, torque, normal_lever_arms=levers, method="cascade"
    )
    assert block.info.rung == ("block" if n < 500 else "cascade")
    assert single.info.rung == "single"
    assert cascade.info.rung == "cascade"
    assert cascade.info.pivots < single.info.pivots
    order = rng.permutation(n)
    shuffled = fl.solve_contact(
        matrix[np.ix_(order, order)], row[order], gaps[order], torque, normal_lever_arms=levers
    )
    assert shuffled.info.rung == "block"
    scale = single.normal_forces.max()
    for state, forces in (
        (block, block.normal_forces),
        (cascade, cascade.normal_forces),
        (shuffled, shuffled.normal_forces[np.argsort(order)]),
    ):
        np.testing.assert_allclose(forces, single.normal_forces, rtol=0, atol=SOLVER * scale)
        np.testing.assert_allclose(state.rotation, single.rotation, rtol=SOLVER, atol=0)
        np.testing.assert_allclose(state.tangent, single.tangent, rtol=SOLVER, atol=0)
        assert state.info.backward_error <= 10 * EPS
        assert state.status == single.status


def test_pairs_that_must_leave_leave_a_block_too() -> None:
    state = fl.solve_contact(THREE, np.ones(3), [1, 0, 1], 10.0, method="block")
    np.testing.assert_allclose(state.normal_forces, [5, 0, 5], rtol=ROUND_OFF, atol=ROUND_OFF)
    warm = fl.solve_contact(
        FOUR, np.ones(4), [3, 0, 0, 9], 5.0, method="block", warm_pairs=[3, 1, 2, 0]
    )
    np.testing.assert_allclose(warm.rotation, 38.42857142857143, rtol=ROUND_OFF, atol=0)


def test_twins_and_several_motions_in_blocks() -> None:
    twins = np.array([[2, 1, 1, 0.5], [1, 2, 2, 1], [1, 2, 2, 1], [0.5, 1, 1, 2]])
    state = fl.solve_contact(twins, np.ones(4), np.zeros(4), 5.0, method="block")
    np.testing.assert_allclose(state.normal_forces[[0, 3]], [2.0, 2.0], rtol=ROUND_OFF, atol=0)
    assert state.status == 3
    rng = np.random.default_rng(8)
    for _ in range(50):
        root = rng.standard_normal((12, 12))
        compliance = root @ root.T / 12 + 1e-2 * np.eye(12)
        levers = rng.standard_normal((12, 3))
        loads = levers.T @ np.abs(rng.standard_normal(12))
        gaps = rng.uniform(-0.2, 1.0, 12)
        block = fl.solve_contact_general(compliance, gaps, levers, loads, method="block")
        single = fl.solve_contact_general(compliance, gaps, levers, loads, method="single")
        scale = single.normal_forces.max()
        np.testing.assert_allclose(
            block.normal_forces, single.normal_forces, rtol=0, atol=SOLVER * scale
        )


def test_uniqueness_has_the_stated_reason() -> None:
    """Open pairs that would drive each other away make a second state. A single entry too large for
    an elastic compliance is seen; three of which none is too large only by a proof, or not at all
    where the caller vouches for the matrix."""
    rng = np.random.default_rng(2)
    matrix, row, gaps, torque = flank_problem(80, rng)
    gaps[40:] += 10.0
    elastic = fl.solve_contact(matrix, row, gaps, torque)
    assert (elastic.status, elastic.info.uniqueness) == (0, "elastic")
    proven = fl.solve_contact(matrix, row, gaps, torque, positive_definite=False)
    assert (proven.status, proven.info.uniqueness) == (0, "proven")
    large = matrix.copy()
    large[40, 41] = large[41, 40] = -1e6
    state = fl.solve_contact(large, row, gaps, torque)
    assert (state.status, state.info.uniqueness) == (3, "not certain")
    three = matrix.copy()
    root = np.sqrt(matrix.diagonal())
    for i, j in ((50, 60), (60, 70), (50, 70)):
        three[i, j] = three[j, i] = -0.9 * root[i] * root[j]
    assert fl.solve_contact(three, row, gaps, torque, positive_definite=False).status == 3
    vouched = fl.solve_contact(three, row, gaps, torque, positive_definite=True)
    assert (vouched.status, vouched.info.uniqueness) == (0, "elastic")
    assert vouched.active_pairs.max() < 40


def test_few_pairs_are_proven_unique() -> None:
    rng = np.random.default_rng(2)
    matrix, row, gaps, torque = flank_problem(40, rng)
    assert fl.solve_contact(matrix, row, gaps, torque).info.uniqueness == "proven"


def test_a_promise_that_the_pairs_in_contact_break_is_not_believed() -> None:
    state = fl.solve_contact([[1, 2], [2, 1]], np.ones(2), [0, 0], 1.0, positive_definite=True)
    assert state.status == 3


def test_hilbert_is_solved_by_some_rung() -> None:
    i = np.arange(12)
    matrix = 1.0 / (i[:, None] + i + 1.0)
    for method in ("block", "single"):
        state = fl.solve_contact(matrix, np.ones(12), np.zeros(12), 1.0, method=method)
        assert state.info.backward_error <= 10 * EPS
        assert (state.normal_forces >= 0).all()


def test_no_pair_can_carry_the_load() -> None:
    with pytest.raises(errors.NoContactState):
        fl.solve_contact_general(np.eye(2), [0, 0], [1, 1], -1.0, method="block")
