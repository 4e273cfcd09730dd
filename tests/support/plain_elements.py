"""A plain solution of a pair: fine elements, linear shape functions, no analytic parts.

Loads and displacements use linear shape functions over the flank nodes (consistent loads,
work-conjugate means), so there are neither pressure modes nor a near field. The pairing is
independent (polar angles interpolated over radius), with equal cells over all flanks that could
touch.

`python -m tests.support.plain_elements` solves the scene of `internal_pair.json` and writes the
numbers to this file.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from unittest import mock

import numpy as np

import flankload as fl
from flankload.bodies import Body, SectorMesh
from flankload.bodies.involute import sector_breaks
from flankload.elasticity.finite_elements import stiffness
from flankload.elasticity.sector_closure import close_ring
from flankload.mechanisms.flank_pair.assembly import build_bodies
from flankload.pairing.body_pair import BodyPair
from tests.support.condensed import condense
from tests.support.paths import REFERENCE_SOLUTIONS

FILE = REFERENCE_SOLUTIONS / "internal_pair.json"


@dataclass(frozen=True)
class Hats:
    """Response of all teeth to the loads on tooth 0, (z, p, p), and their arc lengths (p,)."""

    places: np.ndarray
    response: np.ndarray

    def weights(self, s: np.ndarray, width: np.ndarray) -> np.ndarray:
        """Weight of each shape function (n, p) in uniform pressure of sum 1 on cells at s (n,)."""
        points, weight = np.polynomial.legendre.leggauss(12)
        at = np.clip(s[:, None] + 0.5 * width[:, None] * points, self.places[0], self.places[-1])
        k = np.clip(np.searchsorted(self.places, at, side="right") - 1, 0, self.places.size - 2)
        x = (at - self.places[k]) / np.diff(self.places)[k]
        found = np.zeros((s.size, self.places.size))
        rows = np.broadcast_to(np.arange(s.size)[:, None], k.shape)
        np.add.at(found, (rows, k), 0.5 * weight * (1 - x))
        np.add.at(found, (rows, k + 1), 0.5 * weight * x)
        return found


def nodal_unit_loads(mesh: SectorMesh, *, along_flank: bool = False) -> np.ndarray:
    """Consistent loads (2N, p) of the shape functions of sum 1, normal or tangential."""
    points, weights = np.polynomial.legendre.leggauss(8)
    shape = np.stack([points * (points - 1) / 2, points * (points + 1) / 2, 1 - points**2])
    slope = np.stack([points - 0.5, points + 0.5, -2 * points])
    hats = np.stack([(1 - points) / 2, (1 + points) / 2])
    count = len(mesh.flank_edges)
    loads, sums = np.zeros((len(mesh.nodes), 2, count + 1)), np.zeros(count + 1)
    for e, edge in enumerate(mesh.flank_edges):
        tangent = slope.T @ mesh.nodes[edge]
        across = np.stack([-tangent[:, 1], tangent[:, 0]], axis=1)
        loads[edge[:, None], :, [e, e + 1]] += np.einsum(
            "g,qg,hg,gd->qhd", weights, shape, hats, tangent if along_flank else across
        )
        sums[e : e + 2] += (weights * hats) @ np.linalg.norm(tangent, axis=1)
    return (loads / sums).reshape(-1, count + 1)


def hats_of(body: Body, plane: str) -> Hats:
    """Solve a body's sector for all its shape functions and close the ring."""
    mesh = body.mesh
    assert mesh is not None
    matrix = stiffness(mesh.nodes, mesh.cells, body.material, plane)
    sector, _ = condense(matrix, nodal_unit_loads(mesh), mesh)
    ends = np.append(mesh.flank_edges[:, 0], mesh.flank_edges[-1, 1])
    return Hats(mesh.flank_arc_length[ends], close_ring(sector, mesh.teeth))


def fine_bodies(scene: dict, element_mm: float, inner_mm: float) -> BodyPair:
    """Bodies with elements of equal length along the flanks that grow to another length inside."""
    part = inner_mm / element_mm
    sizes = {"FILLET": 0.4 * part, "FIRST_LAYER": 1.0, "INNER": part, "FIRST_ROW": 0.4 * part}
    accuracy = {"flank_element_mm": element_mm, "estimate": False, "tangents": False}
    with mock.patch.multiple(sector_breaks, **sizes):
        return build_bodies(fl.Scene.from_dict({**scene, "accuracy": accuracy}))


