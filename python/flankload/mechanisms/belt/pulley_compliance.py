"""Compliance of an elastic pulley, and the response of a timing belt on it.

One sector of the pulley is solved under unit forces at the nodes that a belt can touch, and the
ring of all sectors is closed by a Fourier sum. The response of any shape functions on flanks and
lands follows from these, wherever the belt lies on the pulley.

The elements of belt and pulley do not match: the force of a shape function h of the belt is
distributed over the pulley's elements by h, and the same columns average displacements. On lands,
the forces N are conjugate to the displacements of the shape functions: on both bodies the pressure
is M^-1 N in shape functions, M = ∫ h h ds, and the displacement is M^-1 ∫ h u ds, the linear
function with the same moments as the displacements u. A linear motion of the pulley's surface
therefore moves the belt exactly.

The lands of the belt follow the pulley, w = v - C_ll N - C_lf F - C_lt t, with v ≥ 0 where they can
lift. Substituted into N = P F + p T2 + P_t t + S w, this gives N, and with it every response of a
strip, as a linear function of F, T2, t and v as before: the contact problem has the same form with
other coefficients.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import asin
from typing import TYPE_CHECKING

import numpy as np

from flankload.base.rotation import turned
from flankload.elasticity.finite_elements import degrees_of, stiffness
from flankload.elasticity.job_log import JobLog
from flankload.elasticity.nodal_loads import linear_shapes
from flankload.elasticity.sector_closure import close_ring, condense_sector, unknowns_of
from flankload.mechanisms.belt.columns import gauss_points, quadratic
from flankload.mechanisms.belt.pulley_mesh import PulleyMesh, fractions
from flankload.mechanisms.belt.row import Columns, made_symmetric
from flankload.mechanisms.belt.strip import Kind

if TYPE_CHECKING:
    from flankload.base.arrays import Floats, Numbers
    from flankload.cost import Account
    from flankload.mechanisms.belt.belt import ElasticPulley, Strip
    from flankload.mechanisms.belt.row import StripResponse


@dataclass(frozen=True)
class Touch:
    """Shape functions on one sector of a pulley.

    Attributes
    ----------
    sector : int
        Index in the direction of rotation.
    numbers : (c,) array
        Index of each shape function among all.
    forces : (r, c) array
        Unit force of each as a combination of `unit_forces`; the transpose averages displacements.
    """

    sector: int
    numbers: Numbers
    forces: Floats


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
    mesh: PulleyMesh, *, sliding: bool = False, account: Account | None = None
) -> PulleyResponse:
    """Solve the finite elements of one sector and close the ring.

    Parameters
    ----------
    sliding : bool
        Whether forces along the lands are included.
    """
    pulley, sector = mesh.pulley, mesh.sector
    loads = unit_forces(mesh, sliding=sliding)
    log, along, unknowns = JobLog(account), mesh.land.size * sliding, unknowns_of(sector)
    log.account.count(
        unit_loads_normal=loads.shape[1] - along,
        unit_loads_tangential=along,
        fe_solutions=loads.shape[1],
        fe_unknowns=unknowns,
    )
    matrix = stiffness(sector.nodes, sector.cells, pulley.material, pulley.plane)
    by_node = loads.reshape(matrix.nodes, matrix.unknowns, -1)
    condensed = condense_sector(matrix, sector, by_node, (), log)
    return PulleyResponse(mesh, close_ring(condensed, pulley.teeth), unknowns)


def pulley_compliance(known: PulleyResponse, touches: list[Touch], count: int) -> Floats:
    """Compliance of the pulley between shape functions, symmetric, (count, count), mm²/N."""
    found = np.zeros((count, count))
    for loaded in touches:
        moved = known.response @ loaded.forces
        for read in touches:
            apart = (read.sector - loaded.sector) % known.mesh.pulley.teeth
            found[np.ix_(read.numbers, loaded.numbers)] = read.forces.T @ moved[apart]
    return 0.5 * (found + found.T)


def on_elastic_pulley(
    response: StripResponse, strip: Strip, known: PulleyResponse
) -> StripResponse:
    """Response of a strip on an elastic pulley, with land displacements relative to the pulley.

    The response on a rigid pulley has the columns of lifting lands, and of sliding lands if
    requested.
    """
    touches, count = touches_of(strip, response, known.mesh, known.response.shape[1])
    whole = pulley_compliance(known, touches, count)
    n, lift = response.flanks.tooth.size, response.by[Kind.RADIAL]
    lands = slice(n, n + response.land.size)
    held = np.eye(response.land.size) + lift.reaction @ whole[lands, lands]
    sunk = {Kind.PAIR: whole[:, :n], Kind.SLIDING: whole[:, lands.stop :]}
    by = {}
    for kind, own in response.by.items():
        # displacements of the pulley, and contact forces of the lands
        moved = sunk.get(kind, np.zeros((count, own.tight.size)))
        push = np.asarray(np.linalg.solve(held, own.reaction - lift.reaction @ moved[lands]))
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


def unit_forces(mesh: PulleyMesh, *, sliding: bool) -> Floats:
    """Unit forces (2N, r) at the nodes that a belt can touch, in the frame of the sector.

    In x and y at the nodes of the flank; at those of the land inwards, and against the rotation if
    lands slide.
    """
    flank, land = degrees_of(mesh.flank), 2 * mesh.land
    inwards = -mesh.sector.nodes[mesh.land]
    inwards /= np.linalg.norm(inwards, axis=1)[:, None]
    against = np.column_stack([-inwards[:, 1], inwards[:, 0]])
    directions = [inwards, against] if sliding else [inwards]
    loads = np.zeros((2 * len(mesh.sector.nodes), flank.size + land.size * len(directions)))
    loads[flank, np.arange(flank.size)] = 1.0
    for k, way in enumerate(directions):
        columns = flank.size + land.size * k + np.arange(land.size)
        loads[land, columns], loads[land + 1, columns] = way.T
    return loads


def touches_of(
    strip: Strip, response: StripResponse, mesh: PulleyMesh, rows: int
) -> tuple[list[Touch], int]:
    """Shape functions of a belt on its pulley as combinations of r unit forces, and their number.

    The functions belong to flanks, to lands and, if these slide, to loads along the lands; they are
    ordered as the pairs, then as `response.land`, then as `response.land` again.
    """
    pitch, sliding = strip.pitch_rad, Kind.SLIDING in response.by
    touches, count = [], 0
    for tooth, line in enumerate(response.flanks.lines, response.first_tooth):
        forces = flank_forces(mesh, turned(line, -pitch * (tooth + response.phase)), rows)
        touches.append(Touch(tooth, count + np.arange(forces.shape[1]), forces))
        count += forces.shape[1]
    functions = response.land.size
    for number in range(response.lands):
        own = np.flatnonzero(response.land == number)
        if not own.size:
            continue
        sector = response.first_land + number
        away = response.land_angle_rad[own] - pitch * (sector + response.phase)
        held, along = land_forces(mesh, away * _narrower(strip, mesh.pulley), rows)
        touches.append(Touch(sector, count + own, held))
        if sliding:
            touches.append(Touch(sector, count + functions + own, along))
    return touches, count + functions * (1 + sliding)


def _narrower(strip: Strip, pulley: ElasticPulley) -> float:
    """Ratio of the land widths of pulley and belt; the belt presses on the whole land."""
    width = strip.tooth.width_mm if strip.tooth is not None else 0.0
    return pulley.half_land_rad / (0.5 * strip.pitch_rad - asin(0.5 * width / strip.land_radius_mm))


def flank_forces(mesh: PulleyMesh, flank: Floats, rows: int) -> Floats:
    """Forces at the nodes of a pulley's flank equivalent to the shape functions of a belt's flank.

    Points at equal fractions of both flank lengths coincide. The nodes (2 c - 1, 2) of the belt's
    flank are in the frame of the sector, from the land on. The forces (r, c), as combinations of r
    unit forces, point out of the belt; each is a unit force distributed as a shape function.
    """
    own = fractions(mesh.sector.nodes[mesh.flank])
    parts = fractions(flank)
    at, weight = gauss_points(_breaks(parts[::2], own[::2]))
    linear = linear_shapes(at, parts[::2])
    along = weight[:, None] * (quadratic(at, parts)[1] @ flank)
    out = np.column_stack([-along[:, 1], along[:, 0]])
    lengths = linear.T @ np.linalg.norm(along, axis=1)
    forces = np.einsum("gq,gh,gd->qdh", quadratic(at, own)[0], linear, out) / lengths
    found = np.zeros((rows, lengths.size))
    found[: 2 * own.size] = forces.reshape(2 * own.size, -1)
    return found


def land_forces(mesh: PulleyMesh, ends_rad: Floats, rows: int) -> tuple[Floats, Floats]:
    """Forces at the nodes of a land equivalent to shape functions at ascending angles (c,).

    `held` (r, c) act inwards, conjugate to the displacements of the shape functions; `along` (r, c)
    are forces against the rotation distributed as each shape function, (r, 0) without sliding
    lands.
    """
    nodes = np.arctan2(*mesh.sector.nodes[mesh.land].T[::-1])
    first, last = 2 * mesh.flank.size, 2 * mesh.flank.size + nodes.size
    ends = np.clip(ends_rad, nodes[0], nodes[-1])
    at, weight = gauss_points(_breaks(ends, nodes[::2]))
    weight = weight * mesh.pulley.land_radius_mm
    linear = linear_shapes(at, ends)
    spread = quadratic(at, nodes)[0].T @ (weight[:, None] * linear)
    held = np.zeros((rows, ends.size))
    held[first:last] = np.linalg.solve(linear.T @ (weight[:, None] * linear), spread.T).T
    if rows == last:
        return held, held[:, :0]
    along = np.zeros_like(held)
    along[last:] = spread / (weight @ linear)
    return held, along


def _breaks(ends: Floats, nodes: Floats) -> Floats:
    """Kinks of shape functions and ends of elements, from the first to the last of `ends`."""
    breaks = np.union1d(ends, nodes)
    return breaks[(breaks >= ends[0]) & (breaks <= ends[-1])]
