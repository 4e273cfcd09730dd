"""A pinion and its shaft as one solid: the figures of `tests/physics/test_flexible_shafts.py`.

The plane mesh of the product's sector is repeated around the axis, continued to it, and extruded in
quadratic layers (27- and 18-node elements); the shaft is its part inside the hub circle. Nothing of
`elasticity.prism` is used. About 800 000 unknowns: run it with a direct solver for such problems,

    pip install pypardiso
    python -m tests.support.solid_pinion_shaft 8
"""

from __future__ import annotations

import sys
from dataclasses import dataclass

import numpy as np
from numpy.polynomial.legendre import leggauss, legvander
from scipy.sparse import coo_array, csr_matrix

import flankload as fl
from flankload.bodies import Body
from flankload.bodies.body import SectorMesh
from flankload.elasticity.near_field import mode_loads
from flankload.elasticity.shape_functions import block_basis
from flankload.mechanisms.flank_pair.assembly import build_bodies

E, NU = 206000.0, 0.3
WIDTH, SHAFT, BEARINGS = 40.0, 28.0, (-60.0, 60.0)
#: N/mm of each bearing; of the axial and the rotational support at its end.
RADIAL, AXIAL, TURNING = 3e5, 1e6, 1e10
#: Ends of layers from the end faces of the pinion outwards, mm.
OUTSIDE = np.array([0.0, 1.5, 4.0, 8.0, 14.0, 22.0, 31.0, 40.0])
#: Circles of the core inside the bore, parts of its radius.
CORE = (1.0, 0.7, 0.4)


def pinion() -> Body:
    """Module 2, 17 teeth, root circle 29 mm, with mesh lines at the bore and on the shaft."""
    gear = {"kind": "gear", "module_mm": 2.0, "pressure_angle_deg": 20}
    one = {"teeth": 17, "tip_diameter_mm": 38.0, "bore_diameter_mm": 14.0}
    one |= {"hub_diameter_mm": SHAFT, "hub_width_mm": WIDTH + 20.0}
    scene = {
        "body_1": gear | one,
        "body_2": gear | {"teeth": 51, "tip_diameter_mm": 106.0, "bore_diameter_mm": 40.0},
        "pair": {"center_distance_mm": 68.0, "face_width_mm": WIDTH},
        "load": {"torque_Nm": 60},
        "positions": {"count": 4},
        "effects": {"dimension": 3},
        "accuracy": {"flank_element_mm": 3.0},
    }
    return build_bodies(fl.Scene.from_dict(scene)).body_1


@dataclass(frozen=True)
class Section:
    """Nodes (M, 2), groups of elements (kind, nodes, whether of the shaft), nodes of sector 0."""

    nodes: np.ndarray
    groups: list[tuple[str, np.ndarray, bool]]
    sector: np.ndarray