def solve_plainly(
    scene: dict, *, element_mm: float, inner_mm: float, cell_mm: float, rotation_rad: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Rotation (P,), forces (P, S) and sites (S,) of a scene.

    Cells cover all points with a gap below 1.3 times the expected rotations (P,).
    """
    pair = fine_bodies(scene, element_mm, inner_mm)
    hats = [hats_of(body, "strain") for body in (pair.body_1, pair.body_2)]
    found = [
        _state(scene, pair, hats, position, cell_mm, expected)
        for position, expected in zip(pair.position_rad, rotation_rad, strict=True)
    ]
    rotations, forces = zip(*found, strict=True)
    return np.array(rotations), np.array(forces), pair.pairing.sites


def _state(
    scene: dict, pair: BodyPair, hats: list[Hats], position: float, cell: float, expected: float
) -> tuple[float, np.ndarray]:
    pairing = pair.pairing
    columns = [
        rows[:, rows[3] < 1.3 * expected]
        for site in range(pairing.sites.size)
        if (rows := blind_pairs(pair, site, position, cell)).size
    ]
    site, s_1, s_2, gap, lever_1, lever_2 = np.concatenate(columns, axis=1)
    site, lever = site.astype(int), 0.5 * (lever_1 + lever_2)
    matrix = np.zeros((site.size, site.size))
    widths = (np.full(site.size, cell), cell * lever_1 / lever_2)
    for z, (s, width) in enumerate(zip((s_1, s_2), widths, strict=True)):
        weights, teeth = hats[z].weights(s, width), pairing.site_teeth[z]
        for i in np.unique(site):
            for j in np.unique(site):
                response = hats[z].response[(teeth[i] - teeth[j]) % len(hats[z].response)]
                block = weights[site == i] @ response @ weights[site == j].T
                matrix[np.ix_(site == i, site == j)] += block
    matrix /= scene["pair"]["face_width_mm"]
    torque = 1000.0 * scene["load"]["torque_Nm"]
    state = fl.solve_contact(matrix / lever[:, None], lever_1, gap, torque, normal_lever_arms=lever)
    return state.rotation, np.bincount(site, state.normal_forces, pairing.sites.size)


def blind_pairs(pair: BodyPair, site: int, position: float, cell: float) -> np.ndarray:
    """Site, arc lengths, gap angle, levers of cells on all circles common to both flanks."""
    turns = pair.pairing.turns(np.array([position]))
    centers = (np.zeros(2), np.array([pair.pairing.center_distance_mm, 0.0]))
    bodies = (pair.body_1, pair.body_2)
    places = []
    for z, body in enumerate(bodies):
        s = np.arange(body.curve.length_mm - 0.5 * cell, body.mode_range_mm[0], -cell)
        if z == 1:
            s = np.linspace(body.mode_range_mm[0], body.curve.length_mm, 20001)
        curve = body.curve.rotated(turns[z][0] + pair.pairing.site_angles_rad[z][site])
        point = curve.point(s) + centers[z]
        lever = np.abs(np.sum(point * curve.tangent(s), axis=1))
        places.append((s, np.hypot(*point.T), np.arctan2(point[:, 1], point[:, 0]), lever))
    (s_1, r_1, angle_1, lever_1), (s_2, r_2, angle_2, lever_2) = places
    if (np.diff(r_2) > 0).any():
        return np.zeros((6, 0))  # a flank far round the body
    on_both = (r_1 > r_2.min()) & (r_1 < r_2.max())
    angle, s, lever = (
        np.interp(r_1, r_2[::-1], v[::-1]) for v in (np.unwrap(angle_2), s_2, lever_2)
    )
    gap = np.angle(np.exp(1j * (angle - angle_1)))
    return np.stack([0 * s + site, s_1, s, gap, lever_1, lever])[:, on_both]


def main() -> None:
    """Solve the stored case with the stored parameters and write its numbers."""
    case = json.loads(FILE.read_text(encoding="utf-8"))
    result = fl.solve(fl.Scene.from_dict(case["scene"]))
    rotation, force, sites = solve_plainly(
        case["scene"], **case["settings"], rotation_rad=result.rotation_rad
    )
    case["sites"] = sites.tolist()
    case["rotation_rad"] = [float(f"{value:.8g}") for value in rotation]
    case["site_force_N"] = [[round(float(value), 2) for value in row] for row in force]
    FILE.write_text(json.dumps(case, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
