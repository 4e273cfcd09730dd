"""Solid bodies: plane triangles extruded in layers of 15-node wedges, turned by the helix."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flankload.bodies.flank_surface import section_curves
from flankload.studies.verification.deck import Part, Ties
from flankload.studies.verification.triangles import (
    Triangles,
    border_owners,
    held_nodes,
    quadratic,
    sides,
)

if TYPE_CHECKING:
    from flankload.base.arrays import Complexes, Flags, Floats, Numbers
    from flankload.bodies import Body

#: Each layer from an end of the width is so many times as thick as the one before, and the layers
#: in the middle so many times as thick as those at the ends.
GROWTH, MIDDLE = 1.7, 3.0
#: Nodes beside a flank follow its modifications up to this distance, as part of its length.
FOLLOWING = 0.25


@dataclass(frozen=True)
class Stand:
    """Place of a solid body: angle of its section at z = 0, x of its axis there.

    `shear` is the displacement of the axis along x and y per length along z.
    """

    turn_rad: float
    axis_mm: float
    shear: tuple[float, float]


@dataclass(frozen=True)
class Layers:
    """Layers of wedges of a body: thin ones near the contacts, thick ones elsewhere.

    `edges_mm` (L + 1,) are the ends of the thin layers; `coarse` those of them that are ends of the
    thick layers, ascending, from 0 to L; `common` the first of the thin layers of the common width,
    and the one after the last; `near` (m,) the triangles with thin layers, all on flanks included.
    """

    edges_mm: Floats
    coarse: Numbers
    common: tuple[int, int]
    near: Flags


def layers_of(low_mm: float, high_mm: float, count: int) -> Floats:
    """Ends (count + 1,) of layers that are thin at both ends of a width, mm."""
    from_end = np.minimum(np.arange(count), np.arange(count)[::-1])
    thickness = np.minimum(GROWTH**from_end, MIDDLE)
    inside = np.concatenate([[0.0], np.cumsum(thickness)]) / thickness.sum()
    return np.asarray(low_mm + (high_mm - low_mm) * inside)


def beyond(edges_mm: Floats, range_mm: tuple[float, float]) -> Floats:
    """Ends of the layers of a body: those of the common width, continued to the body's own ends."""
    step = float(np.diff(edges_mm).min())

    def outer(rest: float) -> Floats:
        """Distances from the common width, ascending."""
        if rest <= 1e-9 * step:
            return np.empty(0)
        count = 1
        while step * (GROWTH**count - 1.0) / (GROWTH - 1.0) < rest:
            count += 1
        ends = np.cumsum(GROWTH ** np.arange(count))
        return np.asarray(rest * ends / ends[-1])

    below = edges_mm[0] - outer(float(edges_mm[0] - range_mm[0]))[::-1]
    above = edges_mm[-1] + outer(float(range_mm[1] - edges_mm[-1]))
    return np.concatenate([below, edges_mm, above])


def modification_turn(body: Body, tooth: int, s_mm: Floats, z_mm: Floats) -> Floats:
    """Turn (m, n) of the points of a flank about the axis by the metal removed, rad.

    Counter-clockwise, at arc lengths (n,) and places (m,) along z, of the tooth with this number in
    the order of pitch errors.
    """
    axial = body.axial
    removed = axial.gap_mm(z_mm)
    if axial.tooth_slopes_mm:
        removed = removed + axial.tooth_gaps_mm(z_mm)[tooth]
    radius = body.base_radius_mm or abs(body.normal_lever_mm)
    turn = np.repeat(-body.outward * removed[:, np.newaxis] / radius, s_mm.size, axis=1)
    if axial.surface is not None:
        known = axial.surface.at(axial.zeta(z_mm), axial.width_mm)
        before = _complex(body.curve.point(s_mm))
        for row, curve in zip(turn, section_curves(body, known), strict=True):
            row += np.angle(_complex(curve.point(s_mm)) / before)
    return turn


def solid_part(
    body: Body, mesh: Triangles, teeth: tuple[int, ...], layers: Layers, stand: Stand
) -> Part:
    """A body of the deck, from its section in its own frame and the tooth of each of its flanks."""
    plane, triangles, border = quadratic(mesh)
    fine, coarse = layers.edges_mm, layers.edges_mm[layers.coarse]
    numbers = np.arange(len(plane))
    near, far = (np.isin(numbers, triangles[rows]) for rows in (layers.near, ~layers.near))
    corners = numbers < len(mesh.vertices)
    at_edge = np.tile(near, (fine.size, 1))
    at_edge[layers.coarse] |= far
    masks = (
        at_edge,
        np.tile(near & corners, (fine.size - 1, 1)),
        np.tile(far & corners, (coarse.size - 1, 1)),
    )
    z = np.concatenate([fine, _middles(fine), _middles(coarse)])
    places = _placed(body, plane, z, _turns(body, mesh, plane, border, teeth, z), stand)
    chosen = np.concatenate(masks)
    number = np.where(chosen, np.cumsum(chosen).reshape(chosen.shape) - 1, -1)
    edge, between, wide = np.split(number, np.cumsum([len(mask) for mask in masks])[:-1])
    nodes = places[chosen]
    ties = _ties(triangles, layers, (edge, between, wide), near & far)
    nodes[ties.nodes] = np.einsum("kj,kjx->kx", ties.weights, nodes[ties.masters])
    of_held = np.unique(number[:, held_nodes(mesh, border)])
    return Part(
        nodes=nodes,
        cells=np.concatenate(
            [
                _wedges(triangles[layers.near], edge, between),
                _wedges(triangles[~layers.near], edge[layers.coarse], wide),
            ]
        ),
        held=np.setdiff1d(of_held[of_held >= 0], ties.nodes),
        flanks=_faces(mesh, len(teeth), layers),
        material=body.material,
        ties=ties,
    )


