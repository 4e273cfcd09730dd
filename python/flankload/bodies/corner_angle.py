"""Interior angle of the metal at a node of a mesh."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from flankload.base.arrays import Cells, Floats

#: Interior angle of a smooth surface, degrees.
STRAIGHT_ANGLE = 180.0


def angle_at(nodes: Floats, cells: Cells, node: int) -> float:
    """Interior angle of all elements at a corner node, degrees."""
    whole = 0.0
    for kind, data in cells:
        corners = 3 if kind.startswith("triangle") else 4
        cell, at = np.nonzero(data[:, :corners] == node)
        before, behind = (at - 1) % corners, (at + 1) % corners
        # an edge leaves its end in the direction 4 middle - 3 here - other end
        one, two = (
            4 * nodes[data[cell, corners + edge]] - 3 * nodes[node] - nodes[data[cell, end]]
            for edge, end in ((at, behind), (before, before))
        )
        cross = one[:, 0] * two[:, 1] - one[:, 1] * two[:, 0]
        whole += float(np.abs(np.arctan2(cross, np.sum(one * two, axis=1))).sum())
    return float(np.degrees(whole))
