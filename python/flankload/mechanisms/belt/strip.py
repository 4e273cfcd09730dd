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
from typing import TYPE_CHECKING

import numpy as np
from scipy.sparse import csc_array, hstack

from flankload.elasticity.finite_elements import assembled, condensed, degrees_of, stiffness
from flankload.elasticity.sector_row import RowCell
from flankload.mechanisms.belt.columns import Flanks, flank_columns, land_columns

if TYPE_CHECKING:
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
    basis = (_frames(mesh.turns_rad) @ lands.basis).tocsc()
    matrix = (basis.T @ _stiffness(strip, mesh) @ basis).tocsc()
    held, pulled = 2 * mesh.tight + 1, 2 * mesh.slack + 1
    shape = (matrix.shape[0], pulled.size)
    pull = assembled(np.ones(pulled.size), pulled, np.arange(pulled.size), shape)
    prescribed = np.concatenate([lands.degrees, held])
    forces = hstack([basis.T @ pairs, pull, *([lands.forces] if sliding else [])]).toarray()
    columns, direct = _columns(matrix, forces, prescribed)
    sizes = (pairs.shape[1], pulled.size, sliding * lands.number.size, lands.number.size, held.size)
    kinds = np.repeat(list(Kind), sizes)
    loads = np.flatnonzero(kinds < (Kind.TIGHT if lifting else Kind.RADIAL))
    left, right = mesh.left[: None if cuts[0] else 0], mesh.right[: None if cuts[1] else 0]
    cut = np.concatenate([degrees_of(left), degrees_of(right)])
    inner = np.setdiff1d(np.arange(matrix.shape[0]), np.concatenate([prescribed, cut]))
    solve, complement = condensed(matrix, inner, cut, account)
    solved = solve(columns[inner])
    if account is not None:
        normal = int((kinds[loads] != Kind.SLIDING).sum())
        account.count(unit_loads_normal=normal, unit_loads_tangential=loads.size - normal)
        account.count(fe_unknowns=inner.size)
        account.workspace_bytes += columns.nbytes + solved.nbytes
    local = columns[inner].T @ solved[:, loads] + direct[:, loads]
    carried = columns[cut] - matrix[cut][:, inner] @ solved
    return Piece(
        cell=_cell(local, carried, complement, degrees_of(left).size),
        kinds=kinds,
        flanks=flanks,
        land=lands.number,
        land_angle_rad=lands.angle_rad,
        degrees_of_freedom=inner.size,
    )


def _columns(matrix: csc_array, forces: Floats, prescribed: Numbers) -> tuple[Floats, Floats]:
    """Nodal forces of all columns, and their direct response.

    The columns of `forces` come first, then unit displacements of the `prescribed` degrees of
    freedom, whose output is the negative reaction.
    """
    held = matrix[:, prescribed].toarray()
    columns, loads = np.hstack([forces, -held]), forces.shape[1]
    direct = np.zeros((columns.shape[1],) * 2)
    direct[loads:, :loads] = forces[prescribed]
    direct[:loads, loads:] = forces[prescribed].T
    direct[loads:, loads:] = -held[prescribed]
    return columns, direct


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


def _stiffness(strip: Strip, mesh: BeltMesh) -> csc_array:
    """Stiffness of the elements and of the cord, per mm of width."""
    solid = stiffness(mesh.nodes, mesh.cells, strip.material, "strain")
    return (solid + cord_stiffness(strip, mesh)).tocsc()


def cord_stiffness(strip: Strip, mesh: BeltMesh) -> csc_array:
    """Stiffness (2N, 2N) of quadratic bars along the cord, and of the tension in them.

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
    degrees = (2 * bars[:, :, None] + np.arange(2)).reshape(-1, 6)
    rows = np.repeat(degrees, 6, axis=1).ravel()
    columns = np.tile(degrees, (1, 6)).ravel()
    return assembled(blocks.ravel(), rows, columns, (2 * len(mesh.nodes), 2 * len(mesh.nodes)))


def _frames(turns_rad: Floats) -> csc_array:
    """Columns outwards and along the turn at each node, in x and y."""
    cosine, sine = np.cos(turns_rad), np.sin(turns_rad)
    first = 2 * np.arange(turns_rad.size)
    rows = np.concatenate([first, first + 1, first, first + 1])
    columns = np.concatenate([first, first, first + 1, first + 1])
    values = np.concatenate([cosine, sine, -sine, cosine])
    size = 2 * turns_rad.size
    return assembled(values, rows, columns, (size, size))
