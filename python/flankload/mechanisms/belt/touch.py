"""Contact of a timing belt with its pulley: shape functions as forces at the nodes of one sector.

A shape function of the belt lies anywhere on a flank or a land of the pulley, whose elements have
other boundaries. Its force is distributed over these elements as over those of the belt, and the
same columns average displacements.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import asin
from typing import TYPE_CHECKING

import numpy as np

from flankload.elasticity.finite_elements import degrees_of
from flankload.mechanisms.belt.belt import turn_matrix
from flankload.mechanisms.belt.shape_functions import gauss_points, linear, quadratic
from flankload.mechanisms.belt.strip import Kind

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from flankload.mechanisms.belt.belt import Strip
    from flankload.mechanisms.belt.pulley import ElasticPulley
    from flankload.mechanisms.belt.pulley_mesh import PulleyMesh
    from flankload.mechanisms.belt.row import StripResponse

    Floats = NDArray[np.float64]
    Numbers = NDArray[np.int64]


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
        Unit force of each, as combination of `unit_forces`; its transpose averages displacements.
    """

    sector: int
    numbers: Numbers
    forces: Floats


def unit_forces(mesh: PulleyMesh, *, sliding: bool) -> Floats:
    """Unit forces at the nodes that a belt can touch, in the frame of the sector.

    Parameters
    ----------
    mesh : PulleyMesh
        N nodes.
    sliding : bool
        Whether forces along the lands are included.

    Returns
    -------
    (2N, r) array
        In x and y at the nodes of the flank; at those of the land inwards, and against the
        rotation.
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
    """Shape functions of a belt on its pulley: those of flanks, of lands, and along the lands.

    Parameters
    ----------
    response : StripResponse
        At any position; it determines whether lands slide.
    rows : int
        Number r of unit forces.

    Returns
    -------
    touches : list of Touch
        Ordered as the pairs, then as `response.land`, then as `response.land` again.
    count : int
        Number of shape functions.
    """
    pitch, sliding = strip.pitch_rad, Kind.SLIDING in response.by
    touches, count = [], 0
    for tooth, line in enumerate(response.flanks.lines, response.first_tooth):
        turn = turn_matrix(-pitch * (tooth + response.phase))
        forces = flank_forces(mesh, line @ turn, rows)
        touches.append(Touch(tooth, count + np.arange(forces.shape[1]), forces))
        count += forces.shape[1]
    hats = response.land.size
    for number in range(response.lands):
        own = np.flatnonzero(response.land == number)
        if not own.size:
            continue
        sector = response.first_land + number
        away = response.land_angle_rad[own] - pitch * (sector + response.phase)
        held, along = land_forces(mesh, away * _narrower(strip, mesh.pulley), rows)
        touches.append(Touch(sector, count + own, held))
        if sliding:
            touches.append(Touch(sector, count + hats + own, along))
    return touches, count + hats * (1 + sliding)


def _narrower(strip: Strip, pulley: ElasticPulley) -> float:
    """Ratio of the land widths of pulley and belt, which presses on the whole land."""
    width = strip.tooth.width_mm if strip.tooth is not None else 0.0
    return pulley.half_land_rad / (0.5 * strip.pitch_rad - asin(0.5 * width / strip.land_radius_mm))


def flank_forces(mesh: PulleyMesh, flank: Floats, rows: int) -> Floats:
    """Forces at the nodes of a pulley's flank equivalent to the shape functions of a belt's flank.

    Points at equal fractions of both flank lengths coincide.

    Parameters
    ----------
    flank : (2 c - 1, 2) array
        Nodes of the belt's flank in the frame of the sector, from the land on.
    rows : int
        Number r of unit forces.

    Returns
    -------
    (r, c) array
        Pointing out of the belt, for a unit force distributed as each shape function.
    """
    own = _parts(mesh.sector.nodes[mesh.flank])
    parts = _parts(flank)
    at, weight = gauss_points(_breaks(parts[::2], own[::2]))
    hats = linear(at, parts[::2])
    along = weight[:, None] * (quadratic(at, parts)[1] @ flank)
    out = np.column_stack([-along[:, 1], along[:, 0]])
    lengths = hats.T @ np.linalg.norm(along, axis=1)
    forces = np.einsum("gq,gh,gd->qdh", quadratic(at, own)[0], hats, out) / lengths
    found = np.zeros((rows, lengths.size))
    found[: 2 * own.size] = forces.reshape(2 * own.size, -1)
    return found


def land_forces(mesh: PulleyMesh, ends_rad: Floats, rows: int) -> tuple[Floats, Floats]:
    """Forces at the nodes of a land equivalent to shape functions at given angles.

    Parameters
    ----------
    ends_rad : (c,) array
        End nodes of the shape functions in the frame of the sector, ascending, on its land.
    rows : int
        Number r of unit forces.

    Returns
    -------
    held : (r, c) array
        Inwards: forces conjugate to the displacements of the shape functions.
    along : (r, c) array or (r, 0) array
        Against the rotation: force distributed as each shape function; empty without sliding lands.
    """
    nodes = np.arctan2(*mesh.sector.nodes[mesh.land].T[::-1])
    first, last = 2 * mesh.flank.size, 2 * mesh.flank.size + nodes.size
    ends = np.clip(ends_rad, nodes[0], nodes[-1])
    at, weight = gauss_points(_breaks(ends, nodes[::2]))
    weight = weight * mesh.pulley.land_radius_mm
    hats = linear(at, ends)
    spread = quadratic(at, nodes)[0].T @ (weight[:, None] * hats)
    held = np.zeros((rows, ends.size))
    held[first:last] = np.linalg.solve(hats.T @ (weight[:, None] * hats), spread.T).T
    if rows == last:
        return held, held[:, :0]
    along = np.zeros_like(held)
    along[last:] = spread / (weight @ hats)
    return held, along


def _parts(places: Floats) -> Floats:
    """Fractions of the length of a line of nodes."""
    way = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(places, axis=0).T))])
    return np.asarray(way / way[-1])


def _breaks(ends: Floats, nodes: Floats) -> Floats:
    """Kinks of shape functions and ends of elements, from the first to the last of `ends`."""
    breaks = np.union1d(ends, nodes)
    return breaks[(breaks >= ends[0]) & (breaks <= ends[-1])]