def _middles(edges: Floats) -> Floats:
    return np.asarray(0.5 * (edges[1:] + edges[:-1]))


def _wedges(triangles: Numbers, edge: Numbers, between: Numbers) -> Numbers:
    """Wedges (layers * m, 15), layer by layer, from the numbers of nodes at the edges of layers
    and between them.
    """
    low, high = edge[:-1][:, triangles], edge[1:][:, triangles]
    middle = between[:, triangles[:, :3]]
    parts = [low[..., :3], high[..., :3], low[..., 3:], high[..., 3:], middle]
    return np.concatenate(parts, axis=2).reshape(-1, 15)


def _ties(
    triangles: Numbers, layers: Layers, numbers: tuple[Numbers, Numbers, Numbers], shared: Flags
) -> Ties:
    """Ties of thin layers to thick ones, by the functions of the faces of the latter."""
    edge, between, wide = numbers
    own, ends = sides(triangles[:, :3])
    sides_on = np.intersect1d(own[layers.near], own[~layers.near])
    middle = np.zeros(len(ends), dtype=np.int64)
    middle[own] = triangles[:, 3:]
    fine, coarse = layers.edges_mm, layers.edges_mm[layers.coarse]
    found: list[tuple[int, list[int], list[float]]] = []

    def tie(node: int, z: float, plane: tuple[int, ...]) -> None:
        """By (low, middle, high) of a vertex, or by all eight nodes of a face."""
        c = int(np.searchsorted(coarse, z)) - 1
        t = 2.0 * (z - coarse[c]) / (coarse[c + 1] - coarse[c]) - 1.0
        low, high = edge[layers.coarse[c]], edge[layers.coarse[c + 1]]
        if len(plane) == 1:
            masters = [low[plane[0]], high[plane[0]], wide[c, plane[0]]]
            found.append((node, masters, [0.5 * t * (t - 1.0), 0.5 * t * (t + 1.0), 1.0 - t * t]))
            return
        a, b, m = plane
        corner, face, side = 0.25 * (t * t - 1.0), 0.5, 0.5 * (1.0 - t * t)
        masters = [low[a], low[b], high[a], high[b], low[m], high[m], wide[c, a], wide[c, b]]
        ends_of = [face * (1.0 - t), face * (1.0 + t)]
        found.append((node, masters, [corner] * 4 + ends_of + [side] * 2))

    thin = np.setdiff1d(np.arange(fine.size), layers.coarse)
    for vertex in np.flatnonzero(shared[: int(triangles[:, :3].max()) + 1]).tolist():
        for level in thin.tolist():
            tie(int(edge[level, vertex]), fine[level], (vertex,))
        for level, z in enumerate(_middles(fine).tolist()):
            tie(int(between[level, vertex]), z, (vertex,))
    for side in sides_on.tolist():
        for level in thin.tolist():
            (a, b), m = ends[side].tolist(), int(middle[side])
            tie(int(edge[level, m]), fine[level], (a, b, m))
    return Ties.of(found)


def _turns(
    body: Body,
    mesh: Triangles,
    plane: Floats,
    border: Numbers,
    teeth: tuple[int, ...],
    z_mm: Floats,
) -> Floats:
    """Turn (m, N) of the nodes of the section at each z by the metal removed beside them."""
    from scipy.spatial import cKDTree

    turns = np.zeros((z_mm.size, len(plane)))
    for k, tooth in enumerate(teeth):
        rows = mesh.border.flank == k
        nodes = np.concatenate([mesh.border.ends[rows].ravel(), border[rows]])
        s = np.concatenate([mesh.border.s[rows].ravel(), mesh.border.s[rows].mean(axis=1)])
        own = modification_turn(body, tooth, s, z_mm)
        if not own.any():
            continue
        reach = FOLLOWING * body.curve.length_mm
        distance, nearest = cKDTree(plane[nodes]).query(plane, distance_upper_bound=reach)
        near = np.flatnonzero(np.isfinite(distance))
        turns[:, near] += (1.0 - distance[near] / reach) * own[:, nearest[near]]
    return turns


def _placed(body: Body, plane: Floats, z_mm: Floats, turns_rad: Floats, stand: Stand) -> Floats:
    """Places (m, N, 3) of the nodes of the section at each z."""
    angle = stand.turn_rad + body.axial.twist_rad_per_mm * z_mm[:, np.newaxis] + turns_rad
    turned = _complex(plane) * np.exp(1j * angle)
    x = turned.real + stand.axis_mm + stand.shear[0] * z_mm[:, np.newaxis]
    y = turned.imag + stand.shear[1] * z_mm[:, np.newaxis]
    return np.stack([x, y, np.broadcast_to(z_mm[:, np.newaxis], x.shape)], axis=2)


def _faces(mesh: Triangles, n_flanks: int, layers: Layers) -> tuple[Numbers, ...]:
    """Element and face (3 to 5) of each flank in each of the layers of the common width."""
    own = border_owners(mesh)
    own[:, 0] = (np.cumsum(layers.near) - 1)[own[:, 0]]  # thin layers come first
    count, (low, high) = int(layers.near.sum()), layers.common
    return tuple(
        own[mesh.border.flank == k] + np.array([layer * count, 3])
        for k in range(n_flanks)
        for layer in range(low, high)
    )


def _complex(points: Floats) -> Complexes:
    return np.asarray(points[..., 0] + 1j * points[..., 1])
