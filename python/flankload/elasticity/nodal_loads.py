"""Unit forces at the nodes of a flank, and tables between them: the near field of the paper.

The nodes are the ends of the edges. The force of a node is distributed by its linear shape
function, and displacements are averaged with the same weights, so that tables between nodes are
symmetric. Tables are interpolated linearly, Eqs. (21) and (22).
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

import numpy as np

from flankload.bodies.body import MeshedFlank, WholeMesh
from flankload.elasticity.near_field import consistent_loads, loaded_edges

if TYPE_CHECKING:
    from flankload.base.arrays import Floats
    from flankload.bodies.body import SectorMesh


def flank_nodes(flank: SectorMesh | MeshedFlank) -> Floats:
    """Arc lengths (n,) of the ends of a flank's edges, ascending, mm."""
    _, s = loaded_edges(flank)
    return np.append(s[:, 0], s[-1, 1])


def nodes_of(mesh: SectorMesh | WholeMesh) -> Floats:
    """Arc lengths of the nodes of the first flank, which all flanks of a body share."""
    return flank_nodes(mesh.flanks[0])


def linear_shapes(s: Floats, nodes: Floats) -> Floats:
    """Values (k, n) of the linear shape functions of the nodes at s (k,), constant beyond them."""
    at = np.clip(np.searchsorted(nodes, s, side="right") - 1, 0, nodes.size - 2)
    part = np.clip((s - nodes[at]) / (nodes[at + 1] - nodes[at]), 0.0, 1.0)
    values = np.zeros((np.size(s), nodes.size))
    rows = np.arange(np.size(s))
    values[rows, at] = 1.0 - part
    values[rows, at + 1] = part
    return values


def shape_widths(nodes: Floats) -> Floats:
    """Integrals of the linear shape functions of the nodes, mm."""
    around = np.concatenate([nodes[:1], nodes, nodes[-1:]])
    return np.asarray(0.5 * (around[2:] - around[:-2]))


def nodal_unit_loads(
    flank: SectorMesh | MeshedFlank,
    nodes: Floats,
    *,
    along: Literal["normal", "tangent"] = "normal",
) -> Floats:
    """Consistent loads (2 N, n) of a normal or tangential unit force at each node (n,).

    Per mm of width, degree of freedom 2*node + component; nodes by arc length, mm.
    """
    widths = shape_widths(nodes)
    return consistent_loads(
        flank,
        lambda s: linear_shapes(s, nodes) / widths,
        count=nodes.size,
        along=along,
        edges=loaded_edges(flank),
    )


def every_second_node(nodes: Floats) -> tuple[Floats, Floats]:
    """Every second node and the last (m,), and their unit forces in terms of all nodes (n, m).

    The columns are forces at all nodes that replace the unit force at each of these; their sum is
    1.
    """
    fewer = nodes[::2] if nodes.size % 2 else np.append(nodes[::2], nodes[-1])
    return fewer, linear_shapes(nodes, fewer) * shape_widths(nodes)[:, None] / shape_widths(fewer)
