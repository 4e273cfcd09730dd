"""The general form of the contact loop: several motions, preload, levers of any sign."""

from __future__ import annotations

import re

import numpy as np
import pytest
from scipy.optimize import linprog

import flankload as fl
from flankload import errors
from tests.support.contact_problems import random_problem
from tests.support.tolerances import ROUND_OFF, SOLVER

EPS = float(np.finfo(float).eps)
TEETH = 24
BASE_RADIUS = 20.0
TORQUE = 5000.0 * BASE_RADIUS


def floating_spline() -> tuple[np.ndarray, np.ndarray]:
    """Compliance and levers of a spline whose hub turns and floats: (φ, x, y)."""
    angle = 2 * np.pi * np.arange(TEETH) / TEETH
    levers = np.column_stack([np.full(TEETH, BASE_RADIUS), np.cos(angle), np.sin(angle)])
    compliance = 1e-5 * np.eye(TEETH)
    for offset, part in ((1, 0.2), (2, 0.05)):
        for sign in (-1, 1):
            compliance += 1e-5 * part * np.roll(np.eye(TEETH), sign * offset, axis=1)
    return compliance, levers


def test_centred_spline_shares_equally() -> None:
    compliance, levers = floating_spline()
    state = fl.solve_contact_general(compliance, np.zeros(TEETH), levers, [TORQUE, 0, 0])
    np.testing.assert_allclose(
        state.normal_forces, TORQUE / (TEETH * BASE_RADIUS), rtol=ROUND_OFF, atol=0
    )
    np.testing.assert_allclose(state.motions[1:] / state.motions[0], 0.0, rtol=0, atol=ROUND_OFF)
    assert state.info.backward_error <= 10 * EPS


@pytest.mark.parametrize("radial_load", [1000.0, 2400.0])
def test_radial_load_adds_a_cosine(radial_load: float) -> None:
    compliance, levers = floating_spline()
    state = fl.solve_contact_general(
        compliance, np.zeros(TEETH), levers, [TORQUE, radial_load, 0.0]
    )
    expected = TORQUE / (TEETH * BASE_RADIUS) + 2 * radial_load / TEETH * levers[:, 1]
    np.testing.assert_allclose(
        state.normal_forces, expected, rtol=0, atol=10 * ROUND_OFF * expected.max()
    )


def test_radial_load_lifts_teeth_off() -> None:
    """Beyond M/(2 r_b) the teeth on the far side open; the loads are still held."""
    compliance, levers = floating_spline()
    loads = np.array([TORQUE, 4500.0, 0.0])
    state = fl.solve_contact_general(compliance, np.zeros(TEETH), levers, loads)
    assert 0 < state.active_pairs.size < TEETH
    assert state.normal_forces[0] == state.normal_forces.max()
    np.testing.assert_allclose(
        levers.T @ state.normal_forces, loads, rtol=0, atol=ROUND_OFF * TORQUE
    )
    assert state.final_gap_angles.min() >= 0
    assert state.info.backward_error <= 10 * EPS


@pytest.mark.parametrize("method", ["auto", "primal", "block", "cascade", "load_path"])
@pytest.mark.parametrize("n", [30, 120, 480])
@pytest.mark.parametrize("radial_load", [2400.0, 4500.0])
def test_a_floating_hub_of_many_pairs(n: int, radial_load: float, method: str) -> None:
    """Three motions: a pair that alone holds one of them may not leave for rounding's sake."""
    angle = 2 * np.pi * np.arange(n) / n
    levers = np.column_stack([np.full(n, BASE_RADIUS), np.cos(angle), np.sin(angle)])
    apart = np.abs(angle[:, None] - angle)
    apart = np.minimum(apart, 2 * np.pi - apart)
    compliance = 1e-5 * (np.exp(-n / 24 * apart) + 0.05 * np.eye(n))
    gaps = np.random.default_rng(n).uniform(0, 0.02, n)
    loads = np.array([TORQUE, radial_load, 0.0])
    state = fl.solve_contact_general(compliance, gaps, levers, loads, method=method)
    assert (state.info.rung == "load_path") == (method == "load_path")
    assert state.status == 0
    assert state.info.backward_error <= 10 * EPS
    reference = fl.solve_contact_general(compliance, gaps, levers, loads, method="load_path")
    scale = reference.normal_forces.max()
    np.testing.assert_allclose(
        state.normal_forces, reference.normal_forces, rtol=0, atol=SOLVER * scale
    )


