"""State of contact and its certificate."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flankload.base.card import Card
from flankload.base.read_only import KeepsReadOnly

Vector = NDArray[np.float64]

# force directions whose stiffness is below this part of the largest are undetermined
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
        definite, as for elastic bodies, and all columns read confirm it.
    influence_columns : int
        Number of computed columns of the influence matrix: all, except for
        `solve_contact_on_demand`.
    undetermined : tuple of tuple of int
        Groups of pairs of which only the sum of the forces is determined.
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
    influence_columns: int
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


def undetermined_groups(
    compliance: Vector, load_rows: Vector, forces: Vector, gaps: Vector, status: int
) -> tuple[tuple[int, ...], ...]:
    """Groups of touching pairs of which only the sum of the forces is determined.

    Directions in force space that change neither gaps nor loads: right singular vectors of the
    equilibrated equations with small singular values. Pairs that one of them couples are one group.
    """
    if status <= 0:
        return ()
    touching = np.flatnonzero(gaps <= 0.0)
    if touching.size < 2 or not forces.any():
        return ()
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
        groups.append(tuple(sorted(int(touching[k]) for k in group)))
    return tuple(sorted(groups))
