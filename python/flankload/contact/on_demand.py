"""Contact problems with influence columns on demand instead of a stored matrix."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

import flankload._core as _core
from flankload.contact.problem import (
    ContactProblem,
    array,
    expect_positive_diagonal,
    expect_shape,
    loads_of_motions,
    method_number,
    structure_of,
    unchecked,
)
from flankload.contact.state import ContactState, CoreAnswer, failure, state_of
from flankload.errors import InputError

Vector = NDArray[np.float64]


def solve_contact_on_demand(
    influence_columns: Callable[[NDArray[np.intp]], ArrayLike],
    diagonal: ArrayLike,
    normal_gaps: ArrayLike,
    motions: ArrayLike,
    loads: ArrayLike,
    *,
    load_rows: ArrayLike | None = None,
    method: str = "auto",
    symmetric: bool = True,
    positive_definite: bool | None = None,
) -> ContactState:
    """Find the state of contact of a problem with expensive or large influence columns.

    Columns are requested in groups, for pairs near contact only; `info.influence_columns` is the
    number of computed columns.

    Parameters
    ----------
    influence_columns : callable
        Called with the numbers of m pairs, from 0; returns their columns of K [mm/N], shape (n, m).
        No pair is requested twice.
    diagonal : array_like of shape (n,)
        Diagonal of K [mm/N].
    normal_gaps, motions, loads, load_rows, method
        As in `solve_contact_general`; not method ``paper``.
    symmetric : bool, optional
        Whether K is symmetric: the compliance of elastic bodies without friction (default).
    positive_definite : bool, optional
        Whether K, or the symmetric part of an asymmetric K, is known to be positive definite.
        Default: the value of `symmetric`. If False, uniqueness is not certain, since its proof
        requires the whole matrix.

    Returns
    -------
    ContactState

    Raises
    ------
    InputError, NoContactState, PivotLimit, SingularContact
        As in `solve_contact_general`.
    """
    scale = array("diagonal", diagonal, 1)
    if scale.size == 0:
        raise InputError("diagonal: expected at least one pair, found shape (0,)")
    expect_positive_diagonal(scale, "diagonal")
    load = loads_of_motions(loads)
    nothing = np.empty((scale.size, 0), order="F")
    problem = unchecked(
        nothing, "influence_columns", normal_gaps, motions, load_rows, n_motions=load.size
    )
    if method == "paper":
        raise InputError("method: 'paper' expected the whole matrix, found columns on demand")
    definite = symmetric if positive_definite is None else positive_definite
    problem = replace(problem, structure=structure_of(symmetric=symmetric, definite=definite))
    return _solve_stepwise(influence_columns, scale, problem, load, method_number(method, problem))


def _solve_stepwise(
    influence_columns: Callable[[NDArray[np.intp]], ArrayLike],
    diagonal: Vector,
    problem: ContactProblem,
    loads: Vector,
    method: int,
) -> ContactState:
    """Solve with the known columns and compute the requested ones, until none is requested."""
    known = np.empty(0, dtype=np.int32)
    warm = np.empty(0, dtype=np.int32)
    computed = problem.compliance
    while True:
        count, wanted, *parts = _core.flankload_contact_columns(
            known + 1,
            computed.ravel(order="F"),
            diagonal,
            problem.gaps,
            problem.motions,
            problem.load_rows,
            loads,
            problem.structure,
            method,
            warm + 1,
        )
        answer = CoreAnswer(*parts)
        if answer.code < 0:
            raise failure(problem, loads, answer)
        if count == 0:
            return state_of(problem, loads, answer, known=known, columns=computed)
        pairs = wanted[:count] - 1
        known = np.concatenate([known, pairs])
        computed = np.asfortranarray(
            np.hstack([computed, _columns(influence_columns, pairs, diagonal)])
        )
        warm = np.flatnonzero(answer.active).astype(np.int32)


def _columns(
    influence_columns: Callable[[NDArray[np.intp]], ArrayLike],
    pairs: NDArray[np.int32],
    diagonal: Vector,
) -> Vector:
    """The requested columns, checked."""
    computed = array("influence_columns", influence_columns(pairs.astype(np.intp)), 2)
    expect_shape("influence_columns", computed, (diagonal.size, pairs.size))
    own = computed[pairs, np.arange(pairs.size)]
    wrong = np.flatnonzero(np.abs(own - diagonal[pairs]) > 1e-12 * diagonal[pairs])
    if wrong.size:
        pair = int(pairs[wrong[0]])
        raise InputError(
            f"influence_columns: expected {diagonal[pair]:g} of the diagonal at pair {pair}, "
            f"found {own[wrong[0]]:g}"
        )
    return computed
