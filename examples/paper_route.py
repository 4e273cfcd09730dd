"""The method of the paper from end to end, equation by equation, and the default method.

W. Weese, V. Popov: Modellierung des mehrflächigen Reibungskontaktes zweier Rotationskörper. One
position of the FZG type C pair, without friction. Run: python examples/paper_route.py
"""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import flankload as fl
from flankload.bodies import Body
from flankload.elasticity.finite_elements import stiffness
from flankload.elasticity.job_log import JobLog
from flankload.elasticity.nodal_loads import flank_nodes
from flankload.elasticity.sector_closure import close_ring, condense_sector
from flankload.mechanisms.flank_pair.assembly import build_bodies

SCENE = Path(__file__).parent / "scenes" / "external_gear.toml"
ANGLE_DEG = 11.25  # half a pitch on: two pairs of teeth carry
STEPS = 5  # of each force, Fig. 5


@dataclass
class Flank:
    """One flank where it stands: its nodes about O1, and their unit normals and tangents."""

    points: np.ndarray
    normals: np.ndarray
    tangents: np.ndarray

    @property
    def radii(self) -> np.ndarray:
        return np.linalg.norm(self.points, axis=1)

    def at(self, radii: np.ndarray, values: np.ndarray) -> np.ndarray:
        """Nodal values where circles about O1 cut the flank: functions of r, (21) and (22)."""
        order = np.argsort(self.radii)
        k = np.clip(np.searchsorted(self.radii[order], radii) - 1, 0, len(order) - 2)
        low, high = order[k], order[k + 1]
        part = (radii - self.radii[low]) / (self.radii[high] - self.radii[low])
        part = part.reshape(-1, *[1] * (values.ndim - 1))
        return (1 - part) * values[low] + part * values[high]


def nodal_tables(body: Body) -> tuple[np.ndarray, np.ndarray]:
    """3.1: unit forces along the normal at every node of the flank of tooth 0, one FE job.

    Displacements along normal and tangent (z, n, n) of the nodes of all z teeth, mm²/N: u and v in
    the directions of the flank. Mid-side nodes, whose compliance
    differs from that of corners, are left out.
    """
    mesh = body.mesh
    corners = np.append(mesh.flank_edges[:, 0], mesh.flank_edges[-1, 1])
    s = flank_nodes(mesh)
    loads = np.zeros((len(mesh.nodes), 2, 2 * s.size))
    for first, directions in ((0, body.curve.normal(s)), (s.size, body.curve.tangent(s))):
        for k, (node, direction) in enumerate(zip(corners, directions, strict=True)):
            loads[node, :, first + k] = direction
    matrix = stiffness(mesh.nodes, mesh.cells, body.material, "strain")
    # one tooth and its share of the rim …
    sector = condense_sector(matrix, mesh, loads, (), JobLog())
    response = close_ring(sector, mesh.teeth)  # … copied all around ("FE-Copystrukturen")
    return response[:, : s.size, : s.size], response[:, s.size :, : s.size]


def angles_to_deformed(flank: Flank, radii: np.ndarray, moved: np.ndarray) -> np.ndarray:
    """Fig. 5: polar angles at which the polyline through the moved nodes cuts the circles r_i."""
    line = flank.points + moved  # (24)
    r = np.linalg.norm(line, axis=1)
    order = np.argsort(r)
    k = np.clip(np.searchsorted(r[order], radii) - 1, 0, r.size - 2)
    one, along = line[order][k], line[order][k + 1] - line[order][k]
    b, c = np.sum(one * along, axis=1), np.sum(one**2, axis=1) - radii**2
    t = -c / (b + np.sqrt(b**2 - np.sum(along**2, axis=1) * c))  # both cuts: the near one
    x, y = (one + t[:, None] * along).T
    return np.arctan2(y, x)


def influence_numbers(
    tables: tuple[np.ndarray, np.ndarray],
    sense: int,
    flanks: list[Flank],
    teeth: np.ndarray,
    radii: list[np.ndarray],
    forces: np.ndarray,
) -> np.ndarray:
    """a_ij of one body, (5), (6): angle of the circle cut over the force, by least squares.

    Body 1 turns back from its mate (sense -1), body 2 on (1).
    """
    sizes = [r.size for r in radii]
    ends = np.concatenate([[0], np.cumsum(sizes)])
    numbers = np.zeros((ends[-1], ends[-1]))
    for f, loaded in enumerate(flanks):
        for g, flank in enumerate(flanks):
            tooth = (teeth[g] - teeth[f]) % len(tables[0])
            # by forces that push into the body; columns: forces at the circles r_j
            u, v = (-loaded.at(radii[f], table[tooth].T).T for table in tables)
            still = angles_to_deformed(flank, radii[g], 0 * flank.points)
            for j in range(sizes[f]):
                moved = u[:, j, None] * flank.normals + v[:, j, None] * flank.tangents
                steps = forces[ends[f] + j] * np.arange(1, STEPS + 1) / STEPS  # from above 0
                theta = sense * np.array(
                    [angles_to_deformed(flank, radii[g], F * moved) - still for F in steps]
                )
                rows = slice(ends[g], ends[g + 1])
                numbers[rows, ends[f] + j] = theta.T @ steps / (steps @ steps)
    return numbers


