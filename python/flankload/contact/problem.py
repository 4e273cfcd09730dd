"""Contact problem after validation, in the form of the core."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

import flankload._core as _core
from flankload.contact.arguments import array, columns, expect_finite, expect_shape
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
RUNGS = {number: name for name, number in METHODS.items()} | {5: "single_pivoted"}

# properties of K that are passed to the core
GENERAL, SYMMETRIC, DEFINITE, DEFINITE_PART = range(4)
# for this number of pairs, scaling and a proof of uniqueness cost nothing
_FEW_PAIRS = 60


@dataclass(frozen=True)
class ContactProblem:
    """A contact problem in the general form.

    Attributes
    ----------
    compliance : ndarray of shape (n, n)
        K [mm/N], Fortran order.
    gaps : ndarray of shape (n,)
        g0 [mm].
    motions, load_rows : ndarray of shape (n, q)
        B and R, Fortran order.
    structure : int
        Properties of K that are passed to the core.
    gap_scale : ndarray of shape (n,)
        Divisors of final gaps: the row scales of the angle form, else one.
    load_unit : float
        Divisor of loads and load rows: the row scale of the angle form if it is the same for all
        rows, else one.
    names : tuple of str
        Names of K for the caller, in errors of an entry and of the whole.
    """

    compliance: Vector
    gaps: Vector
    motions: Vector
    load_rows: Vector
    structure: int
    gap_scale: Vector
    load_unit: float
    names: tuple[str, str]

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
    """Problem of influence coefficients and gap angles: K = diag(b) A, g0 = b ε, B = b, R = m."""
    matrix = _square("flexibility_matrix", flexibility_matrix)
    n = matrix.shape[0]
    torque_row = array("lever_arms", lever_arms, 1)
    expect_shape("lever_arms", torque_row, (n,))
    gaps = array("gap_angles", gap_angles, 1)
    expect_shape("gap_angles", gaps, (n,))
    if normal_lever_arms is None:
        row_scale = np.abs(torque_row)
        name = "lever_arms"
    else:
        row_scale = array("normal_lever_arms", normal_lever_arms, 1)
        expect_shape("normal_lever_arms", row_scale, (n,))
        name = "normal_lever_arms"
    least = row_scale.min()
    if not least > 0.0:
        raise InputError(
            f"{name}: expected row scales > 0, found {least:g} at pair {int(row_scale.argmin())}",
            code=-5,
        )
    if not torque_row.max() > 0.0:
        raise InputError(
            f"lever_arms: expected at least one > 0, found none above {torque_row.max():g}", code=-5
        )
    # a common scale for all rows does not make a matrix symmetric: rows remain those of angles,
    # without a copy, and the loads are scaled, so that B = R without friction
    scaled = n <= _FEW_PAIRS or row_scale.max() > least
    load_unit = 1.0 if scaled else float(least)
    if not scaled:
        row_scale = np.ones(n)
        torque_row = torque_row / load_unit
    return _problem(
        matrix,
        row_scale if scaled else None,
        row_scale * gaps,
        row_scale[:, np.newaxis],
        torque_row[:, np.newaxis],
        positive_definite=positive_definite,
        gap_scale=row_scale,
        load_unit=load_unit,
        names=("flexibility_matrix", "diag(normal_lever_arms) flexibility_matrix"),
    )


def general(
    compliance_matrix: ArrayLike,
    normal_gaps: ArrayLike,
    motions: ArrayLike,
    n_motions: int,
    *,
    load_rows: ArrayLike | None,
    positive_definite: bool | None,
) -> ContactProblem:
    """The problem in its general form."""
    matrix = _square("compliance_matrix", compliance_matrix)
    n = matrix.shape[0]
    gaps = array("normal_gaps", normal_gaps, 1)
    expect_shape("normal_gaps", gaps, (n,))
    levers = columns("motions", motions, (n, n_motions))
    rows = levers if load_rows is None else columns("load_rows", load_rows, (n, n_motions))
    return _problem(
        matrix,
        None,
        gaps,
        levers,
        rows,
        positive_definite=positive_definite,
        gap_scale=np.ones(n),
        load_unit=1.0,
        names=("compliance_matrix", "compliance_matrix"),
    )


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
    """The core's number of a method."""
    if method not in METHODS:
        available = ", ".join(repr(name) for name in METHODS)
        raise InputError(f"method: expected one of {available}, found {method!r}")
    q = problem.motions.shape[1]
    if method == "paper" and (q != 1 or not problem.motions.min() > 0.0):
        raise InputError(
            f"method: 'paper' expected one motion with levers > 0, found {q} motions "
            f"with levers from {problem.motions.min():g}",
            code=-4 if q != 1 else -5,
        )
    return METHODS[method]


def expect_positive_diagonal(diagonal: Vector, name: str) -> None:
    """Raise if the normal displacement of a pair under its own force is not positive."""
    if not diagonal.min() > 0.0:
        raise InputError(
            f"{name}: expected a diagonal > 0, found {diagonal.min():g} "
            f"at pair {int(diagonal.argmin())}",
            code=-5,
        )


def _square(name: str, values: ArrayLike) -> Vector:
    """Check for a square matrix of numbers; finiteness is checked later."""
    matrix = array(name, values, 2, finite=False)
    n = matrix.shape[0]
    expect_shape(name, matrix, (n, n))
    if n == 0:
        raise InputError(f"{name}: expected at least one pair, found shape (0, 0)")
    return matrix


def _problem(
    matrix: Vector,
    row_scale: Vector | None,
    gaps: Vector,
    motions: Vector,
    load_rows: Vector,
    *,
    positive_definite: bool | None,
    gap_scale: Vector,
    load_unit: float,
    names: tuple[str, str],
) -> ContactProblem:
    """Scale rows and check the whole matrix in one pass, without unnecessary copies."""
    if not matrix.flags.forc:
        matrix = np.asfortranarray(matrix)
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
        expect_finite(names[0], matrix)
    expect_positive_diagonal(compliance.diagonal(), names[0])
    return ContactProblem(
        compliance=compliance,
        gaps=gaps,
        motions=np.asfortranarray(motions),
        load_rows=np.asfortranarray(load_rows),
        structure=_structure(
            symmetric=symmetric == 1,
            elastic=elastic == 1,
            n=gaps.size,
            positive_definite=positive_definite,
        ),
        gap_scale=gap_scale,
        load_unit=load_unit,
        names=names,
    )


def _structure(*, symmetric: bool, elastic: bool, n: int, positive_definite: bool | None) -> int:
    """Properties of K that are passed to the core.

    A symmetric matrix is assumed to belong to elastic bodies unless an entry contradicts this or
    the caller requests a proof; for few pairs the proof costs nothing. Nothing is assumed about a
    matrix that is not symmetric.
    """
    if not symmetric:
        return DEFINITE_PART if positive_definite else GENERAL
    if positive_definite or (positive_definite is None and elastic and n > _FEW_PAIRS):
        return DEFINITE
    return SYMMETRIC
