"""Meshes for tests: whole bodies from the FZG pair's sectors, and another kind of mesher."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.path import Path as Outline
from scipy.spatial import Delaunay

from flankload.bodies.body import Body
from flankload.meshes.io import RawMesh
from flankload.meshes.plane_mesh import boundary_edges, raise_to_quadratic
from tests.support.paths import MESHES, TEST_MESHES

PINION = MESHES / "fzg_c_pinion.msh"
WHEEL = MESHES / "fzg_c_wheel.msh"
#: The same pair with larger elements on its flanks, for tests of bodies meshed as a whole.
COARSE_MM = 2.5
COARSE_PINION = TEST_MESHES / "pinion_coarse.msh"
COARSE_WHEEL = TEST_MESHES / "wheel_coarse.msh"
Cells = tuple[tuple[str, np.ndarray], ...]


def turned(points: np.ndarray, angle: float) -> np.ndarray:
    c, s = np.cos(angle), np.sin(angle)
    return points @ np.array([[c, s], [-s, c]])


def edges_of(raw: RawMesh, name: str) -> np.ndarray:
    """Boundary edges of a set of a quadratic mesh."""
    edges = boundary_edges(raise_to_quadratic(raw.nodes, raw.cells)[1])
    return edges[np.isin(edges, raw.sets[name]).all(axis=1)]


def whole_of(raw: RawMesh, teeth: int) -> tuple[np.ndarray, Cells, dict[str, np.ndarray]]:
    """Nodes, cells and edge sets of the whole body of a sector with the sets FLANK and BORE."""
    count = len(raw.nodes)
    every = np.vstack([turned(raw.nodes, 2 * np.pi * k / teeth) for k in range(teeth)])
    _, first, number = np.unique(np.round(every, 6), axis=0, return_index=True, return_inverse=True)
    number = number.ravel()
    cells = tuple(
        (kind, number[np.vstack([data + count * k for k in range(teeth)])])
        for kind, data in raw.cells
    )
    flank, bore = edges_of(raw, "FLANK"), edges_of(raw, "BORE")
    sets = {f"FLANK_{k}": number[flank + count * k] for k in range(teeth)}
    sets["BORE"] = np.vstack([number[bore + count * k] for k in range(teeth)])
    return every[first], cells, sets


def delaunay_sector(
    body: Body, size: float, turn: float
) -> tuple[np.ndarray, Cells, dict[str, np.ndarray]]:
    """Six-node triangles in a sector of a gear, as from another mesher.

    Corner and mid-side nodes of the contour lie on the true profile.
    """
    involute = body.involute
    assert involute is not None
    low, high = body.mode_range_mm
    half = np.pi / body.teeth
    mirror = np.array([1.0, -1.0])
    at_root, at_tip = body.curve.point([0.0, body.curve.length_mm])
    # the body's own frame has tooth 0 centred on the x axis
    root, tip = (float(np.arctan2(place[1], place[0])) for place in (at_root, at_tip))

    def arc(radius: float, start: float, end: float):
        def place(t: np.ndarray) -> np.ndarray:
            angle = start + (end - start) * t
            return radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)

        return place

    def along(start: float, end: float, factor: np.ndarray):
        return lambda t: body.curve.point(start + (end - start) * t) * factor

    def ray(angle: float, start: float, end: float):
        return lambda t: (
            (start + (end - start) * t)[:, None] * np.array([np.cos(angle), np.sin(angle)])
        )

    foot, bore = involute.root_radius_mm, body.bore_radius_mm
    pieces = [
        ("", arc(foot, -half, -root), foot * (half - root)),
        ("", along(0.0, low, mirror), low),
        ("", along(low, high, mirror), high - low),
        ("", arc(involute.tip_radius_mm, -tip, tip), 2 * tip * involute.tip_radius_mm),
        ("FLANK", along(high, low, np.ones(2)), high - low),
        ("", along(low, 0.0, np.ones(2)), low),
        ("", arc(foot, root, half), foot * (half - root)),
        ("CUT_LEFT", ray(half, foot, bore), foot - bore),
        ("BORE", arc(bore, half, -half), 2 * half * bore),
        ("CUT_RIGHT", ray(-half, bore, foot), foot - bore),
    ]
    corners, middles, names = [], [], []
    for name, place, length in pieces:
        if length < 1e-9:
            continue
        parts = max(1, int(np.ceil(length / size)))
        corners.append(place(np.arange(parts) / parts))
        middles.append(place((np.arange(parts) + 0.5) / parts))
        names += [name] * parts
    contour, between = np.vstack(corners), np.vstack(middles)
    outline = Outline(contour)
    x, y = np.meshgrid(
        np.arange(contour[:, 0].min(), contour[:, 0].max(), size),
        np.arange(contour[:, 1].min(), contour[:, 1].max(), 0.87 * size),
    )
    x[::2] += 0.5 * size
    inner = np.stack([x.ravel(), y.ravel()], axis=1)
    apart = np.linalg.norm(inner[:, None] - contour[None], axis=2).min(axis=1)
    inner = inner[outline.contains_points(inner) & (apart > 0.7 * size)]
    nodes = np.vstack([contour, inner])
    triangles = Delaunay(nodes).simplices
    inside = outline.contains_points(nodes[triangles].mean(axis=1))
    nodes, cells = raise_to_quadratic(nodes, (("triangle", triangles[inside]),))
    ring = np.arange(len(contour))
    sets: dict[str, list[list[int]]] = {}
    edges = {tuple(sorted(edge[:2])): edge[2] for edge in boundary_edges(cells).tolist()}
    assert len(edges) == len(contour)
    for k, name in enumerate(names):
        first, last = int(ring[k]), int(ring[(k + 1) % len(contour)])
        middle = edges[tuple(sorted((first, last)))]
        nodes[middle] = between[k]
        if name:
            sets.setdefault(name, []).append([first, last, middle])
    return turned(nodes, turn), cells, {name: np.array(rows) for name, rows in sets.items()}


def write_gmsh_41(path: Path, nodes: np.ndarray, cells: Cells, sets: dict[str, np.ndarray]) -> None:
    """gmsh 4.1 as text: one surface, and a curve for each set of three-node edges."""
    types = {"triangle": 2, "quad": 3, "triangle6": 9, "quad9": 10, "quad8": 16}
    lines = ["$MeshFormat", "4.1 0 8", "$EndMeshFormat", "$PhysicalNames", str(1 + len(sets))]
    lines += ['2 1 "BODY"', *(f'1 {k} "{name}"' for k, name in enumerate(sets, start=2))]
    lines += ["$EndPhysicalNames", "$Entities", f"0 {len(sets)} 1 0"]
    lines += [f"{k} 0 0 0 1 1 0 1 {k} 0" for k in range(2, 2 + len(sets))]
    lines += ["1 0 0 0 1 1 0 1 1 0", "$EndEntities"]
    # node numbers with a gap, so that number and index differ
    number = np.arange(len(nodes)) + 11
    lines += ["$Nodes", f"1 {len(nodes)} 11 {number[-1]}", f"2 1 0 {len(nodes)}"]
    lines += [str(k) for k in number]
    lines += [f"{float(x)!r} {float(y)!r} 0" for x, y in nodes]
    blocks = [(2, 1, types[kind], data) for kind, data in cells]
    blocks += [(1, k, 8, edges) for k, edges in enumerate(sets.values(), start=2)]
    total = sum(len(block[3]) for block in blocks)
    lines += ["$EndNodes", "$Elements", f"{len(blocks)} {total} 1 {total}"]
    element = 0
    for dimension, entity, kind, data in blocks:
        lines.append(f"{dimension} {entity} {kind} {len(data)}")
        for row in number[data].tolist():
            element += 1
            lines.append(" ".join(map(str, [element, *row])))
    path.write_text("\n".join([*lines, "$EndElements", ""]), encoding="ascii")


TEETH = {"body_1": 16, "body_2": 24}


def sector(key: str, path: Path, **keys: object) -> dict[str, object]:
    return {"kind": "mesh", "file": str(path), "teeth": TEETH[key], **keys}


def whole(key: str, path: Path, **keys: object) -> dict[str, object]:
    names = [f"FLANK_{k}" for k in range(TEETH[key])]
    return {"kind": "mesh", "file": str(path), "flank_sets": names, **keys}
