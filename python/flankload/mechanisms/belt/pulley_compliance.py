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
from scipy.linalg import lu_factor, lu_solve

from flankload.elasticity.finite_elements import stiffness
from flankload.elasticity.job_log import JobLog
from flankload.elasticity.sector_closure import close_ring, condense
from flankload.mechanisms.belt.row import Columns, made_symmetric
from flankload.mechanisms.belt.strip import Kind
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
    response : (z, r, r) array
        [t]: response of `unit_forces` on sector t to those on sector 0, each in its own frame,
        mm²/N.
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
    condensed, unknowns = condense(matrix, loads, sector, log=JobLog(account))
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
    touches, count = touches_of(strip, response, known.mesh, known.response.shape[1])
    whole = pulley_compliance(known, touches, count)
    n, lift = response.flanks.tooth.size, response.by[Kind.RADIAL]
    lands = slice(n, n + response.land.size)
    held = lu_factor(np.eye(response.land.size) + lift.reaction @ whole[lands, lands])
    sunk = {Kind.PAIR: whole[:, :n], Kind.SLIDING: whole[:, lands.stop :]}
    by = {}
    for kind, own in response.by.items():
        # displacements of the pulley, and contact forces of the lands
        moved = sunk.get(kind, np.zeros((count, own.tight.size)))
        push = lu_solve(held, own.reaction - lift.reaction @ moved[lands])
        moved = moved + whole[:, lands] @ push
        by[kind] = Columns(
            own.displacement + moved[:n] - lift.displacement @ moved[lands],
            push,
            own.tight - lift.tight @ moved[lands],
        )
    return replace(
        response,
        by=by if response.phase else made_symmetric(by),  # strands bend at edges of lands
        degrees_of_freedom=response.degrees_of_freedom + known.degrees_of_freedom,
        elastic_pulley=True,
    )
