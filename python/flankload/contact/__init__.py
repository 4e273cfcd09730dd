"""The contact loop: which pairs touch and what they carry; one call of the core each.

The angle form (equations (16), (17) and (20) of the paper) is a thin wrapper around the general
form

    g = K F + g0 - B q >= 0,   F >= 0,   g F = 0,   R^T F = Q.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

import flankload._core as _core
from flankload.contact.arguments import array, columns, expect_shape, pair_numbers
from flankload.contact.state import ContactInfo, ContactState, undetermined_groups
from flankload.errors import (
    InputError,
    NegativeForce,
    NoContactState,
    PivotLimit,
    SingularContact,
)

__all__ = ["ContactInfo", "ContactState", "solve_contact", "solve_contact_general"]

Vector = NDArray[np.float64]

_METHODS = {
    "auto": 0,
    "single": 1,
    "paper": 2,
    "block": 3,
    "load_path": 4,
    "cascade": 6,
    "primal": 7,
}
_RUNGS = {number: name for name, number in _METHODS.items()} | {5: "single_pivoted"}
# What the core is told of K.
_GENERAL, _SYMMETRIC, _DEFINITE, _DEFINITE_PART = range(4)
# Asymmetry that assembly leaves in a symmetric matrix, relative to its diagonal.
_ASYMMETRY = 1e-12


def solve_contact(
    flexibility_matrix: ArrayLike,
    lever_arms: ArrayLike,
    gap_angles: ArrayLike,
    torque: float,
    *,
    method: str = "auto",
    normal_lever_arms: ArrayLike | None = None,
    warm_pairs: ArrayLike | None = None,
    positive_definite: bool = False,
) -> ContactState:
    """Find the pairs in contact, their forces and the rotation for a torque.

    Parameters
    ----------
    flexibility_matrix : array_like of shape (n, n)
        Influence numbers A [rad/N].
    lever_arms : array_like of shape (n,)
        Torque row m [mm]; with friction its own signs included.
    gap_angles : array_like of shape (n,)
        Initial gap angles [rad]; a common offset goes into the rotation.
    torque : float
        Torque M >= 0 [N mm]. Without torque the rotation is the least gap angle.
    method : {"auto", "single", "block", "load_path", "paper"}
        ``single`` lets any pair join or leave, one at a time; ``block`` many at once;
        ``load_path`` follows the state from zero torque (Lemke). Where one does not settle, the
        next answers: block, single, single with exchange of rows, load path. ``auto`` begins with
        ``single`` for few pairs, else with ``block``. ``paper`` only lets pairs join.
    normal_lever_arms : array_like of shape (n,), optional
        Row scale b > 0 [mm] where it differs from ``abs(lever_arms)``.
    warm_pairs : array_like of int, optional
        Pairs to begin with, from 0; a good guess saves time and never changes the answer.
    positive_definite : bool, optional
        True: the symmetric part of diag(b) A (rows weighted with m/b where m differs from b) is
        known to be positive definite, as for any elastic compliance without friction. The
        uniqueness of the state then rests on that, checked on the pairs in contact; otherwise it
        is proven from the whole matrix, which for many pairs takes longer than the solution.

    Returns
    -------
    ContactState

    Raises
    ------
    InputError
        Code -4: shapes, NaN, negative torque, unknown method; code -5: a row scale that is not
        positive, or no lever arm > 0.
    NoContactState, PivotLimit, SingularContact
        There is no state, or it was not found.
    NegativeForce
        Method ``paper`` ended with tension; the state is attached.

    Notes
    -----
    Weese & Popov, equations (16) to (34), with any pair free to leave.
    """
    matrix = array("flexibility_matrix", flexibility_matrix, 2)
    n = matrix.shape[0]
    expect_shape("flexibility_matrix", matrix, (n, n))
    if n == 0:
        raise InputError("flexibility_matrix: expected at least one pair, found shape (0, 0)")
    torque_row = array("lever_arms", lever_arms, 1)
    expect_shape("lever_arms", torque_row, (n,))
    gaps = array("gap_angles", gap_angles, 1)
    expect_shape("gap_angles", gaps, (n,))
    load = array("torque", torque, 0)
    if load < 0.0:
        raise InputError(f"torque: expected a number >= 0, found {float(load):g}")
    if normal_lever_arms is None:
        row_scale = np.abs(torque_row)
        name = "lever_arms"
    else:
        row_scale = array("normal_lever_arms", normal_lever_arms, 1)
        expect_shape("normal_lever_arms", row_scale, (n,))
        name = "normal_lever_arms"
    if not row_scale.min() > 0.0:
        raise InputError(
            f"{name}: expected row scales > 0, found {row_scale.min():g} "
            f"at pair {int(row_scale.argmin())}",
            code=-5,
        )
    if not torque_row.max() > 0.0:
        raise InputError(
            f"lever_arms: expected at least one > 0, found none above {torque_row.max():g}", code=-5
        )
    return _solve(
        row_scale[:, np.newaxis] * matrix,
        row_scale * gaps,
        row_scale[:, np.newaxis],
        torque_row[:, np.newaxis],
        load[np.newaxis],
        method=method,
        warm_pairs=warm_pairs,
        positive_definite=positive_definite,
        gap_scale=row_scale,
        names=("flexibility_matrix", "diag(normal_lever_arms) flexibility_matrix"),
    )


def solve_contact_general(
    compliance_matrix: ArrayLike,
    normal_gaps: ArrayLike,
    motions: ArrayLike,
    loads: ArrayLike,
    *,
    load_rows: ArrayLike | None = None,
    method: str = "auto",
    warm_pairs: ArrayLike | None = None,
    positive_definite: bool = False,
) -> ContactState:
    """Find the state of contact of the general form with any number of free motions.

    Parameters
    ----------
    compliance_matrix : array_like of shape (n, n)
        K, recession along the normal of pair i for a unit force on pair j [mm/N].
    normal_gaps : array_like of shape (n,)
        g0 [mm]; negative where bodies overlap before they move (preload).
    motions : array_like of shape (n, q) or (n,)
        B, gap closed by a unit of each motion; zero and negative levers are legal.
    loads : array_like of shape (q,) or float
        Q, the load on each motion.
    load_rows : array_like of shape (n, q) or (n,), optional
        R, part of a unit force in each load; B where there is no friction (default).
    method, warm_pairs, positive_definite
        As in `solve_contact`; ``paper`` takes one motion.

    Returns
    -------
    ContactState
        With final gaps along the normals [mm] in place of angles.

    Raises
    ------
    InputError, NoContactState, PivotLimit, SingularContact, NegativeForce
        As `solve_contact`. `NoContactState` carries a motion on which the loads do work and that
        no pair resists.
    """
    matrix = array("compliance_matrix", compliance_matrix, 2)
    n = matrix.shape[0]
    expect_shape("compliance_matrix", matrix, (n, n))
    if n == 0:
        raise InputError("compliance_matrix: expected at least one pair, found shape (0, 0)")
    gaps = array("normal_gaps", normal_gaps, 1)
    expect_shape("normal_gaps", gaps, (n,))
    load = np.atleast_1d(array("loads", loads, None))
    expect_shape("loads", load, (load.size,))
    if load.size == 0:
        raise InputError("loads: expected at least one motion, found shape (0,)")
    levers = columns("motions", motions, (n, load.size))
    rows = levers if load_rows is None else columns("load_rows", load_rows, (n, load.size))
    return _solve(
        matrix,
        gaps,
        levers,
        rows,
        load,
        method=method,
        warm_pairs=warm_pairs,
        positive_definite=positive_definite,
        gap_scale=np.ones(n),
        names=("compliance_matrix", "compliance_matrix"),
    )


def _solve(
    compliance: Vector,
    gaps: Vector,
    motions: Vector,
    load_rows: Vector,
    loads: Vector,
    *,
    method: str,
    warm_pairs: ArrayLike | None,
    positive_definite: bool,
    gap_scale: Vector,
    names: tuple[str, str],
) -> ContactState:
    """Call the core once and turn what it says into a state or an error."""
    number = _method_number(method)
    n = gaps.size
    diagonal = compliance.diagonal()
    if not diagonal.min() > 0.0:
        raise InputError(
            f"{names[0]}: expected a diagonal > 0, found {diagonal.min():g} "
            f"at pair {int(diagonal.argmin())}",
            code=-5,
        )
    if method == "paper" and (loads.size != 1 or not motions.min() > 0.0):
        raise InputError(
            f"method: 'paper' expected one motion with levers > 0, found {loads.size} motions "
            f"with levers from {motions.min():g}",
            code=-4 if loads.size != 1 else -5,
        )
    warm = pair_numbers(warm_pairs, n)
    forces, final_gaps, motion, tangent, active, counters, certificate, code = (
        _core.flankload_solve_contact(
            np.asfortranarray(compliance),
            gaps,
            np.asfortranarray(motions),
            np.asfortranarray(load_rows),
            loads,
            _structure(compliance, positive_definite=positive_definite),
            number,
            warm + 1,
        )
    )
    if code < 0 and code != NegativeForce.code:
        raise _failure(code, names, counters, motion, float(certificate[4]) * loads)
    active_pairs = np.flatnonzero(active)
    info = ContactInfo(
        rung=_RUNGS[int(counters[3])],
        pivots=int(counters[0]),
        refactorisations=int(counters[1]),
        condition=float(certificate[0]),
        growth=float(certificate[1]),
        backward_error=float(certificate[2]),
        margin=float(certificate[3]),
        unique=bool(counters[2]),
        undetermined=undetermined_groups(compliance, load_rows, forces, final_gaps, code),
    )
    state = ContactState(
        normal_forces=forces,
        final_gap_angles=final_gaps / gap_scale,
        rotation=float(motion[0]),
        active_pairs=active_pairs,
        status=code,
        info=info,
        motions=motion,
        tangent=tangent,
    )
    if code == NegativeForce.code:
        pair = int(forces.argmin())
        raise NegativeForce(
            f"method 'paper' ended with tension, {forces[pair]:g} N at pair {pair}", state=state
        )
    return state


def _method_number(method: str) -> int:
    """The core's number of a method."""
    if method not in _METHODS:
        available = ", ".join(repr(name) for name in _METHODS)
        raise InputError(f"method: expected one of {available}, found {method!r}")
    return _METHODS[method]


