"""Many contact problems in one call: torques of a list, sequences of positions."""

from __future__ import annotations

import ctypes

import numpy as np
import pytest

import flankload as fl
from flankload import errors
from tests.support.contact_problems import flank_problem, random_problem
from tests.support.tolerances import ROUND_OFF, SOLVER

EPS = float(np.finfo(float).eps)
JAMMING = np.array([[1.0, 1.5], [0.5, 1.0]])


def same(one: fl.ContactState, other: fl.ContactState) -> None:
    """The same state to the accuracy of the solver, each with its own certificate."""
    scale = max(other.normal_forces.max(), 1e-300)
    np.testing.assert_allclose(one.normal_forces, other.normal_forces, rtol=0, atol=SOLVER * scale)
    np.testing.assert_allclose(one.rotation, other.rotation, rtol=SOLVER, atol=0)
    np.testing.assert_allclose(one.tangent, other.tangent, rtol=SOLVER, atol=0)
    assert one.active_pairs.tolist() == other.active_pairs.tolist()
    assert one.status == other.status
    assert one.info.backward_error <= 10 * EPS


@pytest.mark.parametrize("method", ["auto", "single", "cascade", "load_path"])
@pytest.mark.parametrize("friction", [0.0, 0.2])
@pytest.mark.parametrize("n", [12, 90, 200])
def test_torques_of_a_list(n: int, friction: float, method: str) -> None:
    rng = np.random.default_rng(n)
    matrix, row, gaps, torque = flank_problem(n, rng, friction=friction)
    torques = torque * np.array([1.0, 0.03, 30.0, 0.0, 1.0, 3.0, 1e-9, 0.5])
    states = fl.solve_contact_torques(
        matrix, row, gaps, torques, normal_lever_arms=np.ones(n), method=method
    )
    assert len(states) == torques.size
    for state, load in zip(states, torques, strict=True):
        same(state, fl.solve_contact(matrix, row, gaps, load, normal_lever_arms=np.ones(n)))


def test_the_load_path_keeps_its_factor() -> None:
    """From torque to torque few pairs join: far fewer than each torque needs by itself."""
    matrix, row, gaps, torque = flank_problem(300, np.random.default_rng(1))
    torques = torque * np.linspace(0.5, 1.5, 40)
    states = fl.solve_contact_torques(matrix, row, gaps, torques)
    alone = [fl.solve_contact(matrix, row, gaps, load) for load in torques]
    together = sum(state.info.pivots for state in states)
    assert together < 0.2 * sum(state.info.pivots for state in alone)
    rotations = np.array([state.rotation for state in states])
    assert (np.diff(rotations) > 0).all()
    for state, other in zip(states, alone, strict=True):
        same(state, other)


def test_no_torques_no_states() -> None:
    assert fl.solve_contact_torques(np.eye(2), [1, 1], [0, 0], []) == ()
    with pytest.raises(errors.InputError, match="found 'lemke'"):
        fl.solve_contact_torques(np.eye(2), [1, 1], [0, 0], [], method="lemke")


def test_a_torque_that_cannot_be_held_loses_no_other_state() -> None:
    with pytest.raises(errors.NoContactState, match=r"^torque 1 \(1 N mm\): ") as caught:
        fl.solve_contact_torques(
            JAMMING, [1, -1], [0, 0.2], [0.1, 1.0, 0.3], normal_lever_arms=[1, 1]
        )
    error = caught.value
    assert error.place == (1,)
    np.testing.assert_allclose(error.largest_torque, 0.4, rtol=1e-9, atol=0)
    first, second, third = error.states
    assert second is None
    assert isinstance(first, fl.ContactState)
    assert isinstance(third, fl.ContactState)
    np.testing.assert_allclose(third.rotation, 0.3, rtol=ROUND_OFF, atol=0)


def wandering_contact(count: int, n: int) -> tuple[list, list, list, list]:
    """A point of contact that wanders over the pairs; pairs are laid around it."""
    rng = np.random.default_rng(3)
    matrices, levers, gaps, keys = [], [], [], []
    for p in range(count):
        size = n + p % 3
        first = 2 * p
        place = (first + np.arange(size)) / n
        apart = np.abs(place[:, None] - place)
        matrices.append(np.exp(-8 * apart) + 0.1 * np.eye(size))
        levers.append(np.full(size, 20.0) + 0.1 * rng.standard_normal(size))
        matrices[-1] /= levers[-1][:, None]
        center = (2 * p + n / 2) / n
        gaps.append(0.5 * (place - center) ** 2)
        keys.append(first + np.arange(size))
    return matrices, levers, gaps, keys


@pytest.mark.parametrize("keyed", [False, True])
def test_a_sequence_is_its_positions(keyed: bool) -> None:
    matrices, levers, gaps, keys = wandering_contact(30, 40)
    states = fl.solve_contact_sequence(
        matrices, levers, gaps, 4.0, pair_keys=keys if keyed else None
    )
    assert len(states) == 30
    for p, state in enumerate(states):
        same(state, fl.solve_contact(matrices[p], levers[p], gaps[p], 4.0))


def test_keys_carry_the_contact_along() -> None:
    """Known by their place, the pairs of the last position are mostly those of this one."""
    matrices, levers, gaps, keys = wandering_contact(32, 120)
    cold = sum(
        fl.solve_contact(*one, 4.0).info.pivots for one in zip(matrices, levers, gaps, strict=True)
    )
    numbered = fl.solve_contact_sequence(matrices, levers, gaps, 4.0)
    keyed = fl.solve_contact_sequence(matrices, levers, gaps, 4.0, pair_keys=keys)
    assert sum(state.info.pivots for state in keyed) < 0.6 * cold
    assert sum(state.info.pivots for state in numbered) < cold


