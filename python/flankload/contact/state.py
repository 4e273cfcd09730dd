"""States of contact with their certificates, or exceptions, from the output of the core."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from flankload.base.card import Card
from flankload.base.read_only import KeepsReadOnly
from flankload.contact.problem import (
    DEFINITE,
    METHOD_NAMES,
    ContactProblem,
    expect_finite,
    expect_positive_diagonal,
)
from flankload.contact.status import Status, status_text
from flankload.errors import (
    ContactError,
    InputError,
    NegativeForce,
    NoContactState,
    PivotLimit,
    SingularContact,
)

Vector = NDArray[np.float64]

# largest stiffness of an undetermined force direction, over the largest of all
_UNDETERMINED = 1e-8


@dataclass(frozen=True)
class ContactInfo:
    """Solution history of a state, and its certificate.

    Attributes
    ----------
    rung : str
        The loop that found the state.
    pivots, refactorisations : int
        Number of pairs that joined or left; number of complete factorisations that restored
        accuracy.
    condition : float
        Condition number of the equilibrated equations of the active pairs.
    growth : float
        Growth of the entries in elimination without row exchanges.
    backward_error : float
        Largest residual of a row of the problem, relative to the size of the row.
    margin : float
        Distance to the nearest change of the active pairs: the minimum of force divided by largest
        force (active pairs) and of gap divided by the size of the row (others).
    unique : bool
        Whether no other state exists, on the basis of `uniqueness`.
    uniqueness : {"proven", "elastic", "not certain"}
        Basis of `unique`: the whole matrix was factored; or the matrix is known to be positive
        definite, as for elastic bodies, and all entries confirm it.
    undetermined : tuple of tuple of int
        Groups of pairs for which only the sum of the forces is determined.
    """

    rung: str
    pivots: int
    refactorisations: int
    condition: float
    growth: float
    backward_error: float
    margin: float
    unique: bool
    uniqueness: str
    undetermined: tuple[tuple[int, ...], ...] = ()


@dataclass(frozen=True, repr=False)
class ContactState(Card, KeepsReadOnly):
    """State of contact of n pairs; its arrays are read-only.

    Attributes
    ----------
    normal_forces : ndarray of shape (n,)
        Normal forces [N], zero if a pair is open.
    final_gap_angles : ndarray of shape (n,)
        Final gap angles [rad]; from `solve_contact_general` final gaps along the normals [mm].
    rotation : float
        Rotation of body 1 in the sense of its torque [rad]; the first motion of the general form.
    active_pairs : ndarray of int
        Pairs with contact force, from 0, ascending.
    status : int
        0 solved; 1 solved, ill-conditioned (distribution between pairs uncertain, sums correct) or
        rows not satisfied to 10 eps (``info.backward_error``); 2 solved, degenerate (a pair with
        neither force nor gap); 3 solved, uniqueness not certain. The state attached to a
        `NegativeForce` has -6.
    info : ContactInfo
        Certificate and counters.
    motions : ndarray of shape (q,)
        All motions of the general form; ``motions[0] == rotation``.
    tangent : ndarray of shape (q, q)
        Derivative of the motions with respect to the loads for constant active pairs [rad/(N mm)].
    """

    normal_forces: Vector
    final_gap_angles: Vector
    rotation: float
    active_pairs: NDArray[np.intp]
    status: int
    info: ContactInfo
    motions: Vector
    tangent: Vector

    def __post_init__(self) -> None:
        for numbers in (
            self.normal_forces,
            self.final_gap_angles,
            self.active_pairs,
            self.motions,
            self.tangent,
        ):
            numbers.flags.writeable = False


def _undetermined_groups(
    compliance: Vector, load_rows: Vector, forces: Vector, gaps: Vector
) -> list[list[int]]:
    """Groups of touching pairs for which only the sum of the forces is determined.

    Force directions that change neither gaps nor loads are right singular vectors of the
    equilibrated equations with small singular values. Pairs that are coupled by them form a group.
    """
    touching = np.flatnonzero(gaps <= 0.0)
    if touching.size < 2 or not forces.any():
        return []
    scale = 1.0 / np.sqrt(compliance.diagonal()[touching])
    rows = load_rows[touching].T * scale
    rows = rows / np.maximum(np.abs(rows).max(axis=1, keepdims=True), np.finfo(float).tiny)
    scaled = compliance[np.ix_(touching, touching)] * scale * scale[:, np.newaxis]
    equations = np.vstack([scaled, rows])
    _, sizes, vectors = np.linalg.svd(equations)
    weak = vectors[sizes < _UNDETERMINED * sizes[0]]
    linked = np.abs(weak.T @ weak) > 1e-3
    groups = []
    left = set(np.flatnonzero(linked.diagonal()).tolist())
    while left:
        group = {left.pop()}
        front = set(group)
        while front:
            front = {k for k in left if linked[k, list(front)].any()}
            left -= front
            group |= front
        groups.append([int(touching[k]) for k in group])
    return groups


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


def columns_used(answer: CoreAnswer) -> slice:
    """Columns of K that a state depends on; all if there is none."""
    active = answer.active.nonzero()[0]
    return slice(active[0], active[-1] + 1) if answer.code >= 0 and active.size else slice(None)


def state_of(
    problem: ContactProblem,
    loads: Vector,
    answer: CoreAnswer,
) -> ContactState:
    """The state of contact, or the exception for the core's status code."""
    code = int(answer.code)
    if code < 0 and code != Status.NEGATIVE_FORCE:
        raise failure(problem, loads, answer)
    unique = bool(answer.counters[2])
    info = ContactInfo(
        rung=METHOD_NAMES[int(answer.counters[3])],
        pivots=int(answer.counters[0]),
        refactorisations=int(answer.counters[1]),
        condition=float(answer.certificate[0]),
        growth=float(answer.certificate[1]),
        backward_error=float(answer.certificate[2]),
        margin=float(answer.certificate[3]),
        unique=unique,
        uniqueness=_uniqueness(unique, problem.structure),
        undetermined=_undetermined(problem, answer),
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
    if code == Status.NEGATIVE_FORCE:
        pair = int(answer.forces.argmin())
        raise NegativeForce(
            f"method 'paper' ended with tension, {answer.forces[pair]:g} N at pair {pair}",
            state=state,
        )
    return state


def _undetermined(problem: ContactProblem, answer: CoreAnswer) -> tuple[tuple[int, ...], ...]:
    """Groups of pairs for which only the sum of the forces is determined, by pair number."""
    if answer.code <= 0:
        return ()
    groups = _undetermined_groups(problem.compliance, problem.load_rows, answer.forces, answer.gaps)
    return tuple(sorted(tuple(sorted(group)) for group in groups))


def failure(problem: ContactProblem, loads: Vector, answer: CoreAnswer) -> ContactError:
    """The exception of a code of the core."""
    code = int(answer.code)
    if code == Status.NO_CONTACT_STATE:
        return _no_state(answer, float(answer.certificate[4]) * loads)
    if code == Status.PIVOT_LIMIT:
        return PivotLimit(f"no contact state found after {int(answer.counters[0])} pivots")
    if code == Status.SINGULAR_CONTACT:
        return _singular(problem, answer.motion)
    if code in (Status.INVALID_INPUT, Status.INVALID_SCALE):
        given = problem.compliance.T if problem.by_rows else problem.compliance
        expect_finite(problem.names[0], given)
        expect_positive_diagonal(given.diagonal(), problem.names[0])
    if code == Status.OUT_OF_RANGE:
        return InputError(
            "loads: expected units in which forces, gaps and motions lie between 1e-308 and 1e308, "
            "found units in which they do not",
            code=code,
        )
    return InputError(f"{status_text(code)} (code {code})", code=code)


def _singular(problem: ContactProblem, motion: Vector) -> SingularContact:
    """The exception with the unconstrained motion, or about the matrix."""
    largest = motion[np.abs(motion).argmax()]
    if not abs(largest) > 0.0:
        return SingularContact(
            f"{problem.names[1]}: the rows of pairs in contact are linearly dependent",
            motion=np.zeros(motion.size),
        )
    loose = motion / largest + 0.0
    name = "motions" if np.array_equal(problem.load_rows, problem.motions) else "load_rows"
    return SingularContact(
        f"{name}: expected pairs that restrain every motion, found none along "
        + ", ".join(f"{part:g}" for part in loose),
        motion=loose,
    )


def _no_state(answer: CoreAnswer, held: Vector) -> NoContactState:
    """The exception with the information whether no state exists or none was found."""
    proven = bool(answer.counters[4])
    message = (
        status_text(Status.NO_CONTACT_STATE)
        if proven
        else "no contact state was found; that none exists is not proven"
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
