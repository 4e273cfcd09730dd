"""Response of a whole meshed body at all its flanks: one factorisation, no symmetry assumed."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flankload.elasticity import degrees_of, factored
from flankload.near_field import mode_loads

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray
    from scipy.sparse import csc_matrix

    from flankload.bodies.body import WholeMesh


def whole_response(
    matrix: csc_matrix,
    mesh: WholeMesh,
    mode_range_mm: tuple[float, float],
    n_modes: int,
    tell: Callable[[str], None],
) -> tuple[NDArray[np.float64], int]:
    """Response of every flank to the pressure modes on every flank.

    Parameters
    ----------
    matrix : csc_matrix, (2N, 2N)
        Stiffness of the body.
    mesh : WholeMesh
        With f flanks.
    mode_range_mm : (float, float)
    n_modes : int
    tell : callable
        Told the name of each step when it is done.

    Returns
    -------
    response : (f * f, p, p) array
        response[i * f + j] is that of flank i to the modes on flank j.
    degrees_of_freedom : int
        Those that are not held.
    """
    free = np.setdiff1d(np.arange(matrix.shape[0]), degrees_of(mesh.fixed_nodes))
    solve = factored(matrix[free][:, free].tocsc())
    tell("factorisation")
    loads = []
    for flank in mesh.flanks:
        column = mode_loads(flank, mode_range_mm, n_modes)[free]
        rows = np.flatnonzero(column.any(axis=1))
        loads.append((rows, column[rows]))
    f = len(loads)
    response = np.empty((f, f, n_modes, n_modes))
    for j, (rows, column) in enumerate(loads):
        right = np.zeros((free.size, n_modes))
        right[rows] = column
        moved = solve(right)
        for i, (seen, weight) in enumerate(loads):
            response[i, j] = weight.T @ moved[seen]
    tell("solution")
    return response.reshape(f * f, n_modes, n_modes), free.size
