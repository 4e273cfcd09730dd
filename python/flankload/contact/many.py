"""Several contact problems in one call of the core: lists of torques, sequences of positions."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

import flankload._core as _core
from flankload.contact.problem import (
    ContactProblem,
    from_angles,
    in_given_order,
    method_number,
    torque_loads,
)
from flankload.contact.state import ContactState, CoreAnswer, state_of
from flankload.errors import ContactError, InputError

Vector = NDArray[np.float64]


def solve_contact_torques(
    flexibility_matrix: ArrayLike,
    lever_arms: ArrayLike,
    gap_angles: ArrayLike,
    torques: ArrayLike,
    *,
    method: str = "auto",
    normal_lever_arms: ArrayLike | None = None,
    positive_definite: bool | None = None,
) -> tuple[ContactState, ...]:
    """States of contact of one position for a list of torques, in one call of the core.

    The torques are solved in ascending order; each state starts from the pairs and, if possible,
    the factor of the previous one.

    Parameters
    ----------
    torques : array_like of shape (T,)
        Torques >= 0 [N mm], in any order.
    flexibility_matrix, lever_arms, gap_angles, method, normal_lever_arms, positive_definite
        As in `solve_contact`.

    Returns
    -------
    tuple of ContactState
        In the order of the torques.

    Raises
    ------
    InputError
        As in `solve_contact`.
    ContactError
        For the first torque without a state, as `solve_contact` would raise it; its `states`
        contain those of the other torques (None if there is none), its `place` is the index of the
        torque.
    """
    problem = from_angles(
        flexibility_matrix,
        lever_arms,
        gap_angles,
        normal_lever_arms=normal_lever_arms,
        positive_definite=positive_definite,
    )
    loads = torque_loads("torques", torques, 1)
    states, error = _solve_all([problem], loads, None, method=method, threads=1)
    if error is not None:
        _, number = error.place
        raise _with_states(error, states[0], (number,), f"torque {number} ({loads[number]:g} N mm)")
    return _complete(states[0])


def solve_contact_sequence(
    flexibility_matrices: Sequence[ArrayLike] | NDArray[np.float64],
    lever_arms: Sequence[ArrayLike] | NDArray[np.float64],
    gap_angles: Sequence[ArrayLike] | NDArray[np.float64],
    torque: ArrayLike,
    *,
    method: str = "auto",
    normal_lever_arms: Sequence[ArrayLike] | NDArray[np.float64] | None = None,
    pair_keys: Sequence[ArrayLike] | NDArray[np.integer] | None = None,
    positive_definite: bool | None = None,
    threads: int = 0,
) -> tuple[ContactState, ...] | tuple[tuple[ContactState, ...], ...]:
    """States of contact of a sequence of positions, in one call of the core.

    Each position starts from the pairs in contact at the previous one. Threads process groups of
    eight positions; the result is bitwise independent of their number.

    Parameters
    ----------
    flexibility_matrices : sequence of P array_like of shape (n, n)
        Influence coefficients A of each position [rad/N]; n may differ from position to position.
    lever_arms, gap_angles, normal_lever_arms : sequence of P array_like of shape (n,)
        As in `solve_contact`, for each position.
    torque : float or array_like of shape (T,)
        Torque, or the torques for each position [N mm].
    pair_keys : sequence of P array_like of int of shape (n,), optional
        Identification of a pair from one position to the next, distinct within a position; for a
        moving point of contact, the place relative to that point. Default: its number.
    method, positive_definite
        As in `solve_contact`.
    threads : int, optional
        Number of threads; 0 (default): the default of OpenMP.

    Returns
    -------
    tuple of ContactState, or with T torques a tuple of them for each position

    Raises
    ------
    InputError
        As in `solve_contact`; the line names the position.
    ContactError
        For the first state that does not exist; its `states` contain all others (None if there is
        none), its `place` contains the indices of the position and of the torque.
    """
    loads = torque_loads("torque", torque, None)
    if loads.ndim > 1:
        raise InputError(f"torque: expected a number or a list, found shape {loads.shape}")
    count = len(flexibility_matrices)
    if not isinstance(threads, int | np.integer) or threads < 0:
        raise InputError(f"threads: expected an integer >= 0, found {threads!r}")
    parts = {
        "lever_arms": lever_arms,
        "gap_angles": gap_angles,
        "normal_lever_arms": normal_lever_arms,
        "pair_keys": pair_keys,
    }
    for name, part in parts.items():
        if part is not None and len(part) != count:
            raise InputError(f"{name}: expected one a position, {count}, found {len(part)}")
    if count == 0:
        return ()
    problems = []
    for p in range(count):
        try:
            problems.append(
                from_angles(
                    flexibility_matrices[p],
                    lever_arms[p],
                    gap_angles[p],
                    normal_lever_arms=None if normal_lever_arms is None else normal_lever_arms[p],
                    positive_definite=positive_definite,
                )
            )
        except InputError as refusal:
            raise InputError(f"position {p}: {refusal}", code=refusal.code) from None
    keys = None if pair_keys is None else _keys(pair_keys, problems)
    states, error = _solve_all(
        problems, np.atleast_1d(loads), keys, method=method, threads=min(int(threads), count)
    )
    if error is not None:
        p, number = error.place
        kept = tuple(line[0] for line in states) if loads.ndim == 0 else tuple(map(tuple, states))
        where = f"position {p}" if loads.ndim == 0 else f"position {p}, torque {number}"
        raise _with_states(error, kept, error.place, where)
    if loads.ndim == 0:
        return tuple(_complete(line)[0] for line in states)
    return tuple(_complete(line) for line in states)


def _complete(states: Sequence[ContactState | None]) -> tuple[ContactState, ...]:
    """All states, if none is missing."""
    return tuple(state for state in states if state is not None)


def _with_states(
    error: ContactError, states: Sequence[object], place: tuple[int, ...], where: str
) -> ContactError:
    """The exception with its place and the other states."""
    error.args = (f"{where}: {error}",)
    error.states = tuple(states)
    error.place = place
    return error


def _keys(
    pair_keys: Sequence[ArrayLike] | NDArray[np.integer], problems: list[ContactProblem]
) -> list[NDArray[np.int32]]:
    """Keys, checked: integers, distinct within a position."""
    result = []
    for p, problem in enumerate(problems):
        keys = np.asarray(pair_keys[p])
        if keys.shape != (problem.n,) or not np.issubdtype(keys.dtype, np.integer):
            raise InputError(
                f"pair_keys: expected {problem.n} integers at position {p}, found shape "
                f"{keys.shape} of {keys.dtype}"
            )
        if np.unique(keys).size != keys.size:
            raise InputError(f"pair_keys: expected each key once, position {p} has one twice")
        result.append(keys.astype(np.int32))
    return result


def _solve_all(
    problems: list[ContactProblem],
    loads: Vector,
    keys: list[NDArray[np.int32]] | None,
    *,
    method: str,
    threads: int,
) -> tuple[list[list[ContactState | None]], ContactError | None]:
    """States by problem and load, and the first exception with its place."""
    number = max(method_number(method, problem) for problem in problems)
    problems = [in_given_order(problem, slice(None)) for problem in problems]
    if loads.size == 0:
        return [[] for _ in problems], None
    sizes = np.array([problem.n for problem in problems], dtype=np.int32)
    if keys is None:
        keys = [np.arange(n, dtype=np.int32) for n in sizes]
    forces, gaps, motion, tangent, active, counters, certificate, codes = (
        _core.flankload_solve_sequence(
            threads,
            sizes,
            np.concatenate([problem.compliance.ravel(order="K") for problem in problems]),
            np.concatenate([problem.gaps for problem in problems]),
            np.concatenate([problem.motions.ravel(order="F") for problem in problems]),
            np.concatenate([problem.load_rows.ravel(order="F") for problem in problems]),
            np.asfortranarray(
                loads[np.newaxis, :, np.newaxis] / [problem.load_unit for problem in problems]
            ),
            np.concatenate(keys),
            np.array([problem.structure for problem in problems], dtype=np.int32),
            number,
        )
    )
    ends = np.cumsum(sizes)
    states: list[list[ContactState | None]] = []
    first_error: ContactError | None = None
    for p, problem in enumerate(problems):
        part = slice(ends[p] - sizes[p], ends[p])
        line: list[ContactState | None] = []
        for t in range(loads.size):
            answer = CoreAnswer(
                forces[part, t].copy(),
                gaps[part, t].copy(),
                motion[:, t, p].copy(),
                tangent[:, :, t, p].copy(),
                active[part, t],
                counters[:, t, p],
                certificate[:, t, p],
                int(codes[t, p]),
            )
            try:
                line.append(state_of(problem, loads[t : t + 1], answer))
            except ContactError as error:
                line.append(None)
                if first_error is None:
                    error.place = (p, t)
                    first_error = error
        states.append(line)
    return states, first_error
