"""A gear and a ring with changed keys, meshed gears, and the whole ring of a sector."""

from __future__ import annotations

import numpy as np
from scipy.sparse.linalg import splu

from flankload.bodies.body import Body, SectorMesh
from flankload.bodies.involute.involute_body import build_involute_body
from flankload.elasticity.finite_elements import degrees_of
from flankload.elasticity.near_field import mode_loads
from flankload.scene import Gear, Ring
from tests.support.plane_sectors import STEEL
from tests.support.plane_stiffness import plane_stiffness

RING = {
    "teeth": 60,
    "module_mm": 3.0,
    "tip_diameter_mm": 175.2,
    "root_diameter_mm": 187.5,
    "outer_diameter_mm": 220.0,
}


def gear(**keys) -> Gear:
    """The FZG type C pinion, with changed keys."""
    given = {
        "teeth": 16,
        "module_mm": 4.5,
        "profile_shift": 0.182,
        "tip_diameter_mm": 82.46,
        "bore_diameter_mm": 30.0,
    }
    return Gear(**(given | keys))


def ring(**keys) -> Ring:
    """A ring of 60 teeth, with changed keys."""
    return Ring(**(RING | keys))


def full_ring(
    mesh: SectorMesh, span: tuple[float, float], n_modes: int, more: np.ndarray | None = None
) -> np.ndarray:
    """Response of all teeth of the whole meshed ring to the modes on tooth 0, (z, p, p).

    `more` columns (2N, q) of a sector's own frame are read only: (z, p + q, p).
    """
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
    matrix = plane_stiffness(nodes, ((kind, cells),), STEEL, "strain")
    own = mode_loads(mesh, span, n_modes)
    if more is not None:
        own = np.hstack([own, more])
    loads = []
    for tooth in range(mesh.teeth):
        angle = 2 * np.pi * tooth / mesh.teeth
        turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
        column = np.zeros((2 * len(nodes), own.shape[1]))
        rows = degrees_of(number[tooth * count : (tooth + 1) * count])
        turned = np.einsum("ncq,cd->ndq", own.reshape(count, 2, -1), turn)
        np.add.at(column, rows, turned.reshape(2 * count, -1))
        loads.append(column)
    held = np.concatenate([number[mesh.fixed_nodes + t * count] for t in range(mesh.teeth)])
    free = np.setdiff1d(np.arange(2 * len(nodes)), degrees_of(np.unique(held)))
    moved = np.zeros((2 * len(nodes), n_modes))
    moved[free] = splu(matrix[free][:, free].tocsc()).solve(loads[0][free, :n_modes])
    return np.array([column.T @ moved for column in loads])


def gear_body(teeth: int, element_mm: float, **keys: float) -> Body:
    spec = Gear(
        teeth=teeth,
        module_mm=4.5,
        **{
            "profile_shift": 0.182,
            "tip_diameter_mm": 4.5 * (teeth + 2.3),
            "bore_diameter_mm": 2.0 * teeth,
            **keys,
        },
    )
    return build_involute_body(spec, "body_1", flank_element_mm=element_mm)
