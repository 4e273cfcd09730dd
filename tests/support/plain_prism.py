"""A prism the plain way: the whole sparse stiffness of all nodes and functions of z."""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_array, csc_array
from scipy.sparse.linalg import splu

from flankload.bodies.body import SectorMesh
from flankload.elasticity.axial_basis import AxialBasis
from flankload.elasticity.finite_elements import SectionStiffness, section_stiffness
from flankload.elasticity.near_field import mode_loads
from tests.support.plane_sectors import STEEL


def unknowns(nodes: np.ndarray, functions: int, kept: int | None = None) -> np.ndarray:
    """Unknowns of nodes by node, function of z, component; the first `kept` functions only."""
    kept = functions if kept is None else kept
    return (np.asarray(nodes)[:, None] * 3 * functions + np.arange(3 * kept)).ravel()


def whole_stiffness(section: SectionStiffness, axial: AxialBasis) -> csc_array:
    """K_PP x M + K_PQ x D1 + K_PQ' x D1' + K_QQ x S1, symmetric, all of it."""
    functions = axial.count
    local = np.arange(3 * functions)
    total = np.einsum("ntcd,tab->nacbd", section.blocks, axial.terms)
    rows = section.rows[:, None, None] * 3 * functions + local[:, None]
    columns = section.columns[:, None, None] * 3 * functions + local
    rows, columns = np.broadcast_arrays(rows, columns)
    size = 3 * functions * section.nodes
    values = total.reshape(-1, 3 * functions, 3 * functions)
    return coo_array((values.ravel(), (rows.ravel(), columns.ravel())), shape=(size,) * 2).tocsc()


def product_loads(in_plane: np.ndarray, along: np.ndarray) -> np.ndarray:
    """Loads of P_a P_b by unknowns, at column a n_z + b."""
    n_s, n_z = in_plane.shape[1], along.shape[1]
    loads = np.einsum("ica,kb->ikcab", in_plane.reshape(-1, 3, n_s), along)
    return loads.reshape(-1, n_s * n_z)


def solved(matrix: csc_array, loads: np.ndarray, held: np.ndarray) -> np.ndarray:
    """Displacements of all unknowns where some are held."""
    free = np.setdiff1d(np.arange(matrix.shape[0]), held)
    moved = np.zeros_like(loads)
    moved[free] = splu(matrix[free][:, free].tocsc()).solve(loads[free])
    return moved


def full_prism_ring(
    mesh: SectorMesh,
    span: tuple[float, float],
    n_modes: int,
    axial: AxialBasis,
    *,
    twist: float,
    load_degree: int,
    sectors: int | None = None,
) -> np.ndarray:
    """Response of all teeth of the whole meshed ring to the modes on tooth 0, (z, p, p).

    `sectors`: number of those of an open row whose ends are held, instead of the ring.
    """
    count, teeth = len(mesh.nodes), mesh.teeth if sectors is None else sectors
    angles = 2 * np.pi * np.arange(teeth) / mesh.teeth
    turns = [np.array([[np.cos(a), np.sin(a)], [-np.sin(a), np.cos(a)]]) for a in angles]
    pieces = [mesh.nodes @ turn for turn in turns]
    every = np.vstack(pieces)
    _, number = np.unique(np.round(every, 7), axis=0, return_inverse=True)
    number = number.ravel()
    nodes = np.zeros((number.max() + 1, 2))
    nodes[number] = every
    ((kind, data),) = mesh.cells
    cells = number[np.vstack([data + tooth * count for tooth in range(teeth)])]
    section = section_stiffness(nodes, ((kind, cells),), STEEL, twist)
    own = mode_loads(mesh, span, n_modes, twist=twist).reshape(count, 3, n_modes)
    loads = []
    for tooth, turn in enumerate(turns):
        turned = own.copy()
        turned[:, :2] = np.einsum("ncq,cd->ndq", own[:, :2], turn)
        column = np.zeros((len(nodes), 3, n_modes))
        np.add.at(column, number[tooth * count : (tooth + 1) * count], turned)
        loads.append(product_loads(column.reshape(-1, n_modes), axial.load_vectors(load_degree)))
    held = np.concatenate([number[mesh.fixed_nodes + t * count] for t in range(teeth)])
    if sectors is not None:
        ends = mesh.left_nodes, mesh.right_nodes + (sectors - 1) * count
        held = np.concatenate([held, *(number[end] for end in ends)])
    moved = solved(
        whole_stiffness(section, axial), loads[0], unknowns(np.unique(held), axial.count)
    )
    return np.array([column.T @ moved for column in loads])