def paper_route(spacing_mm: float) -> tuple[float, np.ndarray, int]:
    """Rotation, part of each flank in the load, and how often influence numbers were made."""
    tree = tomllib.loads(SCENE.read_text(encoding="utf-8"))
    tree |= {"positions": {"angles_deg": [ANGLE_DEG]}, "effects": {"near_field": "nodes"}}
    tree["accuracy"] = {"flank_element_mm": spacing_mm}
    scene = fl.Scene.from_dict(tree)
    pair = build_bodies(scene)
    width, torque = scene.pair.face_width_mm, 1000.0 * scene.torques_Nm[0]
    turns = pair.pairing.turns(pair.position_rad)
    sites = np.flatnonzero(np.isin(pair.pairing.sites, [-1, 0]))
    bodies, axes = (pair.body_1, pair.body_2), (0.0, pair.pairing.center_distance_mm)
    placed: list[list[Flank]] = []
    for z, body in enumerate(bodies):
        s = flank_nodes(body.mesh)
        curves = [
            body.curve.rotated(turns[z][0] + pair.pairing.site_angles_rad[z][k]) for k in sites
        ]
        placed.append(
            [
                Flank(c.point(s) + np.array([axes[z], 0.0]), c.normal(s), c.tangent(s))
                for c in curves
            ]
        )
    # 2, 3.2: contact pairs on circles about O1, here through the nodes of flank 1
    radii, gaps, levers = [], [], []
    for one, two in zip(*placed, strict=True):
        r = one.radii[(one.radii > two.radii.min()) & (one.radii < two.radii.max())]
        radii.append(r)
        angles = [angles_to_deformed(flank, r, 0 * flank.points) for flank in (one, two)]
        gaps.append(angles[1] - angles[0])  # eps_anf = angle A O1 B
        levers.append(np.abs(np.sum(one.at(r, one.points) * one.at(r, one.tangents), axis=1)))
    gap, b = np.concatenate(gaps), np.concatenate(levers)  # b_i = r_i sin(gamma_i), (17)
    tables = [tuple(table / width for table in nodal_tables(body)) for body in bodies]
    forces, passes = np.full(b.size, 1.0), 0
    while True:  # influence numbers depend on the forces: those found are their range
        numbers = sum(
            influence_numbers(
                tables[z], 2 * z - 1, placed[z], pair.pairing.site_teeth[z][sites], radii, forces
            )
            for z in (0, 1)
        )  # (10)
        state = fl.solve_contact(numbers, b, gap, torque, method="paper")  # (18)-(20), (25)-(34)
        passes += 1
        found = np.maximum(state.normal_forces, 1.0)
        if passes > 1 and np.abs(found - forces).max() < 1e-4 * found.max():
            break
        forces = found
    carried = [part.sum() for part in np.split(state.normal_forces, [radii[0].size])]
    return float(state.rotation), np.array(carried) / sum(carried), passes


def default_route() -> tuple[float, np.ndarray]:
    """The same position by `fl.solve`: pressure modes, near field, small forces."""
    tree = tomllib.loads(SCENE.read_text(encoding="utf-8"))
    tree |= {"positions": {"angles_deg": [ANGLE_DEG]}}
    result = fl.solve(fl.Scene.from_dict(tree))
    return float(result.rotation_rad[0]), result.load_share[0]


def main() -> None:
    rotation, share = default_route()
    print(f"default way:        rotation {1e6 * rotation:8.2f} urad, load shares {share.round(4)}")
    for spacing in (0.2, 0.1):
        found, parts, passes = paper_route(spacing)
        print(
            f"paper, h = {spacing:4.2f} mm: rotation {1e6 * found:8.2f} urad "
            f"({100 * (found / rotation - 1):+.2f} %), load shares {parts.round(4)}, "
            f"{passes} passes"
        )


if __name__ == "__main__":
    main()
