"""Arguments of `solve_contact` that make no problem: one line that names the fault."""

from __future__ import annotations

import tracemalloc
from typing import Any

import numpy as np
import pytest

import flankload as fl
from flankload import _core, errors
from tests.support.contact_problems import THREE

EPS = np.finfo(float).eps
MATRIX = np.array([[10, 7, 5], [7, 10, 7], [5, 7, 10.0]])


def refusal(code: int, **changed: Any) -> str:
    """The message for a good problem with some arguments changed."""
    arguments: dict[str, Any] = {
        "flexibility_matrix": MATRIX,
        "lever_arms": np.ones(3),
        "gap_angles": np.zeros(3),
        "torque": 5.0,
    } | changed
    with pytest.raises(errors.InputError) as caught:
        fl.solve_contact(**arguments)
    assert caught.value.code == code
    assert isinstance(caught.value, ValueError)
    return str(caught.value)


def test_matrix_that_is_not_square() -> None:
    message = refusal(-4, flexibility_matrix=MATRIX[:2])
    assert message == "flexibility_matrix: expected shape (2, 2), found (2, 3)"


def test_matrix_with_one_axis() -> None:
    message = refusal(-4, flexibility_matrix=[1.0])
    assert message == "flexibility_matrix: expected 2 axes, found shape (1,)"


@pytest.mark.parametrize("name", ["lever_arms", "gap_angles", "normal_lever_arms"])
def test_number_in_place_of_a_vector(name: str) -> None:
    message = refusal(-4, **{name: 1.0})
    assert message == f"{name}: expected an array of shape (n,), found a single number"


def test_number_in_place_of_the_matrix() -> None:
    message = refusal(-4, flexibility_matrix=5)
    assert message == (
        "flexibility_matrix: expected an array of shape (n, n), found a single number"
    )


@pytest.mark.parametrize(
    "name", ["flexibility_matrix", "lever_arms", "gap_angles", "normal_lever_arms", "torque"]
)
def test_complex_numbers_are_not_cut_down_to_their_real_part(name: str) -> None:
    shape = {"flexibility_matrix": (3, 3), "torque": ()}.get(name, (3,))
    message = refusal(-4, **{name: np.full(shape, 1.0 + 0j)})
    assert message == f"{name}: expected real numbers, found complex128"


@pytest.mark.parametrize("name", ["compliance_matrix", "normal_gaps", "motions", "load_rows"])
def test_general_form_refuses_complex_numbers_and_single_ones(name: str) -> None:
    good: dict[str, Any] = {
        "compliance_matrix": MATRIX,
        "normal_gaps": np.zeros(3),
        "motions": np.ones(3),
        "load_rows": np.ones(3),
    }
    for bad, words in ((good[name] * 1j, "found complex128"), (1.0, "expected .*shape")):
        with pytest.raises(errors.InputError, match=f"^{name}: .*{words}"):
            fl.solve_contact_general(**good | {name: bad}, loads=1.0)


def test_general_form_refuses_complex_loads() -> None:
    with pytest.raises(errors.InputError, match=r"^loads: expected real numbers"):
        fl.solve_contact_general(MATRIX, np.zeros(3), np.ones(3), 1j)


def test_integer_beyond_any_float() -> None:
    assert refusal(-4, gap_angles=[10**400, 0, 0]).startswith("gap_angles: expected an array of")


def test_no_pairs() -> None:
    message = refusal(-4, flexibility_matrix=np.empty((0, 0)), lever_arms=[], gap_angles=[])
    assert "at least one pair" in message


@pytest.mark.parametrize("name", ["lever_arms", "gap_angles", "normal_lever_arms"])
def test_vector_of_the_wrong_length(name: str) -> None:
    assert refusal(-4, **{name: np.ones(4)}) == f"{name}: expected shape (3,), found (4,)"


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("name", ["lever_arms", "gap_angles", "normal_lever_arms"])
def test_vector_with_nan_or_infinity(name: str, bad: float) -> None:
    message = refusal(-4, **{name: [1.0, bad, 1.0]})
    assert message == f"{name}: expected finite numbers, found {bad} at [1]"


def test_matrix_with_nan() -> None:
    matrix = MATRIX.copy()
    matrix[2, 1] = np.nan
    message = refusal(-4, flexibility_matrix=matrix)
    assert message == "flexibility_matrix: expected finite numbers, found nan at [2, 1]"


