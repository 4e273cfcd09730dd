"""What a timing belt does under forces on its teeth, on its lands and at its slack end.

The strip is solved once: its tight end is held along the strand, its lands are held radially, the
cord stands in it as bars, and its slack end is pulled. All columns are of unit forces per mm of
width, spread over the elements as linear hats; the same hats read displacements, so what comes out
is symmetric. What the lands push back with is read from the same solutions.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from scipy.sparse import coo_matrix, csc_matrix, hstack

from flankload.belt_columns import Flanks, flank_columns, land_columns
from flankload.bodies.belt_mesh import BeltMesh, mesh_strip
from flankload.elasticity import factored, stiffness

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from flankload.bodies.belt import Strip
    from flankload.cost import Account

    Floats = NDArray[np.float64]
    Numbers = NDArray[np.int64]

#: Columns solved at once: with many teeth all of them would not fit into memory.
BLOCK = 64


@dataclass(frozen=True)
class LandColumns:
    """What the h hats of the lands do when they rub, or when they give way.

    Attributes
    ----------
    recession : (n, h) array
        Of the flanks under a force along the turn, or per way outwards.
    reaction : (h, h) array
        Of the lands.
    tight : (h,) array
        Of the tight strand.
    """

    recession: Floats
    reaction: Floats
    tight: Floats


@dataclass(frozen=True)
class StripResponse:
    """A strip by its forces per mm of width; n pairs, h hats on the lands.

    Attributes
    ----------
    flanks : Flanks
    compliance : (n, n) array
        K, by which flanks recede under forces on flanks, mm²/N.
    by_slack : (n,) array
        L, the same under the tension of the slack strand.
    land : (h,) array
        On which land each hat stands.
    reaction : (h, n) array
        P, forces of the lands on the belt under forces on flanks.
    reaction_by_slack : (h,) array
    tight, tight_by_slack : (n,) array, float
        The tension that holds the tight end.
    rubbing, lifting : LandColumns or None
        Where they were asked for.
    degrees_of_freedom : int
    """

    flanks: Flanks
    compliance: Floats
    by_slack: Floats
    land: Numbers
    reaction: Floats
    reaction_by_slack: Floats
    tight: Floats
    tight_by_slack: float
    rubbing: LandColumns | None
    lifting: LandColumns | None
    degrees_of_freedom: int


def solve_strip(
    strip: Strip,
    mesh: BeltMesh | None = None,
    *,
    rubbing: bool = False,
    lifting: bool = False,
    account: Account | None = None,
) -> StripResponse:
    """Solve the elements of a belt once.

    Parameters
    ----------
    strip : Strip
    mesh : BeltMesh, optional
        Of it.
    rubbing, lifting : bool
        Also what lands do that rub, or that give way.
    account : Account, optional

    Returns
    -------
    StripResponse
    """
    mesh = mesh if mesh is not None else mesh_strip(strip)
    polar = _polar_frames(mesh.nodes)
    matrix = polar.T @ _stiffness(strip, mesh) @ polar
    matrix = matrix.tocsc()
    flanks, columns = flank_columns(strip, mesh)
    n = flanks.tooth.size
    land, hats, spread = land_columns(mesh)
    pull = csc_matrix(([1.0], ([2 * mesh.cord[-1] + 1], [0])), shape=(matrix.shape[0], 1))
    loads = hstack([polar.T @ columns, pull, *([spread] if rubbing else [])], format="csc")
    solved = _Solved(strip, mesh, matrix, loads[:, :n], hats, account)
    if account is not None:
        account.count(unit_loads_normal=n, unit_loads_tangential=spread.shape[1] * rubbing)
    forced = solved.under(loads)
    lifted = solved.giving_way(hats) if lifting else None
    seen = forced.recession
    return StripResponse(
        flanks=flanks,
        compliance=0.5 * (seen[:, :n] + seen[:, :n].T),
        by_slack=seen[:, n],
        land=land,
        reaction=forced.reaction[:, :n],
        reaction_by_slack=forced.reaction[:, n],
        tight=forced.tight[:n],
        tight_by_slack=float(forced.tight[n]),
        rubbing=LandColumns(seen[:, n + 1 :], forced.reaction[:, n + 1 :], forced.tight[n + 1 :])
        if rubbing
        else None,
        lifting=lifted,
        degrees_of_freedom=solved.free.size,
    )


class _Solved:
    """The factorised strip; columns are solved in blocks, and only what is read of them is kept."""

    def __init__(
        self,
        strip: Strip,
        mesh: BeltMesh,
        matrix: csc_matrix,
        flanks: csc_matrix,
        hats: csc_matrix,
        account: Account | None,
    ) -> None:
        self._matrix, self._flanks, self._hats = matrix, flanks, hats
        # lands are held outwards, the tight end along the turn
        along = mesh.tight_end * 2 + 1
        lands = np.unique(np.concatenate(mesh.lands)) * 2
        self._held = np.concatenate([lands, along])
        self.free = np.setdiff1d(np.arange(matrix.shape[0]), self._held)
        self._solve = factored(matrix[self.free][:, self.free].tocsc(), account)
        # by its moment, since the strand lies on the pitch line
        arms = np.linalg.norm(mesh.nodes[mesh.tight_end], axis=1) / strip.pitch_radius_mm
        self._arms = np.concatenate([np.zeros(lands.size), arms])

    def under(self, loads: csc_matrix) -> LandColumns:
        """What flanks, lands and the tight strand do under nodal loads."""
        return self._read(loads, given=False)

    def giving_way(self, ways: csc_matrix) -> LandColumns:
        """The same where lands give way outwards."""
        found = self._read(ways, given=True)
        return replace(found, reaction=0.5 * (found.reaction + found.reaction.T))

    def _read(self, columns: csc_matrix, *, given: bool) -> LandColumns:
        parts = []
        for first in range(0, columns.shape[1], BLOCK):
            block = columns[:, first : first + BLOCK].toarray()
            moved = block if given else np.zeros_like(block)
            load = -(self._matrix @ block) if given else block
            moved[self.free] = self._solve(load[self.free])
            # what holds: the land pushes outwards, the tight strand pulls against the turn
            holds = self._matrix[self._held] @ moved
            if not given:
                holds -= block[self._held]
            parts.append(
                (self._flanks.T @ moved, self._hats[self._held].T @ holds, -self._arms @ holds)
            )
        return LandColumns(*(np.concatenate(part, axis=-1) for part in zip(*parts, strict=True)))


def _stiffness(strip: Strip, mesh: BeltMesh) -> csc_matrix:
    """Of the elements and of the cord, per mm of width."""
    solid = stiffness(mesh.nodes, mesh.cells, strip.material, "strain")
    return (solid + cord_stiffness(strip, mesh)).tocsc()


def cord_stiffness(strip: Strip, mesh: BeltMesh) -> csc_matrix:
    """Stiffness of quadratic bars along the cord, and of the tension that holds them straight.

    The tension resists the slope of the radial displacement alone: the slope of the bar's own
    normal would resist sliding around the pulley, too.

    Parameters
    ----------
    strip : Strip
    mesh : BeltMesh
        N nodes.

    Returns
    -------
    csc_matrix, (2N, 2N)
        Per mm of width.
    """
    cord = mesh.cord
    bars = np.stack([cord[:-2:2], cord[1:-1:2], cord[2::2]], axis=1)
    places = mesh.nodes[bars]
    outwards = places / np.linalg.norm(places, axis=2)[:, :, None]
    blocks = np.zeros((len(bars), 6, 6))
    for point in np.array([-1.0, 1.0]) / np.sqrt(3.0):  # two points: no locking in curved bars
        slopes = np.array([point - 0.5, -2.0 * point, point + 0.5])
        along = np.einsum("k,ekd->ed", slopes, places)
        length = np.linalg.norm(along, axis=1)
        strain = np.einsum("k,ed->ekd", slopes, along).reshape(-1, 6) / length[:, None] ** 2
        slope = (slopes[:, None] * outwards).reshape(-1, 6) / length[:, None]
        for part, factor in ((strain, strip.cord_N_per_mm), (slope, strip.prestress_N_per_mm)):
            blocks += (factor * length)[:, None, None] * part[:, :, None] * part[:, None, :]
    degrees = (2 * bars[:, :, None] + np.arange(2)).reshape(-1, 6)
    rows = np.repeat(degrees, 6, axis=1).ravel()
    columns = np.tile(degrees, (1, 6)).ravel()
    size = 2 * len(mesh.nodes)
    return coo_matrix((blocks.ravel(), (rows, columns)), shape=(size, size)).tocsc()


def _polar_frames(nodes: Floats) -> csc_matrix:
    """Columns outwards and along the turn at each node, in x and y."""
    cosine, sine = (nodes / np.linalg.norm(nodes, axis=1)[:, None]).T
    first = 2 * np.arange(len(nodes))
    rows = np.concatenate([first, first + 1, first, first + 1])
    columns = np.concatenate([first, first, first + 1, first + 1])
    values = np.concatenate([cosine, sine, -sine, cosine])
    size = 2 * len(nodes)
    return coo_matrix((values, (rows, columns)), shape=(size, size)).tocsc()