def whole_section(mesh: SectorMesh) -> Section:
    """The section of the whole pinion, down to the axis."""
    bore = mesh.fixed_nodes[np.argsort(np.arctan2(*mesh.nodes[mesh.fixed_nodes].T[::-1]))]
    rim = mesh.nodes[bore]
    parts = np.repeat(CORE, 2)[:-1].copy()
    parts[1::2] = 0.5 * (np.array(CORE[:-1]) + np.array(CORE[1:]))
    nodes, count = [mesh.nodes], len(mesh.nodes)
    circles = [bore]
    for part in parts[1:]:
        nodes.append(part * rim)
        circles.append(count + np.arange(len(rim)))
        count += len(rim)
    nodes += [0.5 * CORE[-1] * rim[::2], np.zeros((1, 2))]
    half, axis = count + np.arange(len(rim[::2])), count + len(rim[::2])
    quads, triangles = [], []
    for e in range(0, len(rim) - 1, 2):
        for out, middle, inner in zip(circles[0:-1:2], circles[1::2], circles[2::2], strict=True):
            corners = [inner[e], out[e], out[e + 2], inner[e + 2]]
            quads.append(
                [*corners, middle[e], out[e + 1], middle[e + 2], inner[e + 1], middle[e + 1]]
            )
        last = circles[-1]
        triangles.append([axis, last[e], last[e + 2], half[e // 2], last[e + 1], half[e // 2 + 1]])
    regions = zip(mesh.cells, mesh.regions, strict=True)
    groups = [(kind, cells, name == "hub") for (kind, cells), name in regions]
    groups += [("quad9", np.array(quads), True), ("triangle6", np.array(triangles), True)]
    own = np.vstack(nodes)
    angles = 2.0 * np.pi * np.arange(mesh.teeth) / mesh.teeth
    turns = [np.array([[np.cos(a), np.sin(a)], [-np.sin(a), np.cos(a)]]) for a in angles]
    every = np.vstack([own @ turn for turn in turns])
    _, number = np.unique(np.round(every, 6), axis=0, return_inverse=True)
    number = number.ravel()
    places = np.zeros((number.max() + 1, 2))
    places[number] = every
    repeated = len(own) * np.arange(mesh.teeth)[:, None, None]
    groups = [
        (kind, number[(cells + repeated).reshape(-1, cells.shape[1])], shaft)
        for kind, cells, shaft in groups
    ]
    return Section(places, groups, number[: len(mesh.nodes)])


def lagrange(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Quadratic functions of a layer at x in [-1, 1], (3, n), and their derivatives."""
    values = np.stack([0.5 * x * (x - 1.0), 1.0 - x**2, 0.5 * x * (x + 1.0)])
    return values, np.stack([x - 0.5, -2.0 * x, x + 0.5])


def layer_stiffness(nodes: np.ndarray, kind: str, cells: np.ndarray, height: float) -> np.ndarray:
    """Stiffness (e, 9 k, 9 k) of extruded elements, by level, node, component."""
    lam, mu = E * NU / ((1 + NU) * (1 - 2 * NU)), 0.5 * E / (1 + NU)
    moduli = np.diag([2 * mu] * 3 + [mu] * 3)
    moduli[:3, :3] += lam
    basis = block_basis(nodes, kind, cells, 5 if kind == "quad9" else 4)
    slope = basis.slopes
    k, _, elements, points = slope.shape
    value = np.broadcast_to(basis.values[:, None], (k, elements, points))
    total = np.zeros((elements, 9 * k, 9 * k))
    x, weights = leggauss(3)
    along, change = lagrange(x)
    for q in range(3):
        d_x, d_y = (np.einsum("l,keg->lkeg", along[:, q], slope[:, c]) for c in (0, 1))
        d_z = np.einsum("l,keg->lkeg", change[:, q] * 2.0 / height, value)
        strain = np.zeros((6, 3, k, 3, elements, points))
        strain[0, :, :, 0] = strain[3, :, :, 1] = strain[4, :, :, 2] = d_x
        strain[1, :, :, 1] = strain[3, :, :, 0] = strain[5, :, :, 2] = d_y
        strain[2, :, :, 2] = strain[4, :, :, 0] = strain[5, :, :, 1] = d_z
        strain = strain.reshape(6, 9 * k, elements, points)
        for g in range(points):
            rows = strain[..., g].transpose(2, 0, 1)
            weight = basis.dx[:, g] * weights[q] * 0.5 * height
            total += rows.transpose(0, 2, 1) @ (moduli @ rows) * weight[:, None, None]
    return total


@dataclass(frozen=True)
class Solid:
    """Levels z (L,), number of each node at each level (L, M; -1: none), layers on the pinion."""

    section: Section
    z: np.ndarray
    number: np.ndarray
    on_pinion: np.ndarray

    @property
    def size(self) -> int:
        """Number of unknowns."""
        return 3 * (int(self.number.max()) + 1)

    def layers(self, shaft: bool) -> np.ndarray:
        """Numbers of layers with elements of the shaft, or with the others."""
        return np.arange(self.on_pinion.size) if shaft else np.flatnonzero(self.on_pinion)

    def mean(self, level: int, motion: str) -> np.ndarray:
        """Functional: mean displacement x, y, z of the shaft's section, or its rotation t."""
        area = np.zeros(len(self.section.nodes))
        for kind, cells, shaft in self.section.groups:
            if shaft:
                basis = block_basis(self.section.nodes, kind, cells, 4)
                for local, value in enumerate(basis.values):
                    np.add.at(area, cells[:, local], (value * basis.dx).sum(axis=1))
        on = np.flatnonzero(area)
        at, found, weights = 3 * self.number[level, on], np.zeros(self.size), area[on]
        if motion in "xyz":
            found[at + "xyz".index(motion)] = weights / weights.sum()
            return found
        x, y = self.section.nodes[on].T
        polar = (weights * (x**2 + y**2)).sum()
        found[at], found[at + 1] = -weights * y / polar, weights * x / polar
        return found


def solid_of(section: Section, layers: int) -> Solid:
    """Layers over the pinion, graded to its ends, and outside of it."""
    heights = np.ones(layers)
    heights[[0, -1]], heights[[1, -2]] = 0.4, 0.7
    inside = WIDTH * (np.append(0.0, np.cumsum(heights)) / heights.sum() - 0.5)
    beyond = 0.5 * WIDTH + OUTSIDE[1:]
    ends = np.concatenate([-beyond[::-1], inside, beyond])
    z = np.zeros(2 * ends.size - 1)
    z[::2], z[1::2] = ends, 0.5 * (ends[1:] + ends[:-1])
    on_pinion = np.abs(z[1::2]) < 0.5 * WIDTH
    used = np.zeros((z.size, len(section.nodes)), dtype=bool)
    for layer, inner in enumerate(on_pinion):
        for _, cells, shaft in section.groups:
            if inner or shaft:
                used[2 * layer : 2 * layer + 3, np.unique(cells)] = True
    number = np.full(used.shape, -1)
    number[used] = np.arange(used.sum())
    return Solid(section, z, number, on_pinion)


def stiffness_of(solid: Solid) -> coo_array:
    """Upper triangle of the stiffness of all elements."""
    rows, columns, values = [], [], []
    heights = np.round(solid.z[2::2] - solid.z[:-2:2], 9)
    for kind, cells, shaft in solid.section.groups:
        known: dict[float, np.ndarray] = {}
        for layer in solid.layers(shaft).tolist():
            height = float(heights[layer])
            if height not in known:
                known[height] = layer_stiffness(solid.section.nodes, kind, cells, height)
            nodes = solid.number[2 * layer : 2 * layer + 3][:, cells].transpose(1, 0, 2)
            at = (3 * nodes[..., None] + np.arange(3)).reshape(len(cells), -1)
            one, two = np.triu_indices(at.shape[1])
            rows.append(np.minimum(at[:, one], at[:, two]).ravel().astype(np.int32))
            columns.append(np.maximum(at[:, one], at[:, two]).ravel().astype(np.int32))
            values.append(known[height][:, one, two].ravel())
    places = np.concatenate(rows), np.concatenate(columns)
    return coo_array((np.concatenate(values), places), shape=(solid.size,) * 2)


def line_loads(solid: Solid, body: Body, count: int) -> np.ndarray:
    """Loads P_b(2 z/b) per mm of width, even over the height of the flank of tooth 0."""
    assert isinstance(body.mesh, SectorMesh)
    in_plane = mode_loads(body.mesh, body.mode_range_mm, 1, twist=0.0).reshape(-1, 3)
    x, weights = leggauss(8)
    along, _ = lagrange(x)
    by_level = np.zeros((solid.z.size, count))
    for layer in np.flatnonzero(solid.on_pinion).tolist():
        low, _, high = solid.z[2 * layer : 2 * layer + 3]
        z = low + 0.5 * (high - low) * (x + 1.0)
        shapes = along * weights * 0.5 * (high - low)
        by_level[2 * layer : 2 * layer + 3] += shapes @ legvander(2.0 * z / WIDTH, count - 1)
    found = np.zeros((solid.size, count))
    for node in np.flatnonzero(np.abs(in_plane).sum(axis=1)).tolist():
        for level in np.flatnonzero(by_level.any(axis=1)).tolist():
            at = 3 * solid.number[level, solid.section.sector[node]]
            found[at : at + 3] += in_plane[node][:, None] * by_level[level]
    return found / (body.mode_range_mm[1] - body.mode_range_mm[0])


def compliance(layers: int, count: int = 4) -> np.ndarray:
    """Compliance (count, count) between the line loads, mm/N."""
    from pypardiso import PyPardisoSolver

    body = pinion()
    assert isinstance(body.mesh, SectorMesh)
    solid = solid_of(whole_section(body.mesh), layers)
    loads = line_loads(solid, body, count)
    one, two = (int(np.argmin(np.abs(solid.z - place))) for place in BEARINGS)
    springs = [(RADIAL, solid.mean(level, motion)) for level in (one, two) for motion in "xy"]
    springs += [(AXIAL, solid.mean(two, "z")), (TURNING, solid.mean(one, "t"))]
    # points that hold the sparse part, taken off again below
    center = int(np.argmin(np.hypot(*solid.section.nodes.T)))
    ends = [3 * solid.number[level, center] for level in (one, two)]
    x, y = solid.section.nodes.T
    rim = int(np.argmax(np.where(solid.number[one] >= 0, x - np.abs(y), -np.inf)))
    points = [ends[0], ends[0] + 1, ends[1], ends[1] + 1, ends[1] + 2]
    points.append(3 * int(solid.number[one, rim]) + 1)
    held = np.zeros((solid.size, len(points)))
    held[points, np.arange(len(points))] = 1.0
    hold = 1e5
    matrix = csr_matrix(stiffness_of(solid).tocsr())
    matrix = matrix + csr_matrix((np.full(6, hold), (points, points)), shape=matrix.shape)
    added = np.column_stack([*(functional for _, functional in springs), held])
    sizes = np.array([size for size, _ in springs] + [-hold] * len(points))
    moved = PyPardisoSolver(mtype=2).solve(matrix, np.asfortranarray(np.hstack([loads, added])))
    free, by_added = moved[:, :count], moved[:, count:]
    inner = np.diag(1.0 / sizes) + added.T @ by_added
    return loads.T @ (free - by_added @ np.linalg.solve(inner, added.T @ free))


if __name__ == "__main__":
    print(np.array2string(1e6 * compliance(int(sys.argv[1])), precision=3), "nm/N")
