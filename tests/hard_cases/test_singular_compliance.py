"""K that is singular among the pairs in contact, though they hold every motion.

Rigid bodies on few springs are so: more pairs touch than there are springs, and only the motions
make the equations regular. Each problem is made around a state of whole numbers, so that one exists
and no rounding hides that K is singular.
"""

from __future__ import annotations

import numpy as np
import pytest

import flankload as fl
from tests.support.oracle import EPS, Problem, judge_problem

METHODS = ("auto", "single", "block", "load_path")
KINDS = ("springs", "indefinite", "unsymmetric")
#: How far whole-number states may be off: none of the problems has a condition above 1e5.
EXACT = 1e-10


def solve(problem: Problem, method: str) -> fl.ContactState:
    """The state, held against 60-digit arithmetic."""
    state = fl.solve_contact_general(
        problem.compliance,
        problem.gaps,
        problem.motions,
        problem.loads,
        load_rows=problem.load_rows,
        method=method,
    )
    verdict = judge_problem(problem, state)
    assert verdict.backward_error <= 10 * EPS
    assert verdict.exact_violation <= 10 * EPS
    assert state.info.backward_error <= 10 * EPS
    return state


def whole_number_problem(rng: np.random.Generator, kind: str) -> tuple[Problem, np.ndarray]:
    """A problem and forces that solve it, with K singular among the pairs that carry them."""
    while True:
        q = int(rng.integers(1, 4))
        n = int(rng.integers(q + 1, 13))
        carrying = np.sort(rng.permutation(n)[: int(rng.integers(q + 1, min(n, 7) + 1))])
        if kind == "springs":
            roots = rng.integers(-3, 4, (n, max(1, carrying.size - int(rng.integers(1, q + 1)))))
            matrix = roots @ roots.T
        else:
            matrix = rng.integers(-3, 4, (n, n))
            matrix = matrix + matrix.T if kind == "indefinite" else matrix
            np.fill_diagonal(matrix, rng.integers(1, 6, n))
            # The row and column of one pair as the sum of two others'.
            if carrying.size < 3:
                continue
            one, two, both = carrying[:3]
            matrix[both] = matrix[one] + matrix[two]
            matrix[:, both] = matrix[:, one] + matrix[:, two]
        levers = rng.integers(-3, 4, (n, q))
        inside = matrix[np.ix_(carrying, carrying)].astype(float)
        held = levers[carrying].astype(float)
        bordered = np.block([[inside, -held], [held.T, np.zeros((q, q))]])
        singular = np.linalg.matrix_rank(inside) < carrying.size
        if singular and matrix.diagonal().min() > 0 and np.linalg.cond(bordered) < 1e4:
            break
    forces = np.zeros(n, dtype=int)
    forces[carrying] = rng.integers(1, 6, carrying.size)
    open_by = rng.integers(1, 9, n)
    open_by[carrying] = 0
    gaps = open_by - matrix @ forces + levers @ rng.integers(-5, 6, q)
    columns = levers.astype(float)
    problem = Problem(
        matrix.astype(float), gaps.astype(float), columns, columns, columns.T @ forces
    )
    return problem, forces


@pytest.mark.parametrize("method", METHODS)
def test_two_rows_that_are_multiples(method: str) -> None:
    """By hand: the gaps want 2 F1 - 3 F2 = (2 φ - 3)/2 = -(φ + 2)/3, so φ = 5/8."""
    matrix = np.array([[4.0, -6.0], [-6.0, 9.0]])
    column = np.array([[2.0], [1.0]])
    problem = Problem(matrix, np.array([3.0, -2.0]), column, column, np.array([2.0]))
    state = solve(problem, method)
    np.testing.assert_allclose(state.normal_forces, [41 / 64, 23 / 32], rtol=4 * EPS, atol=0)
    np.testing.assert_allclose(state.motions, 5 / 8, rtol=4 * EPS, atol=0)
    # The rotation does not grow with the load at all: the pairs just share it otherwise.
    np.testing.assert_allclose(state.tangent, 0.0, rtol=0, atol=16 * EPS)
    assert state.status == 0


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("kind", KINDS)
def test_a_state_of_whole_numbers_is_found(kind: str, method: str) -> None:
    """The very state where it is proven to be the only one: where K is positive definite for forces
    that hold no load, as with no more pairs than springs and motions."""
    rng = np.random.default_rng(40 + KINDS.index(kind))
    proven = 0
    for _ in range(50):
        problem, forces = whole_number_problem(rng, kind)
        state = solve(problem, method)
        if state.info.unique:
            atol = EXACT * forces.max()
            np.testing.assert_allclose(state.normal_forces, forces, rtol=0, atol=atol)
            proven += 1
    assert proven >= (10 if kind == "springs" else 0)


def test_uniqueness_is_not_proven_across_the_loads() -> None:
    """Twins share their force in any way, and [[1, 2], [2, 1]] has three states: in both K is not
    positive definite where no force works on the load."""
    for matrix, gaps in (([[1.0, 1], [1, 1]], [0.0, 0]), ([[1.0, 2], [2, 1]], [0.0, 0])):
        state = fl.solve_contact_general(np.array(matrix), gaps, [1.0, 1], 1.0)
        assert state.status == 3
