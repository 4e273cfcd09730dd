"""Compliance files as written by another program: nodes of the project's elements, no modes."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from flankload.bodies.body import Body
from flankload.bodies.free_corner import corner_angles
from flankload.elasticity.finite_elements import stiffness
from flankload.elasticity.sector_closure import close_ring
from tests.support.condensed import condense


def flank_order(body: Body) -> np.ndarray:
    """Nodes of the flank from root to tip, mid-side nodes included."""
    assert body.mesh is not None
    edges = body.mesh.flank_edges
    return np.append(edges[:, [0, 2]].ravel(), edges[-1, 1])


def nodal_response(body: Body, plane: str = "strain") -> np.ndarray:
    """Displacements along the normals of all teeth (z, n, n) for unit nodal forces on tooth 0."""
    mesh = body.mesh
    assert mesh is not None
    nodes = flank_order(body)
    normals = body.curve.normal(mesh.flank_arc_length[nodes])
    loads = np.zeros((2 * len(mesh.nodes), nodes.size))
    for k, node in enumerate(nodes):
        loads[2 * node : 2 * node + 2, k] = normals[k]
    matrix = stiffness(mesh.nodes, mesh.cells, body.material, plane)
    sector, _ = condense(matrix, loads, mesh)
    return close_ring(sector, mesh.teeth)


def nodal_arrays(body: Body, turn_rad: float, **changes: Any) -> dict[str, Any]:
    """The plain format, with the body at position zero."""
    assert body.mesh is not None
    c, s = np.cos(turn_rad), np.sin(turn_rad)
    arrays = {
        "format": "flankload nodal compliance",
        "version": 1,
        "teeth": body.teeth,
        "points": body.mesh.nodes[flank_order(body)] @ np.array([[c, s], [-s, c]]),
        "compliance": nodal_response(body),
        "offsets": np.arange(body.teeth),
        "columns": "nodal_forces",
        "elements": "quadratic",
        "young_modulus_MPa": body.material.young_modulus_MPa,
        "poisson_ratio": body.material.poisson_ratio,
        "plane": "strain",
        "reference_radius_mm": body.reference_radius_mm,
        "tip_corner_deg": corner_angles(body)[1],
        **changes,
    }
    return {name: value for name, value in arrays.items() if value is not None}


def to_pressures(arrays: dict[str, Any]) -> dict[str, Any]:
    """The same with columns for nodal pressures, by Simpson-like element integrals.

    Written out for quadratic elements of three nodes: the consistent mass matrix of each is
    length/30 [[4, 2, -1], [2, 16, 2], [-1, 2, 4]] in the order first, middle, last.
    """
    points = arrays["points"]
    n = len(points)
    mass = np.zeros((n, n))
    local = np.array([[4, 2, -1], [2, 16, 2], [-1, 2, 4]]) / 30
    for k in range(0, n - 1, 2):
        length = np.linalg.norm(np.diff(points[k : k + 3], axis=0), axis=1).sum()
        mass[k : k + 3, k : k + 3] += length * local
    return {**arrays, "columns": "nodal_pressures", "compliance": arrays["compliance"] @ mass}


def write_npz(path: Path, arrays: dict[str, Any]) -> None:
    np.savez(path, **{name: np.asarray(value) for name, value in arrays.items()})


def csv_of(arrays: dict[str, Any]) -> str:
    """The same numbers as a table."""
    tables = ("points", "compliance", "offsets")
    lines = [f"# {name} = {value}" for name, value in arrays.items() if name not in tables]
    n = len(arrays["points"])
    lines.append(", ".join(["offset", "x_mm", "y_mm", *(f"c_{k + 1}" for k in range(n))]))
    for offset, block in zip(arrays["offsets"], arrays["compliance"], strict=True):
        for place, row in zip(arrays["points"], block, strict=True):
            lines.append(", ".join(repr(float(value)) for value in (offset, *place, *row)))
    return "\n".join(lines) + "\n"
