"""Local refinement of triangles by bisection of their longest sides.

Bisection extends to the neighbours until no vertex lies in the middle of a side; angles stay above
half the smallest initial angle (Rivara). New vertices of a flank lie on its curve.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flankload.meshes.plane_mesh import jacobians
from flankload.studies.verification.triangles import Border, Triangles, find_sides, quadratic, sides

if TYPE_CHECKING:
    from collections.abc import Callable

    from flankload.base.arrays import Flags, Floats, Numbers

#: Largest number of bisections of a triangle: from a body's size to a ten-thousandth of it.
MOST_HALVINGS = 60
#: Least Jacobian of a triangle relative to its mean; a straight triangle has 1.
LEAST_JACOBIAN = 0.4


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
    old = mesh.border
    keep, part = new < 0, new >= 0
    ends, s = old.ends[part], old.s[part]
    at = new[part]
    a, b, m = mesh.vertices[ends[:, 0]], mesh.vertices[ends[:, 1]], old.middles[part]
    s_middle = s.mean(axis=1)
    # at one and three quarters of the parabola through both ends and the middle
    first = 0.375 * a + 0.75 * m - 0.125 * b
    second = -0.125 * a + 0.75 * m + 0.375 * b
    flank = old.flank[part]
    for k, curve in enumerate(mesh.curves):
        on = flank == k
        if on.any():
            first[on] = curve.point(0.5 * (s[on, 0] + s_middle[on]))
            second[on] = curve.point(0.5 * (s_middle[on] + s[on, 1]))
    return Border(
        ends=np.concatenate(
            [old.ends[keep], np.stack([ends[:, 0], at], 1), np.stack([at, ends[:, 1]], 1)]
        ),
        middles=np.concatenate([old.middles[keep], first, second]),
        flank=np.concatenate([old.flank[keep], flank, flank]),
        s=np.concatenate(
            [old.s[keep], np.stack([s[:, 0], s_middle], 1), np.stack([s_middle, s[:, 1]], 1)]
        ),
        held=np.concatenate([old.held[keep], old.held[part], old.held[part]]),
    )
