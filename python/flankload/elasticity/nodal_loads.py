"""Unit forces at the nodes of a flank, and tables between them: the near field of the paper.

The force of a node is distributed by the linear shape function of the node, and displacements are
averaged with the same weights: tables between the nodes are symmetric and treat all nodes equally,
whereas forces on single nodes of quadratic elements distinguish ends and middles of edges. The
nodes are the ends of the edges; tables are interpolated linearly between them, Eqs. (21) and (22).
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
    """Arc lengths (n,) of the ends of a flank's edges, which carry unit loads, ascending, mm."""
    _, s = loaded_edges(flank)
    return np.append(s[:, 0], s[-1, 1])


def nodes_of(mesh: SectorMesh | WholeMesh) -> Floats:
    """Arc lengths of the nodes of the first flank; they apply to all flanks of the body."""
    return flank_nodes(mesh.flanks[0])


def linear_shapes(s: Floats, nodes: Floats) -> Floats:
    """Values (k, n) of the linear shape functions of the nodes at places s (k,).

    Beyond the first and the last node they keep their end values.
    """
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
    """Loads (2 N, n) of a unit force at each node (n,), out of the material or along the flank.

    Consistent, per mm of width, degree of freedom 2*node + component; arc lengths of the nodes are
    the same on every flank of a body, mm.
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
    """Half as many nodes (m,), and their unit forces as sums of those of all nodes (n,).

    Every second node and the last remain; the columns (n, m) are the forces at all nodes that
    replace the unit force at each of these, and sum to 1.
    """
    fewer = nodes[::2] if nodes.size % 2 else np.append(nodes[::2], nodes[-1])
    return fewer, linear_shapes(nodes, fewer) * shape_widths(nodes)[:, None] / shape_widths(fewer)
