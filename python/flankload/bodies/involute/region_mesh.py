"""Elements of web and hub below the rim of a gear's sector."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from flankload.bodies.involute.sector_breaks import ROW_RATIO
from flankload.meshes.blocks import BlockMesh, growing_breaks, symmetric_breaks, with_middles

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flankload.bodies.body import SectorMesh


#: First row at a circle where the width changes, over the flank element, and largest ratio of
#: neighbouring rows. With 1/4 and 1.4, the compliance of a wheel of 24 teeth with a web of 0.3 of
#: the width changes by 0.01 % (mean) and 0.1 % (linear along the axis).
ROW_AT_JUMP, GROWTH = 1.0, 2.0


def with_regions(
    mesh: SectorMesh, bore_radius_mm: float, below: Sequence[tuple[str, float]], element_mm: float
) -> SectorMesh:
    """Extend a sector, fixed on its inner circle, by regions down to the bore, where it is fixed.

    `below`: names and outer radii of the regions, outermost first, beginning with that circle;
    `element_mm`: largest length of an element along the flank.
    """
    blocks = BlockMesh([mesh.nodes], [], len(mesh.nodes))
    angle = np.arctan2(*mesh.nodes[mesh.fixed_nodes].T[::-1])
    lowest = mesh.fixed_nodes[np.argsort(-angle)]  # blocks are right-handed
    directions = mesh.nodes[lowest] / below[0][1]
    left, right = [mesh.left_nodes, lowest[-1:]], [mesh.right_nodes, lowest[:1]]
    for outer, inner in pairwise([radius for _, radius in below] + [bore_radius_mm]):
        height, first, size = outer - inner, ROW_AT_JUMP * element_mm, ROW_RATIO * outer
        if inner > bore_radius_mm or len(below) == 1:
            rows = symmetric_breaks(height, first, GROWTH, size)
        else:  # no jump of the width at the bore of a hub
            rows = growing_breaks(height, first, GROWTH, np.array([[0.0], [size]]))
        radii = outer - with_middles(rows)[::-1] * height
        numbers = blocks.add(radii[:, None, None] * directions, {"top": lowest})
        lowest = numbers[0]
        left.append(numbers[-2::-1, -1])
        right.append(numbers[-2::-1, 0])
    nodes = blocks.nodes
    return replace(
        mesh,
        nodes=nodes,
        cells=(*mesh.cells, *(("quad9", cells) for cells in blocks.cells)),
        flank_arc_length=np.append(
            mesh.flank_arc_length, np.full(len(nodes) - len(mesh.nodes), np.nan)
        ),
        fixed_nodes=np.unique(lowest),
        left_nodes=np.concatenate(left)[:-1],
        right_nodes=np.concatenate(right)[:-1],
        regions=("",) * len(mesh.cells) + tuple(name for name, _ in below),
    )
