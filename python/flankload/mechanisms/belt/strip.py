"""Response of pieces of a timing belt to forces on teeth, lands and strands.

Lands are fixed radially by shape functions, the cord is a line of bars in the mesh; the tight
strand fixes the cord where it begins, the slack strand pulls it. No force acts on the belt beyond
these points, which supports the last land. All columns are those of unit forces per mm of width,
distributed by linear shape functions; displacements are averaged with the same functions.

A piece is condensed to its columns and to its faces in the middles of teeth, which it shares with
adjacent pieces. For prescribed displacements, at lands (by shape functions) and at the tight
strand, a column contains the nodal forces caused by a unit displacement; as an output it gives the
negative reaction. The whole response of a piece is therefore one symmetric matrix.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from flankload.elasticity.finite_elements import SectionStiffness, stiffness
from flankload.elasticity.fronts.condensation import condense_in_order
from flankload.elasticity.fronts.dissection import dissect
from flankload.elasticity.sector_row import RowCell
from flankload.mechanisms.belt.columns import Flanks, Lands, flank_columns, land_columns

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flankload.base.arrays import Floats, Numbers
    from flankload.cost import Account
    from flankload.mechanisms.belt.belt import Strip
    from flankload.mechanisms.belt.belt_mesh import BeltMesh


class Kind(IntEnum):
    """Kind of a column."""

    PAIR = 0
    SLACK = 1
    SLIDING = 2
    RADIAL = 3
    TIGHT = 4


@dataclass(frozen=True)
class Piece:
    """A piece of belt condensed to its columns, per mm of width.

    Attributes
    ----------
    cell : RowCell
        Response of all columns to those that are loads, and the coupling to the cuts.
    kinds : (r,) array
        `Kind` of each column; loads come first.
    flanks : Flanks
        n pairs, in the order of their columns.
    land : (h,) array
        Land of each shape function.
    land_angle_rad : (h,) array
        Angle of the end node of each shape function.
    """

    cell: RowCell
    kinds: Numbers
    flanks: Flanks
    land: Numbers
    land_angle_rad: Floats
    degrees_of_freedom: int


def solve_piece(
    strip: Strip,
    mesh: BeltMesh,
    cuts: tuple[bool, bool] = (False, False),
    *,
    sliding: bool = False,
    lifting: bool = False,
    account: Account | None = None,
) -> Piece:
    """Solve the finite elements of a piece of belt once.

    `cuts` are whether another piece adjoins at its left and its right face; `sliding` and `lifting`
    whether the columns of such lands are included.
    """
    flanks, pairs = flank_columns(strip, mesh)
    lands = land_columns(mesh)
    matrix = _matrix(strip, mesh, lands)
    held, pulled = 2 * mesh.tight + 1, 2 * mesh.slack + 1
    pull = np.zeros((len(matrix), pulled.size))
    pull[pulled, np.arange(pulled.size)] = 1.0
    by_node = pairs.reshape(len(mesh.nodes), 2, -1)
    own = (_frames(mesh.turns_rad).transpose(0, 2, 1) @ by_node).reshape(pairs.shape)
    lands.transform(own)
    prescribed = np.concatenate([lands.degrees, held])
    forces = np.hstack([own, pull, *([lands.forces] if sliding else [])])
    columns, direct = _columns(matrix, forces, prescribed)
    sizes = (pairs.shape[1], pulled.size, sliding * lands.number.size, lands.number.size, held.size)
    kinds = np.repeat(list(Kind), sizes)
    loads = np.flatnonzero(kinds < (Kind.TIGHT if lifting else Kind.RADIAL))
    left, right = mesh.left[: None if cuts[0] else 0], mesh.right[: None if cuts[1] else 0]
    cut = np.concatenate([left, right])
    inner = np.ones(len(mesh.nodes), dtype=bool)
    inner[cut] = False
    cells = _coupled(mesh)
    order = dissect(mesh.nodes, cells, inner=inner, kept=cut, unknowns=2)
    found = condense_in_order(
        _free_stiffness(matrix, prescribed, cells),
        order,
        columns.reshape(len(mesh.nodes), 2, -1),
        account=account,
    )
    unknowns = len(matrix) - 2 * cut.size - prescribed.size
    if account is not None:
        normal = int((kinds[loads] != Kind.SLIDING).sum())
        account.count(unit_loads_normal=normal, unit_loads_tangential=loads.size - normal)
        account.count(fe_unknowns=unknowns, fe_solutions=columns.shape[1])
        account.workspace_bytes += matrix.nbytes + columns.nbytes
    local = found.local[0][:, loads] + direct[:, loads]
    return Piece(
        cell=_cell(local, found.carried[0], found.stiffness, 2 * left.size),
        kinds=kinds,
        flanks=flanks,
        land=lands.number,
        land_angle_rad=lands.angle_rad,
        degrees_of_freedom=unknowns,
    )


def _columns(matrix: Floats, forces: Floats, prescribed: Numbers) -> tuple[Floats, Floats]:
    """Nodal forces of all columns on the other degrees of freedom, and their direct response.

    The columns of `forces` come first, then unit displacements of the `prescribed` degrees of
    freedom, whose output is the negative reaction.
    """
    held = matrix[:, prescribed]
    columns, loads = np.hstack([forces, -held]), forces.shape[1]
    columns[prescribed] = 0.0
    direct = np.zeros((columns.shape[1],) * 2)
    direct[loads:, :loads] = forces[prescribed]
    direct[:loads, loads:] = forces[prescribed].T
    direct[loads:, loads:] = -held[prescribed]
    return columns, direct


def _free_stiffness(
    matrix: Floats, prescribed: Numbers, cells: Sequence[Numbers]
) -> SectionStiffness:
    """Blocks of a stiffness (2N, 2N) without the coupling to prescribed degrees of freedom."""
    nodes = len(matrix) // 2
    pairs = [
        np.repeat(part, part.shape[1], axis=1) * nodes + np.tile(part, part.shape[1])
        for part in cells
    ]
    rows, columns = np.divmod(np.unique(np.concatenate([part.ravel() for part in pairs])), nodes)
    free = np.ones((nodes, 2))
    free.ravel()[prescribed] = 0.0
    blocks = matrix.reshape(nodes, 2, nodes, 2)[rows, :, columns]
    blocks *= free[rows][:, :, None] * free[columns][:, None, :]
    own = np.flatnonzero(rows == columns)
    for k in range(2):
        held = own[free[rows[own], k] == 0.0]
        blocks[held, k, k] = matrix.diagonal()[2 * rows[held] + k]
    return SectionStiffness(rows, columns, blocks[:, None], nodes, np.zeros_like(rows))


def _coupled(mesh: BeltMesh) -> list[Numbers]:
    """Elements, and for each edge on lands those around its ends, whose nodes it couples."""
    found = [cells for _, cells in mesh.cells]
    for line in mesh.lands.values():
        for edge in pairwise(line[::2].tolist()):
            beside = [cells[np.isin(cells, edge).any(axis=1)].ravel() for _, cells in mesh.cells]
            found.append(np.unique(np.concatenate(beside))[None])
    return found


def _cell(local: Floats, carried: Floats, complement: Floats, left: int) -> RowCell:
    """Cell whose first `left` degrees of freedom of the cuts are those of the left face."""
    return RowCell(
        local=(local,),
        carried=((carried[:left], carried[left:]),),
        stiffness=(
            complement[:left, :left],
            complement[:left, left:],
            complement[left:, :left],
            complement[left:, left:],
        ),
    )


def _matrix(strip: Strip, mesh: BeltMesh, lands: Lands) -> Floats:
    """Stiffness (2N, 2N) of elements and cord, per mm of width, outwards and along the turn.

    In terms of the displacements of the shape functions on lands.
    """
    solid = stiffness(mesh.nodes, mesh.cells, strip.material, "strain")
    bars, cord = cord_stiffness(strip, mesh)
    frames = _frames(mesh.turns_rad)

    def turned(rows: Numbers, columns: Numbers, blocks: Floats) -> Floats:
        return frames[rows].transpose(0, 2, 1) @ blocks @ frames[columns]

    whole = np.zeros((2 * len(mesh.nodes),) * 2)
    by_nodes = whole.reshape(len(mesh.nodes), 2, -1, 2).transpose(0, 2, 1, 3)
    pairs = solid.rows, solid.columns
    by_nodes[pairs] = turned(*pairs, solid.blocks[:, 0])
    pairs = np.repeat(bars, 3, axis=1).ravel(), np.tile(bars, 3).ravel()
    by_pairs = cord.reshape(-1, 3, 2, 3, 2).transpose(0, 1, 3, 2, 4).reshape(-1, 2, 2)
    np.add.at(by_nodes, pairs, turned(*pairs, by_pairs))  # bars share nodes
    for side in (whole, whole.T):
        lands.transform(side)
    return whole


def cord_stiffness(strip: Strip, mesh: BeltMesh) -> tuple[Numbers, Floats]:
    """Nodes (E, 3) and stiffness (E, 6, 6) of quadratic bars along the cord and their tension.

    Per mm of width. The tension resists the slope of the radial displacement alone: the slope of
    the bar's own normal would resist sliding around the pulley, too. Only on the pulley: nothing
    pulls the rest.
    """
    cord = mesh.cord
    bars = np.stack([cord[:-2:2], cord[1:-1:2], cord[2::2]], axis=1)
    places = mesh.nodes[bars]
    outwards = places / np.linalg.norm(places, axis=2)[:, :, None]
    taut = np.zeros(len(bars))
    taut[mesh.bars] = strip.prestress_N_per_mm
    blocks = np.zeros((len(bars), 6, 6))
    for point in np.array([-1.0, 1.0]) / np.sqrt(3.0):  # two points: no locking in curved bars
        slopes = np.array([point - 0.5, -2.0 * point, point + 0.5])
        along = np.einsum("k,ekd->ed", slopes, places)
        length = np.linalg.norm(along, axis=1)
        strain = np.einsum("k,ed->ekd", slopes, along).reshape(-1, 6) / length[:, None] ** 2
        slope = (slopes[:, None] * outwards).reshape(-1, 6) / length[:, None]
        for part, factor in ((strain, strip.cord_N_per_mm), (slope, taut)):
            blocks += (factor * length)[:, None, None] * part[:, :, None] * part[:, None, :]
    return bars, blocks


def _frames(turns_rad: Floats) -> Floats:
    """Unit vectors outwards and along the turn at each node, as columns (N, 2, 2)."""
    cosine, sine = np.cos(turns_rad), np.sin(turns_rad)
    return np.array([[cosine, -sine], [sine, cosine]]).transpose(2, 0, 1)