def test_words_in_place_of_numbers() -> None:
    assert refusal(-4, gap_angles=["a", "b", "c"]).startswith("gap_angles: expected an array")


def test_negative_torque() -> None:
    assert refusal(-4, torque=-1.0) == "torque: expected a number >= 0, found -1"


def test_torque_that_is_a_list() -> None:
    assert refusal(-4, torque=[1.0, 2.0]) == "torque: expected a number, found shape (2,)"


def test_torque_nan() -> None:
    assert refusal(-4, torque=np.nan).startswith("torque: expected finite numbers, found nan")


def test_unknown_method_names_the_available_ones() -> None:
    assert refusal(-4, method="lemke") == (
        "method: expected one of 'auto', 'single', 'paper', 'block', 'load_path', 'cascade', "
        "'primal', found 'lemke'"
    )


def test_row_scale_of_zero() -> None:
    message = refusal(-5, lever_arms=[1.0, 0.0, 1.0])
    assert message == "lever_arms: expected row scales > 0, found 0 at pair 1"


def test_negative_row_scale() -> None:
    message = refusal(-5, normal_lever_arms=[1.0, 1.0, -2.0])
    assert message == "normal_lever_arms: expected row scales > 0, found -2 at pair 2"


def test_no_lever_arm_above_zero() -> None:
    assert refusal(-5, lever_arms=[-1.0, -1.0, -2.0]).startswith(
        "lever_arms: expected at least one > 0"
    )


def test_diagonal_that_is_not_positive() -> None:
    matrix = MATRIX.copy()
    matrix[1, 1] = 0.0
    message = refusal(-5, flexibility_matrix=matrix)
    assert message == "flexibility_matrix: expected a diagonal > 0, found 0 at pair 1"


@pytest.mark.parametrize(
    ("warm", "words"),
    [
        ([3], "from 0 to 2, found 3"),
        ([-1, 0], "found -1"),
        ([0, 0], "found a pair twice"),
        ([0.5], "list of integers"),
    ],
)
def test_warm_pairs_that_are_none(warm: list[float], words: str) -> None:
    message = refusal(-4, warm_pairs=warm)
    assert message.startswith("warm_pairs: expected")
    assert words in message


def test_general_form_with_loads_that_do_not_fit() -> None:
    with pytest.raises(errors.InputError, match=r"motions: expected shape \(3, 2\), found \(3,\)"):
        fl.solve_contact_general(MATRIX, np.zeros(3), np.ones(3), [1.0, 2.0])


def test_method_paper_takes_one_motion() -> None:
    with pytest.raises(errors.InputError, match="'paper' expected one motion"):
        fl.solve_contact_general(MATRIX, np.zeros(3), np.eye(3), np.ones(3), method="paper")


def test_lists_singles_and_strides_are_the_same_problem() -> None:
    gaps = np.array([0.5, 0.0, 0.25])
    reference = fl.solve_contact(MATRIX, np.ones(3), gaps, 5.0)
    padded = np.zeros((6, 6))
    padded[::2, ::2] = MATRIX
    for matrix in (
        MATRIX.tolist(),
        MATRIX.astype(np.float32),
        np.asfortranarray(MATRIX),
        padded[::2, ::2],
    ):
        state = fl.solve_contact(
            matrix, [1, 1, 1], gaps.astype(np.float32)[::-1][::-1], np.float32(5)
        )
        assert state.normal_forces.tolist() == reference.normal_forces.tolist()
        assert state.rotation == reference.rotation


def test_arguments_stay_as_they_were() -> None:
    matrix, gaps = MATRIX.copy(), np.array([0.5, 0.0, 0.25])
    fl.solve_contact(matrix, np.ones(3), gaps, 5.0)
    assert matrix.tolist() == MATRIX.tolist()
    assert gaps.tolist() == [0.5, 0.0, 0.25]


