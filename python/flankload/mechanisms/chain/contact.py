"""Contact of rollers with their pockets: one linear contact problem, or an iteration of these.

    g = K F + g0 - B phi >= 0,  F >= 0,  g F = 0,  B·F = M

K contains the chain as a truss with its tight end fixed along the strand, and the contact
compliance of each roller, which is isotropic. B contains the lever arm of each normal about the
axis, which is 0 at the middle of a seat. The slack tension and the wear are loads of the truss:
they shift g0.

Linear state: planes tangent to the seat arcs, about the rollers' places on the pitch circle, with
tensions for the lateral stiffness that decrease linearly from end to end. Iteration: planes at the
nearest points of the pockets, with their curvature and the current tensions, until no roller moves.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from flankload.contact import solve_contact_general
from flankload.mechanisms.chain.wrap import (
    Planes,
    Wrap,
    cross,
    in_pocket,
    nearest_planes,
    seat_planes,
)

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flankload.base.arrays import Floats
    from flankload.contact import ContactState
    from flankload.mechanisms.chain.wrap import Chain

#: Planes of a seat in a linear state: 17 give an error of the tensions of 1.3 % of the tight
#: tension in the widest seat, 9 give 4.7 %.
SEAT_PLANES = 17
#: Additional compliance of each plane, relative to that of the contact; it makes the forces on
#: several planes of a roller unique.
PLANE_COMPLIANCE_RATIO = 1e-4
#: Relative change of the torque for the derivative of the rotation: in a linear state, whose seats
#: have corners, and in the iteration.
TORQUE_STEP = {False: 0.05, True: 1e-3}
#: Ratio of the rotational stiffness of support and contact below which the support is weak.
WEAK_SUPPORT_RATIO = 1e-5
#: Largest motion of a roller in a pass, in pitches, and the motion below which it has converged.
LONGEST_STEP, CONVERGED = 0.02, 1e-10
#: Largest number of passes.
MOST_PASSES = 200
#: Least and largest factor of a step, and the pass from which the least factor is used.
LEAST_STEP_FACTOR, LARGEST_STEP_FACTOR, STEADY_FROM = 0.25, 1.5, 60
#: Least torque, relative to that of the slack strand, which replaces smaller ones: with these the
#: rotation between planes is not unique.
LEAST_TORQUE = 1e-4


@dataclass(frozen=True)
class WrapState:
    """State at a position; n rollers.

    Attributes
    ----------
    rotation_rad : float
        Rotation of the sprocket relative to the uniform motion of the tight strand.
    compliance_rad_per_Nmm : float
        Derivative of the rotation with respect to the torque.
    force_N : (n, 2) array
        Forces of the pockets on the rollers: circumferential, and outwards, of each pocket.
    place_mm : (n, 2) array
        Displacements of the rollers from the pitch circle, in the same directions.
    tension_N : (n + 1,) array
        In front of each roller and behind the last: tight strand, links, slack strand.
    backward_error, condition : float
        For the last contact problem.
    moves_mm : float
        Largest motion of a roller in the last pass; 0 for a linear state and after convergence.
    """

    rotation_rad: float
    compliance_rad_per_Nmm: float
    force_N: Floats
    place_mm: Floats
    tension_N: Floats
    status: int
    passes: int
    pivots: int
    planes: int
    backward_error: float
    condition: float
    moves_mm: float


def work_of(states: Sequence[WrapState]) -> dict[str, int]:
    """Counted work of states, by the names of `cost.COUNTERS`."""
    return {
        "states": len(states),
        "contact_passes": sum(state.passes for state in states),
        "influence_columns": sum(state.passes * state.planes for state in states),
        "pivots": sum(state.pivots for state in states),
    }


@dataclass(frozen=True)
class _Pass:
    """One contact problem and the motion it causes."""

    move: Floats
    turn: float
    force: Floats
    bend: Floats
    tight_N: float
    link_N: Floats
    state: ContactState
    planes: int


def solve_wrap(
    wrap: Wrap,
    chain: Chain,
    torque_Nmm: float,
    slack_N: float,
    *,
    large_displacement: bool,
    with_compliance: bool = True,
) -> WrapState:
    """State of the rollers at a position under a torque and the tension of the slack strand.

    With large displacements it is iterated until convergence, otherwise it is one linear state. The
    compliance is the derivative of the rotation with respect to the torque.

    Raises ContactError if the contact problem has no solution.
    """
    found = _iterate(
        _Problem.of(wrap, chain, torque_Nmm, slack_N), large_displacement=large_displacement
    )
    # the slack tension turns the sprocket, too: its torque is the scale
    more = TORQUE_STEP[large_displacement] * (torque_Nmm + slack_N * wrap.levers_mm[1])
    other = found
    if with_compliance:
        other = _iterate(
            _Problem.of(wrap, chain, torque_Nmm + more, slack_N),
            found if large_displacement else None,
            large_displacement=large_displacement,
        )
    step = found.step
    polar = wrap.angles_rad + found.turned
    return WrapState(
        rotation_rad=found.turned,
        compliance_rad_per_Nmm=(other.turned - found.turned) / more,
        force_N=in_pocket(step.force, polar),
        place_mm=in_pocket(found.place, polar) - [0.0, wrap.sprocket.pitch_radius_mm],
        tension_N=np.array([step.tight_N, *step.link_N, slack_N]),
        status=step.state.status,
        passes=found.passes + with_compliance * other.passes,
        pivots=found.pivots + with_compliance * other.pivots,
        planes=step.planes,
        backward_error=step.state.info.backward_error,
        condition=step.state.info.condition,
        moves_mm=found.moves_mm,
    )


@dataclass(frozen=True)
class _Problem:
    """A wrap under load.

    Attributes
    ----------
    torque_Nmm, slack_N, tight_N : float
        Torque, and tensions of both strands.
    run_mm : float
        Motion of the tight end along its strand.
    """

    wrap: Wrap
    chain: Chain
    torque_Nmm: float
    slack_N: float
    tight_N: float
    run_mm: float

    @classmethod
    def of(cls, wrap: Wrap, chain: Chain, torque_Nmm: float, slack_N: float) -> _Problem:
        """Load of a linear state: its tight tension is that of a rigid wrap."""
        one, two = wrap.levers_mm
        torque = max(torque_Nmm, LEAST_TORQUE * slack_N * two)
        tight = (torque + slack_N * two) / one
        # the tight strand moves uniformly: a pitch of the loaded chain with each tooth
        run = chain.link_mm * (1 + tight / chain.link_stiffness_N) * wrap.advance
        return cls(wrap, chain, torque, slack_N, tight, run)

    def linear(self) -> _Pass:
        """The linear state, on planes tangent to the seats."""
        centers, half = self.wrap.centers, self.wrap.sprocket.seat_half_angle_rad
        tensions = np.linspace(self.tight_N, self.slack_N, len(centers) + 1)[1:-1]
        angles = np.linspace(-half, half, SEAT_PLANES)
        planes = seat_planes(self.wrap, centers, 0.0, angles)
        return self.solved(centers, tensions, np.zeros((len(centers), 2, 2)), planes)

    def solved(self, place: Floats, tension: Floats, bend: Floats, planes: Planes) -> _Pass:
        """One contact problem about places of the rollers."""
        n = len(place)
        chain, tight = self.chain, self.wrap.tight
        stiffness, force = self._truss(place, tension, bend)
        # the tight end is fixed along its strand: one direction of roller 0 is prescribed
        known = np.zeros(2 * n)
        known[:2] = -(self.run_mm + place[0] @ tight) * tight
        free = np.eye(2 * n)[:, 1:]
        free[:2, 0] = [-tight[1], tight[0]]
        parts = np.zeros((planes.gap.size, n, 2))
        parts[np.arange(planes.gap.size), planes.roller] = planes.normal
        rows = parts.reshape(-1, 2 * n)
        # the curvature of a seat rotates with the sprocket
        drag = np.einsum("nij,nj->ni", bend, _rotation_shift(place)).ravel()
        solved = free @ np.linalg.solve(
            free.T @ stiffness @ free,
            free.T @ np.column_stack([force - stiffness @ known, drag, rows.T]),
        )
        base, dragged, moved = solved[:, 0] + known, solved[:, 1], solved[:, 2:]
        same = planes.roller[:, None] == planes.roller[None, :]
        alike = planes.normal @ planes.normal.T + PLANE_COMPLIANCE_RATIO * np.eye(planes.gap.size)
        matrix = rows @ moved + same * alike / chain.contact_stiffness_N_per_mm
        levers = cross(place[planes.roller], planes.normal) - rows @ dragged
        state, turn = _solve_with_support(
            0.5 * (matrix + matrix.T),
            planes.gap + rows @ base,
            levers,
            self.torque_Nmm + float(drag @ base),
            float(drag @ (_rotation_shift(place).ravel() - dragged)),
        )
        on_planes = state.normal_forces[: planes.gap.size]
        move = base + moved @ on_planes + dragged * turn
        pushed = on_planes[:, None] * planes.normal
        forces = np.zeros((n, 2))
        np.add.at(forces, planes.roller, pushed)
        # the reaction at the tight end is its tension
        held = (stiffness @ move - drag * turn - force - forces.ravel())[:2] @ tight
        return _Pass(
            move=move.reshape(n, 2),
            turn=turn,
            force=forces,
            bend=_curvature_stiffness(n, planes, on_planes),
            tight_N=float(held),
            link_N=_link_tensions(chain, place, move.reshape(n, 2)),
            state=state,
            planes=planes.gap.size,
        )

    def _truss(self, place: Floats, tension: Floats, bend: Floats) -> tuple[Floats, Floats]:
        """Stiffness and forces of the links, of both strands and of the curvature of the seats."""
        n = len(place)
        stiffness, force = self.chain.truss(place, tension)
        blocks = stiffness.reshape(n, 2, n, 2)
        blocks[np.arange(n), :, np.arange(n), :] += bend
        pull = force.reshape(n, 2)
        pull[-1] += self.slack_N * self.wrap.slack
        for k, way, strand in (
            (0, self.wrap.tight, self.tight_N),
            (-1, self.wrap.slack, self.slack_N),
        ):
            across = np.array([-way[1], way[0]])
            spring = strand / self.chain.span_mm * np.outer(across, across)
            blocks[k, :, k, :] += spring
            pull[k] -= spring @ (place[k] - self.wrap.centers[k])
        return stiffness, force


@dataclass(frozen=True)
class _Iterated:
    """Result of an iteration."""

    step: _Pass
    place: Floats
    turned: float
    passes: int
    pivots: int
    moves_mm: float


def _iterate(
    problem: _Problem, start: _Iterated | None = None, *, large_displacement: bool
) -> _Iterated:
    """One linear state, or passes until convergence, optionally from an earlier result."""
    wrap, chain = problem.wrap, problem.chain
    if start is None:
        step = problem.linear()
        place, turned = wrap.centers + step.move, step.turn
        passes, pivots, moves = 1, step.state.info.pivots, 0.0
    else:
        step, place, turned = start.step, start.place, start.turned
        passes, pivots, moves = 0, 0, 0.0
    if not large_displacement:
        return _Iterated(step, place, turned, passes, pivots, moves)
    longest, part = LONGEST_STEP * chain.pitch_mm, 1.0
    last = np.zeros_like(place)
    while passes < MOST_PASSES:
        planes = nearest_planes(wrap, place, turned)
        problem = replace(problem, tight_N=step.tight_N)
        step = problem.solved(place, chain.tensions(place), step.bend, planes)
        passes, pivots = passes + 1, pivots + step.state.info.pivots
        part = _part(part, step.move, last) if passes < STEADY_FROM else LEAST_STEP_FACTOR
        last, moves = step.move, float(np.abs(step.move).max())
        factor = min(part, longest / max(moves, 1e-3 * longest))
        place, turned = place + factor * step.move, turned + factor * step.turn
        if moves < CONVERGED * chain.pitch_mm:
            moves = 0.0
            break
    return _Iterated(step, place, turned, passes, pivots, moves)


def _part(part: float, move: Floats, last: Floats) -> float:
    """Factor of a step, from the change by the previous one (Aitken).

    Flanks have no curvature here, and tensions are those of the previous pass.
    """
    change = move - last
    size = float((change**2).sum())
    if size == 0.0 or not last.any():
        return part
    return float(
        np.clip(-part * (last * change).sum() / size, LEAST_STEP_FACTOR, LARGEST_STEP_FACTOR)
    )


def _curvature_stiffness(rollers: int, planes: Planes, on_planes_N: Floats) -> Floats:
    """(n, 2, 2) Tangential stiffness of each roller: forces times the curvature of the seats."""
    along = np.column_stack([-planes.normal[:, 1], planes.normal[:, 0]])
    bends = np.zeros((rollers, 2, 2))
    np.add.at(
        bends,
        planes.roller,
        (on_planes_N * np.maximum(planes.curvature, 0.0))[:, None, None]
        * along[:, :, None]
        * along[:, None, :],
    )
    return bends


def _rotation_shift(place: Floats) -> Floats:
    """Displacements of places by a unit rotation about the axis."""
    return np.column_stack([-place[:, 1], place[:, 0]])


def _solve_with_support(
    matrix: Floats, gaps: Floats, levers: Floats, torque: float, support: float
) -> tuple[ContactState, float]:
    """Contact with a sprocket on an elastic support against rotation, N mm/rad.

    B·F + s phi = M: a support that is not weak is condensed into the matrix, K + B Bᵀ/s, g0 - B
    M/s, which eliminates the rotation. A separate pair provides the motion that the contact loop
    requires.
    """
    if support * np.abs(matrix).max() <= WEAK_SUPPORT_RATIO * np.abs(levers).max() ** 2:
        state = solve_contact_general(
            matrix, gaps, levers[:, None], [torque], method="single", positive_definite=True
        )
        return state, state.rotation
    n = gaps.size
    folded = np.zeros((n + 1, n + 1))
    folded[:n, :n] = matrix + np.outer(levers, levers) / support
    folded[n, n] = np.abs(matrix).max()
    state = solve_contact_general(
        folded,
        np.append(gaps - levers * torque / support, 0.0),
        np.append(np.zeros(n), 1.0)[:, None],
        [1.0],
        method="single",
        positive_definite=True,
    )
    return state, float(torque - levers @ state.normal_forces[:n]) / support


def _link_tensions(chain: Chain, place: Floats, move: Floats) -> Floats:
    """Tensions of the links after a small motion."""
    link = np.diff(place, axis=0)
    t = link / np.hypot(*link.T)[:, None]
    stretch = (t * np.diff(move, axis=0)).sum(axis=1)
    return chain.tensions(place) + chain.link_stiffness_N / chain.link_mm * stretch