def test_radial_load_beyond_the_drive_flanks_has_no_state() -> None:
    compliance, levers = floating_spline()
    loads = np.array([TORQUE, 6000.0, 0.0])
    with pytest.raises(errors.NoContactState, match="free to move along") as caught:
        fl.solve_contact_general(compliance, np.zeros(TEETH), levers, loads)
    motion = caught.value.motion
    assert loads @ motion > 0
    assert (levers @ motion).max() <= ROUND_OFF * np.abs(levers @ motion).max()


def test_random_problems_against_linear_programming() -> None:
    """A state exists exactly where forces >= 0 can hold the loads; zero levers included."""
    rng = np.random.default_rng(4)
    with_state = without = 0
    for case in range(200):
        q = int(rng.integers(1, 5))
        n = int(rng.integers(q + 1, 13))
        root = rng.standard_normal((n, n))
        compliance = root @ root.T / n + 10.0 ** rng.uniform(-4, 0) * np.eye(n)
        levers = rng.standard_normal((n, q))
        levers[rng.random(n) < 0.1] = 0.0
        gaps = rng.uniform(-0.2, 1.0, n)
        loads = rng.standard_normal(q)
        if case % 2:
            loads = levers.T @ np.abs(rng.standard_normal(n))
        held = linprog(np.zeros(n), A_eq=levers.T, b_eq=loads, method="highs").status == 0
        if np.linalg.matrix_rank(levers) < q:
            continue
        if not held:
            without += 1
            with pytest.raises(errors.NoContactState) as caught:
                fl.solve_contact_general(compliance, gaps, levers, loads)
            work = levers @ caught.value.motion
            assert loads @ caught.value.motion > 0
            assert work.max() <= SOLVER * np.abs(work).max()
            continue
        state = fl.solve_contact_general(compliance, gaps, levers, loads)
        with_state += 1
        assert state.info.unique
        assert state.info.backward_error <= 10 * EPS
        forces = state.normal_forces
        final = compliance @ forces + gaps - levers @ state.motions
        scale = np.abs(compliance) @ forces + np.abs(gaps) + np.abs(levers) @ np.abs(state.motions)
        assert (final >= -20 * EPS * scale).all()
        assert (np.abs(final) <= 20 * EPS * scale)[state.active_pairs].all()
        assert (forces >= 0).all()
    assert with_state > 100
    assert without > 20


@pytest.mark.parametrize("method", ["auto", "single", "block", "load_path", "paper"])
def test_one_motion_is_the_angle_form_bit_for_bit(method: str) -> None:
    """K = diag(b) A, g0 = b ε, B = b, R = m: friction, levers of any sign, preload, no load."""
    rng = np.random.default_rng(31)
    refusals = errors.ContactError if method == "paper" else errors.NoContactState
    solved = refused = 0
    for case in range(120):
        matrix, row, levers, gaps, torque = random_problem(rng, unsymmetric=bool(case % 2))
        if case % 3 == 0:
            row[rng.random(row.size) < 0.3] = 0.0
            row[rng.random(row.size) < 0.3] *= -0.2
        if case % 5 == 0:
            gaps = gaps - 0.5 * gaps.max()
        if case % 7 == 0:
            torque = 0.0
        if not row.max() > 0:
            continue
        warm = rng.permutation(row.size)[:2]
        kind = {
            "method": method,
            "warm_pairs": warm,
            "positive_definite": np.array_equal(row, levers),
        }
        scaled = levers[:, None] * matrix
        try:
            angles = fl.solve_contact(matrix, row, gaps, torque, normal_lever_arms=levers, **kind)
        except refusals as error:
            refused += 1
            with pytest.raises(type(error), match=re.escape(str(error).split(": ")[-1])):
                fl.solve_contact_general(
                    scaled, levers * gaps, levers, torque, load_rows=row, **kind
                )
            continue
        general = fl.solve_contact_general(
            scaled, levers * gaps, levers, torque, load_rows=row, **kind
        )
        solved += 1
        for name in ("normal_forces", "active_pairs", "motions", "tangent"):
            assert np.array_equal(getattr(general, name), getattr(angles, name)), name
        assert np.array_equal(general.final_gap_angles / levers, angles.final_gap_angles)
        assert general.rotation == angles.rotation
        assert general.status == angles.status
        assert general.info == angles.info
    assert solved > 60
    assert refused > 0