def test_every_position_under_every_torque() -> None:
    matrices, levers, gaps, keys = wandering_contact(11, 70)
    torques = [0.5, 8.0, 2.0]
    lines = fl.solve_contact_sequence(matrices, levers, gaps, torques, pair_keys=keys)
    for p, line in enumerate(lines):
        for torque, state in zip(torques, line, strict=True):
            same(state, fl.solve_contact(matrices[p], levers[p], gaps[p], torque))


def test_answers_are_bitwise_the_same_with_any_number_of_threads() -> None:
    matrices, levers, gaps, keys = wandering_contact(40, 150)
    results = [
        fl.solve_contact_sequence(
            matrices, levers, gaps, [1.0, 5.0], pair_keys=keys, threads=number
        )
        for number in (1, 2, 3, 0)
    ]
    for other in results[1:]:
        for line, twin in zip(results[0], other, strict=True):
            for state, same_state in zip(line, twin, strict=True):
                assert state.normal_forces.tobytes() == same_state.normal_forces.tobytes()
                assert state.final_gap_angles.tobytes() == same_state.final_gap_angles.tobytes()
                assert state.rotation == same_state.rotation
                assert state.info == same_state.info


def test_more_threads_than_a_machine_can_have() -> None:
    one = [np.eye(2)] * 40, np.ones((40, 2)), np.zeros((40, 2)), 1.0
    for threads in (100_000, 2**40):
        assert len(fl.solve_contact_sequence(*one, threads=threads)) == 40


def test_the_threads_of_the_host_program_stay_as_they_were() -> None:
    """OpenMP's number of threads, which is OpenBLAS's too, is the caller's own."""
    openmp = ctypes.CDLL("libgomp.so.1")
    before = openmp.omp_get_max_threads()
    matrices, levers, gaps, _ = wandering_contact(3, 20)
    try:
        openmp.omp_set_num_threads(3)
        fl.solve_contact(matrices[0], levers[0], gaps[0], 1.0)
        fl.solve_contact_torques(matrices[0], levers[0], gaps[0], [1.0, 2.0])
        fl.solve_contact_sequence(matrices, levers, gaps, 1.0, threads=2)
        assert openmp.omp_get_max_threads() == 3
    finally:
        openmp.omp_set_num_threads(before)


def test_friction_and_free_bodies_mix_in_a_sequence() -> None:
    """Symmetric and unsymmetric matrices, each passed to the core with its structure."""
    rng = np.random.default_rng(8)
    problems = [random_problem(rng, unsymmetric=bool(k % 2))[:4] for k in range(20)]
    states = fl.solve_contact_sequence(
        [matrix for matrix, *_ in problems],
        [row for _, row, *_ in problems],
        [gaps for *_, gaps in problems],
        20.0,
        normal_lever_arms=[levers for _, _, levers, _ in problems],
    )
    for (matrix, row, levers, gaps), state in zip(problems, states, strict=True):
        same(state, fl.solve_contact(matrix, row, gaps, 20.0, normal_lever_arms=levers))


def test_a_position_without_state_loses_no_other() -> None:
    levers = [[1.0, -1.0]] * 3
    with pytest.raises(errors.NoContactState, match=r"^position 1: ") as caught:
        fl.solve_contact_sequence(
            [JAMMING] * 3,
            levers,
            [[0, 2.0], [0, 0.2], [0, 3.0]],
            1.0,
            normal_lever_arms=[[1, 1]] * 3,
        )
    assert caught.value.place == (1, 0)
    assert [state is None for state in caught.value.states] == [False, True, False]


@pytest.mark.parametrize(
    ("changed", "line"),
    [
        ({"torque": -1.0}, "torque: expected a number >= 0, found -1"),
        ({"torque": [1.0, -2.0]}, "torque: expected numbers >= 0, found -2"),
        ({"torque": [[1.0]]}, "torque: expected a number or a list, found shape (1, 1)"),
        ({"lever_arms": [[1, 1]]}, "lever_arms: expected one a position, 2, found 1"),
        (
            {"gap_angles": [[0, 0], [0, np.nan]]},
            "position 1: gap_angles: expected finite numbers, found nan at [1]",
        ),
        (
            {"pair_keys": [[0, 1], [2, 2]]},
            "pair_keys: expected each key once, position 1 has one twice",
        ),
        (
            {"pair_keys": [[0, 1], [0.5, 2]]},
            "pair_keys: expected 2 integers at position 1, found shape (2,) of float64",
        ),
        ({"threads": -1}, "threads: expected an integer >= 0, found -1"),
        ({"threads": None}, "threads: expected an integer >= 0, found None"),
    ],
)
def test_refusals(changed: dict, line: str) -> None:
    arguments = {
        "flexibility_matrices": [np.eye(2)] * 2,
        "lever_arms": [[1, 1]] * 2,
        "gap_angles": [[0, 0]] * 2,
        "torque": 1.0,
    } | changed
    with pytest.raises(errors.InputError) as caught:
        fl.solve_contact_sequence(**arguments)
    assert str(caught.value) == line
    assert fl.solve_contact_sequence([], [], [], 1.0) == ()
