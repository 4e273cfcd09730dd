"""Elements of web and hub behind the rim of a sector."""

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
    mesh: SectorMesh, fixed_radius_mm: float, behind: Sequence[tuple[str, float]], element_mm: float
) -> SectorMesh:
    """Extend a sector, fixed on a circle, by regions up to another one, where it is then fixed.

    `behind`: names of the regions and radii of the circles at which they begin, from that circle
    on, inwards or outwards; `element_mm`: largest length of an element along the flank.
    """
    blocks = BlockMesh([mesh.nodes], [], len(mesh.nodes))
    angle = np.arctan2(*mesh.nodes[mesh.fixed_nodes].T[::-1])
    sense = 1.0 if fixed_radius_mm < behind[0][1] else -1.0
    last = mesh.fixed_nodes[np.argsort(-sense * angle)]  # blocks are right-handed
    directions = mesh.nodes[last] / behind[0][1]
    first_cut, last_cut = [last[:1]], [last[-1:]]
    for start, end in pairwise([radius for _, radius in behind] + [fixed_radius_mm]):
        height, first = sense * (start - end), ROW_AT_JUMP * element_mm
        size = ROW_RATIO * max(start, end)
        if end != fixed_radius_mm or len(behind) == 1:
            rows = symmetric_breaks(height, first, GROWTH, size)
        else:  # no jump of the width at the bore of a hub
            rows = growing_breaks(height, first, GROWTH, np.array([[0.0], [size]]))
        radii = start - sense * with_middles(rows)[::-1] * height
        numbers = blocks.add(radii[:, None, None] * directions, {"top": last})
        last = numbers[0]
        first_cut.append(numbers[-2::-1, 0])
        last_cut.append(numbers[-2::-1, -1])
    right, left = (first_cut, last_cut) if sense > 0.0 else (last_cut, first_cut)
    nodes = blocks.nodes
    return replace(
        mesh,
        nodes=nodes,
        cells=(*mesh.cells, *(("quad9", cells) for cells in blocks.cells)),
        flank_arc_length=np.append(
            mesh.flank_arc_length, np.full(len(nodes) - len(mesh.nodes), np.nan)
        ),
        fixed_nodes=np.unique(last),
        left_nodes=np.concatenate([mesh.left_nodes, *left])[:-1],
        right_nodes=np.concatenate([mesh.right_nodes, *right])[:-1],
        regions=("",) * len(mesh.cells) + tuple(name for name, _ in behind),
    )
