"""Reference values of helical pairs by three-dimensional finite elements, for their `case.json`.

    python benchmarks/solid_elements.py helical_internal_pair [--meshes 0 1 2]

solves the scene of the case on three meshes, writes the values of each to `meshes.json` in the
folder of the case, and the extrapolated ones with their uncertainties to `case.json`.

No part of the contact model of flankload takes part: no pressure modes, no half-space, no mirror
images, no lumped contact. Elements, their condensation and the closed ring are those of flankload
(quadratic in the section, polynomials along the helix), with elements far shorter than the
contacts are wide. `docs/theory/solid_references.md` describes the method.
"""

from __future__ import annotations

import argparse
import json
import tomllib
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from time import process_time
from typing import Any
from unittest import mock

import numpy as np
from scipy.interpolate import PchipInterpolator

import flankload as fl
from flankload.bodies import Body
from flankload.bodies.involute import sector_breaks
from flankload.elasticity.fronts.condensation import condense_nodes
from flankload.elasticity.near_field import loaded_edges
from flankload.elasticity.prism import Prism
from flankload.elasticity.sector_closure import Harmonics
from flankload.mechanisms.flank_pair.assembly import build_bodies
from flankload.meshes.blocks import even_breaks
from flankload.pairing.body_pair import BodyPair

HERE = Path(__file__).resolve().parent
#: Positions of each case.
POSITIONS = {"helical_internal_pair": (3, 1, 5), "helical_sharp_corner": (7,)}
#: Middles of the parts of the width over which line loads are means, and their length, mm.
PLACES_MM, LENGTH_MM = (-6.5, -5.0, -3.0, -1.0, 1.0, 3.0, 5.0, 6.5), 1.0
#: Cells have gaps up to this multiple of the expected rotation, and reach that far to both sides of
#: the least gap, mm: the contacts are 0.2 to 0.4 mm wide on each side.
REACH, BESIDE_MM = 1.15, 0.55
#: Ends of the cells beside the end of a flank, in cells: the pressure is singular on a sharp tip.
BESIDE_END = (0.0, 0.06, 0.15, 0.3, 0.6, 1.0, 1.5)
#: Points of a flank curve at which polar angles are tabled.
TABLED = 6001
#: Line loads below this part of the mean are small.
SMALL = 0.1
#: Least uncertainties: rotation (part), forces (part of their sum), line loads (part of the mean).
LEAST = {"rotation": 2e-4, "pair_force": 3e-4, "line_load_at": 5e-3}


@dataclass(frozen=True)
class Mesh:
    """A mesh: element length on the flanks and inside, degree along the axis and on cuts, cells.

    `corner_mm`: element length beside tip corners and where the mates' tip corners touch.
    """

    element_mm: float
    inner_mm: float
    degree: int
    cut_degree: int
    cell_mm: float
    slices: int
    corner_mm: float | None = None


#: Three meshes of each case. From one to the next, cells and elements at corners are shorter by the
#: root of 2.
MESHES = {
    "helical_internal_pair": (
        Mesh(0.32, 2.0, 12, 6, 0.1414, 8),
        Mesh(0.28, 2.0, 16, 6, 0.1, 10),
        Mesh(0.24, 2.0, 22, 6, 0.0707, 14),
    ),
    "helical_sharp_corner": (
        Mesh(0.34, 2.0, 12, 6, 0.08, 8, 0.1),
        Mesh(0.3, 2.0, 16, 6, 0.0566, 10, 0.0707),
        Mesh(0.26, 2.0, 20, 6, 0.04, 12, 0.05),
    ),
}
#: Distance from a corner over which elements are short, mm, and their growth per mm beyond it.
AT_CORNER_MM, BEYOND_CORNER = 0.35, 0.4


@dataclass(frozen=True)
class Cells:
    """Cells of a position: site, slice, gap angle, lever (n,), and g points of each, with weights.

    `s`, `direction`: arc lengths (n, g) and directions of the force (n, g, 3) on both flanks.
    """

    edges_mm: np.ndarray
    site: np.ndarray
    slice: np.ndarray
    gap: np.ndarray
    lever: np.ndarray
    z: np.ndarray
    weight: np.ndarray
    s: tuple[np.ndarray, np.ndarray]
    direction: tuple[np.ndarray, np.ndarray]


