"""Contact problem of a timing belt on its pulley, and an equivalent row of springs.

    g = K F + g0 - B phi >= 0,  F >= 0,  g F = 0,  R·F = Q

All forces are per mm of width. The slack tension T2 and the pitch difference are in g0; without
friction R = B and Q is the torque. Fixed lands react with N = P F + p T2.

Sliding lands carry a circumferential friction force t = mu N: N = (1 - mu P_t)^-1 (P F + p T2) is
substituted into K, g0 and the balance of torque. Lands that can lift by w >= 0 react with
N = P F + p T2 + S w >= 0, and N w = 0: the same problem with more unknowns, whose matrix
[[K, -Pᵀ], [P, S]] is not symmetric but positive definite, and no worse conditioned than that of
fixed lands.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from flankload.base.torque import in_newton_metres
from flankload.contact import solve_contact_general
from flankload.errors import ContactError, NoContactState
from flankload.mechanisms.belt.strip import Kind
from flankload.mechanisms.wrapped import slack_of

if TYPE_CHECKING:
    from flankload.base.arrays import Flags, Floats, Numbers
    from flankload.contact import ContactState
    from flankload.cost import Account
    from flankload.mechanisms.belt.belt import Strip
    from flankload.mechanisms.belt.columns import Flanks
    from flankload.mechanisms.belt.row import StripResponse
    from flankload.scene import Scene

#: Number of halvings and doublings in the search for the slack tension at which a belt jumps.
STEPS = 20


@dataclass(frozen=True)
class BeltState:
    """State of a belt under a torque: w teeth, n pairs, forces per mm of width.

    Attributes
    ----------
    first_tooth, first_land : int
        Numbers of the first tooth and the first land.
    rotation_rad : float
        Rotation of the pulley while the tight end of the strip is fixed.
    compliance_rad_per_N : float
        Derivative of the rotation with respect to the torque per mm of width.
    pair_N_per_mm : (n,) array
    pair_gap_mm : (n,) array
    tooth_N_per_mm : (w,) array
        Circumferential force of each tooth on the pitch circle.
    land_N_per_mm : (w + 1,) array
        Contact force of each land; negative if a fixed land would have to pull.
    land_friction_N_per_mm : (w + 1,) array
        Circumferential friction force on the belt, on the pitch circle.
    land_lift_mm : (w + 1,) array
        Largest lift of each land.
    tight_N_per_mm : float
        Reaction at the tight end.
    degrees_of_freedom : int
        Number of degrees of freedom of the finite elements.
    """

    first_tooth: int
    first_land: int
    flanks: Flanks
    rotation_rad: float
    compliance_rad_per_N: float
    pair_N_per_mm: Floats
    pair_gap_mm: Floats
    tooth_N_per_mm: Floats
    land_N_per_mm: Floats
    land_friction_N_per_mm: Floats
    land_lift_mm: Floats
    tight_N_per_mm: float
    degrees_of_freedom: int
    contact: ContactState


@dataclass(frozen=True)
class SpringRow:
    """Cord and teeth as springs, from the finite-element response; w teeth, per mm of width.

    Attributes
    ----------
    slack_mm2_per_N : (w,) array
        L, displacement of each tooth under the slack tension.
    tooth_N_per_mm2 : float
        k_t, stiffness of a tooth.
    cord_N_per_mm : float
        EA_eff, tension divided by strain from tooth to tooth: the cord in series with the
        compliance of the land below it, which shortens its path.
    coupling_mm2_per_N : (w - 1,) array
        Displacement of the teeth 1, 2, … pitches from a loaded one because of an elastic pulley;
        empty for a rigid pulley.
    """

    slack_mm2_per_N: Floats
    tooth_N_per_mm2: float
    cord_N_per_mm: float
    coupling_mm2_per_N: Floats = field(default_factory=lambda: np.zeros(0))


def spring_row(strip: Strip, response: StripResponse) -> SpringRow:
    """Row of springs equivalent to the finite elements.

    Every flank moves as a whole (along its levers), with all its pairs in contact:
    A = (Gᵀ K^-1 G)^-1 with the levers divided by the pitch radius in G; L = A Gᵀ K^-1 by_slack.
    These give 1/k_t = A_kk - L_k and p/EA_eff = L_k+1 - L_k, as medians over the teeth; and for an
    elastic pulley A_kl - L_k as medians over all pairs of teeth at the same distance.
    """
    flanks = response.flanks
    along = np.zeros((flanks.tooth.size, response.teeth))
    along[np.arange(flanks.tooth.size), flanks.tooth] = flanks.levers_mm / strip.pitch_radius_mm
    pairs, by_slack = (response.by[kind].displacement for kind in (Kind.PAIR, Kind.SLACK))
    solved = np.linalg.solve(pairs, np.column_stack([along, by_slack]))
    reduced = along.T @ solved
    teeth = np.linalg.inv(reduced[:, :-1])
    slack = teeth @ reduced[:, -1]
    stretch = np.diff(slack) if slack.size > 1 else strip.pitch_mm / strip.cord_N_per_mm
    row = SpringRow(
        slack_mm2_per_N=slack,
        tooth_N_per_mm2=float(1.0 / np.median(teeth.diagonal() - slack)),
        cord_N_per_mm=float(strip.pitch_mm / np.median(stretch)),
    )
    if not response.elastic_pulley:
        return row
    beside = [np.median(teeth.diagonal(d) - slack[:-d]) for d in range(1, slack.size)]
    return replace(row, coupling_mm2_per_N=np.array(beside))


def solve_belt(
    strip: Strip,
    response: StripResponse,
    force_N_per_mm: float,
    slack_N_per_mm: float,
    *,
    land_friction: float = 0.0,
    land_lift: bool = False,
) -> BeltState:
    """State of a belt under a torque divided by the pitch radius, per mm of width.

    The response has the columns of sliding and lifting lands, if requested. The coefficient of
    friction on the lands is positive if friction acts with the teeth, negative if against them.
    Raises ContactError if no state exists.
    """
    problem = contact_problem(strip, response, force_N_per_mm, slack_N_per_mm, land_friction)
    if land_lift:
        problem = _with_lift(problem, response)
    state = solve_contact_general(
        problem.matrix,
        problem.gaps,
        problem.levers,
        problem.torque,
        load_rows=problem.rows,
        # strands that bend at edges of lands press on these; the reverse effect is zero
        positive_definite=True
        if land_friction == 0.0 and not ((land_lift or response.elastic_pulley) and response.phase)
        else None,
    )
    return _state_of(strip, response, problem, state, slack_N_per_mm, land_friction)


def _state_of(
    strip: Strip,
    response: StripResponse,
    problem: Problem,
    state: ContactState,
    slack_N_per_mm: float,
    land_friction: float,
) -> BeltState:
    """Forces on teeth and lands from the solution of the contact problem."""
    n = response.flanks.tooth.size
    force, lift = state.normal_forces[:n], np.zeros(response.land.size)
    pushed = problem.push @ force + problem.push_0
    by = response.by
    tight = by[Kind.PAIR].tight @ force + by[Kind.SLACK].tight[0] * slack_N_per_mm
    if state.normal_forces.size > n:
        lift = state.normal_forces[n:]
        pushed = pushed + by[Kind.RADIAL].reaction @ lift
        tight += by[Kind.RADIAL].tight @ lift
    friction_force = land_friction * pushed
    if land_friction != 0.0:
        tight += by[Kind.SLIDING].tight @ friction_force
    most = np.zeros(response.lands)
    np.maximum.at(most, response.land, lift)
    radius = strip.pitch_radius_mm
    return BeltState(
        first_tooth=response.first_tooth,
        first_land=response.first_land,
        flanks=replace(response.flanks, lines=()),  # results need no nodes
        rotation_rad=state.rotation,
        compliance_rad_per_N=float(state.tangent[0, 0]),
        pair_N_per_mm=force,
        pair_gap_mm=state.final_gap_angles[:n],
        tooth_N_per_mm=_sums(
            response.flanks.tooth, force * response.flanks.levers_mm / radius, response.teeth
        ),
        land_N_per_mm=_sums(response.land, pushed, response.lands),
        land_friction_N_per_mm=_sums(
            response.land, friction_force * strip.land_radius_mm / radius, response.lands
        ),
        land_lift_mm=most,
        tight_N_per_mm=float(tight),
        degrees_of_freedom=response.degrees_of_freedom,
        contact=state,
    )


@dataclass(frozen=True)
class Problem:
    """A contact problem with land forces `push` times the forces plus `push_0`."""

    matrix: Floats
    gaps: Floats
    levers: Floats
    rows: Floats
    torque: float
    push: Floats
    push_0: Floats


def contact_problem(
    strip: Strip, response: StripResponse, force: float, slack: float, friction: float
) -> Problem:
    """The problem with fixed and sliding lands."""
    flanks, radius = response.flanks, strip.pitch_radius_mm
    pairs, by_slack = response.by[Kind.PAIR], response.by[Kind.SLACK]
    pitches = flanks.tooth + response.first_tooth + response.phase
    turn = strip.clearance_rad + pitches * strip.pitch_difference_mm / radius
    held = Problem(
        matrix=pairs.displacement,
        gaps=flanks.gaps_mm + flanks.levers_mm * turn + by_slack.displacement[:, 0] * slack,
        levers=flanks.levers_mm,
        rows=flanks.levers_mm,
        torque=force * radius,
        push=pairs.reaction,
        push_0=by_slack.reaction[:, 0] * slack,
    )
    if friction == 0.0:
        return held
    sliding = response.by[Kind.SLIDING]
    own = np.eye(response.land.size) - friction * sliding.reaction
    push, push_0 = (
        np.asarray(np.linalg.solve(own, part), dtype=np.float64)
        for part in (held.push, held.push_0)
    )
    recedes = friction * sliding.displacement
    helps = friction * strip.land_radius_mm
    return Problem(
        matrix=held.matrix + recedes @ push,
        gaps=held.gaps + recedes @ push_0,
        levers=held.levers,
        rows=held.rows + helps * push.sum(axis=0),
        torque=held.torque - helps * push_0.sum(),
        push=push,
        push_0=push_0,
    )


def _with_lift(held: Problem, response: StripResponse) -> Problem:
    """The same problem with lifts of lands as further unknowns, whose gaps are the land forces."""
    lifts = response.by[Kind.RADIAL]
    none = np.zeros(response.land.size)
    return replace(
        held,
        matrix=np.block([[held.matrix, lifts.displacement], [held.push, lifts.reaction]]),
        gaps=np.concatenate([held.gaps, held.push_0]),
        levers=np.append(held.levers, none),
        rows=np.append(held.rows, none),
    )


def _sums(number: Numbers, values: Floats, count: int) -> Floats:
    """Sums of values by index."""
    return np.bincount(number, values, count).astype(np.float64)


def state_under(
    scene: Scene, strip: Strip, response: StripResponse, torque_Nmm: float, account: Account
) -> BeltState:
    """State of a belt under a torque; its work is counted.

    Raises NoContactState if none exists: friction on the lands turns the pulley further than the
    torque, or the belt jumps.
    """
    slack = slack_of(scene)
    where = f"{in_newton_metres(torque_Nmm):g} N m, slack strand {slack:g} N"
    try:
        state = _solved(scene, strip, response, torque_Nmm, slack)
    except ContactError as error:
        friction, width = scene.effects.land_friction, strip.width_mm
        # without load the torque is that of the lands under the slack tension
        unloaded = contact_problem(strip, response, 0.0, slack / width, friction)
        alone = -width * unloaded.torque
        if alone > torque_Nmm:
            raise NoContactState(
                f"{where}: with effects.land_friction = {friction:g}, sliding lands alone "
                f"carry {in_newton_metres(alone):.4g} N m, more than the torque: they stick"
            ) from error
        raise NoContactState(f"{where}: {error}") from error
    account.count(
        states=1,
        contact_passes=1,
        influence_columns=state.pair_N_per_mm.size,
        pivots=state.contact.info.pivots,
    )
    if _jumps(strip, state):
        most = np.arange(response.lands) == state.land_lift_mm.argmax()
        land = lands_in_words(response.first_tooth + np.arange(response.teeth), most)
        raise NoContactState(
            f"{where}: the land {land} lifts {state.land_lift_mm.max():.3g} mm, more than the "
            "height of the teeth; this belt jumps below a slack tension of about "
            f"{_jump_tension(scene, strip, response, torque_Nmm, slack):.3g} N"
        )
    return state


def lands_in_words(sites: Numbers, some: Flags) -> str:
    """Names of selected lands by the teeth (S,): one before each, and one behind the last.

    `some` (S + 1,) selects lands, from the tight strand.
    """
    before = ", ".join(str(site) for site in sites[some[:-1]])
    words = [f"before tooth {before}"] if before else []
    return " and ".join(words + [f"behind tooth {sites[-1]}"] * bool(some[-1]))


def _solved(
    scene: Scene, strip: Strip, response: StripResponse, torque_Nmm: float, slack_N: float
) -> BeltState:
    return solve_belt(
        strip,
        response,
        torque_Nmm / (strip.pitch_radius_mm * strip.width_mm),
        slack_N / strip.width_mm,
        land_friction=scene.effects.land_friction,
        land_lift=scene.effects.land_lift,
    )


def _jumps(strip: Strip, state: BeltState) -> bool:
    """Whether the lift of a land exceeds the height of a tooth."""
    return strip.tooth is not None and state.land_lift_mm.max() > strip.tooth.height_mm


def _jump_tension(
    scene: Scene, strip: Strip, response: StripResponse, torque_Nmm: float, slack_N: float
) -> float:
    """Slack tension (N) below which the belt jumps; it jumps at the given one."""
    low, high = slack_N, 2.0 * slack_N
    for _ in range(STEPS):
        if not _jumps(strip, _solved(scene, strip, response, torque_Nmm, high)):
            break
        low, high = high, 2.0 * high
    for _ in range(STEPS):
        middle = 0.5 * (low + high)
        if _jumps(strip, _solved(scene, strip, response, torque_Nmm, middle)):
            low = middle
        else:
            high = middle
    return high
