"""Influence columns on demand: only of pairs that come near contact, and the answer of all."""

from __future__ import annotations

import numpy as np
import pytest

import flankload as fl
from flankload import errors
from tests.support.contact_problems import flank_problem
from tests.support.tolerances import SOLVER

EPS = float(np.finfo(float).eps)


class Columns:
    """Columns of a matrix, and a record of who asked for which."""

    def __init__(self, matrix: np.ndarray) -> None:
        self.matrix = matrix
        self.asked: list[int] = []

    def __call__(self, pairs: np.ndarray) -> np.ndarray:
        self.asked += pairs.tolist()
        return self.matrix[:, pairs]


@pytest.mark.parametrize("method", ["auto", "single", "cascade", "load_path"])
@pytest.mark.parametrize("friction", [0.0, 0.2])
@pytest.mark.parametrize("n", [10, 100, 400])
def test_few_columns_and_the_same_state(n: int, friction: float, method: str) -> None:
    matrix, row, gaps, torque = flank_problem(n, np.random.default_rng(n), friction=friction)
    torque = 0.02 * torque if n == 100 else torque
    source = Columns(matrix)
    state = fl.solve_contact_on_demand(
        source,
        matrix.diagonal(),
        gaps,
        np.ones(n),
        torque,
        load_rows=row,
        method=method,
        symmetric=friction == 0.0,
    )
    whole = fl.solve_contact_general(matrix, gaps, np.ones(n), torque, load_rows=row)
    scale = whole.normal_forces.max()
    np.testing.assert_allclose(
        state.normal_forces, whole.normal_forces, rtol=0, atol=SOLVER * scale
    )
    np.testing.assert_allclose(
        state.final_gap_angles, whole.final_gap_angles, rtol=0, atol=SOLVER * gaps.max()
    )
    np.testing.assert_allclose(state.rotation, whole.rotation, rtol=SOLVER, atol=0)
    np.testing.assert_allclose(state.info.margin, whole.info.margin, rtol=1e-6, atol=1e-12)
    assert state.info.backward_error <= 10 * EPS
    assert len(set(source.asked)) == len(source.asked) == state.info.influence_columns
    assert set(state.active_pairs) <= set(source.asked)
    if n >= 100:
        assert state.info.influence_columns <= 2 * state.active_pairs.size + 16
        assert state.info.influence_columns < 0.6 * n
        # What was not read proves nothing.
        assert state.status == (0 if friction == 0.0 else 3)
    assert whole.info.influence_columns == n


def test_several_motions_on_demand() -> None:
    """A spline with a floating hub: the first columns must hold all motions."""
    n = 200
    angle = 2 * np.pi * np.arange(n) / n
    levers = np.column_stack([np.full(n, 20.0), np.cos(angle), np.sin(angle)])
    apart = np.abs(angle[:, None] - angle)
    matrix = 1e-5 * (np.exp(-8 * np.minimum(apart, 2 * np.pi - apart)) + 0.05 * np.eye(n))
    gaps = np.random.default_rng(1).uniform(0, 0.02, n)
    loads = [1e5, 2400.0, 300.0]
    source = Columns(matrix)
    state = fl.solve_contact_on_demand(source, matrix.diagonal(), gaps, levers, loads)
    whole = fl.solve_contact_general(matrix, gaps, levers, loads)
    scale = whole.normal_forces.max()
    np.testing.assert_allclose(
        state.normal_forces, whole.normal_forces, rtol=0, atol=SOLVER * scale
    )
    assert state.info.influence_columns < 0.6 * n


def test_pairs_that_hold_a_load_are_asked_for_where_the_first_ones_do_not() -> None:
    """Only the last of 60 pairs resists the second motion."""
    n = 60
    levers = np.zeros((n, 2))
    levers[:, 0] = 1.0
    levers[-2:, 1] = [1.0, -1.0]
    gaps = np.zeros(n)
    gaps[-2:] = 3.0
    state = fl.solve_contact_on_demand(
        lambda pairs: np.eye(n)[:, pairs], np.ones(n), gaps, levers, [10.0, 1.0]
    )
    whole = fl.solve_contact_general(np.eye(n), gaps, levers, [10.0, 1.0])
    np.testing.assert_allclose(state.normal_forces, whole.normal_forces, rtol=0, atol=SOLVER * 10)
    with pytest.raises(errors.NoContactState) as caught:
        fl.solve_contact_on_demand(
            lambda pairs: np.eye(n)[:, pairs], np.ones(n), gaps, np.abs(levers), [10.0, -1.0]
        )
    assert caught.value.motion @ [10.0, -1.0] > 0


def test_jamming_is_found_with_all_columns() -> None:
    source = Columns(np.array([[1.0, 1.5], [0.5, 1.0]]))
    with pytest.raises(errors.NoContactState) as caught:
        fl.solve_contact_on_demand(
            source, [1, 1], [0, 0.2], [1, 1], 1.0, load_rows=[1, -1], symmetric=False
        )
    np.testing.assert_allclose(caught.value.largest_torque, 0.4, rtol=1e-9, atol=0)
    assert sorted(source.asked) == [0, 1]


@pytest.mark.parametrize(
    ("changed", "line"),
    [
        ({"diagonal": [1.0, 0.0]}, "diagonal: expected a diagonal > 0, found 0 at pair 1"),
        ({"diagonal": []}, "diagonal: expected at least one pair, found shape (0,)"),
        ({"normal_gaps": [0.0]}, "normal_gaps: expected shape (2,), found (1,)"),
        (
            {"influence_columns": lambda pairs: np.eye(3)[:, pairs]},
            "influence_columns: expected shape (2, 2), found (3, 2)",
        ),
        (
            {"influence_columns": lambda pairs: 2.0 * np.eye(2)[:, pairs]},
            "influence_columns: expected 1 of the diagonal at pair 0, found 2",
        ),
        (
            {"influence_columns": lambda pairs: np.full((2, pairs.size), np.nan)},
            "influence_columns: expected finite numbers, found nan at [0, 0]",
        ),
        ({"method": "paper"}, "method: 'paper' expected the whole matrix, found columns on demand"),
    ],
)
def test_refusals(changed: dict, line: str) -> None:
    arguments = {
        "influence_columns": lambda pairs: np.eye(2)[:, pairs],
        "diagonal": [1.0, 1.0],
        "normal_gaps": [0.0, 0.0],
        "motions": [1.0, 1.0],
        "loads": 1.0,
    } | changed
    with pytest.raises(errors.InputError) as caught:
        fl.solve_contact_on_demand(**arguments)
    assert str(caught.value) == line


def test_a_row_that_no_elastic_matrix_has_is_seen_without_its_column() -> None:
    matrix = np.eye(40)
    matrix[30, :16] = matrix[:16, 30] = 5.0
    gaps = np.where(np.arange(40) < 16, 0.0, 0.5)
    source = Columns(matrix)
    state = fl.solve_contact_on_demand(source, np.ones(40), gaps, np.ones(40), 1.0)
    assert 30 not in source.asked
    assert not state.info.unique
    assert state.info.uniqueness == "not certain"
    assert state.status == 3


def test_an_error_of_the_source_passes_through() -> None:
    def broken(pairs: np.ndarray) -> np.ndarray:
        raise OSError("the disk is gone")

    with pytest.raises(OSError, match="the disk is gone"):
        fl.solve_contact_on_demand(broken, [1.0], [0.0], [1.0], 1.0)
