"""Writing of a body's mesh to a file."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flankload.base.rotation import turned
from flankload.bodies.body import SectorMesh, WholeMesh
from flankload.meshes.io import write_mesh
from flankload.meshes.plane_mesh import boundary_edges, raise_to_quadratic

if TYPE_CHECKING:
    from pathlib import Path

    from flankload.base.arrays import Numbers


def write_body(path: str | Path, mesh: SectorMesh | WholeMesh, *, turn_rad: float = 0.0) -> None:
    """Write the mesh of a body with named sets.

    A sector has the sets FLANK, BORE, CUT_LEFT and CUT_RIGHT; a whole body has BORE and FLANK_0,
    FLANK_1, … by tooth number. Web and hub are sets of elements.

    Parameters
    ----------
    path : path
        Its suffix selects the format: .msh, .vtu or .inp.
    mesh : SectorMesh or WholeMesh
    turn_rad : float
        Rotation of the nodes about the axis, to the angle of the body at position zero.

    Raises
    ------
    MeshError
        If the suffix is unknown.
    """
    write_mesh(path, turned(mesh.nodes, turn_rad), mesh.cells, _named_edges(mesh), mesh.regions)


def _named_edges(mesh: SectorMesh | WholeMesh) -> dict[str, Numbers]:
    """Edges (m, 3) of each named set on the boundary."""
    _, cells = raise_to_quadratic(mesh.nodes, mesh.cells)
    boundary = boundary_edges(cells)

    def among(members: Numbers, touching: Numbers | None = None) -> Numbers:
        chosen = np.isin(boundary, members).all(axis=1)
        if touching is not None:
            chosen &= np.isin(boundary[:, 2], touching)
        return boundary[chosen]

    if isinstance(mesh, WholeMesh):
        flanks = {f"FLANK_{flank.tooth}": flank.flank_edges for flank in mesh.flanks}
        return {**flanks, "BORE": among(mesh.fixed_nodes)}
    left, right, bore = mesh.left_nodes, mesh.right_nodes, mesh.bore_nodes
    return {
        "FLANK": mesh.flank_edges,
        "BORE": among(bore),
        "CUT_LEFT": among(np.union1d(left, bore), left),
        "CUT_RIGHT": among(np.union1d(right, bore), right),
    }
