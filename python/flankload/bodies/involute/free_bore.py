"""A bore that is free but for its mean motion, in place of a fixed one."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from flankload.meshes.blocks import edges_along

if TYPE_CHECKING:
    from flankload.bodies.body import SectorMesh


def with_free_bore(mesh: SectorMesh) -> SectorMesh:
    """The sector without fixed nodes; those of its bore (or outside) have `bore_edges`."""
    angle = np.arctan2(*mesh.nodes[mesh.fixed_nodes].T[::-1])
    path = mesh.fixed_nodes[np.argsort(angle)]
    return replace(
        mesh,
        fixed_nodes=np.empty(0, dtype=np.int64),
        left_nodes=np.append(mesh.left_nodes, path[0]),
        right_nodes=np.append(mesh.right_nodes, path[-1]),
        bore_edges=edges_along(path),
    )
