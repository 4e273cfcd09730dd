"""The command check: what was understood of a scene or a mesh file."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from argparse import Namespace
    from collections.abc import Iterable
    from pathlib import Path

    from flankload.bodies.body import Body
    from flankload.effects import Switch
    from flankload.scene import Scene


def check(arguments: Namespace) -> None:
    """Print what was understood; raise where something is wrong."""
    from flankload.mesh_io import is_mesh_name

    (_check_mesh if is_mesh_name(arguments.file) else _check_scene)(arguments.file)


def _check_scene(path: Path) -> None:
    from flankload.scene import read_scene

    scene = read_scene(path)
    if scene.body_2.kind in ("chain", "belt"):
        _check_drive(scene)
        return
    from flankload.assembly import build_bodies
    from flankload.effects import EFFECTS, switches_of
    from flankload.gear_mesh import describe_mesh
    from flankload.premises import broken_by_geometry, held
    from flankload.spline_fit import describe_fit
    from flankload.stages import compliance_of
    from flankload.tolerance import first_discretization, first_scene

    picked = first_discretization(scene).tables()
    scene = first_scene(scene)
    pair = build_bodies(scene)
    for body in (pair.body_1, pair.body_2):
        if body.given is not None:
            compliance_of(body, scene)  # costs next to nothing and finds what is wrong
    print(f"{scene.name}: a valid scene")
    for name, body in (("body_1", pair.body_1), ("body_2", pair.body_2)):
        _print_rows(f"{name}: {body.kind}", _rows_of_body(body))
    mesh, fit = pair.pairing.mesh, pair.pairing.fit
    _print_rows(
        "pair",
        [
            ("offset" if fit else "centre distance", f"{scene.pair.axes_apart_mm:g} mm"),
            ("face width", f"{scene.pair.face_width_mm:g} mm"),
            *(describe_mesh(mesh) if mesh is not None else ()),
            *(describe_fit(fit) if fit is not None else ()),
        ],
    )
    if picked:
        keys = [(key, f"{value}") for table in picked.values() for key, value in table.items()]
        _print_rows(f"knobs that a tolerance of {scene.accuracy.tolerance:g} begins with", keys)
    switches = switches_of(scene)
    has_teeth = pair.pairing.motion is None
    rows = [row for row in EFFECTS if has_teeth or not row.of_teeth]
    _print_rows("effects", [(row.title, _said(switches[row.name])) for row in rows])
    if pair.notes:
        print()
    for note in pair.notes:
        print(f"warning: {note}")
    for broken in held(scene, tuple(broken_by_geometry(pair))):
        print(f"warning: {broken.note}")


def _check_drive(scene: Scene) -> None:
    from flankload.belt_drive import describe_belt
    from flankload.chain_drive import describe_drive
    from flankload.scene.usual import question_notes

    rows = describe_drive(scene) if scene.body_2.kind == "chain" else describe_belt(scene)
    print(f"{scene.name}: a valid scene")
    for title, found in rows.items():
        _print_rows(title, found)
    if notes := question_notes(scene):
        print()
    for note in notes:
        print(f"warning: {note}")


def _said(switch: Switch) -> str:
    return f"{'yes' if switch.on else 'no'} ({switch.because})"


def _rows_of_body(body: Body) -> list[tuple[str, str]]:
    rows = [] if body.kind in ("cam", "follower") else [("teeth", f"{body.teeth}")]
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
    elif body.curve.closed:
        radii = np.hypot(*body.outline.T)
        rows += [
            ("profile", f"{body.curve.length_mm:.4f} mm around"),
            ("radii of the profile", f"{radii.min():.4f} to {radii.max():.4f} mm"),
        ]
    else:
        rows.append(("reference radius", f"{body.reference_radius_mm:g} mm"))
    if body.given is not None:
        return [*rows, ("compliance", body.given.description)]
    if body.mesh is None:
        return [*rows, ("mesh", "none: rigid")]
    return [*rows, *_rows_of_mesh(body)]


def _rows_of_mesh(body: Body) -> list[tuple[str, str]]:
    from flankload.bodies import WholeMesh
    from flankload.mesh_report import quality_rows

    mesh = body.mesh
    assert mesh is not None
    low, high = (float(np.hypot(*body.curve.point([s])[0])) for s in body.mode_range_mm)
    whole = isinstance(mesh, WholeMesh)
    kinds = ", ".join(f"{len(data)} {kind}" for kind, data in mesh.cells)
    rows = [
        ("mesh of the whole body" if whole else "mesh of a sector",
         f"{len(mesh.nodes)} nodes, {kinds}"),
        *quality_rows(mesh.nodes, mesh.cells),
        ("held", f"{mesh.fixed_nodes.size} nodes, mean radius {body.bore_radius_mm:.4f} mm"),
        ("flank", f"{mesh.flank_elements} elements"
         + ("" if body.curve.closed else f", radii {low:.4f} to {high:.4f} mm")),
    ]  # fmt: skip
    if isinstance(mesh, WholeMesh) and len(mesh.flanks) > 1:
        rows.append(("flanks", f"{len(mesh.flanks)}"))
    if body.flank_nodes is not None:
        nodes = body.flank_nodes
        rows.append(("flank nodes", f"{nodes.count}, up to {nodes.spacing_mm:.3g} mm apart"))
    return rows


def _check_mesh(path: Path) -> None:
    from flankload.errors import MeshError
    from flankload.mesh_defects import find_defects
    from flankload.mesh_io import read_mesh
    from flankload.mesh_report import hints, mesh_rows, set_rows

    mesh = read_mesh(path)
    defects = list(find_defects(mesh))
    print(f"{path}: a plane mesh" + (" with defects" if defects else ""))
    _print_rows("mesh", mesh_rows(mesh))
    _print_rows("sets", set_rows(mesh) or [("none", "a scene needs flank and fixed sets")])
    remarks = [*mesh.notes, *hints(mesh)]
    if remarks:
        print()
    for remark in remarks:
        print(f"note: {remark}")
    if not defects:
        return
    print("\nwrong")
    for defect in defects:
        print(f"  expected {defect.expected}, found {defect.found}")
    raise MeshError(file=path, key="", expected=defects[0].expected, found=defects[0].found)


def _print_rows(title: str, rows: Iterable[tuple[str, str]]) -> None:
    rows = list(rows)
    width = max(24, *(len(name) for name, _ in rows))
    print(f"\n{title}")
    for name, value in rows:
        print(f"  {name:<{width}}  {value}")
