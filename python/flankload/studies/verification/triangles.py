"""Triangles of a whole body, with a border on the exact flank curves.

Only corners are stored: a side is straight inside the body and has its own middle node on the
border. `refined` bisects triangles, `quadratic` returns six-node elements.

Bisection of the longest sides extends to the neighbours until no vertex lies in the middle of a
side; angles stay above half the smallest initial angle (Rivara). New vertices of a flank lie on its
curve.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import TYPE_CHECKING

import numpy as np

from flankload.base.rotation import turned
from flankload.bodies import Body, SectorMesh, WholeMesh
from flankload.elasticity.whole_body import ring_of
from flankload.meshes.plane_mesh import boundary_edges, jacobians

if TYPE_CHECKING:
    from collections.abc import Callable

    from flankload.base.arrays import Cells, Flags, Floats, Numbers
    from flankload.flank import FlankCurve

#: Border nodes closer to a flank curve than this part of its length lie on it.
ON_CURVE = 1e-4
#: Largest number of bisections of a triangle: from a body's size to a ten-thousandth of it.
MOST_HALVINGS = 60
#: Least Jacobian of a triangle relative to its mean; a straight triangle has 1.
LEAST_JACOBIAN = 0.4


@dataclass(frozen=True)
class Border:
    """Sides that belong to one triangle; k of them.

    `ends` (k, 2) are vertices, with the material on the left; `middles` (k, 2) places in mm;
    `flank` (k,) is the number of the flank curve of a side, -1 if none; `s` (k, 2) are the arc
    lengths of both ends on that curve in mm, NaN if none; `held` (k,) are the fixed sides.
    """

    ends: Numbers
    middles: Floats
    flank: Numbers
    s: Floats
    held: Flags

    def at(self, rows: Flags) -> Border:
        """Some of the sides."""
        return Border(*(getattr(self, field.name)[rows] for field in fields(self)))


@dataclass(frozen=True)
class Triangles:
    """A plane body in triangles: vertices (n, 2) in mm, corners (m, 3) counter-clockwise.

    `curves` are the curves numbered by `border.flank`, at their places.
    """

    vertices: Floats
    corners: Numbers
    border: Border
    curves: tuple[FlankCurve, ...]


def whole_body(body: Body, flanks: tuple[tuple[int, float], ...]) -> Triangles:
    """Mesh of a whole body, in the body's own frame.

    Each flank that may touch has its tooth and its angle (rad); a flank with pitch error moves the
    border with it. `curves` follow the order of the flanks.
    """
    mesh = body.mesh
    assert mesh is not None
    if isinstance(mesh, SectorMesh):
        nodes, cells, numbers = ring_of(mesh)
        held = numbers[:, mesh.bore_nodes]
    else:
        nodes, cells, held = mesh.nodes.copy(), mesh.cells, mesh.fixed_nodes
    edges = boundary_edges(cells)
    curves = tuple(body.curve.rotated(angle) for _, angle in flanks)
    flank = np.full(len(edges), -1)
    s_ends = np.full((len(edges), 2), np.nan)
    for k, (tooth, angle) in enumerate(flanks):
        standing, known = angle, np.full(len(nodes), np.nan)
        if isinstance(mesh, SectorMesh):
            standing = 2 * np.pi * tooth / body.teeth
            known[numbers[tooth]] = mesh.flank_arc_length
        for given in mesh.flanks if isinstance(mesh, WholeMesh) else ():
            if given.tooth == tooth:
                known = given.flank_arc_length
        s = _arc_lengths(body.curve.rotated(standing), nodes, edges, known)
        ours = ~np.isnan(s[edges]).any(axis=1)
        on = np.unique(edges[ours])
        nodes[on] = curves[k].point(s[on])
        flank[ours] = k
        s_ends[ours] = s[edges[ours, :2]]
    middles = nodes[edges[:, 2]]
    for k, curve in enumerate(curves):
        middles[flank == k] = curve.point(s_ends[flank == k].mean(axis=1))
    corners = _triangles(nodes, cells)
    used, corners = np.unique(corners, return_inverse=True)
    place = np.full(len(nodes), -1)
    place[used] = np.arange(used.size)
    border = Border(
        ends=place[edges[:, :2]],
        middles=middles,
        flank=flank,
        s=s_ends,
        held=np.asarray(np.isin(edges, held).all(axis=1)),
    )
    return Triangles(nodes[used], corners.reshape(-1, 3), border, curves)


def moved(mesh: Triangles, turn_rad: float, shift_mm: float) -> Triangles:
    """The same body rotated about its axis, which is then at (shift, 0).

    Its curves remain in the body's frame and are omitted.
    """
    shift = np.array([shift_mm, 0.0])
    border = replace(mesh.border, middles=turned(mesh.border.middles, turn_rad) + shift)
    return Triangles(turned(mesh.vertices, turn_rad) + shift, mesh.corners, border, ())


def without(mesh: Triangles, dropped: Flags) -> Triangles:
    """The same body without some triangles (m,); new sides of its border are straight."""
    corners = mesh.corners[~dropped]
    numbers, ends = sides(corners)
    alone = np.bincount(numbers.ravel(), minlength=len(ends)) == 1
    directed = np.stack([corners, np.roll(corners, -1, axis=1)], axis=2).reshape(-1, 2)
    outer = directed[alone[numbers.ravel()]]
    count, old = len(mesh.vertices), mesh.border
    keys = old.ends @ [count, 1]
    order = np.argsort(keys)
    wanted = outer @ [count, 1]
    row = order[np.minimum(np.searchsorted(keys[order], wanted), len(order) - 1)]
    known = keys[row] == wanted
    used, place = np.unique(corners), np.zeros(count, dtype=np.int64)
    place[used] = np.arange(used.size)
    straight = mesh.vertices[outer].mean(axis=1)
    border = Border(
        ends=place[outer],
        middles=np.where(known[:, np.newaxis], old.middles[row], straight),
        flank=np.where(known, old.flank[row], -1),
        s=np.where(known[:, np.newaxis], old.s[row], np.nan),
        held=known & old.held[row],
    )
    return Triangles(mesh.vertices[used], place[corners], border, mesh.curves)


def quadratic(mesh: Triangles) -> tuple[Floats, Numbers, Numbers]:
    """Six-node triangles.

    Returns the nodes (N, 2), vertices first, then middles; the cells (m, 6), corners, then middles
    of the sides 0-1, 1-2, 2-0; and the middle nodes (k,) of the border's sides.
    """
    numbers, ends = sides(mesh.corners)
    n = len(mesh.vertices)
    middles = mesh.vertices[ends].mean(axis=1)
    own = find_sides(ends, mesh.border.ends, n)
    middles[own] = mesh.border.middles
    return np.concatenate([mesh.vertices, middles]), np.hstack([mesh.corners, n + numbers]), n + own


def sides(corners: Numbers) -> tuple[Numbers, Numbers]:
    """Sides of triangles: numbers (m, 3) for 0-1, 1-2, 2-0, and sorted ends (e, 2)."""
    other = np.roll(corners, -1, axis=1)
    count = int(corners.max()) + 1
    # a single number for both ends is much faster to sort than pairs
    keys = np.minimum(corners, other) * count + np.maximum(corners, other)
    keys, numbers = np.unique(keys, return_inverse=True)
    return numbers.reshape(-1, 3), np.stack(np.divmod(keys, count), axis=1)


def find_sides(ends: Numbers, wanted: Numbers, count: int) -> Numbers:
    """Indices of sides (k, 2) among sorted sides (e, 2) of `count` vertices."""
    keys = ends[:, 0] * count + ends[:, 1]
    low, high = wanted.min(axis=1), wanted.max(axis=1)
    return np.searchsorted(keys, low * count + high)


def border_owners(mesh: Triangles) -> Numbers:
    """(k, 2) Triangle and side (0 to 2) that each side of the border belongs to."""
    numbers, ends = sides(mesh.corners)
    first = np.unique(numbers, return_index=True)[1]
    own = find_sides(ends, mesh.border.ends, len(mesh.vertices))
    return np.stack(np.divmod(first[own], 3), axis=1)


def held_nodes(mesh: Triangles, middles: Numbers) -> Numbers:
    """Fixed nodes, with the middle nodes (k,) of the border's sides."""
    held = mesh.border.held
    return np.unique(np.concatenate([mesh.border.ends[held].ravel(), middles[held]]))


