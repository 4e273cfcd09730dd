"""Sector mesh of a body from a file: matching nodes of its cut faces, elements by region."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from flankload.base.rotation import turned
from flankload.bodies.body import SectorMesh
from flankload.bodies.imported.mesh_source import in_order
from flankload.meshes.plane_mesh import boundary_edges, chain

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flankload.base.arrays import Floats, Numbers
    from flankload.bodies.imported.mesh_curve import FlankFit
    from flankload.bodies.imported.mesh_source import MeshSource


#: Largest distance of matching nodes of the cuts, relative to the size of the body.
CUT_TOLERANCE = 1e-6


def sector_of(
    source: MeshSource, flank: Numbers, fixed: Numbers, fit: FlankFit
) -> tuple[SectorMesh, Floats]:
    """Sector mesh with its regions, and its outer contour (k, 2) from cut to cut.

    Raises
    ------
    MeshError
        If the cut faces do not match or touch the flank, or a region is faulty.
    """
    spec, nodes, cells = source.spec, source.body.nodes, source.body.cells
    cuts = [np.setdiff1d(source.nodes_of("cut_sets", name), fixed) for name in spec.cut_sets]
    left, right = _match_cuts(source, cuts)
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
        teeth=spec.number_of_teeth,
    )
    return _with_regions(source, mesh), _outline(mesh)


def _outline(mesh: SectorMesh) -> Floats:
    nodes, edges, fixed = mesh.nodes, boundary_edges(mesh.cells), mesh.fixed_nodes
    inner = [np.union1d(side, fixed) for side in (mesh.left_nodes, mesh.right_nodes)] + [fixed]
    outer = ~np.any([np.isin(edges, members).all(axis=1) for members in inner], axis=0)
    if not outer.any():
        return nodes[in_order(edges)]
    return np.asarray(nodes[in_order(max(chain(edges[outer]), key=len))])


def _match_cuts(source: MeshSource, cuts: list[Numbers]) -> tuple[Numbers, Numbers]:
    """Nodes of the left and right cut; right node k is left node k rotated by one pitch."""
    nodes, teeth = source.body.nodes, source.spec.number_of_teeth
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


def _with_regions(source: MeshSource, mesh: SectorMesh) -> SectorMesh:
    """The sector with its elements by region: that set of `region_sets` with all their nodes."""
    spec = source.spec
    if spec.region_sets is None:
        return mesh
    of_elements = [np.full(len(data), -1) for _, data in mesh.cells]
    for number, name in enumerate(spec.region_sets):
        key, count = f"region_sets[{number}]", 0
        inside = np.zeros(len(mesh.nodes), dtype=bool)
        inside[source.nodes_of(key, name)] = True
        inside[len(source.raw.nodes) :] = True  # nodes that are not in the file
        for found, (_, data) in zip(of_elements, mesh.cells, strict=True):
            named = inside[data].all(axis=1)
            count += int(named.sum())
            if (found[named] >= 0).any():
                other = spec.region_sets[found[named].max()]
                source.refuse(key, f"elements that are not in {other!r}", f"{name!r} has some")
            found[named] = number
        if not count:
            source.refuse(key, "a set of elements", f"none in {name!r}")
    _check_flank(source, spec.region_sets, mesh, of_elements)
    cells, regions = [], []
    for number in range(-1, len(spec.region_sets)):
        for found, (kind, data) in zip(of_elements, mesh.cells, strict=True):
            if (found == number).any():
                cells.append((kind, data[found == number]))
                regions.append("" if number < 0 else spec.region_sets[number])
    return replace(mesh, cells=tuple(cells), regions=tuple(regions))


def _check_flank(
    source: MeshSource, names: Sequence[str], mesh: SectorMesh, of_elements: list[Numbers]
) -> None:
    """Refuse a region with elements of the flank, which are as wide as the teeth."""
    flank = np.append(mesh.flank_edges, mesh.tip_edges)
    for found, (_, data) in zip(of_elements, mesh.cells, strict=True):
        touched = (found >= 0) & np.isin(data, flank).any(axis=1)
        if touched.any():
            number = int(found[touched].min())
            source.refuse(
                f"region_sets[{number}]",
                "a region without nodes of the flank, which is as wide as the teeth",
                f"{touched.sum()} elements of {names[number]!r} on it",
            )
