"""Mirror symmetry of a sector: the second half is not eliminated.

A reflection about the axis of symmetry, with twist a rotation by 180 degrees about it, maps the
elements of the first half to those of the second. The remainder of the second half is that of the
first in reflected unknowns; loads on it are loads on the first half, reflected.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flankload.base.rotation import directions

if TYPE_CHECKING:
    from flankload.base.arrays import Flags, Floats, Numbers
    from flankload.bodies.body import SectorMesh

#: Largest distance between a node and the image of another one, over the size of the mesh: the
#: rounding errors of a mesher, which are those of the elimination.
TOLERANCE = 1e-12
#: Factor of the distance from the axis in the sum that pairs nodes: no simple fraction.
SKEW = 0.6180339887498949


def axis_of(mesh: SectorMesh) -> float:
    """Polar angle of the middle between the cuts of a sector, rad."""
    cuts = np.concatenate([mesh.left_nodes, mesh.right_nodes])
    return float(np.arctan2(*mesh.nodes[cuts].sum(axis=0)[::-1]))


def images_of(mesh: SectorMesh, inner: Flags) -> Numbers | None:
    """Images (N,) in the second half of the nodes of the first half.

    A node on the axis is its own image; -1 for nodes of the second half. None for a sector that is
    not symmetric with its `inner` nodes, or has elements across its axis.
    """
    turn = axis_of(mesh)
    along, apart = (mesh.nodes @ part for part in directions(np.array([turn, turn + 0.5 * np.pi])))
    tolerance = TOLERANCE * float(np.abs(mesh.nodes).max())
    first, second = np.flatnonzero(apart > tolerance), np.flatnonzero(apart < -tolerance)
    if first.size != second.size:
        return None
    place = along + SKEW * np.abs(apart)
    first, second = (part[np.argsort(place[part])] for part in (first, second))
    offset = np.abs([along[first] - along[second], apart[first] + apart[second]])
    if offset.max(initial=0.0) > tolerance:
        return None
    images = np.arange(len(mesh.nodes))
    images[first], images[second] = second, first
    if (images[mesh.left_nodes] != mesh.right_nodes).any() or (inner[images] != inner).any():
        return None
    for _, cells in mesh.cells:
        sides = apart[cells]
        both = np.concatenate([np.sort(cells), np.sort(images[cells])])
        if ((sides.max(axis=1) > tolerance) & (sides.min(axis=1) < -tolerance)).any():
            return None
        if len(np.unique(both, axis=0)) > len(cells):
            return None
    images[second] = -1
    return images


def reflection(mesh: SectorMesh, functions: int, components: int, *, twisted: bool) -> Floats:
    """Reflection (u, u) of the unknowns of a node, by axial function, then component.

    With twist, odd functions of z and axial displacements change their signs.
    """
    turn, sign = 2.0 * axis_of(mesh), -1.0 if twisted else 1.0
    cosine, sine = np.cos(turn), np.sin(turn)
    sine = 0.0 if abs(sine) < TOLERANCE else sine
    of_node = np.array([[cosine, sine, 0.0], [sine, -cosine, 0.0], [0.0, 0.0, sign]])
    signs = np.diag(sign ** np.arange(functions))
    return np.asarray(np.kron(signs, of_node[:components, :components]), dtype=float)


def line_of(
    mesh: SectorMesh, functions: int, components: int, *, twisted: bool
) -> tuple[float, Floats]:
    """Polar angle of the left cut of a symmetric sector, and signs of `CondensedSector.line`."""
    turn = float(np.arctan2(*mesh.nodes[mesh.left_nodes].sum(axis=0)[::-1]))
    sign = -1.0 if twisted else 1.0
    return turn, np.kron(sign ** np.arange(functions), np.array([1.0, -1.0, sign])[:components])