def held_weights(mesh: Triangles, middles: Numbers) -> Floats:
    """Length (h,) of the held sides that belongs to each of `held_nodes`, by Simpson's rule, mm."""
    sides = np.column_stack([mesh.border.ends, middles])[mesh.border.held]
    first, last = (mesh.vertices[mesh.border.ends[mesh.border.held, k]] for k in (0, 1))
    middle = mesh.border.middles[mesh.border.held]
    length = np.linalg.norm(middle - first, axis=1) + np.linalg.norm(last - middle, axis=1)
    nodes, place = np.unique(sides, return_inverse=True)
    parts = length[:, None] * np.array([1.0, 1.0, 4.0]) / 6.0
    return np.asarray(np.bincount(place.ravel(), parts.ravel(), minlength=nodes.size))


def _arc_lengths(curve: FlankCurve, nodes: Floats, edges: Numbers, known: Floats) -> Floats:
    """Arc lengths (N,) of the border nodes on a flank, known ones as they are; NaN elsewhere."""
    border = np.unique(edges)
    samples = curve.point(np.linspace(0.0, curve.length_mm, 64))
    low, high = samples.min(axis=0), samples.max(axis=0)
    room = 0.1 * curve.length_mm
    near = border[((nodes[border] > low - room) & (nodes[border] < high + room)).all(axis=1)]
    s = np.full(len(nodes), np.nan)
    if near.size:
        places, distance = curve.arc_length_of(nodes[near])
        on = distance <= ON_CURVE * curve.length_mm
        s[near[on]] = places[on]
    return np.where(np.isnan(known), s, known)


