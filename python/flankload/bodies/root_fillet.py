"""Points on the root fillets for tooth root stress, and the stress from nodal displacements.

The stress of a free surface is tangential and follows from the tangential strain,

    sigma = E/(1 - nu²) t·du/ds   (plane strain; E t·du/ds in plane stress),

with the unit tangent t. The points are the two Gauss points of each element edge, where the strain
of quadratic elements is most accurate. The local stress under a force on the fillet is not
included.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flankload.base.rotation import turned
from flankload.bodies.body import WholeMesh
from flankload.errors import SceneError
from flankload.meshes.plane_mesh import boundary_edges
from flankload.scene.refusal import refuse

if TYPE_CHECKING:
    from flankload.base.arrays import Flags, Floats, Numbers
    from flankload.bodies.body import Body, SectorMesh
    from flankload.flank import FlankCurve


#: Key of the scene that requests the tooth root stress.
SCENE_KEY = "effects.root_stress"
#: Largest distance of mesh edges from the fillet, over their length: twice that of the middle of a
#: chord over 25 degrees, the largest turn of one element.
FILLET_TOLERANCE = 0.06
#: Least part of the fillet's length that mesh edges cover.
LEAST_COVERAGE = 0.98
#: Gauss points of an edge on [-1, 1].
GAUSS_POINTS = (-(3.0**-0.5), 3.0**-0.5)


@dataclass(frozen=True, eq=False)
class RootPoints:
    """Points on both root fillets of a tooth: q points, those of the working side first.

    Attributes
    ----------
    arc_length_mm : (q,) array
        Along the profile from the root circle, ascending on each side.
    radius_mm : (q,) array
    angle_rad : (q,) array
        Polar angle from the tooth's centre line, positive on the working side of an external
        tooth.
    slant_rad : (q,) array
        Angle of the fillet's tangent to the tooth's centre line.
    working : (q,) array of bool
        Points on the side of the working flank.
    """

    arc_length_mm: Floats
    radius_mm: Floats
    angle_rad: Floats
    slant_rad: Floats
    working: Flags


@dataclass(frozen=True, eq=False)
class FilletNodes:
    """Nodes of both fillets of a tooth, and their shape functions at its stress points.

    Attributes
    ----------
    nodes : (m,) array
    shapes, slopes : (m, q) arrays
        Shape function of each node at each point, and its tangential derivative, 1/mm.
    places, tangents : (q, 2) arrays
        Points in the frame of the mesh, mm, and unit tangents there.
    """

    nodes: Numbers
    shapes: Floats
    slopes: Floats
    places: Floats
    tangents: Floats


@dataclass(frozen=True, eq=False)
class RootFillets:
    """Linear map from nodal displacements to the strains of a body's fillets.

    Attributes
    ----------
    points : RootPoints
        Points of each tooth.
    degrees, strains : tuples of (m,) and (m, q) arrays
        By flank of the mesh (one for a sector): degrees of freedom of the fillets' nodes, and the
        matrix from their displacements to tangential strains.
    on_elements : FilletNodes
        Nodes of the first flank.
    """

    points: RootPoints
    degrees: tuple[Numbers, ...]
    strains: tuple[Floats, ...]
    on_elements: FilletNodes

    def columns(self, flank: int, size: int) -> Floats:
        """Strain columns (size, q) of a flank of the mesh over all degrees of freedom."""
        spread = np.zeros((size, self.strains[flank].shape[1]))
        spread[self.degrees[flank]] = self.strains[flank]
        return spread


def root_fillets(body: Body, key: str) -> RootFillets:
    """Find both fillets of every tooth with a flank in the mesh of a body.

    `key` is "body_1" or "body_2", for messages.

    Raises
    ------
    SceneError
        If the profile of the body is unknown, or its mesh does not contain both fillets of a tooth.
    """
    mesh = body.mesh
    if mesh is None or body.involute is None or "fillet" not in body.curve.labels:
        found = f"{key}.kind = {body.kind!r}"
        if body.kind == "mesh":
            found += " without a profile"
        raise SceneError(
            key=SCENE_KEY,
            expected="bodies with finite elements and a known root fillet "
            "(gear, ring, splines, mesh with profile)",
            found=found,
        )
    turns = [0.0]
    if isinstance(mesh, WholeMesh):
        own = body.flank_turns_rad or (0.0,) * body.teeth
        turns = [2 * np.pi * flank.tooth / body.teeth + own[flank.tooth] for flank in mesh.flanks]
    center = body.involute.turn_rad + body.involute.tooth_center_rad
    teeth = [_both_sides(mesh, body.curve, turn, center, key) for turn in turns]
    points, degrees, strains = teeth[0][0], [], []
    for places, columns, _ in teeth:
        used = np.flatnonzero(columns.any(axis=1))
        degrees.append(used)
        strains.append(_at_places(points, places, columns[used]))
    return RootFillets(points, tuple(degrees), tuple(strains), _on_elements(mesh, teeth[0][2]))


def _both_sides(
    mesh: SectorMesh | WholeMesh, curve: FlankCurve, turn: float, center: float, key: str
) -> tuple[RootPoints, Floats, Numbers]:
    """Gauss points of both fillets of the tooth at the angle `turn`, their strains and edges."""
    edges = boundary_edges(mesh.cells)
    fillet = curve.cut(0.0, curve.range_of("fillet")[1])
    own = turned(mesh.nodes, -turn)
    # the other side of the tooth is the working side of the mirrored tooth
    images = (own, turned(turned(own, -center) * [1.0, -1.0], center))
    parts = []
    for image in images:
        on = _edges_on_fillet(image, edges, fillet, key)
        places, strains = edge_strains(mesh.nodes, image, edges[on])
        s = curve.arc_length_of(places)[0]
        order = np.argsort(s)
        # edge of each point, and number of the point on its edge
        number = np.column_stack([np.repeat(edges[on], 2, axis=0), np.tile([0, 1], on.size)])
        parts.append((s[order], strains[:, order], number[order]))
    s = np.concatenate([part[0] for part in parts])
    working = np.arange(s.size) < parts[0][0].size
    place = turned(curve.point(s), -center)
    along = turned(curve.tangent(s), -center)
    angle = np.arctan2(place[:, 1], place[:, 0])
    points = RootPoints(
        arc_length_mm=s,
        radius_mm=np.hypot(*place.T),
        angle_rad=np.where(working, angle, -angle),
        slant_rad=np.arctan2(np.abs(along[:, 1]), np.abs(along[:, 0])),
        working=working,
    )
    strains, numbers = (np.concatenate([part[k] for part in parts], axis=k % 2) for k in (1, 2))
    return points, strains, numbers


def _on_elements(mesh: SectorMesh | WholeMesh, numbers: Numbers) -> FilletNodes:
    """Shape functions at points, by their edge and the number of the point on it (q, 4)."""
    edges, which = numbers[:, :3], numbers[:, 3]
    shape, slope = (part[which] for part in _line_shapes(np.array(GAUSS_POINTS)))
    nodes, column = np.unique(edges, return_inverse=True)
    column = column.reshape(edges.shape)
    along = np.einsum("qk,qkd->qd", slope, mesh.nodes[edges])
    length = np.linalg.norm(along, axis=1, keepdims=True)
    shapes, slopes = np.zeros((2, nodes.size, len(edges)))
    point = np.arange(len(edges))[:, None]
    shapes[column, point], slopes[column, point] = shape, slope / length
    places = np.einsum("qk,qkd->qd", shape, mesh.nodes[edges])
    return FilletNodes(nodes, shapes, slopes, places, along / length)


def _line_shapes(x: Floats) -> tuple[Floats, Floats]:
    """Shape functions (n, 3) of first, last and middle node on [-1, 1], and their derivatives."""
    values = np.stack([0.5 * x * (x - 1), 0.5 * x * (x + 1), 1 - x**2], axis=-1)
    return values, np.stack([x - 0.5, x + 0.5, -2 * x], axis=-1)


def _edges_on_fillet(nodes: Floats, edges: Numbers, fillet: FlankCurve, key: str) -> Numbers:
    """Edges on the fillet, whose end is the beginning of the flank."""
    form = fillet.length_mm
    middle = fillet.point([0.0, form]).mean(axis=0)
    length = np.linalg.norm(nodes[edges[:, 1]] - nodes[edges[:, 0]], axis=1)
    # a point of a curve is at most half of its length from the middle between its ends
    reach = 0.5 * form + FILLET_TOLERANCE * length
    candidates = np.flatnonzero(np.linalg.norm(nodes[edges[:, 2]] - middle, axis=1) < reach)
    length = length[candidates]
    s, away = fillet.arc_length_of(nodes[edges[candidates]].reshape(-1, 2))
    s, away = s.reshape(-1, 3), away.reshape(-1, 3)
    lies = (away < FILLET_TOLERANCE * length[:, None]).all(axis=1) & (s[:, 2] < form)
    covered = float(np.ptp(s[lies][:, :2], axis=1).sum())
    if not abs(covered / form - 1) <= 1 - LEAST_COVERAGE:
        expected = f"a mesh of {key} that holds both root fillets of a tooth in one piece"
        refuse(SCENE_KEY, expected, f"edges along {100 * covered / form:.0f} % of a fillet")
    return candidates[lies]


def edge_strains(nodes: Floats, image: Floats, edges: Numbers) -> tuple[Floats, Floats]:
    """Strain along edges (m, 3) at their Gauss points.

    `image`: the same nodes (N, 2), rotated or mirrored. Returns the Gauss points (2 m, 2) in the
    frame of `image`, and the matrix (2N, 2 m) of t·du/ds for displacements 2*node + component.
    """
    places, strains = [], np.zeros((len(nodes), 2, 2 * len(edges)))
    for g, x in enumerate(GAUSS_POINTS):
        shape, slope = (part[0] for part in _line_shapes(np.array([x])))
        tangent = np.einsum("k,mkd->md", slope, nodes[edges])
        squared = (tangent**2).sum(axis=1)
        columns = g + 2 * np.arange(len(edges))
        for k in range(3):
            strains[edges[:, k], :, columns] += slope[k] * tangent / squared[:, None]
        places.append(np.einsum("k,mkd->md", shape, image[edges]))
    return np.stack(places, axis=1).reshape(-1, 2), strains.reshape(2 * len(nodes), -1)


def _at_places(wanted: RootPoints, found: RootPoints, rows: Floats) -> Floats:
    """Columns of a tooth, interpolated from its Gauss points to the points of the first tooth."""
    if np.array_equal(wanted.arc_length_mm, found.arc_length_mm):
        return rows
    columns = []
    for side in (True, False):
        own = np.flatnonzero(found.working == side)
        s = found.arc_length_mm[own]
        places = wanted.arc_length_mm[wanted.working == side]
        k = np.clip(np.searchsorted(s, places), 1, s.size - 1)
        part = np.clip((places - s[k - 1]) / (s[k] - s[k - 1]), 0.0, 1.0)
        columns.append((1 - part) * rows[:, own[k - 1]] + part * rows[:, own[k]])
    return np.concatenate(columns, axis=1)
