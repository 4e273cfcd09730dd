"""What a timing belt does under forces on its teeth, on its lands and at its slack end.

The strip is solved once: its tight end is held along the strand, its lands are held radially, the
cord stands in it as bars, and its slack end is pulled. All columns are of unit forces per mm of
width, spread over the elements as linear hats; the same hats read displacements, so what comes out
is symmetric. What the lands push back with is read from the same solutions.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.polynomial.legendre import leggauss
from scipy.sparse import coo_matrix, csc_matrix

from flankload.bodies.belt_mesh import BeltMesh, mesh_strip
from flankload.elasticity import factored, stiffness

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from flankload.bodies.belt import Strip
    from flankload.cost import Account

    Floats = NDArray[np.float64]
    Numbers = NDArray[np.int64]

#: Of the edges.
GAUSS_POINTS = 4


@dataclass(frozen=True)
class Flanks:
    """Contact pairs on the working flanks; n pairs.

    Attributes
    ----------
    tooth : (n,) array
        On which each stands, from the tight end.
    places, normals : (n, 2) arrays
        About the axis of the pulley, mm; normals out of the belt.
    levers_mm : (n,) array
        Moment about the axis of a unit force of the pulley on the belt.
    gaps_mm : (n,) array
        To the groove, along the normals.
    lengths_mm : (n,) array
        Of flank that each stands for.
    """

    tooth: Numbers
    places: Floats
    normals: Floats
    levers_mm: Floats
    gaps_mm: Floats
    lengths_mm: Floats


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
    flanks, columns = _flank_columns(strip, mesh)
    n_loads = flanks.tooth.size
    pull = np.zeros(matrix.shape[0])
    pull[2 * mesh.cord[-1] + 1] = 1.0
    loads = np.column_stack([polar.T @ columns, pull])
    land, hats, spread = _land_hats(mesh)
    if rubbing:
        loads = np.hstack([loads, spread])
    outwards = np.unique(np.concatenate(mesh.lands)) * 2
    along = mesh.tight_end * 2 + 1
    held = np.concatenate([outwards, along])
    free = np.setdiff1d(np.arange(matrix.shape[0]), held)
    solve = factored(matrix[free][:, free].tocsc(), account)
    if account is not None:
        account.count(unit_loads_normal=n_loads, unit_loads_tangential=spread.shape[1] * rubbing)
    moved = np.zeros((matrix.shape[0], loads.shape[1]))
    moved[free] = solve(loads[free])
    # what holds: the land pushes outwards, the tight strand pulls against the turn
    holds = matrix[held] @ moved - loads[held]
    reaction = hats[outwards].T @ holds[: outwards.size]
    # by its moment, since the strand lies on the pitch line
    arms = np.linalg.norm(mesh.nodes[mesh.tight_end], axis=1) / strip.pitch_radius_mm
    tight = -arms @ holds[outwards.size :]
    seen = loads[:, :n_loads].T @ moved
    lifts = (
        _lifting(matrix, free, solve, hats, (along, arms), loads[:, :n_loads]) if lifting else None
    )
    rubs = slice(n_loads + 1, None)
    return StripResponse(
        flanks=flanks,
        compliance=0.5 * (seen[:, :n_loads] + seen[:, :n_loads].T),
        by_slack=seen[:, n_loads],
        land=land,
        reaction=reaction[:, :n_loads],
        reaction_by_slack=reaction[:, n_loads],
        tight=tight[:n_loads],
        tight_by_slack=float(tight[n_loads]),
        rubbing=LandColumns(seen[:, rubs], reaction[:, rubs], tight[rubs]) if rubbing else None,
        lifting=lifts,
        degrees_of_freedom=free.size,
    )


def _lifting(
    matrix: csc_matrix,
    free: Numbers,
    solve: Callable[[Floats], Floats],
    hats: Floats,
    tight_end: tuple[Numbers, Floats],
    loads: Floats,
) -> LandColumns:
    """What lands do that give way outwards, a hat at a time."""
    along, arms = tight_end
    moved = hats.copy()
    moved[free] = solve(-(matrix[free] @ hats))
    holds = matrix @ moved
    stiff = hats.T @ holds
    return LandColumns(
        recession=loads.T @ moved,
        reaction=0.5 * (stiff + stiff.T),
        tight=-arms @ holds[along],
    )


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


def _hats(places: Floats) -> tuple[Floats, Floats, Floats]:
    """Linear hats on the ends of quadratic edges, and the edges' own functions.

    Parameters
    ----------
    places : (m, 2) array
        Of nodes in order, every second one a middle.

    Returns
    -------
    shapes : (g, m) array
        Of the nodes at the Gauss points of all edges.
    hats : (g, (m + 1)/2) array
    along : (g, 2) array
        Tangents there, times the weight of the point and the length of the edge, mm.
    """
    points, weights = leggauss(GAUSS_POINTS)
    local = np.column_stack([points * (points - 1) / 2, 1 - points**2, points * (points + 1) / 2])
    slopes = np.column_stack([points - 0.5, -2 * points, points + 0.5])
    edges = (len(places) - 1) // 2
    shapes = np.zeros((edges, GAUSS_POINTS, len(places)))
    hats = np.zeros((edges, GAUSS_POINTS, edges + 1))
    along = np.zeros((edges, GAUSS_POINTS, 2))
    for e in range(edges):
        nodes = slice(2 * e, 2 * e + 3)
        shapes[e, :, nodes] = local
        hats[e, :, e] = 0.5 * (1 - points)
        hats[e, :, e + 1] = 0.5 * (1 + points)
        along[e] = weights[:, None] * (slopes @ places[nodes])
    return (
        shapes.reshape(-1, len(places)),
        hats.reshape(-1, edges + 1),
        along.reshape(-1, 2),
    )


def _flank_columns(strip: Strip, mesh: BeltMesh) -> tuple[Flanks, Floats]:
    """Pairs on all flanks, and the nodal loads (2N, n) in x and y of a unit force on each."""
    parts: list[tuple[Floats, ...]] = []
    columns = []
    for k, nodes in enumerate(mesh.flanks):
        assert strip.tooth is not None
        angle = float(strip.tooth_angles_rad[k])
        places = mesh.nodes[nodes]
        shapes, hats, along = _hats(places)
        out = np.column_stack([-along[:, 1], along[:, 0]])
        at = shapes @ places
        length = hats.T @ np.linalg.norm(along, axis=1)
        lever = -(hats.T @ (at[:, 0] * out[:, 1] - at[:, 1] * out[:, 0])) / length
        inside = strip.gaps(strip.in_tooth(at, angle))
        gap = (hats.T @ (np.linalg.norm(along, axis=1) * inside)) / length
        middle = (hats.T @ (np.linalg.norm(along, axis=1)[:, None] * at)) / length[:, None]
        normal = hats.T @ out
        normal = normal / np.linalg.norm(normal, axis=1)[:, None]
        parts.append((np.full(length.size, k), middle, normal, lever, gap, length))
        own = np.zeros((len(mesh.nodes), 2, length.size))
        own[nodes] = -np.einsum("gq,gh,gd->qdh", shapes, hats, out) / length
        columns.append(own.reshape(-1, length.size))
    if not parts:
        nothing = np.zeros(0)
        none = Flanks(
            nothing.astype(int),
            nothing.reshape(0, 2),
            nothing.reshape(0, 2),
            nothing,
            nothing,
            nothing,
        )
        return none, np.zeros((2 * len(mesh.nodes), 0))
    return Flanks(*(np.concatenate(part) for part in zip(*parts, strict=True))), np.hstack(columns)


def _land_hats(mesh: BeltMesh) -> tuple[Numbers, Floats, Floats]:
    """Lands of the hats (h,), the hats outwards at the nodes and unit forces along the turn."""
    numbers, hats, spread = [], [], []
    for k, nodes in enumerate(mesh.lands):
        shapes, values, along = _hats(mesh.nodes[nodes])
        length = np.linalg.norm(along, axis=1)
        count = values.shape[1]
        own, force = (np.zeros((len(mesh.nodes), 2, count)) for _ in range(2))
        own[nodes[::2], 0] = np.eye(count)
        own[nodes[1::2], 0] = 0.5 * (np.eye(count)[:-1] + np.eye(count)[1:])
        force[nodes, 1] = shapes.T @ (length[:, None] * values) / (length @ values)
        numbers.append(np.full(count, k))
        hats.append(own.reshape(-1, count))
        spread.append(force.reshape(-1, count))
    return np.concatenate(numbers), np.hstack(hats), np.hstack(spread)