def test_failures_leave_no_numbers_behind() -> None:
    """Singular and refused problems at the flat interface: every output is NaN, no pair is active.

    But for the motion that no pair holds.
    """
    none = np.empty(0, dtype=np.int32)
    levers = np.asfortranarray(np.column_stack([np.ones(3), np.zeros(3)]))
    singular = _core.flankload_solve_contact(
        np.asfortranarray(MATRIX), np.zeros(3), levers, levers, np.array([1.0, 0.0]), 1, 1, none
    )
    assert singular[-1] == -3
    column = np.ones((3, 1), order="F")
    refused = _core.flankload_solve_contact(
        np.asfortranarray(-MATRIX), np.zeros(3), column, column, np.ones(1), 1, 1, none
    )
    assert refused[-1] == -5
    unknown = _core.flankload_solve_contact(
        np.asfortranarray(MATRIX), np.zeros(3), column, column, np.ones(1), 1, 99, none
    )
    assert unknown[-1] == -110
    np.testing.assert_array_equal(singular[2], [0.0, 1.0])
    for outcome in (singular, refused, unknown):
        forces, gaps, motion, tangent, active, _, certificate, _ = outcome
        for numbers in (forces, gaps, tangent, certificate):
            assert np.isnan(numbers).all()
        assert np.isnan(motion).all() or outcome is singular
        assert not active.any()


def test_states_are_frozen() -> None:
    state = fl.solve_contact(MATRIX, np.ones(3), np.zeros(3), 5.0)
    with pytest.raises(AttributeError):
        state.rotation = 0.0  # type: ignore[misc]


def test_arrays_of_a_state_are_read_only() -> None:
    angles = fl.solve_contact(MATRIX, np.ones(3), np.zeros(3), 5.0)
    general = fl.solve_contact_general(MATRIX, np.zeros(3), np.ones(3), 5.0)
    with pytest.raises(errors.NegativeForce) as caught:
        fl.solve_contact(THREE, np.ones(3), [1, 0, 1], 10.0, method="paper")
    for state in (angles, general, caught.value.state):
        arrays = [part for part in vars(state).values() if isinstance(part, np.ndarray)]
        assert len(arrays) == 5
        for numbers in arrays:
            with pytest.raises(ValueError, match="read-only"):
                numbers[...] = 0


# --- one pass over the matrix ---------------------------------------------------------------------
MANY = 90  # more pairs than a tile of the pass, no multiple of it


def many_pairs(*, friction: float = 0.0, row_scales: float = 0.0) -> dict[str, Any]:
    """A parabola that presses on neighbours; row scales equal to a part, or one for all."""
    place = np.linspace(-1.0, 1.0, MANY)
    apart = place[:, np.newaxis] - place
    compliance = 1e-5 * (0.5 + np.exp(-3.0 * np.abs(apart)) + friction * apart)
    levers = 30.0 * (1.0 + row_scales * place)
    return {
        "flexibility_matrix": compliance / levers[:, np.newaxis],
        "lever_arms": levers * (1.0 + 0.1 * friction * place),
        "gap_angles": 1e-3 * place**2 / levers,
        "torque": 500.0,
        "normal_lever_arms": levers,
    }


def layouts(matrix: np.ndarray) -> dict[str, np.ndarray]:
    """The same numbers by rows, by columns, with gaps between them and backwards; read-only."""
    spread = np.zeros((2 * MANY, 3 * MANY))
    spread[::2, ::3] = matrix
    found = {
        "rows": np.ascontiguousarray(matrix),
        "columns": np.asfortranarray(matrix),
        "spread": spread[::2, ::3],
        "backwards": np.ascontiguousarray(matrix[::-1, ::-1])[::-1, ::-1],
    }
    for numbers in found.values():
        numbers.flags.writeable = False
    return found


@pytest.mark.parametrize("row_scales", [0.0, 0.01])
@pytest.mark.parametrize("friction", [0.0, 0.2])
def test_layout_of_the_matrix_changes_no_bit(friction: float, row_scales: float) -> None:
    """Matrices are symmetric to the last bit, nearly symmetric or not, and are not modified."""
    problem = many_pairs(friction=friction, row_scales=row_scales)
    rounded = problem["flexibility_matrix"].copy()
    rounded[np.triu_indices(MANY, 1)] *= 1.0 + 2e-16
    for matrix in (problem["flexibility_matrix"], rounded):
        states = {
            name: fl.solve_contact(**problem | {"flexibility_matrix": laid})
            for name, laid in layouts(matrix).items()
        }
        many = fl.solve_contact_torques(**_of_torques(problem, matrix))
        assert 2 < states["rows"].active_pairs.size < MANY - 2
        assert np.array_equal(many[0].normal_forces, states["rows"].normal_forces)
        for state in states.values():
            for name in ("normal_forces", "final_gap_angles", "motions", "tangent"):
                assert np.array_equal(getattr(state, name), getattr(states["rows"], name)), name
            assert state.info == states["rows"].info


