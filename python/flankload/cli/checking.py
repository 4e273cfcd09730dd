"""The command check: what was understood of a scene or a mesh file."""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from argparse import Namespace
    from collections.abc import Iterable
    from pathlib import Path

    from flankload.bodies.body import Body


def check(arguments: Namespace) -> None:
    """Print what was understood; raise where something is wrong."""
    from flankload.mesh_io import is_mesh_name

    (_check_mesh if is_mesh_name(arguments.file) else _check_scene)(arguments.file)


def _check_scene(path: Path) -> None:
    from flankload.scene import read_scene

    scene = read_scene(path)
    from flankload.assembly import build_bodies
    from flankload.effects import effects_of
    from flankload.gear_mesh import describe_mesh

    pair = build_bodies(scene)
    print(f"{scene.name}: a valid scene")
    for name, body in (("body_1", pair.body_1), ("body_2", pair.body_2)):
        _print_rows(f"{name}: {body.kind}", _rows_of_body(body))
    mesh = pair.pairing.mesh
    _print_rows(
        "pair",
        [
            ("centre distance", f"{scene.pair.center_distance_mm:g} mm"),
            ("face width", f"{scene.pair.face_width_mm:g} mm"),
            *(describe_mesh(mesh) if mesh is not None else ()),
        ],
    )
    asked = asdict(effects_of(scene))
    _print_rows("effects", [(name.replace("_", " "), _yes(on)) for name, on in asked.items()])
    if pair.notes:
        print()
    for note in pair.notes:
        print(f"warning: {note}")


def _yes(on: bool) -> str:
    return "yes" if on else "no"


def _rows_of_body(body: Body) -> list[tuple[str, str]]:
    rows = [("teeth", f"{body.teeth}")]
    involute = body.involute
    if involute is not None:
        for name, radius in (
            ("root", involute.root_radius_mm),
            ("form", involute.form_radius_mm),
            ("base", involute.base_radius_mm),
            ("tip", involute.tip_radius_mm),
        ):
            rows.append((f"{name} diameter", f"{2 * radius:.4f} mm"))
        tip = involute.tip_radius_mm
        rows.append(
            ("tooth thickness at tip", f"{2 * tip * involute.tooth_half_angle_at(tip):.4f} mm")
        )
    else:
        rows.append(("reference radius", f"{body.reference_radius_mm:g} mm"))
    if body.mesh is not None:
        cells = sum(len(data) for _, data in body.mesh.cells)
        size = f"{len(body.mesh.nodes)} nodes, {cells} elements"
        rows.append(("mesh of a sector", f"{size}, {len(body.mesh.flank_edges)} along the flank"))
    else:
        rows.append(("mesh of a sector", "none: rigid"))
    return rows


def _check_mesh(path: Path) -> None:
    from flankload.mesh_io import read_mesh

    mesh = read_mesh(path)
    print(f"{path}: a plane mesh")
    low, high = mesh.nodes.min(axis=0), mesh.nodes.max(axis=0)
    _print_rows(
        "mesh",
        [
            ("nodes", f"{len(mesh.nodes)}"),
            *((kind, f"{len(data)} elements") for kind, data in mesh.cells),
            ("x", f"{low[0]:g} to {high[0]:g} mm"),
            ("y", f"{low[1]:g} to {high[1]:g} mm"),
        ],
    )
    rows = [(name, f"{len(nodes)} nodes") for name, nodes in sorted(mesh.sets.items())]
    _print_rows("sets", rows or [("none", "a scene needs flank, fixed and cut sets")])


def _print_rows(title: str, rows: Iterable[tuple[str, str]]) -> None:
    rows = list(rows)
    width = max(24, *(len(name) for name, _ in rows))
    print(f"\n{title}")
    for name, value in rows:
        print(f"  {name:<{width}}  {value}")