def built(scene: dict[str, Any], **accuracy: float) -> BodyPair:
    """Bodies with their elements, in three dimensions."""
    keys = {"estimate": False, "tangents": False, **accuracy}
    return build_bodies(
        fl.Scene.from_dict({**scene, "accuracy": keys, "effects": {"dimension": 3}})
    )


def corner_places(pair: BodyPair) -> dict[float, float]:
    """Arc lengths at which flanks meet the mates' tip corners, by those of their own corners.

    On the line of action of an external pair.
    """
    found, bodies = {}, (pair.body_1, pair.body_2)
    radii = [body.base_radius_mm for body in bodies]
    whole = np.sqrt(pair.pairing.center_distance_mm**2 - sum(radii) ** 2)
    for body, mate, radius in zip(bodies, bodies[::-1], radii, strict=True):
        tip = np.hypot(*mate.curve.point([mate.curve.length_mm])[0])
        curvature = whole - np.sqrt(tip**2 - mate.base_radius_mm**2)
        s = np.linspace(body.mode_range_mm[0], body.curve.length_mm, TABLED)
        meets = np.interp(np.hypot(curvature, radius), np.hypot(*body.curve.point(s).T), s)
        found[float(s[-1])] = float(meets)
    return found


def fine_bodies(scene: dict[str, Any], mesh: Mesh) -> BodyPair:
    """Bodies with short elements along the flanks that grow inside."""
    part, least = mesh.inner_mm / mesh.element_mm, mesh.corner_mm or mesh.element_mm
    corners = corner_places(built(scene)) if mesh.corner_mm else {}

    def breaks(start: float, end: float, largest: float, least_count: int = 1) -> np.ndarray:
        """Ends of elements that are short beside corners."""
        meets = [place for tip, place in corners.items() if abs(tip - end) < 1e-6]
        if not meets:
            return even_breaks(start, end, largest, least_count)
        s = np.linspace(start, end, TABLED)
        away = np.minimum(np.abs(s - end), np.abs(s - meets[0]))
        size = least + BEYOND_CORNER * np.maximum(away - AT_CORNER_MM, 0.0)
        density = 1.0 / np.minimum(size, largest)
        count = np.append(0.0, np.cumsum(0.5 * (density[1:] + density[:-1]) * np.diff(s)))
        return np.interp(np.linspace(0.0, count[-1], int(np.ceil(count[-1])) + 1), count, s)

    changed = {
        "FILLET": 0.4 * part,
        "FIRST_LAYER": 0.5 * least / mesh.element_mm,
        "INNER": part,
        "FIRST_ROW": 0.4 * part,
        "even_breaks": breaks,
    }
    with mock.patch.multiple(sector_breaks, **changed):
        return built(scene, flank_element_mm=mesh.element_mm)


def turn(angle: float) -> np.ndarray:
    """Counter-clockwise rotation."""
    return np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])


