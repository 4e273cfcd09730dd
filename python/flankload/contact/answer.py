"""Conversion of the core's output to a state of contact or an exception."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from flankload.contact.problem import DEFINITE, RUNGS, ContactProblem
from flankload.contact.state import ContactInfo, ContactState, undetermined_groups
from flankload.contact.status import OUT_OF_RANGE
from flankload.errors import (
    ContactError,
    InputError,
    NegativeForce,
    NoContactState,
    PivotLimit,
    SingularContact,
)

Vector = NDArray[np.float64]


class CoreAnswer(NamedTuple):
    """Output of the core for one state, in its order."""

    forces: Vector
    gaps: Vector
    motion: Vector
    tangent: Vector
    active: NDArray[np.int32]
    counters: NDArray[np.int32]
    certificate: Vector
    code: int


def state_of(
    problem: ContactProblem,
    loads: Vector,
    answer: CoreAnswer,
    *,
    known: NDArray[np.int32] | None = None,
    columns: Vector | None = None,
) -> ContactState:
    """The state of contact, or the exception for the core's status code.

    If only some columns of K were computed, `known` are their pairs.
    """
    code = int(answer.code)
    if code < 0 and code != NegativeForce.code:
        raise failure(problem, loads, answer)
    unique = bool(answer.counters[2])
    info = ContactInfo(
        rung=RUNGS[int(answer.counters[3])],
        pivots=int(answer.counters[0]),
        refactorisations=int(answer.counters[1]),
        condition=float(answer.certificate[0]),
        growth=float(answer.certificate[1]),
        backward_error=float(answer.certificate[2]),
        margin=float(answer.certificate[3]),
        unique=unique,
        uniqueness=_uniqueness(unique, problem.structure),
        influence_columns=problem.n if known is None else known.size,
        undetermined=_undetermined(problem, answer, known, columns),
    )
    state = ContactState(
        normal_forces=answer.forces,
        final_gap_angles=answer.gaps / problem.gap_scale,
        rotation=float(answer.motion[0]),
        active_pairs=answer.active.nonzero()[0],
        status=code,
        info=info,
        motions=answer.motion,
        tangent=answer.tangent / problem.load_unit,
    )
    if code == NegativeForce.code:
        pair = int(answer.forces.argmin())
        raise NegativeForce(
            f"method 'paper' ended with tension, {answer.forces[pair]:g} N at pair {pair}",
            state=state,
        )
    return state


def _undetermined(
    problem: ContactProblem,
    answer: CoreAnswer,
    known: NDArray[np.int32] | None,
    columns: Vector | None,
) -> tuple[tuple[int, ...], ...]:
    """Groups of pairs of which only the sum is determined, numbered among all pairs."""
    if known is None or columns is None:
        return undetermined_groups(
            problem.compliance, problem.load_rows, answer.forces, answer.gaps, answer.code
        )
    groups = undetermined_groups(
        columns[known],
        problem.load_rows[known],
        answer.forces[known],
        answer.gaps[known],
        answer.code,
    )
    return tuple(sorted(tuple(sorted(int(known[k]) for k in group)) for group in groups))


def failure(problem: ContactProblem, loads: Vector, answer: CoreAnswer) -> ContactError:
    """The exception of a code of the core."""
    code = int(answer.code)
    if code == NoContactState.code:
        return _no_state(answer, float(answer.certificate[4]) * loads)
    if code == PivotLimit.code:
        return PivotLimit(f"no state of contact reached after {int(answer.counters[0])} pivots")
    if code == SingularContact.code:
        return _singular(problem, answer.motion)
    if code == OUT_OF_RANGE:
        return InputError(
            "loads: expected units in which forces, gaps and motions lie within 1e-308 … 1e308 "
            "beside loads and gaps, found others",
            code=code,
        )
    return InputError(f"the core refused the problem (code {code})", code=code)


def _singular(problem: ContactProblem, motion: Vector) -> SingularContact:
    """The exception that names the unconstrained motion, or the matrix."""
    largest = motion[np.abs(motion).argmax()]
    if not abs(largest) > 0.0:
        return SingularContact(
            f"{problem.names[1]}: the rows of pairs in contact depend on each other",
            motion=np.zeros(motion.size),
        )
    loose = motion / largest + 0.0
    name = "motions" if np.array_equal(problem.load_rows, problem.motions) else "load_rows"
    return SingularContact(
        f"{name}: expected pairs that hold every motion, found none along "
        + ", ".join(f"{part:g}" for part in loose),
        motion=loose,
    )


def _no_state(answer: CoreAnswer, held: Vector) -> NoContactState:
    """The exception that states whether no state exists or none was found."""
    proven = bool(answer.counters[4])
    message = (
        "no pairs can hold these loads"
        if proven
        else "no state was found; the matrix does not rule out that there is one"
    )
    if answer.motion.any():
        message += ": free to move along " + ", ".join(f"{part:g}" for part in answer.motion)
    if held.size == 1:
        message += f"; {held[0] + 0.0:g} can be held"
    return NoContactState(
        message,
        proven=proven,
        largest_torque=float(held[0]) if held.size == 1 else 0.0,
        motion=answer.motion,
    )


def _uniqueness(unique: bool, structure: int) -> str:
    """Basis for the uniqueness of the state."""
    if not unique:
        return "not certain"
    return "elastic" if structure >= DEFINITE else "proven"
