"""Units of any size: the same answer in other numbers, or an error where a double has no room.

Forces, lengths and motions are multiplied by powers of four, which the core's scales take out
again, so that the scaled problem and its solution are the same to the last bit.
"""

from __future__ import annotations

import numpy as np
import pytest

import flankload as fl
from flankload import errors
from tests.support.general_like import general_like
from tests.support.oracle import EPS, Problem

#: Decades of forces, lengths and motions.
LARGEST = 150
#: Less than this is no normal number, and the largest power of ten.
TINY, TOP = float(np.finfo(float).tiny), 308.0
#: Numbers smaller than the largest by this factor may be lost.
NEGLIGIBLE = 1e-15


def solve(problem: Problem, method: str) -> fl.ContactState:
    return fl.solve_contact_general(
        problem.compliance,
        problem.gaps,
        problem.motions,
        problem.loads,
        load_rows=problem.load_rows,
        method=method,
    )


def in_units(problem: Problem, force: float, length: float, motion: float) -> Problem | None:
    """The problem in other units; None where these are beyond the range of its own numbers."""
    same = problem.motions is problem.load_rows
    with np.errstate(all="ignore"):
        levers = problem.motions * (length / motion)
        scaled = Problem(
            problem.compliance * (length / force),
            problem.gaps * length,
            levers,
            levers if same else problem.load_rows * (length / motion),
            problem.loads * force * (length / motion),
        )
    for before, after in zip(vars(problem).values(), vars(scaled).values(), strict=True):
        normal = np.isfinite(after) & (np.abs(after) >= TINY)
        if not (normal | (before == 0)).all():
            return None
    return scaled


@pytest.mark.parametrize("method", ["auto", "single", "load_path"])
def test_other_units_change_no_bit(method: str) -> None:
    rng = np.random.default_rng(60)
    same, refused = 0, 0
    for _ in range(200):
        problem, held = general_like(rng)
        power = rng.uniform(-LARGEST, LARGEST, 3) * rng.choice([0.3, 1.0])
        force, length, motion = 4.0 ** np.round(power / np.log10(4.0))
        scaled = in_units(problem, force, length, motion)
        if scaled is None or not held or np.abs(problem.gaps).max() > 1e6:
            continue
        state = solve(problem, method)
        expected = (state.normal_forces, state.motions, state.final_gap_angles)
        with np.errstate(all="ignore"):
            wanted = tuple(
                part * unit for part, unit in zip(expected, (force, motion, length), strict=True)
            )
        if not fits(expected, wanted, state.tangent, (force, length, motion)):
            with pytest.raises(errors.InputError) as caught:
                solve(scaled, method)
            assert caught.value.code == -7
            refused += 1
            continue
        found = solve(scaled, method)
        assert found.status == state.status
        assert found.info.pivots == state.info.pivots
        for got, want in zip(
            (found.normal_forces, found.motions, found.final_gap_angles), wanted, strict=True
        ):
            np.testing.assert_array_equal(got, want)
        same += 1
    assert same >= 60
    assert refused >= 5


def fits(
    before: tuple[np.ndarray, ...],
    after: tuple[np.ndarray, ...],
    tangent: np.ndarray,
    units: tuple[float, float, float],
) -> bool:
    """Whether doubles hold a state in its new units; negligible numbers may be lost."""
    force, length, motion = np.log10(units)
    with np.errstate(divide="ignore"):
        growth = np.log10(np.abs(tangent).max()) + 2 * motion - force - length
    if growth > TOP or not all(np.isfinite(part).all() for part in after):
        return False
    return all(
        np.abs(new[np.abs(old) > NEGLIGIBLE * np.abs(old).max()]).min(initial=1.0) >= TINY
        for old, new in zip(before[:2], after[:2], strict=True)
    )


def test_numbers_without_room_are_an_error() -> None:
    """Rotation 1e320 rad and force 1e-320 N: neither infinity nor zero is an answer."""
    for matrix, load, lever in ((1e160, 1e-160, 1e-160), (1e-60, 1e-170, 1e150)):
        with pytest.raises(errors.InputError, match="units") as caught:
            fl.solve_contact_general([[matrix]], [0.0], [lever], load)
        assert caught.value.code == -7


def test_a_row_of_large_numbers_is_no_excuse() -> None:
    """K_ij F_j overflowed where the row's size was summed up, and a pair open by as much as its
    whole row passed as closed to rounding."""
    matrix = np.array([[4.0, 2, 0, -1], [2, 17, -10, -10], [0, -10, 10, 6], [-1, -10, 6, 8]])
    matrix, gaps = matrix * 1e197, np.array([0.0, 0.0, 2.0, -2.0]) * 1e135
    levers = np.array([2.0, 1.0, -2.0, -1.0]) * 1e140
    for method in ("auto", "single", "load_path"):
        state = fl.solve_contact_general(matrix, gaps, levers, 1e-63, method=method)
        gap = matrix @ state.normal_forces + gaps - levers * state.motions
        size = np.abs(matrix) @ state.normal_forces + np.abs(gaps) + np.abs(levers * state.motions)
        assert (gap >= -10 * EPS * size).all()