def planet_carrier(planets: int, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Compliance of the meshes of a sun with its planets, and levers of the sun: (φ, x, y)."""
    place = 2 * np.pi * np.arange(planets) / planets
    action = place + np.deg2rad(90 + 20)
    levers = np.column_stack([np.full(planets, BASE_RADIUS), np.cos(action), np.sin(action)])
    root = rng.standard_normal((planets, planets))
    return 1e-5 * (np.eye(planets) + 0.1 * root @ root.T), levers


@pytest.mark.parametrize("seed", range(5))
def test_three_planets_share_equally_where_the_sun_floats(seed: int) -> None:
    """With any errors of the pins, three forces at 120 degrees balance only if they are equal."""
    rng = np.random.default_rng(seed)
    compliance, levers = planet_carrier(3, rng)
    pins = 0.1 * rng.standard_normal(3)
    share = TORQUE / (3 * BASE_RADIUS)
    state = fl.solve_contact_general(compliance, pins, levers, [TORQUE, 0, 0])
    np.testing.assert_allclose(state.normal_forces, share, rtol=10 * ROUND_OFF, atol=0)
    # The motion of the sun follows from its three gaps.
    moved = np.linalg.solve(levers, compliance @ np.full(3, share) + pins)
    np.testing.assert_allclose(state.motions, moved, rtol=0, atol=SOLVER * np.abs(moved).max())


@pytest.mark.parametrize("planets", [3, 4])
@pytest.mark.parametrize("seed", range(5))
def test_planets_of_a_fixed_sun_share_by_their_pins_errors(seed: int, planets: int) -> None:
    """Springs of one compliance c side by side: F_k = M/(z r_b) + (mean of e - e_k)/c."""
    rng = np.random.default_rng(seed)
    c = 1e-5
    pins = 0.005 * rng.uniform(-1, 1, planets)
    state = fl.solve_contact_general(
        c * np.eye(planets), pins, np.full(planets, BASE_RADIUS), TORQUE
    )
    expected = TORQUE / (planets * BASE_RADIUS) + (pins.mean() - pins) / c
    assert expected.min() > 0
    np.testing.assert_allclose(
        state.normal_forces, expected, rtol=0, atol=10 * ROUND_OFF * expected.max()
    )
    assert np.ptp(state.normal_forces) > 0.02 * expected.mean()


@pytest.mark.parametrize("seed", range(5))
def test_four_planets_of_a_floating_sun_share_in_pairs(seed: int) -> None:
    """Opposite planets carry the same: M/(4 r_b) ± (e_1 + e_3 - e_0 - e_2)/(4 c)."""
    rng = np.random.default_rng(seed)
    _, levers = planet_carrier(4, rng)
    c = 1e-5
    pins = 0.005 * rng.uniform(-1, 1, 4)
    state = fl.solve_contact_general(c * np.eye(4), pins, levers, [TORQUE, 0, 0])
    apart = (pins[1] + pins[3] - pins[0] - pins[2]) / (4 * c)
    expected = TORQUE / (4 * BASE_RADIUS) + apart * np.array([1, -1, 1, -1])
    assert expected.min() > 0
    np.testing.assert_allclose(
        state.normal_forces, expected, rtol=0, atol=10 * ROUND_OFF * expected.max()
    )


def held_by_springs(
    compliance: np.ndarray, gaps: np.ndarray, loads: np.ndarray, stiffness: float
) -> fl.ContactState:
    """Springs on the two shifts folded into the matrix: a supported motion is not an unknown."""
    levers = floating_spline()[1]
    shifts = levers[:, 1:]
    return fl.solve_contact_general(
        compliance + shifts @ shifts.T / stiffness,
        gaps - shifts @ loads[1:] / stiffness,
        levers[:, 0],
        loads[0],
    )


def test_springs_of_a_bearing_folded_and_as_pairs() -> None:
    """A spring S replaces two pairs of compliance 2/S that press from both sides."""
    compliance, levers = floating_spline()
    loads, stiffness = np.array([TORQUE, 1000.0, -400.0]), 3e5
    folded = held_by_springs(compliance, np.zeros(TEETH), loads, stiffness)
    bearing = np.zeros((4, 3))
    bearing[:, 1:] = [[1, 0], [-1, 0], [0, 1], [0, -1]]
    matrix = np.zeros((TEETH + 4, TEETH + 4))
    matrix[:TEETH, :TEETH] = compliance
    matrix[TEETH:, TEETH:] = 2.0 / stiffness * np.eye(4)
    pressed = np.append(np.zeros(TEETH), np.full(4, -0.1))
    bordered = fl.solve_contact_general(matrix, pressed, np.vstack([levers, bearing]), loads)
    largest = folded.normal_forces.max()
    np.testing.assert_allclose(
        bordered.normal_forces[:TEETH], folded.normal_forces, rtol=0, atol=SOLVER * largest
    )
    np.testing.assert_allclose(bordered.motions[0], folded.rotation, rtol=SOLVER, atol=0)
    carried = loads[1:] - levers[:, 1:].T @ folded.normal_forces
    np.testing.assert_allclose(
        bordered.motions[1:], carried / stiffness, rtol=SOLVER, atol=SOLVER * 1e-3
    )
    assert np.abs(bordered.motions[1:]).min() > 1e-4


def test_a_stiff_bearing_is_a_fixed_centre() -> None:
    """The difference that a support of stiffness S leaves falls with 1/S."""
    compliance, levers = floating_spline()
    loads = np.array([TORQUE, 1000.0, -400.0])
    gaps = 1e-3 * levers[:, 1]
    gaps -= gaps.min()
    fixed = fl.solve_contact_general(compliance, gaps, levers[:, 0], TORQUE)
    assert np.ptp(fixed.normal_forces) > 0.05 * fixed.normal_forces.max()
    left = []
    for stiffness in (1e9, 1e11):
        held = held_by_springs(compliance, gaps, loads, stiffness)
        left.append(np.abs(held.normal_forces - fixed.normal_forces).max())
    np.testing.assert_allclose(left[0] / left[1], 100.0, rtol=0.01, atol=0)


def test_preload_needs_no_load() -> None:
    """Drive and coast flank with interference: both press with d / (2 c), and nothing turns."""
    overlap, c = 0.01, 1e-4
    state = fl.solve_contact_general(c * np.eye(2), [-overlap, -overlap], [30.0, -30.0], 0.0)
    np.testing.assert_allclose(state.normal_forces, overlap / c, rtol=ROUND_OFF, atol=0)
    np.testing.assert_allclose(state.rotation, 0.0, rtol=0, atol=ROUND_OFF * overlap)


def test_a_pair_whose_normal_meets_the_axis_carries_its_overlap() -> None:
    state = fl.solve_contact_general(np.diag([1e-4, 2e-4]), [-0.02, 0.0], [0.0, 30.0], 300.0)
    np.testing.assert_allclose(state.normal_forces, [200.0, 10.0], rtol=ROUND_OFF, atol=0)
    np.testing.assert_allclose(state.rotation, 10.0 * 2e-4 / 30.0, rtol=ROUND_OFF, atol=0)


@pytest.mark.parametrize("method", ["auto", "block", "load_path"])
def test_a_motion_that_no_pair_holds_is_named(method: str) -> None:
    rows = np.column_stack([np.ones(3), np.zeros(3)])
    with pytest.raises(errors.SingularContact, match=r"^motions: .* along 0, 1$") as caught:
        fl.solve_contact_general(np.eye(3), np.zeros(3), rows, [1.0, 0.0], method=method)
    assert caught.value.motion.tolist() == [0.0, 1.0]
    with pytest.raises(errors.SingularContact, match=r"^load_rows: .* along 0, 1$"):
        fl.solve_contact_general(
            np.eye(3), np.zeros(3), np.ones((3, 2)), [1.0, 0.0], load_rows=rows, method=method
        )


def test_a_motion_on_which_no_force_works_is_found_in_any_units() -> None:
    """Fewer pairs than motions: the one that is named does no work on any force."""
    rng = np.random.default_rng(17)
    for _ in range(50):
        q = int(rng.integers(2, 5))
        rows = rng.normal(size=(int(rng.integers(1, q)), q)) * 10.0 ** rng.uniform(-20, 20, q)
        n = len(rows)
        loads = rng.uniform(1, 2, n) @ rows
        with pytest.raises(errors.SingularContact) as caught:
            fl.solve_contact_general(np.eye(n), np.zeros(n), rows, loads)
        motion = caught.value.motion
        assert motion.max() == np.abs(motion).max() == 1.0
        work = np.abs(rows * motion).sum(axis=1)
        np.testing.assert_array_less(np.abs(rows @ motion), ROUND_OFF * work)


def test_one_motion_without_levers_is_named() -> None:
    with pytest.raises(errors.SingularContact, match=r"^motions: .* along 1$"):
        fl.solve_contact_general(np.eye(2), [-1.0, 0.0], [0.0, 0.0], 0.0)


def test_a_load_against_all_levers_has_no_state() -> None:
    with pytest.raises(errors.NoContactState) as caught:
        fl.solve_contact_general(np.eye(2), [0, 0], [1, 1], -1.0)
    assert caught.value.code == -1
    assert caught.value.largest_torque == 0.0
    assert caught.value.motion.tolist() == [-1.0]


def test_own_backward_error_where_influences_cancel() -> None:
    """Pair 0, without lever, is pressed as pair 1 lifts: only its gap of 1e-9 remains."""
    compliance = [[0.9, -0.3], [-0.3, 0.7]]
    state = fl.solve_contact_general(compliance, [1e-9, 0.0], [0.0, 1.0], 1e5 / 3)
    expected = [(1e4 - 1e-9) / 0.9, 1e5 / 3]
    np.testing.assert_allclose(state.normal_forces, expected, rtol=ROUND_OFF, atol=0)
    assert state.info.backward_error <= 10 * EPS


@pytest.mark.parametrize("method", ["auto", "single", "block", "load_path"])
def test_no_load_on_several_motions(method: str) -> None:
    """All forces are exactly zero, and the motion is one at which the pairs just touch."""
    rng = np.random.default_rng(0)
    for q in (1, 2, 3, 4):
        gaps, levers = rng.uniform(0, 1, 9), rng.standard_normal((9, q))
        for motions in (levers, np.abs(levers), -np.abs(levers)):
            state = fl.solve_contact_general(
                np.eye(9), gaps, motions, np.zeros(q), method=method, warm_pairs=[3, 5]
            )
            assert not state.normal_forces.any()
            assert state.active_pairs.size == 0
            assert state.status == 0
            assert state.info.backward_error <= 10 * EPS
            left = gaps - motions @ state.motions
            np.testing.assert_allclose(state.final_gap_angles, left, rtol=0, atol=1e3 * ROUND_OFF)
            assert (state.final_gap_angles == 0).sum() >= q


@pytest.mark.parametrize("method", ["auto", "single", "block", "load_path"])
def test_preload_beside_a_motion_without_load(method: str) -> None:
    """Drive and coast flank press each other; the pairs that only place the hub carry nothing."""
    rng = np.random.default_rng(1)
    for _ in range(20):
        levers = np.array([[30.0, 0.0], [-30.0, 0.0], [0.0, 0.7], [0.0, 0.9]])
        coupling = np.zeros((4, 4))
        coupling[2:, :2] = 3e-5 * rng.uniform(size=(2, 2))
        compliance = 1e-4 * np.eye(4) + coupling + coupling.T
        gaps = np.r_[-0.01, -0.01, rng.uniform(0, 1, 2)]
        state = fl.solve_contact_general(compliance, gaps, levers, [0.0, 0.0], method=method)
        np.testing.assert_allclose(
            state.normal_forces, [100, 100, 0, 0], rtol=1e3 * ROUND_OFF, atol=0
        )
        assert state.active_pairs.tolist() == [0, 1]
        assert state.info.backward_error <= 10 * EPS


@pytest.mark.parametrize("method", ["auto", "block", "load_path"])
def test_a_pair_that_the_load_presses_and_the_motion_opens(method: str) -> None:
    """F = 1 and 1 + 0.5 + motion = 0: the pair is open at the start, its gap counts."""
    state = fl.solve_contact_general([[1.0]], [0.5], [-1.0], 1.0, load_rows=[1.0], method=method)
    np.testing.assert_allclose(state.normal_forces, [1.0], rtol=ROUND_OFF, atol=0)
    np.testing.assert_allclose(state.rotation, -1.5, rtol=ROUND_OFF, atol=0)
    assert state.info.backward_error <= 10 * EPS


def test_an_open_problem_asks_nothing_of_lapack(capfd: pytest.CaptureFixture[str]) -> None:
    """No pair can close and no load acts on the motion, so no matrix is factored."""
    matrix = np.array([[2.0, -1.0], [1.0, 2.0]])
    state = fl.solve_contact_general(matrix, [1.0, 1.0], [1.0, 0.0], 0.0, positive_definite=True)
    assert not state.normal_forces.any()
    assert state.status == 0
    assert capfd.readouterr() == ("", "")


def test_a_proof_without_possible_pairs_is_quiet(capfd: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(errors.NegativeForce) as caught:
        fl.solve_contact_general(np.eye(2), [0, 0], [1, 1], -1.0, method="paper")
    assert caught.value.state.normal_forces.min() < 0.0
    assert capfd.readouterr() == ("", "")
