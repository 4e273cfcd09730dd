"""Columns of nodal forces on a timing belt: linear shape functions on its flanks and lands.

A shape function is 1 at an end of an element's edge and decreases to 0 at its neighbours. It
distributes forces over the elements, and displacements are averaged with the same function.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from flankload.base.gauss import leggauss
from flankload.base.rotation import turned
from flankload.elasticity.finite_elements import degrees_of
from flankload.elasticity.nodal_loads import linear_shapes

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flankload.base.arrays import Floats, Numbers
    from flankload.mechanisms.belt.belt import Strip
    from flankload.mechanisms.belt.belt_mesh import BeltMesh

#: Roundoff of moments, relative to the moment of a shape function with itself.
NO_MOMENT = 1e-12
#: Gauss points between two breaks; the integrands are cubic, on round flanks approximately.
GAUSS_POINTS = 4


@dataclass(frozen=True)
class Flanks:
    """Contact pairs on the working flanks; n pairs.

    Attributes
    ----------
    tooth : (n,) array
        Tooth of each pair, counted from the tight end.
    places, normals : (n, 2) arrays
        Relative to the axis of the pulley, mm; normals point out of the belt.
    levers_mm : (n,) array
        Moment about the axis of a unit force of the pulley on the belt.
    gaps_mm : (n,) array
        Gaps to the groove, along the normals.
    lengths_mm : (n,) array
        Flank length represented by each pair.
    lines : tuple of (2 c - 1, 2) arrays
        Places of the nodes of each flank with c pairs, from the land to the tip, mm.
    """

    tooth: Numbers
    places: Floats
    normals: Floats
    levers_mm: Floats
    gaps_mm: Floats
    lengths_mm: Floats
    lines: tuple[Floats, ...]

    @classmethod
    def joined(cls, parts: Sequence[Flanks]) -> Flanks:
        """All flanks of consecutive pieces."""
        names = [name for name in cls.__dataclass_fields__ if name != "lines"]
        return cls(
            **{name: np.concatenate([getattr(part, name) for part in parts]) for name in names},
            lines=tuple(line for part in parts for line in part.lines),
        )

    def turned(self, angle_rad: float) -> Flanks:
        """The same flanks, turned about the axis."""
        return replace(
            self,
            places=turned(self.places, angle_rad),
            normals=turned(self.normals, angle_rad),
            lines=tuple(turned(line, angle_rad) for line in self.lines),
        )


def flank_columns(strip: Strip, mesh: BeltMesh) -> tuple[Flanks, Floats]:
    """Contact pairs on all working flanks, and their nodal loads (2N, n).

    A column has the forces in x and y of a unit force of the pulley on a pair.
    """
    none, nowhere = np.zeros(0), np.zeros((0, 2))
    parts = [Flanks(none.astype(np.int64), nowhere, nowhere, none, none, none, ())]
    columns = [np.zeros((2 * len(mesh.nodes), 0))]
    for tooth, nodes in sorted(mesh.flanks.items()):
        angle = strip.pitch_rad * (tooth + 0.5)
        places = mesh.nodes[nodes]
        shapes, linear, along = _on_edges(places)
        size = np.linalg.norm(along, axis=1)
        out = np.column_stack([-along[:, 1], along[:, 0]])
        at = shapes @ places
        length = linear.T @ size
        lever = -(linear.T @ (at[:, 0] * out[:, 1] - at[:, 1] * out[:, 0])) / length
        gap = (linear.T @ (size * strip.gaps(strip.in_tooth(at, angle)))) / length
        middle = (linear.T @ (size[:, None] * at)) / length[:, None]
        normal = linear.T @ out
        normal = normal / np.linalg.norm(normal, axis=1)[:, None]
        teeth = np.full(length.size, tooth)
        parts.append(Flanks(teeth, middle, normal, lever, gap, length, (places,)))
        own = -np.einsum("gq,gh,gd->qdh", shapes, linear, out) / length
        columns.append(_at_nodes(own.reshape(-1, length.size), degrees_of(nodes), mesh))
    return Flanks.joined(parts), np.hstack(columns)


@dataclass(frozen=True)
class Lands:
    """Shape functions on all lands: h functions, N nodes; radial and circumferential components.

    Attributes
    ----------
    number : (h,) array
        Land of each shape function.
    angle_rad : (h,) array
        Angle of the end node of each shape function.
    degrees : (h,) array
        Degrees of freedom replaced by the displacements of the shape functions.
    moved : (h, 2N) array
        Nodal displacements of these degrees of freedom from the other ones and from these
        displacements.
    forces : (2N, h) array
        Nodal loads of a unit circumferential force on each shape function.
    """

    number: Numbers
    angle_rad: Floats
    degrees: Numbers
    moved: Floats
    forces: Floats

    def transform(self, columns: Floats) -> None:
        """Change nodal forces (2N, n) to forces on the degrees of freedom with these, in place."""
        touched = np.flatnonzero(self.moved.any(axis=0))
        replaced = columns[self.degrees]
        columns[self.degrees] = 0.0
        columns[touched] += self.moved[:, touched].T @ replaced


def land_columns(mesh: BeltMesh) -> Lands:
    """Shape functions on all lands, and the radial displacements of lands in terms of them.

    The radial displacement of a land is the linear function whose moments with all shape functions
    equal those of the nodal displacements u, ∫ h u = ∫ h w. Pressures that the shape functions can
    represent fix such a land; no node is fixed individually. The quadratic functions at the ends
    of an edge have a moment with one shape function only, so w replaces the displacements there.
    """
    size = 2 * len(mesh.nodes)
    numbers, degrees = [np.zeros(0, dtype=np.int64)], [np.zeros(0, dtype=np.int64)]
    moved, forces = [np.zeros((0, size))], [np.zeros((size, 0))]
    for number, nodes in sorted(mesh.lands.items()):
        shapes, linear, along = _on_edges(mesh.nodes[nodes])
        weighted = np.linalg.norm(along, axis=1)[:, None] * linear
        moments = weighted.T @ shapes
        own = moments[:, ::2].diagonal()[:, None]
        ends, middles = 2 * nodes[::2], 2 * nodes[1::2]
        part = np.zeros((ends.size, size))
        for values, columns in ((weighted.T @ linear, ends), (-moments[:, 1::2], middles)):
            part[:, columns] = np.where(np.abs(values) > NO_MOMENT * own, values / own, 0.0)
        numbers.append(np.full(ends.size, number))
        degrees.append(ends)
        moved.append(part)
        forces.append(_at_nodes(moments.T / weighted.sum(axis=0), 2 * nodes + 1, mesh))
    replaced = np.concatenate(degrees)
    return Lands(
        np.concatenate(numbers),
        mesh.turns_rad[replaced // 2],
        replaced,
        np.concatenate(moved),
        np.hstack(forces),
    )


def _at_nodes(values: Floats, degrees: Numbers, mesh: BeltMesh) -> Floats:
    """Columns (2N, k) with these values at these degrees of freedom, and zeros elsewhere."""
    found = np.zeros((2 * len(mesh.nodes), values.shape[1]))
    found[degrees] = values
    return found


def _on_edges(places: Floats) -> tuple[Floats, Floats, Floats]:
    """Shape functions at the Gauss points of a line of quadratic edges with nodes (m, 2).

    Returns the quadratic functions (g, m) of the nodes, the linear ones (g, (m + 1)/2) of the ends
    of the edges, and tangents (g, 2) times the weight of the point and the length of the edge, mm.
    """
    line = np.arange(len(places), dtype=np.float64)
    at, weight = gauss_points(line[::2])
    shapes, slopes = quadratic(at, line)
    return shapes, linear_shapes(at, line[::2]), weight[:, None] * (slopes @ places)


def gauss_points(breaks: Floats) -> tuple[Floats, Floats]:
    """(g,) Gauss points between successive breaks, and their weights."""
    points, weights = leggauss(GAUSS_POINTS)
    steps = 0.5 * np.diff(breaks)[:, None]
    return (breaks[:-1, None] + steps * (1.0 + points)).ravel(), (steps * weights).ravel()


def quadratic(at: Floats, nodes: Floats) -> tuple[Floats, Floats]:
    """(g, m) Functions of quadratic elements at places `at` (g,), and their derivatives.

    Every second one of the nodes (m,) is a mid-side node.
    """
    ends = nodes[::2]
    element = np.clip(np.searchsorted(ends, at, side="right") - 1, 0, ends.size - 2)
    half = 0.5 * (ends[element + 1] - ends[element])
    x = (at - ends[element]) / half - 1.0
    shapes, slopes = np.zeros((2, at.size, nodes.size))
    rows = np.arange(at.size)
    for k, value in enumerate((x * (x - 1) / 2, 1 - x**2, x * (x + 1) / 2)):
        shapes[rows, 2 * element + k] = value
    for k, slope in enumerate((x - 0.5, -2 * x, x + 0.5)):
        slopes[rows, 2 * element + k] = slope / half
    return shapes, slopes
