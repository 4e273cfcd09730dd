"""Stiffness matrices of plane meshes for references that solve with a general sparse solver."""

from collections.abc import Callable

import numpy as np
from scipy.sparse import coo_array, csc_array
from scipy.sparse.linalg import splu

from flankload.base.arrays import Cells, Floats
from flankload.bodies.body import Material
from flankload.elasticity.finite_elements import SectionStiffness, stiffness


def plane_stiffness(nodes: Floats, cells: Cells, material: Material, plane: str) -> csc_array:
    """Stiffness (2N, 2N) of a plane mesh; degree of freedom 2*node + component."""
    return sparse(stiffness(nodes, cells, material, plane))


def sparse(section: SectionStiffness) -> csc_array:
    """Matrix (2N, 2N) of plane blocks."""
    rows = (2 * section.rows[:, None, None] + np.arange(2)[:, None]).repeat(2, axis=2)
    columns = (2 * section.columns[:, None, None] + np.arange(2)).repeat(2, axis=1)
    size = 2 * section.nodes
    entries = (section.blocks[:, 0].ravel(), (rows.ravel(), columns.ravel()))
    return coo_array(entries, shape=(size, size)).tocsc()


def factored(matrix: csc_array) -> Callable[[Floats], Floats]:
    """Solver for right-hand sides (n, k) of a symmetric positive definite matrix (n, n)."""
    return splu(matrix).solve


def of_bars(bars: np.ndarray, blocks: np.ndarray, nodes: int) -> csc_array:
    """Matrix (2N, 2N) of bars with nodes (E, k) and stiffness (E, 2 k, 2 k)."""
    degrees = (2 * bars[:, :, None] + np.arange(2)).reshape(len(bars), -1)
    rows, columns = np.broadcast_arrays(degrees[:, :, None], degrees[:, None, :])
    entries = (blocks.ravel(), (rows.ravel(), columns.ravel()))
    return coo_array(entries, shape=(2 * nodes, 2 * nodes)).tocsc()
