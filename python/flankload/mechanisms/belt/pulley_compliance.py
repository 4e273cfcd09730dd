"""Compliance of an elastic pulley, and the response of a timing belt on it.

One sector of the pulley is solved under unit forces at the nodes that a belt can touch, and the
ring of all sectors is closed by a Fourier sum. The response of any shape functions on flanks and
lands follows from these, wherever the belt lies on the pulley.

On flanks the shape functions of the belt carry forces and average displacements on both bodies. On
lands N are the forces conjugate to the displacements of the shape functions: on both bodies they
represent the pressure M^-1 N in shape functions, M = ∫ hat hat ds, and the displacement is
M^-1 ∫ hat u ds, the linear function with the same moments as the displacements u. A pulley whose
surface moves as a linear function therefore moves the belt by exactly that function.

The lands of the belt follow the pulley, w = v - C_ll N - C_lf F - C_lt t, with v ≥ 0 where they can
lift. Substituted into N = P F + p T2 + P_t t + S w, this gives N, and with it every response of a
strip, as a linear function of F, T2, t and v as before: the contact problem has the same form with
other coefficients.
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
    """Response of a pulley to `unit_forces` on its sectors, per mm of width.

    Attributes
    ----------
    mesh : PulleyMesh
    response : (z, r, r) array
        [t]: response of `unit_forces` on sector t to those on sector 0, each in its own frame,
        mm²/N.
    degrees_of_freedom : int
    """

    mesh: PulleyMesh
    response: Floats
    degrees_of_freedom: int


def solve_pulley(
    mesh: PulleyMesh,
    *,
    sliding: bool = False,
    account: Account | None = None,
) -> PulleyResponse:
    """Solve the finite elements of one sector and close the ring.

    Parameters
    ----------
    sliding : bool
        Whether forces along the lands are included.
    """
    pulley, sector = mesh.pulley, mesh.sector
    loads = unit_forces(mesh, sliding=sliding)
    if account is not None:
        along = mesh.land.size * sliding
        account.count(
            unit_loads_normal=loads.shape[1] - along,
            unit_loads_tangential=along,
        )
    matrix = stiffness(sector.nodes, sector.cells, pulley.material, pulley.plane)
    condensed, unknowns = condense(matrix, loads, sector, account=account)
    return PulleyResponse(mesh, close_ring(condensed, pulley.teeth), unknowns)


def pulley_compliance(known: PulleyResponse, touches: list[Touch], count: int) -> Floats:
    """Compliance of the pulley between shape functions.

    Parameters
    ----------
    count : int
        Number of shape functions.

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
    """Response of a strip on an elastic pulley.

    Parameters
    ----------
    response : StripResponse
        On a rigid pulley, with the columns of lifting lands, and of sliding lands if requested.

    Returns
    -------
    StripResponse
        Its land displacements are relative to the pulley.
    """
    lifting, sliding = response.lifting, response.sliding
    assert lifting is not None
    touches, count = touches_of(strip, response, known.mesh, known.response.shape[1])
    whole = pulley_compliance(known, touches, count)
    n, h = response.flanks.tooth.size, response.land.size
    by_flank, by_land = whole[:, :n], whole[:, n : n + h]
    # for forces on flanks, the slack strand, lifts of lands from the pulley, and friction on lands:
    # `given` is the displacement of the pulley, `push` the contact forces of the lands
    held = np.eye(h) + lifting.reaction @ by_land[n : n + h]
    loads = [response.reaction, response.reaction_by_slack[:, None], lifting.reaction]
    own = [response.compliance, response.by_slack[:, None], lifting.displacement]
    tight = [response.tight, np.array([response.tight_by_slack]), lifting.tight]
    sunk = [by_flank, np.zeros((count, 1)), np.zeros((count, h))]
    if sliding is not None:
        loads.append(sliding.reaction)
        own.append(sliding.displacement)
        tight.append(sliding.tight)
        sunk.append(whole[:, n + h :])
    given = np.hstack(sunk)
    pushed = np.hstack(loads) - lifting.reaction @ given[n : n + h]
    push = np.asarray(np.linalg.solve(held, pushed), dtype=np.float64)
    given = given + by_land @ push
    seen = np.asarray(np.hstack(own) + given[:n] - lifting.displacement @ given[n : n + h])
    strand = np.asarray(np.concatenate(tight) - lifting.tight @ given[n : n + h])
    parts = [slice(0, n), slice(n, n + 1), slice(n + 1, n + 1 + h), slice(n + 1 + h, None)]
    pairs, slack, lifts, sliding_lands = (
        LandColumns(seen[:, p], push[:, p], strand[p]) for p in parts
    )
    compliance, reaction = pairs.displacement, lifts.reaction
    if not response.phase:  # otherwise strands bend at edges of lands
        compliance, reaction = 0.5 * (compliance + compliance.T), 0.5 * (reaction + reaction.T)
    return replace(
        response,
        compliance=compliance,
        by_slack=slack.displacement[:, 0],
        reaction=pairs.reaction,
        reaction_by_slack=slack.reaction[:, 0],
        tight=pairs.tight,
        tight_by_slack=float(slack.tight[0]),
        lifting=replace(lifts, reaction=reaction),
        sliding=sliding_lands if sliding is not None else None,
        degrees_of_freedom=response.degrees_of_freedom + known.degrees_of_freedom,
        elastic_pulley=True,
    )