class Section:
    """Two flanks in the transverse section at z: which points meet when body 1 turns.

    A point of flank 1 moves on a circle about axis 1, to the point of flank 2 with this radius. The
    force has the mean of the normals of both flanks.
    """

    def __init__(self, pair: BodyPair, site: int, position: float, z: float) -> None:
        self.bodies, self.angles = (pair.body_1, pair.body_2), []
        turns = pair.pairing.turns(np.array([position]))
        found = []
        for k, body in enumerate(self.bodies):
            angle = float(turns[k][0] + pair.pairing.site_angles_rad[k][site])
            self.angles.append(angle + body.axial.twist_rad_per_mm * z)
            s = np.linspace(body.mode_range_mm[0], body.curve.length_mm, TABLED)
            point = body.curve.point(s) @ turn(self.angles[k]).T
            point[:, 0] += k * pair.pairing.center_distance_mm
            found.append((s, np.hypot(*point.T), np.unwrap(np.arctan2(*point.T[::-1]))))
        one, two = found
        if two[1][0] > two[1][-1]:
            two = tuple(values[::-1] for values in two)
        self.tables = one, two
        ends = max(one[1].min(), two[1].min()), min(one[1].max(), two[1].max())
        self.meets = bool((np.diff(two[1]) > 0).all()) and ends[0] < ends[1]
        if not self.meets:  # a flank far round the body
            return
        self.low, self.high = np.interp(ends, one[1], one[0])
        s = np.linspace(self.low, self.high, TABLED)
        gap = self.partners(s)[1]
        self.nearest, self.least = s[gap.argmin()], gap.min()

    def partners(self, s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Arc lengths on flank 2 for those on flank 1, and rotations of body 1 until they touch."""
        (s_1, r_1, angle_1), (s_2, r_2, angle_2) = self.tables
        radius = np.interp(s, s_1, r_1)
        gap = np.interp(radius, r_2, angle_2) - np.interp(s, s_1, angle_1)
        return np.interp(radius, r_2, s_2), np.angle(np.exp(1j * gap))

    def forces(self, s: tuple[np.ndarray, ...]) -> tuple[np.ndarray, list[np.ndarray]]:
        """Levers of the forces about axis 1, and their directions in the frames of both bodies."""
        normals, first = [], np.zeros(0)
        for body, places, angle in zip(self.bodies, s, self.angles, strict=True):
            at = np.clip(places, 1e-9, body.curve.length_mm - 1e-9)
            point, tangent = body.curve.point(at), body.curve.tangent(at)
            normal = np.stack([-tangent[:, 1], tangent[:, 0]], axis=1)
            lever = point[:, 0] * normal[:, 1] - point[:, 1] * normal[:, 0]
            along = -body.axial.twist_rad_per_mm * lever
            found = np.column_stack([normal @ turn(angle).T, along])
            normals.append(found / np.linalg.norm(found, axis=1, keepdims=True))
            first = first if first.size else point @ turn(angle).T
        sign = np.sign((normals[0] * normals[1]).sum())
        mean = normals[0] + sign * normals[1]
        mean /= np.linalg.norm(mean, axis=1, keepdims=True)
        local = [np.column_stack([mean[:, :2] @ turn(a), mean[:, 2]]) for a in self.angles]
        return np.abs(first[:, 0] * mean[:, 1] - first[:, 1] * mean[:, 0]), local


def slice_edges(low: float, high: float, count: int) -> np.ndarray:
    """Ends of slices as long as what polynomials along the axis resolve: shorter at both ends."""
    return 0.5 * (low + high) - 0.5 * (high - low) * np.cos(np.pi * np.arange(count + 1) / count)


def spans_of(sections: list[Section], cell: float) -> list[np.ndarray]:
    """Ends (q + 1,) of the cells of a slice in each section, from the end of a flank if it is near.

    Otherwise from the contact line, with which the cells of regular contacts move.
    """
    near = BESIDE_MM + cell
    for sign, end in ((-1.0, "high"), (1.0, "low")):
        away = [abs(getattr(section, end) - section.nearest) for section in sections]
        if min(away) < near:
            reach = max(away) + BESIDE_MM
            graded = np.array(BESIDE_END) * cell
            steps = np.append(graded, np.arange(graded[-1] + cell, reach + cell, cell))
            return [np.sort(getattr(section, end) + sign * steps) for section in sections]
    count = int(np.ceil(BESIDE_MM / cell))
    return [section.nearest + np.arange(-count, count + 1) * cell for section in sections]


def cells_of(pair: BodyPair, position: float, mesh: Mesh, rotation: float) -> Cells:
    """Cells of all pairs of flanks that may touch at a rotation."""
    ranges = np.array([body.axial.range_mm for body in (pair.body_1, pair.body_2)])
    edges = slice_edges(ranges[:, 0].max(), ranges[:, 1].min(), mesh.slices)
    across, along = np.polynomial.legendre.leggauss(4), np.polynomial.legendre.leggauss(3)
    rows = []
    for site in range(pair.pairing.sites.size):
        for j, (start, end) in enumerate(pairwise(edges)):
            z = 0.5 * (start + end) + 0.5 * (end - start) * along[0]
            sections = [Section(pair, site, position, place) for place in z]
            if not all(each.meets for each in sections):
                continue
            if min(each.least for each in sections) > REACH * rotation:
                continue
            spans = spans_of(sections, mesh.cell_mm)
            for q in range(len(spans[0]) - 1):
                points = []
                for each, span, place, part in zip(sections, spans, z, along[1], strict=True):
                    low, high = np.clip(span[q : q + 2], each.low, each.high)
                    if high > low:
                        s = 0.5 * (low + high) + 0.5 * (high - low) * across[0]
                        other, gap = each.partners(s)
                        lever, directions = each.forces((s, other))
                        weight = part * across[1] * (high - low)
                        points.append((s, other, np.full_like(s, place), weight, gap, lever,
                                       *directions))  # fmt: skip
                if len(points) < len(z):  # beyond the end of a flank
                    continue
                s, other, places, weight, gap, lever, one, two = map(
                    np.concatenate, zip(*points, strict=True)
                )
                weight = weight / weight.sum()
                if gap @ weight < 1.5 * rotation:
                    rows.append((site, j, gap @ weight, lever @ weight, places, weight, s, other,
                                 one, two))  # fmt: skip
    site, j, gap, lever, z, weight, s, other, one, two = map(np.array, zip(*rows, strict=True))
    return Cells(edges, site, j, gap, lever, z, weight, (s, other), (one, two))


def loads_of(body: Body, prism: Prism, cells: Cells, k: int) -> tuple[np.ndarray, np.ndarray]:
    """Nodes (m,) of the flank, and consistent loads (m, unknowns, n) of unit forces on cells."""
    from flankload.elasticity.loaded_body import on_edges  # after the compliance, its user

    assert body.mesh is not None
    edges, arc = loaded_edges(body.mesh)
    at, shapes = on_edges(arc, cells.s[k].ravel())
    nodes, number = np.unique(edges, return_inverse=True)
    number = number.reshape(edges.shape)
    functions = prism.axial.values(cells.z.ravel())
    parts = np.einsum("g,ga,gf,gc->gafc", cells.weight.ravel(), shapes, functions,
                      cells.direction[k].reshape(-1, 3))  # fmt: skip
    count, points = cells.s[k].shape
    found = np.zeros((nodes.size, 3 * functions.shape[1], count))
    cell = np.repeat(np.arange(count), points)
    for a in range(3):
        np.add.at(found, (number[at, a], slice(None), cell), parts[:, a].reshape(cell.size, -1))
    return nodes, found


def compliance_of(body: Body, mesh: Mesh, cells: Cells, k: int, tooth: np.ndarray) -> np.ndarray:
    """Mean displacements (n, n) of cells along their forces under unit forces on cells, mm/N.

    One sector is condensed to all forces on its flank, and the ring of sectors closed by harmonics.
    """
    assert isinstance(body.mesh, fl.bodies.SectorMesh)
    twist = body.axial.twist_rad_per_mm
    prism = Prism(body.axial.range_mm, twist, mesh.degree, cut_degree=mesh.cut_degree)
    section = prism.section(body.mesh, body.material)
    nodes, on_flank = loads_of(body, prism, cells, k)
    loads = np.zeros((len(body.mesh.nodes), section.unknowns, tooth.size))
    loads[nodes] = on_flank
    sector = condense_nodes(section, body.mesh, loads)
    found = np.where(tooth[:, None] == tooth, sector.local[0], 0.0)
    ring, teeth = Harmonics(sector, body.mesh.teeth), body.mesh.teeth
    for harmonic in range(teeth // 2 + 1):
        weight = 1.0 if harmonic == 0 or 2 * harmonic == teeth else 2.0
        wave = np.exp(2j * np.pi * harmonic * tooth / teeth)
        carried = ring.loads(harmonic)[0] * wave.conj()
        found += weight / teeth * np.real(carried.conj().T @ ring.solved(harmonic, carried))
    return 0.5 * (found + found.T)


def solve(scene: dict[str, Any], position: int, mesh: Mesh, rotation: float) -> dict[str, float]:
    """Quantities of a position by one mesh."""
    began = process_time()
    pair = fine_bodies(scene, mesh)
    cells = cells_of(pair, float(pair.position_rad[position]), mesh, rotation)
    matrix = np.zeros((cells.site.size, cells.site.size))
    for k, body in enumerate((pair.body_1, pair.body_2)):
        tooth = pair.pairing.site_teeth[k][cells.site]
        matrix += compliance_of(body, mesh, cells, k, tooth)
    torque = 1000.0 * scene["load"]["torque_Nm"]
    state = fl.solve_contact(matrix / cells.lever[:, None], cells.lever, cells.gap, torque)
    found = {f"rotation[{position}]": state.rotation}
    for number, site in enumerate(pair.pairing.sites.tolist()):
        forces = np.where(cells.site == number, state.normal_forces, 0.0)
        if not forces.any():
            continue
        found[f"pair_force[{position}, {site}]"] = forces.sum()
        carried = np.append(0.0, np.cumsum(np.bincount(cells.slice, forces, mesh.slices)))
        between = PchipInterpolator(cells.edges_mm, carried)
        for z in PLACES_MM:
            ends = between([z - 0.5 * LENGTH_MM, z + 0.5 * LENGTH_MM])
            found[f"line_load_at[{position}, {site}, {z}]"] = np.diff(ends)[0] / LENGTH_MM
    nodes = [len(body.mesh.nodes) for body in (pair.body_1, pair.body_2) if body.mesh is not None]
    print(f"position {position}, {mesh}", flush=True)
    print(f"    nodes of sections {nodes}, {cells.site.size} cells, {process_time() - began:.0f} s")
    print(f"    rotation {state.rotation:.8g}", flush=True)
    return {name: float(value) for name, value in found.items()}


def extrapolated(values: list[float], least: float) -> tuple[float, float]:
    """Value and uncertainty: by the second order where the change decreases, else the last one."""
    coarse, middle, fine = values
    before, last = middle - coarse, fine - middle
    decreases = abs(last) < abs(before) and last * before > 0.0
    value = fine + last if decreases else fine
    return value, max(abs(last), 0.5 * abs(before), least)


def quantities_of(meshes: dict[str, list[float]], width_mm: float) -> dict[str, dict[str, Any]]:
    """Quantities of the case from the values by three meshes.

    Line loads are left out where they are small, and beside that: a contact ends within a slice.
    """
    found = {}
    for name, values in meshes.items():
        kind, indices = name.rstrip("]").split("[")
        position, *place = indices.split(", ")
        total = sum(v[-1] for n, v in meshes.items() if n.startswith(f"pair_force[{position}, "))
        if kind == "line_load_at":
            at = PLACES_MM.index(float(place[1]))
            beside = [
                f"{kind}[{position}, {place[0]}, {z}]" for z in PLACES_MM[max(0, at - 1) : at + 2]
            ]
            if min(meshes[each][-1] for each in beside) < SMALL * total / width_mm:
                continue
        unit = {"rotation": "rad", "pair_force": "N", "line_load_at": "N/mm"}[kind]
        size = {"rotation": values[-1], "pair_force": total, "line_load_at": total / width_mm}[kind]
        value, uncertainty = extrapolated(values, LEAST[kind] * size)
        found[name] = {
            "value": float(f"{value:.6g}" if kind == "rotation" else f"{value:.1f}"),
            "uncertainty": float(f"{uncertainty:.2g}"),
            "unit": unit,
        }
    return found


def main() -> None:
    """Solve a case on the meshes that are asked for, and write its values."""
    parser = argparse.ArgumentParser()
    parser.add_argument("case", choices=POSITIONS)
    parser.add_argument("--meshes", type=int, nargs="*", default=[0, 1, 2])
    given = parser.parse_args()
    folder = HERE / given.case
    scene = tomllib.loads((folder / "scene.toml").read_text(encoding="utf-8"))
    scene.pop("effects", None)
    scene.pop("accuracy", None)
    expected = fl.solve(fl.Scene.from_dict({**scene, "effects": {"dimension": 3}})).rotation_rad
    path = folder / "meshes.json"
    known = json.loads(path.read_text(encoding="utf-8")) if path.exists() else {}
    for k in given.meshes:
        for position in POSITIONS[given.case]:
            mesh = MESHES[given.case][k]
            for name, value in solve(scene, position, mesh, expected[position]).items():
                known.setdefault(name, [None] * len(MESHES[given.case]))[k] = float(f"{value:.8g}")
            path.write_text(json.dumps(known, indent=1) + "\n", encoding="utf-8")
    complete = {name: values for name, values in known.items() if None not in values}
    case = json.loads((folder / "case.json").read_text(encoding="utf-8"))
    case["quantities"] = quantities_of(complete, scene["pair"]["face_width_mm"])
    text = json.dumps(case, indent=1, ensure_ascii=False)
    (folder / "case.json").write_text(text + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