def _of_torques(problem: dict[str, Any], matrix: np.ndarray) -> dict[str, Any]:
    """The same for a list of one torque."""
    rest = {name: value for name, value in problem.items() if name != "torque"}
    return rest | {"flexibility_matrix": matrix, "torques": [problem["torque"]]}


@pytest.mark.parametrize("order", ["C", "F"])
@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_number_that_no_solution_reads(bad: float, order: Any) -> None:
    """Columns of open pairs, beside the diagonal and in the corners of tiles, with its mirror."""
    problem = many_pairs()
    for i, j in [(0, 89), (89, 0), (1, 0), (88, 89), (40, 3), (39, 80), (80, 87), (87, 80), (5, 5)]:
        for mirrored in (False, True):
            matrix = np.array(problem["flexibility_matrix"], order=order)
            matrix[i, j] = bad
            if mirrored:
                matrix[j, i] = bad
            place = min([i, j], [j, i]) if mirrored else [i, j]
            with pytest.raises(errors.InputError, match="expected finite numbers") as caught:
                fl.solve_contact(**problem | {"flexibility_matrix": matrix})
            assert str(caught.value).endswith(f"found {bad} at {place}")


@pytest.mark.parametrize("n", [1, 3, 90, 643])
def test_one_entry_decides_the_known_form_of_the_matrix(n: int) -> None:
    """Symmetric, allowed by the diagonal, symmetric to the last bit: any entry can end these."""
    rng = np.random.default_rng(7)
    matrix = np.asfortranarray(rng.random((n, n)))
    matrix = np.asfortranarray(0.4 * (matrix + matrix.T))
    np.fill_diagonal(matrix, 1.0 + rng.random(n))
    assert _core.flankload_matrix_form(matrix) == (1, 1, 1, 1, 0)
    places = rng.integers(0, n, (40, 2)).tolist()
    for i, j in [*places, [n - 1, n - 2], [0, n - 1], [n // 2, n // 2 - 1], [n // 2, 0]]:
        if i == j or n == 1:
            continue
        bound = np.sqrt(matrix[i, i] * matrix[j, j])
        value = matrix[i, j]
        for part, form in ((3e-12, (0, 0, 0, 1, 0)), (3e-13, (1, 1, 0, 1, 0))):
            matrix[i, j] = value + part * bound
            assert _core.flankload_matrix_form(matrix) == form, (i, j, part)
        for bad in (np.nan, np.inf):
            matrix[i, j] = bad
            assert _core.flankload_matrix_form(matrix) == (0, 0, 0, 0, 0), (i, j, bad)
            matrix[j, i] = bad
            assert _core.flankload_matrix_form(matrix) == (0, 0, 0, 0, 0), (i, j, bad)
        matrix[i, j] = matrix[j, i] = -bound * (1.0 + 3e-12)
        assert _core.flankload_matrix_form(matrix) == (1, 0, 1, 1, 0), (i, j)
        matrix[i, j] = matrix[j, i] = value
    assert _core.flankload_matrix_form(matrix) == (1, 1, 1, 1, 0)


def test_large_numbers_are_finite_though_their_sum_is_not() -> None:
    matrix = np.asfortranarray(np.full((MANY, MANY), 1e307))
    matrix[0, 1] *= 2.0
    assert _core.flankload_matrix_form(matrix) == (0, 0, 0, 1, 0)


@pytest.mark.parametrize("order", ["C", "F"])
def test_symmetric_matrix_is_not_copied(order: Any) -> None:
    problem = many_pairs()
    matrix = problem["flexibility_matrix"]
    matrix = np.array(0.5 * (matrix + matrix.T), order=order)
    problem["flexibility_matrix"] = matrix
    general = {
        "compliance_matrix": matrix,
        "normal_gaps": problem["gap_angles"],
        "motions": np.ones(MANY),
        "loads": problem["torque"] / 30.0,
    }
    for solve, arguments in ((fl.solve_contact, problem), (fl.solve_contact_general, general)):
        solve(**arguments)
        tracemalloc.start()
        solve(**arguments)
        _, peak = tracemalloc.get_traced_memory()
        tracemalloc.stop()
        assert peak < 0.5 * matrix.nbytes


@pytest.mark.parametrize("friction", [0.0, 0.2])
def test_one_row_scale_for_many_pairs_is_the_general_form(friction: float) -> None:
    """They agree to rounding: the loads are scaled instead of computing diag(b) A."""
    problem = many_pairs(friction=friction)
    levers, torque = problem["normal_lever_arms"], problem["torque"]
    general = fl.solve_contact_general(
        levers[:, np.newaxis] * problem["flexibility_matrix"],
        levers * problem["gap_angles"],
        levers,
        torque,
        load_rows=problem["lever_arms"],
    )
    matrices = [problem["flexibility_matrix"]]
    row, gaps = problem["lever_arms"], problem["gap_angles"]
    sequence = fl.solve_contact_sequence(
        matrices, [row], [gaps], torque, normal_lever_arms=[levers]
    )
    listed = fl.solve_contact_torques(**_of_torques(problem, matrices[0]))
    for state in (fl.solve_contact(**problem), *listed, *sequence):
        assert np.array_equal(state.active_pairs, general.active_pairs)
        assert (state.status, state.info.uniqueness) == (general.status, general.info.uniqueness)
        largest = general.normal_forces.max()
        np.testing.assert_allclose(
            state.normal_forces, general.normal_forces, rtol=0, atol=1e-12 * largest
        )
        np.testing.assert_allclose(
            levers * state.final_gap_angles, general.final_gap_angles, rtol=1e-9, atol=1e-15
        )
        np.testing.assert_allclose(state.rotation, general.rotation, rtol=1e-12, atol=0)
        np.testing.assert_allclose(state.tangent, general.tangent, rtol=1e-12, atol=0)


def test_one_row_scale_names_the_torque_that_can_be_held() -> None:
    """The torque is in the caller's unit, as in the general form."""
    problem = many_pairs()
    levers = problem["normal_lever_arms"]
    problem["lever_arms"] = levers * np.where(np.abs(np.linspace(-1, 1, MANY)) < 0.1, 1.0, -1.0)
    with pytest.raises(errors.NoContactState) as of_angles:
        fl.solve_contact(**problem)
    with pytest.raises(errors.NoContactState) as general:
        fl.solve_contact_general(
            levers[:, np.newaxis] * problem["flexibility_matrix"],
            levers * problem["gap_angles"],
            levers,
            problem["torque"],
            load_rows=problem["lever_arms"],
        )
    found, expected = of_angles.value.largest_torque, general.value.largest_torque
    assert 0.0 < expected < problem["torque"]
    np.testing.assert_allclose(found, expected, rtol=1e-6, atol=0)


@pytest.mark.parametrize("order", ["C", "F"])
def test_a_declared_matrix_is_not_read_as_a_whole(order: str) -> None:
    """Entries that are not probed may break its symmetry, and its transpose may be another matrix:
    the state is that of K, and its uniqueness is not claimed where the pairs in contact deny it."""
    n = 70
    apart = np.abs(np.subtract.outer(np.arange(n), np.arange(n)))
    base = np.exp(-apart / 9.0) + 0.1 * np.eye(n)
    gaps = 2e-2 * (np.arange(n) - 30.0) ** 2

    def solve(matrix: Any, gaps: Any, known: bool) -> fl.ContactState:
        return fl.solve_contact(matrix, np.ones(n), gaps, 9.0, positive_definite=known)

    for place, size in (((25, 33), 0.3), ((33, 25), 0.3), ((5, 33), 0.05), ((33, 29), 1e-9)):
        matrix = np.array(base, order=order)
        matrix[place] += size
        state, proven = (solve(matrix, gaps, known) for known in (True, False))
        assert (state.status, state.info.uniqueness) == (0, "elastic"), place
        assert state.info.backward_error <= 10.0 * EPS
        np.testing.assert_allclose(state.normal_forces, proven.normal_forces, rtol=0, atol=1e-12)
    # the same state, although the symmetric part of these two pairs is not definite
    forces = solve(base, gaps, known=True).normal_forces
    for i, j in ((24, 36), (36, 24)):
        matrix, shifted = np.array(base, order=order), gaps.copy()
        matrix[i, j] += 2.0
        shifted[i] -= 2.0 * forces[j]
        state = solve(matrix, shifted, known=True)
        np.testing.assert_allclose(state.normal_forces, forces, rtol=0, atol=1e-12)
        assert (state.status, state.info.uniqueness) == (3, "not certain")
    for bad, place, message in (
        (np.nan, (28, 31), r"found nan at \[28, 31\]"),
        (-1.0, (12, 12), "diagonal > 0, found -1 at pair 12"),
    ):
        matrix = np.array(base, order=order)
        matrix[place] = bad
        with pytest.raises(errors.InputError, match=message):
            solve(matrix, gaps, known=True)
