"""A body from the mesh of one sector, whose two cut faces are matched node by node."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flankload.bodies.body import SectorMesh
from flankload.bodies.imported.mesh_flank import in_order
from flankload.bodies.plane import turned
from flankload.meshes.plane_mesh import boundary_edges, chain

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from flankload.bodies.imported.mesh_curve import FlankFit
    from flankload.bodies.imported.mesh_source import MeshSource
    from flankload.meshes.plane_mesh import Cells
    from flankload.scene import MeshBody

    Floats = NDArray[np.float64]
    Numbers = NDArray[np.int64]

#: Largest distance of matching nodes of the cuts, relative to the size of the body.
CUT_TOLERANCE = 1e-6


def sector_of(
    source: MeshSource,
    spec: MeshBody,
    nodes: Floats,
    cells: Cells,
    flank: Numbers,
    fixed: Numbers,
    fit: FlankFit,
) -> tuple[SectorMesh, Floats]:
    """Sector mesh and its outer contour from cut to cut.

    Parameters
    ----------
    source : MeshSource
    spec : MeshBody
    nodes, cells
        Mesh of the body, mirrored if necessary.
    flank : (m, 3) array
        Edges of the flank in order.
    fixed : array
        Fixed nodes.
    fit : FlankFit

    Returns
    -------
    mesh : SectorMesh
    outline : (k, 2) array

    Raises
    ------
    MeshError
        If the cut faces do not match or touch the flank.
    """
    teeth = spec.number_of_teeth
    cuts = [np.setdiff1d(source.nodes_of("cut_sets", name), fixed) for name in spec.cut_sets]
    left, right = _match_cuts(source, nodes, cuts, teeth)
    for side in (left, right):
        if np.isin(flank, side).any():
            expected = "a flank that stays clear of the cut faces"
            source.refuse("flank_set", expected, "nodes that belong to both")
    arc_length = np.full(len(nodes), np.nan)
    arc_length[in_order(fit.edges)] = fit.s
    mesh = SectorMesh(
        nodes=nodes,
        cells=cells,
        flank_edges=fit.edges,
        flank_arc_length=arc_length,
        fixed_nodes=fixed,
        left_nodes=left,
        right_nodes=right,
        teeth=teeth,
    )
    return mesh, _outline(nodes, cells, left, right, fixed)


def _outline(nodes: Floats, cells: Cells, left: Numbers, right: Numbers, fixed: Numbers) -> Floats:
    edges = boundary_edges(cells)
    inner = [np.union1d(side, fixed) for side in (left, right)] + [fixed]
    outer = ~np.any([np.isin(edges, members).all(axis=1) for members in inner], axis=0)
    if not outer.any():
        return nodes[in_order(edges)]
    return np.asarray(nodes[in_order(max(chain(edges[outer]), key=len))])


def _match_cuts(
    source: MeshSource, nodes: Floats, cuts: list[Numbers], teeth: int
) -> tuple[Numbers, Numbers]:
    """Nodes of the left and right cut in matching order: right = left rotated by one pitch."""
    first, second = cuts
    size = float(np.abs(nodes).max())
    if first.size != second.size or not first.size:
        expected = "cut faces with the same number of nodes"
        source.refuse("cut_sets", expected, f"{first.size} and {second.size}")
    pitch = 2 * np.pi / teeth
    best = np.inf
    for left, right in ((first, second), (second, first)):
        distance = np.linalg.norm(turned(nodes[left], pitch)[:, None] - nodes[right][None], axis=2)
        nearest = distance.argmin(axis=1)
        worst = float(distance.min(axis=1).max())
        best = min(best, worst)
        if worst <= CUT_TOLERANCE * size and np.unique(nearest).size == left.size:
            return left, right[nearest]
    return source.refuse(
        "cut_sets",
        f"cut faces that match when turned by 360/{teeth} deg (to {CUT_TOLERANCE * size:.1g} mm)",
        f"nodes up to {best:.3g} mm apart",
    )
