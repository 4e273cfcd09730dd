"""Properties that every state of contact has, whatever the problem: searched by hypothesis."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

import flankload as fl
from tests.support.tolerances import SOLVER

# The same examples in every run; nothing is written.
searched = settings(derandomize=True, deadline=None, database=None, max_examples=80)
METHODS = st.sampled_from(["auto", "single", "block", "load_path"])


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


def numbers(least: float, most: float) -> st.SearchStrategy[float]:
    return st.floats(least, most, allow_subnormal=False)


@st.composite
def problems(draw: st.DrawFn) -> Drawn:
    """From one pair to ten; K from nearly diagonal to nearly singular (condition up to 1e5)."""
    n = draw(st.integers(1, 10))
    root = draw(arrays(float, (n, n), elements=numbers(-1, 1)))
    ridge = 10.0 ** draw(numbers(-4, 0))
    return Drawn(
        root @ root.T / n + ridge * np.eye(n),
        draw(arrays(float, n, elements=numbers(0.5, 2))),
        draw(arrays(float, n, elements=numbers(0, 1))),
        10.0 ** draw(numbers(-3, 3)),
    )


def assert_same(
    forces: np.ndarray, rotation: float, problem: Drawn, state: fl.ContactState
) -> None:
    """The same forces and rotation as a state, to the solver tolerance on the problem's scale."""
    scale = state.normal_forces.max() * max(1.0, 1e-5 * state.info.condition)
    np.testing.assert_allclose(forces, state.normal_forces, rtol=0, atol=SOLVER * scale)
    turn = max(abs(state.rotation), (np.abs(problem.gaps) / problem.levers).max())
    np.testing.assert_allclose(rotation, state.rotation, rtol=0, atol=SOLVER * turn)


@searched
@given(problems(), st.randoms(use_true_random=False), METHODS)
def test_order_of_the_pairs_does_not_matter(problem: Drawn, random, method: str) -> None:
    order = np.array(random.sample(range(problem.gaps.size), problem.gaps.size))
    moved = Drawn(
        problem.compliance[np.ix_(order, order)],
        problem.levers[order],
        problem.gaps[order],
        problem.torque,
    ).solve(method)
    forces = np.empty(order.size)
    forces[order] = moved.normal_forces
    assert_same(forces, moved.rotation, problem, problem.solve(method))


@searched
@given(problems(), st.integers(-40, 40), st.integers(-40, 40), st.integers(-40, 40), METHODS)
def test_units_of_even_powers_of_two_change_no_bit(
    problem: Drawn, length: int, force: int, angle: int, method: str
) -> None:
    """Units 4^k of length, force and angle: scaling is exact, so is every step of the loop."""
    long, strong, turned = 4.0**length, 4.0**force, 4.0**angle
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


@searched
@given(problems(), numbers(1e-6, 1e6), numbers(1e-6, 1e6), METHODS)
def test_other_units_change_nothing(
    problem: Drawn, length: float, force: float, method: str
) -> None:
    other = Drawn(
        problem.compliance * (length / force),
        problem.levers * length,
        problem.gaps * length,
        problem.torque * (force * length),
    ).solve(method)
    assert_same(other.normal_forces / force, other.rotation, problem, problem.solve(method))


@searched
@given(problems(), METHODS)
def test_mirrored_problems_have_mirrored_states(problem: Drawn, method: str) -> None:
    """Equal under reversal of its pairs, a problem has a state that is equal too."""
    mirrored = Drawn(
        0.5 * (problem.compliance + problem.compliance[::-1, ::-1]),
        0.5 * (problem.levers + problem.levers[::-1]),
        0.5 * (problem.gaps + problem.gaps[::-1]),
        problem.torque,
    )
    state = mirrored.solve(method)
    assert_same(state.normal_forces[::-1], state.rotation, mirrored, state)


@searched
@given(problems(), METHODS)
def test_motions_counted_the_other_way_round_change_their_sign(problem: Drawn, method: str) -> None:
    plain = problem.solve(method)
    other = Drawn(problem.compliance, -problem.levers, problem.gaps, -problem.torque).solve(method)
    assert np.array_equal(other.normal_forces, plain.normal_forces)
    assert other.rotation == -plain.rotation


@searched
@given(problems(), numbers(-100, 100), METHODS)
def test_a_common_gap_angle_goes_into_the_rotation(
    problem: Drawn, offset: float, method: str
) -> None:
    moved = Drawn(
        problem.compliance, problem.levers, problem.gaps + offset * problem.levers, problem.torque
    )
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


@searched
@given(problems(), numbers(1.01, 100), METHODS)
def test_more_torque_turns_further(problem: Drawn, factor: float, method: str) -> None:
    more = Drawn(problem.compliance, problem.levers, problem.gaps, factor * problem.torque).solve(
        method
    )
    less = problem.solve(method)
    assert more.rotation > less.rotation


@searched
@given(problems(), st.data(), METHODS)
def test_a_pair_that_stays_open_changes_nothing(problem: Drawn, data, method: str) -> None:
    n = problem.gaps.size
    plain = problem.solve(method)
    reach = data.draw(arrays(float, n, elements=numbers(-1e-2, 1e-2)))
    lever = data.draw(numbers(-2, 2))
    left = data.draw(numbers(1e-3, 10))
    place = data.draw(st.integers(0, n))
    wider = np.insert(np.insert(problem.compliance, place, reach, axis=0), place, 0.0, axis=1)
    wider[:, place] = np.insert(reach, place, 2.0)
    wide = Drawn(
        wider,
        np.insert(problem.levers, place, lever),
        np.insert(
            problem.gaps,
            place,
            lever * plain.rotation - reach @ plain.normal_forces + left * (1 + plain.rotation),
        ),
        problem.torque,
    )
    state = wide.solve(method)
    assert state.normal_forces[place] == 0.0
    assert_same(np.delete(state.normal_forces, place), state.rotation, problem, plain)


@searched
@given(problems(), numbers(1e-9, 1e9), METHODS)
def test_gaps_and_torque_times_a_number_give_forces_times_that_number(
    problem: Drawn, factor: float, method: str
) -> None:
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
