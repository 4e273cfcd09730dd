"""Contact problems: the pairs in contact and their forces.

The angle form (equations (16), (17) and (20) of the paper) is converted to the general form

    g = K F + g0 - B q >= 0,   F >= 0,   g F = 0,   R^T F = Q.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

import flankload._core as _core
from flankload.contact.many import solve_contact_sequence, solve_contact_torques
from flankload.contact.problem import (
    ContactProblem,
    from_angles,
    general,
    in_given_order,
    loads_of_motions,
    method_number,
    pair_numbers,
    torque_loads,
)
from flankload.contact.state import (
    ContactInfo,
    ContactState,
    CoreAnswer,
    Vector,
    columns_used,
    state_of,
)

__all__ = [
    "ContactInfo",
    "ContactState",
    "solve_contact",
    "solve_contact_general",
    "solve_contact_sequence",
    "solve_contact_torques",
]


def solve_contact(
    flexibility_matrix: ArrayLike,
    lever_arms: ArrayLike,
    gap_angles: ArrayLike,
    torque: float,
    *,
    method: str = "auto",
    normal_lever_arms: ArrayLike | None = None,
    warm_pairs: ArrayLike | None = None,
    positive_definite: bool | None = None,
) -> ContactState:
    """Find the pairs in contact, their forces and the rotation for a torque.

    Parameters
    ----------
    flexibility_matrix : array_like of shape (n, n)
        Influence coefficients A [rad/N].
    lever_arms : array_like of shape (n,)
        Torque row m [mm]; with friction including its own signs.
    gap_angles : array_like of shape (n,)
        Initial gap angles [rad]; a common offset becomes part of the rotation.
    torque : float
        Torque M >= 0 [N mm]. Without torque the rotation is the smallest gap angle.
    method : {"auto", "single", "primal", "block", "cascade", "load_path", "paper"}
        ``single`` lets any pair join or leave, one at a time, with forces in equilibrium with the
        loads at every step, also known as ``primal``; ``block`` changes many pairs at once;
        ``cascade`` uses blocks that begin with the contact of a coarser problem, for pairs in flank
        order; ``load_path`` follows the state from zero torque (Lemke). If one does not converge,
        the next one is used: block, single, single with exchange of rows, load path. ``auto``
        begins with ``single`` for few pairs, with ``cascade`` for many in flank order without
        `warm_pairs`, else with ``block``. ``paper`` only lets pairs join.
    normal_lever_arms : array_like of shape (n,), optional
        Row scale b > 0 [mm] if it differs from ``abs(lever_arms)``.
    warm_pairs : array_like of int, optional
        Initial pairs, from 0; a good guess saves time and does not change the result.
    positive_definite : bool, optional
        Basis for the uniqueness of the state. None (default): a symmetric diag(b) A is assumed to
        be the compliance of elastic bodies, which is positive definite; this is checked on all
        columns that the solution has read (`info.uniqueness` is ``"elastic"``), and for few pairs,
        for which the cost is negligible, proven from the whole matrix (``"proven"``). A matrix that
        is not symmetric (friction) is always factored as a whole. False: nothing is assumed, which
        for many pairs takes longer than the solution. True: the symmetric part of diag(b) A (rows
        weighted with m/b if m differs from b) is known to be positive definite; with many pairs,
        only the entries that the solution reads are then checked.

    Returns
    -------
    ContactState

    Raises
    ------
    InputError
        Code -4: shapes, NaN, negative torque, unknown method; code -5: a row scale that is not
        positive, or no lever arm > 0.
    NoContactState, PivotLimit, SingularContact
        No state exists, or none was found.
    NegativeForce
        Method ``paper`` ended with tension; the state is attached.

    Notes
    -----
    Weese & Popov, equations (16) to (34), with the extension that any pair can leave.
    """
    problem = from_angles(
        flexibility_matrix,
        lever_arms,
        gap_angles,
        normal_lever_arms=normal_lever_arms,
        positive_definite=positive_definite,
    )
    load = torque_loads("torque", torque, 0)[np.newaxis]
    return _solve(problem, load, method=method, warm_pairs=warm_pairs)


def solve_contact_general(
    compliance_matrix: ArrayLike,
    normal_gaps: ArrayLike,
    motions: ArrayLike,
    loads: ArrayLike,
    *,
    load_rows: ArrayLike | None = None,
    method: str = "auto",
    warm_pairs: ArrayLike | None = None,
    positive_definite: bool | None = None,
) -> ContactState:
    """Find the state of contact of the general form with any number of free motions.

    Parameters
    ----------
    compliance_matrix : array_like of shape (n, n)
        K, normal displacement of pair i under a unit force on pair j [mm/N].
    normal_gaps : array_like of shape (n,)
        g0 [mm]; negative if bodies overlap before they move (preload).
    motions : array_like of shape (n, q) or (n,)
        B, gap closed by a unit of each motion; zero and negative lever arms are allowed.
    loads : array_like of shape (q,) or float
        Q, the load on each motion.
    load_rows : array_like of shape (n, q) or (n,), optional
        R, contribution of a unit force to each load; by default B (no friction).
    method, warm_pairs, positive_definite
        As in `solve_contact`; ``paper`` requires a single motion.

    Returns
    -------
    ContactState
        With final gaps along the normals [mm] instead of angles.

    Raises
    ------
    InputError, NoContactState, PivotLimit, SingularContact, NegativeForce
        As in `solve_contact`. `NoContactState` contains a motion on which the loads do work and
        that no pair resists.
    """
    load = loads_of_motions(loads)
    problem = general(
        compliance_matrix,
        normal_gaps,
        motions,
        load_rows,
        n_motions=load.size,
        positive_definite=positive_definite,
    )
    return _solve(problem, load, method=method, warm_pairs=warm_pairs)


def _solve(
    problem: ContactProblem, loads: Vector, *, method: str, warm_pairs: ArrayLike | None
) -> ContactState:
    """Call the core once, or again if it was given the transpose of another matrix."""
    number = method_number(method, problem)
    warm = pair_numbers(warm_pairs, problem.n)
    while True:
        answer = CoreAnswer(
            *_core.flankload_solve_contact(
                problem.compliance,
                problem.gaps,
                problem.motions,
                problem.load_rows,
                loads / problem.load_unit,
                problem.structure,
                number,
                warm + 1,
            )
        )
        given = in_given_order(problem, columns_used(answer))
        if given is problem:
            return state_of(problem, loads, answer)
        problem = given
