"""Ring closure against fully meshed rings, symmetry, convergence of the smooth compliance."""

from __future__ import annotations

import numpy as np
import pytest
from plane_sectors import STEEL, ring_sector
from scipy.sparse.linalg import splu
from tolerances import ROUND_OFF

from flankload.bodies.body import SectorMesh
from flankload.compliance import close_ring, condense
from flankload.elasticity import degrees_of, stiffness
from flankload.near_field import mode_loads

#: Wanted of the ring closure: identical to the meshed ring but for rounding.
CLOSURE = 1e-10


def full_ring(mesh: SectorMesh, span: tuple[float, float], n_modes: int) -> np.ndarray:
    """Response of all teeth of the whole meshed ring to the modes on tooth 0, (z, p, p)."""
    pieces, count = [], len(mesh.nodes)
    for tooth in range(mesh.teeth):
        angle = 2 * np.pi * tooth / mesh.teeth
        turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
        pieces.append(mesh.nodes @ turn)
    every = np.vstack(pieces)
    _, number = np.unique(np.round(every, 7), axis=0, return_inverse=True)
    number = number.ravel()
    nodes = np.zeros((number.max() + 1, 2))
    nodes[number] = every
    ((kind, data),) = mesh.cells
    cells = number[np.vstack([data + tooth * count for tooth in range(mesh.teeth)])]
    matrix = stiffness(nodes, ((kind, cells),), STEEL, "strain")
    loads = []
    for tooth, piece in enumerate(pieces):
        turned = SectorMesh(**{**vars(mesh), "nodes": piece})
        column = np.zeros((2 * len(nodes), n_modes))
        rows = degrees_of(number[tooth * count : (tooth + 1) * count])
        np.add.at(column, rows, mode_loads(turned, span, n_modes))
        loads.append(column)
    held = np.concatenate([number[mesh.fixed_nodes + t * count] for t in range(mesh.teeth)])
    free = np.setdiff1d(np.arange(2 * len(nodes)), degrees_of(np.unique(held)))
    moved = np.zeros((2 * len(nodes), n_modes))
    moved[free] = splu(matrix[free][:, free].tocsc()).solve(loads[0][free])
    return np.array([column.T @ moved for column in loads])


@pytest.mark.parametrize("teeth", [5, 6])
def test_ring_closure_equals_the_meshed_ring(teeth: int) -> None:
    mesh, span = ring_sector(teeth)
    matrix = stiffness(mesh.nodes, mesh.cells, STEEL, "strain")
    sector, _ = condense(matrix, mode_loads(mesh, span, 3), mesh)
    found, expected = close_ring(sector, teeth), full_ring(mesh, span, 3)
    assert np.abs(found - expected).max() <= CLOSURE * np.abs(expected).max()


def test_ring_obeys_betti_without_being_told() -> None:
    teeth = 6
    mesh, span = ring_sector(teeth)
    matrix = stiffness(mesh.nodes, mesh.cells, STEEL, "strain")
    sector, _ = condense(matrix, mode_loads(mesh, span, 4), mesh)
    response = close_ring(sector, teeth)
    mirrored = response[-np.arange(teeth) % teeth].transpose(0, 2, 1)
    np.testing.assert_allclose(
        response, mirrored, rtol=0, atol=100 * ROUND_OFF * np.abs(response).max()
    )
    # a unit of pressure on its own tooth gives way, and most where it presses
    assert (np.diag(response[0]) > 0).all()
    assert response[0, 0, 0] > np.abs(response[1:, 0, 0]).max()