def _triangles(nodes: Floats, cells: Cells) -> Numbers:
    """Corners of triangles: quadrilaterals are split along their shorter diagonal."""
    parts = []
    for kind, data in cells:
        if kind.startswith("triangle"):
            parts.append(data[:, :3])
            continue
        a, b, c, d = data[:, :4].T
        first = np.linalg.norm(nodes[a] - nodes[c], axis=1)
        second = np.linalg.norm(nodes[b] - nodes[d], axis=1)
        split = np.stack([[a, b, c], [a, c, d]])  # (2, 3, E)
        other = np.stack([[a, b, d], [b, c, d]])
        chosen = np.where(first <= second, split, other)
        parts.append(chosen.transpose(0, 2, 1).reshape(-1, 3))
    return np.concatenate(parts)


def refined(mesh: Triangles, size_at: Callable[[Floats], Floats]) -> Triangles:
    """Refine until no side is longer than wanted and no border side is bent too much.

    `size_at` maps places (m, 2) to the largest allowed side of a triangle there (m,), mm.
    """
    for _ in range(MOST_HALVINGS):
        places = mesh.vertices[mesh.corners]
        longest = _lengths(places).max(axis=1)
        marked = (longest > size_at(places.mean(axis=1))) | _bent(mesh)
        if not marked.any():
            break
        mesh = _halved(mesh, marked)
    return mesh


def _bent(mesh: Triangles) -> Flags:
    """Triangles that a curved side of the border nearly inverts."""
    nodes, cells, middles = quadratic(mesh)
    on_border = np.zeros(len(nodes), dtype=bool)
    on_border[middles] = True
    outer = np.flatnonzero(on_border[cells[:, 3:]].any(axis=1))
    determinants = jacobians(nodes, "triangle6", cells[outer])
    bent = np.zeros(len(cells), dtype=bool)
    bent[outer] = determinants.min(axis=1) < LEAST_JACOBIAN * determinants.mean(axis=1)
    return bent


