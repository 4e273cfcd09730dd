"""Properties that every state of contact has, whatever the problem: seeded random problems."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import pytest

import flankload as fl
from tests.support.tolerances import SOLVER

SEED, PROBLEMS = 20261124, 60
METHODS = pytest.mark.parametrize("method", ["auto", "single", "block", "load_path"])
#: Probability of an array that consists of the ends and the middle of its range.
ROUND = 0.3


@dataclass(frozen=True)
class Drawn:
    """A problem without friction: K, row levers, normal gaps, torque."""

    compliance: np.ndarray
    levers: np.ndarray
    gaps: np.ndarray
    torque: float

    def solve(self, method: str = "auto") -> fl.ContactState:
        return fl.solve_contact_general(
            self.compliance, self.gaps, self.levers, self.torque, method=method
        )


def numbers(
    rng: np.random.Generator, least: float, most: float, shape: tuple[int, ...] = ()
) -> np.ndarray:
    """Numbers in a range; some arrays consist of its ends and its middle."""
    if rng.random() < ROUND:
        return rng.choice([least, 0.5 * (least + most), most], shape)
    return rng.uniform(least, most, shape)


def problems() -> Iterator[tuple[np.random.Generator, Drawn]]:
    """Problems of one to ten pairs; K is nearly diagonal to nearly singular (condition to 1e5).

    Each comes with the random generator for the changes of a test.
    """
    rng = np.random.default_rng(SEED)
    for number in range(PROBLEMS):
        n = 1 + number % 10
        root = numbers(rng, -1, 1, (n, n))
        ridge = 10.0 ** numbers(rng, -5, 0)
        yield (
            rng,
            Drawn(
                root @ root.T / n + ridge * np.eye(n),
                numbers(rng, 0.5, 2, (n,)),
                numbers(rng, 0, 1, (n,)),
                float(10.0 ** numbers(rng, -3, 3)),
            ),
        )


def assert_same(
    forces: np.ndarray, rotation: float, problem: Drawn, state: fl.ContactState
) -> None:
    """The same forces and rotation as a state, to the solver tolerance on the problem's scale."""
    scale = state.normal_forces.max() * max(1.0, 1e-5 * state.info.condition)
    np.testing.assert_allclose(forces, state.normal_forces, rtol=0, atol=SOLVER * scale)
    turn = max(abs(state.rotation), (np.abs(problem.gaps) / problem.levers).max())
    np.testing.assert_allclose(rotation, state.rotation, rtol=0, atol=SOLVER * turn)


def test_problems_are_of_all_kinds() -> None:
    drawn = [problem for _, problem in problems()]
    conditions = [np.linalg.cond(problem.compliance) for problem in drawn]
    assert min(conditions) == 1.0
    assert max(conditions) > 5e3
    assert {problem.gaps.size for problem in drawn} == set(range(1, 11))
    assert any(np.count_nonzero(problem.gaps == 0.0) > 2 for problem in drawn)
    active = [len(problem.solve().active_pairs) < problem.gaps.size for problem in drawn]
    assert 0.3 < np.mean(active) < 0.9


@METHODS
def test_order_of_the_pairs_does_not_matter(method: str) -> None:
    for rng, problem in problems():
        order = rng.permutation(problem.gaps.size)
        moved = Drawn(
            problem.compliance[np.ix_(order, order)],
            problem.levers[order],
            problem.gaps[order],
            problem.torque,
        ).solve(method)
        forces = np.empty(order.size)
        forces[order] = moved.normal_forces
        assert_same(forces, moved.rotation, problem, problem.solve(method))


@METHODS
def test_units_of_even_powers_of_two_change_no_bit(method: str) -> None:
    """Units 4^k of length, force and angle: scaling is exact, so is every step of the loop."""
    for rng, problem in problems():
        long, strong, turned = 4.0 ** rng.integers(-40, 41, 3)
        plain = problem.solve(method)
        other = Drawn(
            problem.compliance * (long / strong),
            problem.levers * (long / turned),
            problem.gaps * long,
            problem.torque * (strong * long / turned),
        ).solve(method)
        assert np.array_equal(other.normal_forces / strong, plain.normal_forces)
        assert np.array_equal(other.final_gap_angles / long, plain.final_gap_angles)
        assert other.rotation / turned == plain.rotation
        assert other.active_pairs.tolist() == plain.active_pairs.tolist()
        assert other.status == plain.status
        assert other.info == plain.info


