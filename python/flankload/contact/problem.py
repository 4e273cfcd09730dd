"""Contact problems in the form of the core, and validation of all arguments."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

import flankload._core as _core
from flankload.contact.status import Status
from flankload.errors import InputError

Vector = NDArray[np.float64]

METHODS = {
    "auto": 0,
    "single": 1,
    "paper": 2,
    "block": 3,
    "load_path": 4,
    "cascade": 6,
    "primal": 7,
}
METHOD_NAMES = {number: name for name, number in METHODS.items()} | {5: "single_pivoted"}

# properties of K that are passed to the core
GENERAL, SYMMETRIC, DEFINITE, DEFINITE_PART = range(4)
# largest number of pairs for which scaling and a proof of uniqueness have negligible cost
_FEW_PAIRS = 60
# asymmetry due to rounding in the assembly, relative to the diagonal
_ASYMMETRY = 1e-12


@dataclass(frozen=True)
class ContactProblem:
    """A contact problem of n pairs in the general form, its arrays in Fortran order.

    `compliance` K [mm/N] is (n, n), `gaps` g0 [mm] (n,), `motions` B and `load_rows` R are (n, q).
    `names`: those of K in errors about an entry and about the matrix; `structure`: properties of K
    for the core. `gap_scale` divides final gaps: the row scales of the angle form, otherwise 1.
    `load_unit` divides loads and load rows: the row scale of the angle form if it is the same for
    all rows, otherwise 1. `by_rows`: `compliance` is the transpose of K, which has not been
    compared with it (`in_given_order`).
    """

    compliance: Vector
    gaps: Vector
    motions: Vector
    load_rows: Vector
    names: tuple[str, str]
    structure: int = GENERAL
    gap_scale: Vector | float = 1.0
    load_unit: float = 1.0
    by_rows: bool = False

    @property
    def n(self) -> int:
        """Number of pairs."""
        return self.gaps.size


def from_angles(
    flexibility_matrix: ArrayLike,
    lever_arms: ArrayLike,
    gap_angles: ArrayLike,
    *,
    normal_lever_arms: ArrayLike | None,
    positive_definite: bool | None,
) -> ContactProblem:
    """The problem in the angle form: K = diag(b) A, g0 = b ε, B = b, R = m."""
    matrix = _square("flexibility_matrix", flexibility_matrix)
    n = matrix.shape[0]
    torque_row = vector("lever_arms", lever_arms, n)
    gaps = vector("gap_angles", gap_angles, n)
    row_scale, name = np.abs(torque_row), "lever_arms"
    if normal_lever_arms is not None:
        name = "normal_lever_arms"
        row_scale = vector(name, normal_lever_arms, n)
    least = row_scale.min()
    if not least > 0.0:
        raise InputError(
            f"{name}: expected row scales > 0, found {least:g} at pair {int(row_scale.argmin())}",
            code=Status.INVALID_SCALE,
        )
    if not torque_row.max() > 0.0:
        raise InputError(
            f"lever_arms: expected at least one > 0, found none above {torque_row.max():g}",
            code=Status.INVALID_SCALE,
        )
    # with one scale for all rows, the matrix is used without a copy, and the loads are scaled, so
    # that B = R without friction
    scaled = n <= _FEW_PAIRS or row_scale.max() > least
    load_unit = 1.0 if scaled else float(least)
    if not scaled:
        row_scale = np.ones(n)
        torque_row = torque_row / load_unit
    problem = ContactProblem(
        compliance=matrix,
        gaps=row_scale * gaps,
        motions=np.asfortranarray(row_scale[:, np.newaxis]),
        load_rows=np.asfortranarray(torque_row[:, np.newaxis]),
        names=("flexibility_matrix", "diag(normal_lever_arms) flexibility_matrix"),
        gap_scale=row_scale,
        load_unit=load_unit,
    )
    return _checked(problem, row_scale if scaled else None, positive_definite)


def general(
    compliance_matrix: ArrayLike,
    normal_gaps: ArrayLike,
    motions: ArrayLike,
    load_rows: ArrayLike | None,
    n_motions: int,
    positive_definite: bool | None,
) -> ContactProblem:
    """The problem in its general form."""
    matrix = _square("compliance_matrix", compliance_matrix)
    n, name = len(matrix), "compliance_matrix"
    gaps = vector("normal_gaps", normal_gaps, n)
    levers = columns("motions", motions, (n, n_motions))
    rows = levers if load_rows is None else columns("load_rows", load_rows, (n, n_motions))
    problem = ContactProblem(
        matrix, gaps, np.asfortranarray(levers), np.asfortranarray(rows), names=(name, name)
    )
    return _checked(problem, None, positive_definite)


def torque_loads(name: str, torque: ArrayLike, n_axes: int | None) -> Vector:
    """Check a torque >= 0, or a list of torques."""
    load = array(name, torque, n_axes)
    if load.size and load.min() < 0.0:
        what = "a number" if load.ndim == 0 else "numbers"
        raise InputError(f"{name}: expected {what} >= 0, found {float(load.min()):g}")
    return load


def loads_of_motions(loads: ArrayLike) -> Vector:
    """Check for one load per motion."""
    load = np.atleast_1d(array("loads", loads, None))
    expect_shape("loads", load, (load.size,))
    if load.size == 0:
        raise InputError("loads: expected at least one motion, found shape (0,)")
    return load


def method_number(method: str, problem: ContactProblem) -> int:
    """Number of a method in the core."""
    if method not in METHODS:
        available = ", ".join(repr(name) for name in METHODS)
        raise InputError(f"method: expected one of {available}, found {method!r}")
    q = problem.motions.shape[1]
    if method == "paper" and (q != 1 or not problem.motions.min() > 0.0):
        raise InputError(
            f"method: 'paper' expected one motion with levers > 0, found {q} motions "
            f"with levers from {problem.motions.min():g}",
            code=Status.INVALID_INPUT if q != 1 else Status.INVALID_SCALE,
        )
    return METHODS[method]


def expect_positive_diagonal(diagonal: Vector, name: str) -> None:
    """Raise if the normal displacement of a pair under its own force is not positive."""
    if not diagonal.min() > 0.0:
        raise InputError(
            f"{name}: expected a diagonal > 0, found {diagonal.min():g} "
            f"at pair {int(diagonal.argmin())}",
            code=Status.INVALID_SCALE,
        )


def _square(name: str, values: ArrayLike) -> Vector:
    """Check for a square matrix of numbers; finiteness is checked later."""
    matrix = array(name, values, 2, finite=False)
    n = matrix.shape[0]
    expect_shape(name, matrix, (n, n))
    if n == 0:
        raise InputError(f"{name}: expected at least one pair, found shape (0, 0)")
    return matrix


def _checked(
    problem: ContactProblem, row_scale: Vector | None, positive_definite: bool | None
) -> ContactProblem:
    """Scale rows and check the whole matrix in one pass, without unnecessary copies.

    A symmetric matrix is assumed to be that of elastic bodies, unless an entry contradicts this,
    the caller requests a proof, or there are few pairs.
    """
    matrix, name = problem.compliance, problem.names[0]
    if not matrix.flags.forc:
        matrix = np.asfortranarray(matrix)
    if positive_definite and problem.n > _FEW_PAIRS:
        return _declared(problem, matrix, row_scale)
    by_rows = not matrix.flags.f_contiguous
    compliance = matrix.T if by_rows else matrix
    if row_scale is None:
        symmetric, elastic, mirrored, finite, _ = _core.flankload_matrix_form(compliance)
        if not mirrored:
            compliance = np.asfortranarray(matrix)
    else:
        compliance, symmetric, elastic, _ = _core.flankload_normal_compliance(
            compliance, int(by_rows), row_scale
        )
        finite = symmetric
    if not finite:
        expect_finite(name, matrix)
    expect_positive_diagonal(compliance.diagonal(), name)
    definite = positive_definite
    if definite is None:
        definite = symmetric == 1 and elastic == 1 and problem.n > _FEW_PAIRS
    kinds = (SYMMETRIC, DEFINITE) if symmetric == 1 else (GENERAL, DEFINITE_PART)
    structure = kinds[1] if definite else kinds[0]
    return replace(problem, compliance=compliance, structure=structure)


def _declared(problem: ContactProblem, matrix: Vector, row_scale: Vector | None) -> ContactProblem:
    """Scale rows of a matrix that is known to be positive definite, without a pass over it.

    A few entries decide whether it is factored as a symmetric one. If others are not symmetric, the
    refinement of the core does not converge, and it factors the matrix as a general one.
    """
    if row_scale is not None:
        matrix = matrix * row_scale[:, np.newaxis]
    last = problem.n - 1
    symmetric = all(
        abs(matrix.item(i, j) - matrix.item(j, i))
        <= _ASYMMETRY * min(abs(matrix.item(i, i)), abs(matrix.item(j, j)))
        for i, j in ((0, 1), (0, last), (last // 2, last // 2 + 1), (last // 3, last))
    )
    by_rows = symmetric and not matrix.flags.f_contiguous
    return replace(
        problem,
        compliance=matrix.T if by_rows else np.asfortranarray(matrix),
        structure=DEFINITE if symmetric else DEFINITE_PART,
        by_rows=by_rows,
    )


def in_given_order(problem: ContactProblem, used: slice) -> ContactProblem:
    """The problem itself if K equals its transpose in columns that were used, else with K."""
    given = problem.compliance.T
    if not problem.by_rows or np.array_equal(given[:, used].T, given[used]):
        return problem
    return replace(problem, compliance=np.asfortranarray(given), by_rows=False)


def array(name: str, values: Any, n_axes: int | None, *, finite: bool = True) -> Vector:
    """Real numbers in double precision, checked."""
    try:
        given = np.asarray(values)
        real = given.dtype.kind != "c"
        # a cast would drop imaginary parts
        numbers = given.astype(np.float64, copy=False) if real else np.empty(0)
    except (TypeError, ValueError, OverflowError) as error:
        raise InputError(f"{name}: expected an array of numbers, found {error}") from None
    if not real:
        raise InputError(f"{name}: expected real numbers, found {given.dtype}")
    if n_axes and numbers.ndim == 0:
        shape = "(n,)" if n_axes == 1 else "(n, n)"
        raise InputError(f"{name}: expected an array of shape {shape}, found a single number")
    if n_axes is not None and numbers.ndim != n_axes:
        kind = ("a number", "1 axis")[n_axes] if n_axes < 2 else f"{n_axes} axes"
        raise InputError(f"{name}: expected {kind}, found shape {numbers.shape}")
    if finite:
        expect_finite(name, numbers)
    return numbers


def expect_finite(name: str, numbers: Vector) -> None:
    """Raise an InputError if a number is NaN or infinite."""
    # the sum of squares is the fastest check; each number is checked if it overflows
    flat = numbers.ravel(order="K")
    if not np.vdot(flat, flat) < np.inf and not np.isfinite(flat).all():
        place = np.argwhere(~np.isfinite(numbers))[0].tolist()
        found = numbers[tuple(place)]
        at = f" at {place}" if place else ""
        raise InputError(f"{name}: expected finite numbers, found {found}{at}")


def vector(name: str, values: ArrayLike, n: int) -> Vector:
    """One finite number per pair."""
    numbers = array(name, values, 1)
    expect_shape(name, numbers, (n,))
    return numbers


def expect_shape(name: str, numbers: Vector, shape: tuple[int, ...]) -> None:
    """Raise an InputError if the shape differs from the expected one."""
    if numbers.shape != shape:
        raise InputError(f"{name}: expected shape {shape}, found {numbers.shape}")


def columns(name: str, values: ArrayLike, shape: tuple[int, int]) -> Vector:
    """An array with one column per motion; a vector is one column."""
    result = array(name, values, None)
    if result.ndim == 1 and shape[1] == 1:
        result = result[:, np.newaxis]
    expect_shape(name, result, shape)
    return result


def pair_numbers(warm_pairs: ArrayLike | Sequence[int] | None, n: int) -> NDArray[np.int32]:
    """Distinct numbers of pairs, from 0."""
    if warm_pairs is None:
        return np.empty(0, dtype=np.int32)
    pairs = np.asarray(warm_pairs)
    if pairs.size == 0:
        return np.empty(0, dtype=np.int32)
    if pairs.ndim != 1 or not np.issubdtype(pairs.dtype, np.integer):
        raise InputError(
            f"warm_pairs: expected a list of integers, found shape {pairs.shape} of {pairs.dtype}"
        )
    if pairs.min() < 0 or pairs.max() >= n:
        raise InputError(
            f"warm_pairs: expected numbers from 0 to {n - 1}, found {pairs.min()} to {pairs.max()}"
        )
    if np.unique(pairs).size != pairs.size:
        raise InputError("warm_pairs: expected each pair once, found a pair twice")
    return pairs.astype(np.int32)