def _lengths(places: Floats) -> Floats:
    """Lengths (m, 3) of the sides 0-1, 1-2, 2-0 of triangles with corners (m, 3, 2)."""
    return np.asarray(np.linalg.norm(places - np.roll(places, -1, axis=1), axis=2))


def _halved(mesh: Triangles, marked: Flags) -> Triangles:
    """Bisect marked triangles, and those that must follow."""
    own, ends = sides(mesh.corners)
    longest = _lengths(mesh.vertices[mesh.corners]).argmax(axis=1)
    rows = np.arange(len(own))
    parted = np.zeros(len(ends), dtype=bool)
    parted[own[rows, longest][marked]] = True
    while True:
        follow = parted[own].any(axis=1) & ~parted[own[rows, longest]]
        if not follow.any():
            break
        parted[own[rows, longest][follow]] = True
    count = len(mesh.vertices)
    middles = mesh.vertices[ends].mean(axis=1)
    border_side = find_sides(ends, mesh.border.ends, count)
    middles[border_side] = mesh.border.middles
    new = np.full(len(ends), -1)
    new[parted] = count + np.arange(int(parted.sum()))
    # rotated so that the longest side comes first
    order = (longest[:, None] + np.arange(3)) % 3
    corners = np.take_along_axis(mesh.corners, order, axis=1)
    vertices = np.concatenate([mesh.vertices, middles[parted]])
    return Triangles(
        vertices=vertices,
        corners=_parts(corners, new[np.take_along_axis(own, order, axis=1)]),
        border=_halved_border(mesh, new[border_side]),
        curves=mesh.curves,
    )


def _parts(corners: Numbers, new: Numbers) -> Numbers:
    """Triangles after bisection; `new` (m, 3) are the vertices on their sides, -1 if none."""
    (a, b, c), (p, q, r) = corners.T, new.T
    none, second, third = p < 0, q >= 0, r >= 0
    once = ~none
    parts = [
        np.stack([a, b, c], 1)[none],
        np.stack([p, b, c], 1)[once & ~second],
        np.stack([p, b, q], 1)[once & second],
        np.stack([p, q, c], 1)[once & second],
        np.stack([a, p, c], 1)[once & ~third],
        np.stack([a, p, r], 1)[once & third],
        np.stack([p, c, r], 1)[once & third],
    ]
    return np.concatenate(parts)


def _halved_border(mesh: Triangles, new: Numbers) -> Border:
    """The border with bisected sides; `new` (k,) are the vertices on them, or -1."""
    whole, old, at = mesh.border.at(new < 0), mesh.border.at(new >= 0), new[new >= 0]
    (i, j), m = old.ends.T, old.middles
    a, b = mesh.vertices[i], mesh.vertices[j]
    s_middle = old.s.mean(axis=1)
    # at one and three quarters of the parabola through both ends and the middle
    first = 0.375 * a + 0.75 * m - 0.125 * b
    second = -0.125 * a + 0.75 * m + 0.375 * b
    for k, curve in enumerate(mesh.curves):
        on = old.flank == k
        if on.any():
            first[on] = curve.point(0.5 * (old.s[on, 0] + s_middle[on]))
            second[on] = curve.point(0.5 * (s_middle[on] + old.s[on, 1]))
    ends = [np.stack([i, at], 1), np.stack([at, j], 1)]
    s = [np.stack([old.s[:, 0], s_middle], 1), np.stack([s_middle, old.s[:, 1]], 1)]
    return Border(
        ends=np.concatenate([whole.ends, *ends]),
        middles=np.concatenate([whole.middles, first, second]),
        flank=np.concatenate([whole.flank, old.flank, old.flank]),
        s=np.concatenate([whole.s, *s]),
        held=np.concatenate([whole.held, old.held, old.held]),
    )
