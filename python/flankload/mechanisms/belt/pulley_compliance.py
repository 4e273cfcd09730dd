"""A timing belt on a pulley that yields: what the pulley does, and the strip that rests on it.

One sector of the pulley is solved under unit forces at the nodes that a belt can touch, and the
ring of all sectors closed by Fourier. Any hats on flanks and lands follow from these, wherever the
belt lies on the pulley.

On flanks the hats of the belt carry forces and read displacements on both bodies. On lands N are
the forces that go with the ways of the hats: on both bodies they stand for a pressure M^-1 N in
hats, M = ∫ hat hat ds, and the way is M^-1 ∫ hat u ds, the linear function whose moments are those
of the displacements. So a pulley that moves as hats do, moves the belt by just that.

The lands of the belt follow the pulley, w = v - C_ll N - C_lf F - C_lt t, with v ≥ 0 where they may
lift. Put into N = P F + p T2 + P_t t + S w this leaves N, and with it all that a strip answers,
linear in F, T2, t and v as before: the contact problem is the same with other numbers.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from flankload.elasticity.finite_elements import stiffness
from flankload.elasticity.sector_closure import close_ring, condense
from flankload.mechanisms.belt.row import LandColumns
from flankload.mechanisms.belt.touch import Touch, touches_of, unit_forces

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from flankload.cost import Account
    from flankload.mechanisms.belt.belt import Strip
    from flankload.mechanisms.belt.pulley_mesh import PulleyMesh
    from flankload.mechanisms.belt.row import StripResponse

    Floats = NDArray[np.float64]


@dataclass(frozen=True)
class PulleyResponse:
    """A pulley by `unit_forces` on its sectors, per mm of width.

    Attributes
    ----------
    mesh : PulleyMesh
    response : (z, r, r) array
        [t]: what `unit_forces` see on sector t of those on sector 0, each in its own frame, mm²/N.
    degrees_of_freedom : int
    """

    mesh: PulleyMesh
    response: Floats
    degrees_of_freedom: int


def solve_pulley(
    mesh: PulleyMesh,
    *,
    rubbing: bool = False,
    account: Account | None = None,
) -> PulleyResponse:
    """Solve the elements of one sector and close the ring.

    Parameters
    ----------
    mesh : PulleyMesh
    rubbing : bool
        Also under forces along the lands.
    account : Account, optional

    Returns
    -------
    PulleyResponse
    """
    pulley, sector = mesh.pulley, mesh.sector
    loads = unit_forces(mesh, rubbing=rubbing)
    if account is not None:
        along = mesh.land.size * rubbing
        account.count(
            unit_loads_normal=loads.shape[1] - along,
            unit_loads_tangential=along,
        )
    matrix = stiffness(sector.nodes, sector.cells, pulley.material, pulley.plane)
    condensed, unknowns = condense(matrix, loads, sector, account=account)
    return PulleyResponse(mesh, close_ring(condensed, pulley.teeth), unknowns)


def pulley_compliance(known: PulleyResponse, touches: list[Touch], count: int) -> Floats:
    """What hats on a pulley see of each other.

    Parameters
    ----------
    known : PulleyResponse
    touches : list of Touch
    count : int
        Of all hats.

    Returns
    -------
    (count, count) array
        Symmetric, mm²/N.
    """
    found = np.zeros((count, count))
    for loaded in touches:
        moved = known.response @ loaded.forces
        for read in touches:
            apart = (read.sector - loaded.sector) % known.mesh.pulley.teeth
            found[np.ix_(read.numbers, loaded.numbers)] = read.forces.T @ moved[apart]
    return 0.5 * (found + found.T)


def rest_on(response: StripResponse, strip: Strip, known: PulleyResponse) -> StripResponse:
    """What a strip answers whose pulley yields.

    Parameters
    ----------
    response : StripResponse
        On a rigid pulley, with what lands do that give way, and that rub where that is asked for.
    strip : Strip
    known : PulleyResponse

    Returns
    -------
    StripResponse
        Ways of the lands are now those off the pulley.
    """
    lifting, rubbing = response.lifting, response.rubbing
    assert lifting is not None
    touches, count = touches_of(strip, response, known.mesh, known.response.shape[1])
    whole = pulley_compliance(known, touches, count)
    n, h = response.flanks.tooth.size, response.land.size
    by_flank, by_land = whole[:, :n], whole[:, n : n + h]
    # under forces on flanks, of the slack strand, under ways of lands off the pulley, along lands:
    # `given` is what the pulley lets go, `push` what the lands push with
    held = np.eye(h) + lifting.reaction @ by_land[n : n + h]
    loads = [response.reaction, response.reaction_by_slack[:, None], lifting.reaction]
    own = [response.compliance, response.by_slack[:, None], lifting.recession]
    tight = [response.tight, np.array([response.tight_by_slack]), lifting.tight]
    sunk = [by_flank, np.zeros((count, 1)), np.zeros((count, h))]
    if rubbing is not None:
        loads.append(rubbing.reaction)
        own.append(rubbing.recession)
        tight.append(rubbing.tight)
        sunk.append(whole[:, n + h :])
    given = np.hstack(sunk)
    pushed = np.hstack(loads) - lifting.reaction @ given[n : n + h]
    push = np.asarray(np.linalg.solve(held, pushed), dtype=np.float64)
    given = given + by_land @ push
    seen = np.asarray(np.hstack(own) + given[:n] - lifting.recession @ given[n : n + h])
    strand = np.asarray(np.concatenate(tight) - lifting.tight @ given[n : n + h])
    parts = [slice(0, n), slice(n, n + 1), slice(n + 1, n + 1 + h), slice(n + 1 + h, None)]
    pairs, slack, lifts, rubs = (LandColumns(seen[:, p], push[:, p], strand[p]) for p in parts)
    compliance, reaction = pairs.recession, lifts.reaction
    if not response.phase:  # else strands bend at edges of lands
        compliance, reaction = 0.5 * (compliance + compliance.T), 0.5 * (reaction + reaction.T)
    return replace(
        response,
        compliance=compliance,
        by_slack=slack.recession[:, 0],
        reaction=pairs.reaction,
        reaction_by_slack=slack.reaction[:, 0],
        tight=pairs.tight,
        tight_by_slack=float(slack.tight[0]),
        lifting=replace(lifts, reaction=reaction),
        rubbing=rubs if rubbing is not None else None,
        degrees_of_freedom=response.degrees_of_freedom + known.degrees_of_freedom,
        pulley_yields=True,
    )