def _structure(compliance: Vector, *, positive_definite: bool) -> int:
    """What the core is told of K."""
    if _is_symmetric(compliance):
        return _DEFINITE if positive_definite else _SYMMETRIC
    return _DEFINITE_PART if positive_definite else _GENERAL


def _failure(
    code: int,
    names: tuple[str, str],
    counters: NDArray[np.int32],
    motion: Vector,
    held: Vector,
) -> Exception:
    """The exception of a code of the core."""
    if code == NoContactState.code:
        return NoContactState(
            "no pairs can hold these loads: free to move along "
            + ", ".join(f"{part:g}" for part in motion)
            + (f"; {held[0]:g} can be held" if held.size == 1 else ""),
            largest_torque=float(held[0]) if held.size == 1 else 0.0,
            motion=motion,
        )
    if code == PivotLimit.code:
        return PivotLimit(f"no state of contact reached after {int(counters[0])} pivots")
    if code == SingularContact.code:
        return SingularContact(
            f"{names[1]}: the rows of pairs in contact depend on each other, "
            "or a motion is held by no pair"
        )
    return InputError(f"the core refused the problem (code {code})", code=code)


def _is_symmetric(matrix: Vector) -> bool:
    """Symmetric to the rounding of its assembly, each entry on the scale of its diagonal."""
    difference = matrix - matrix.T
    np.abs(difference, out=difference)
    if difference.max() <= _ASYMMETRY * matrix.diagonal().min():
        return True
    root = np.sqrt(matrix.diagonal())
    return bool((difference <= _ASYMMETRY * np.outer(root, root)).all())