@METHODS
def test_other_units_change_nothing(method: str) -> None:
    for rng, problem in problems():
        length, force = 10.0 ** numbers(rng, -6, 6, (2,))
        other = Drawn(
            problem.compliance * (length / force),
            problem.levers * length,
            problem.gaps * length,
            problem.torque * (force * length),
        ).solve(method)
        assert_same(other.normal_forces / force, other.rotation, problem, problem.solve(method))


@METHODS
def test_mirrored_problems_have_mirrored_states(method: str) -> None:
    """Equal under reversal of its pairs, a problem has a state that is equal too."""
    for _, problem in problems():
        mirrored = Drawn(
            0.5 * (problem.compliance + problem.compliance[::-1, ::-1]),
            0.5 * (problem.levers + problem.levers[::-1]),
            0.5 * (problem.gaps + problem.gaps[::-1]),
            problem.torque,
        )
        state = mirrored.solve(method)
        assert_same(state.normal_forces[::-1], state.rotation, mirrored, state)


@METHODS
def test_motions_counted_the_other_way_round_change_their_sign(method: str) -> None:
    for _, problem in problems():
        plain = problem.solve(method)
        other = Drawn(problem.compliance, -problem.levers, problem.gaps, -problem.torque).solve(
            method
        )
        assert np.array_equal(other.normal_forces, plain.normal_forces)
        assert other.rotation == -plain.rotation


@METHODS
def test_a_common_gap_angle_goes_into_the_rotation(method: str) -> None:
    for rng, problem in problems():
        offset = float(numbers(rng, -100, 100))
        gaps = problem.gaps + offset * problem.levers
        moved = Drawn(problem.compliance, problem.levers, gaps, problem.torque)
        state, plain = moved.solve(method), problem.solve(method)
        # Gaps of the size of the offset carry its rounding into all forces.
        lost = abs(offset) * np.finfo(float).eps * 100 / np.linalg.eigvalsh(problem.compliance)[0]
        np.testing.assert_allclose(
            state.normal_forces,
            plain.normal_forces,
            rtol=0,
            atol=SOLVER * plain.normal_forces.max() + lost,
        )
        np.testing.assert_allclose(
            state.rotation, plain.rotation + offset, rtol=SOLVER, atol=SOLVER * (1 + abs(offset))
        )


@METHODS
def test_more_torque_turns_further(method: str) -> None:
    for rng, problem in problems():
        torque = float(numbers(rng, 1.01, 100)) * problem.torque
        more = Drawn(problem.compliance, problem.levers, problem.gaps, torque).solve(method)
        assert more.rotation > problem.solve(method).rotation


@METHODS
def test_a_pair_that_stays_open_changes_nothing(method: str) -> None:
    for rng, problem in problems():
        n = problem.gaps.size
        plain = problem.solve(method)
        reach = numbers(rng, -1e-2, 1e-2, (n,))
        lever, left = float(numbers(rng, -2, 2)), float(numbers(rng, 1e-3, 10))
        place = int(rng.integers(0, n + 1))
        wider = np.insert(np.insert(problem.compliance, place, reach, axis=0), place, 0.0, axis=1)
        wider[:, place] = np.insert(reach, place, 2.0)
        gap = lever * plain.rotation - reach @ plain.normal_forces + left * (1 + plain.rotation)
        wide = Drawn(
            wider,
            np.insert(problem.levers, place, lever),
            np.insert(problem.gaps, place, gap),
            problem.torque,
        )
        state = wide.solve(method)
        assert state.normal_forces[place] == 0.0
        assert_same(np.delete(state.normal_forces, place), state.rotation, problem, plain)


@METHODS
def test_gaps_and_torque_times_a_number_give_forces_times_that_number(method: str) -> None:
    for rng, problem in problems():
        factor = float(10.0 ** numbers(rng, -9, 9))
        plain = problem.solve(method)
        for times, exact in ((factor, False), (2.0 ** round(np.log2(factor)), True)):
            state = Drawn(
                problem.compliance, problem.levers, times * problem.gaps, times * problem.torque
            ).solve(method)
            if exact:
                assert np.array_equal(state.normal_forces, times * plain.normal_forces)
                assert state.rotation == times * plain.rotation
                assert state.info == plain.info
            else:
                assert_same(state.normal_forces / times, state.rotation / times, problem, plain)
