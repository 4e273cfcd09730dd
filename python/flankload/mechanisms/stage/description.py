"""Rows of `flankload check` for a planetary stage, and its data sheet."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flankload.mechanisms.data_sheet import DataSheet, SheetRow
from flankload.mechanisms.flank_pair.data_sheet import rows_of_mesh, rows_of_profile_and_body
from flankload.mechanisms.flank_pair.description import rows_of_body
from flankload.mechanisms.premises import require_premises
from flankload.mechanisms.protocol import Description
from flankload.mechanisms.several.premises import broken_by_geometry
from flankload.mechanisms.stage.assembly import NAMES, StageAssembly, assemble
from flankload.pairing.gear_pair import describe_gears
from flankload.pairing.stage import orbit_orders, surviving_order
from flankload.result.stage import HIGHEST_ORDER
from flankload.scene.stage import clearance_mm

if TYPE_CHECKING:
    from flankload.base.arrays import Floats
    from flankload.mechanisms.protocol import Rows
    from flankload.scene import Scene

#: Roles of the bodies.
ROLES = ("sun", "planet", "ring")


def describe(scene: Scene) -> Description:
    """Describe bodies, meshes, phases and orders; raises a SceneError if they are impossible."""
    assembly = assemble(scene)
    rows = {
        (role if name == role else f"{name}: {role}"): rows_of_body(body, getattr(scene, name))
        for name, role, body in zip(NAMES, ROLES, assembly.bodies, strict=True)
    }
    for title, _, mesh in assembly.different_meshes:
        rows[title] = list(describe_gears(mesh.gears))
    rows["stage"] = _rows_of_stage(scene, assembly)
    broken = require_premises(scene, broken_by_geometry(assembly))
    return Description(rows, (*assembly.notes, *(one.note for one in broken)))


def _rows_of_stage(scene: Scene, assembly: StageAssembly) -> Rows:
    stage, pairing = scene.stage, assembly.pairing
    assert stage is not None
    zs, _, zr = pairing.teeth
    rows = [
        ("centre distance", f"{pairing.center_distance_mm:.8g} mm"),
        ("face width", f"{assembly.face_width_mm:g} mm"),
        ("ratio, carrier driven and ring at rest", f"{1 + zr / zs:.6g}"),
        ("planets at", f"{_listed(np.degrees(pairing.angles_rad))} deg"),
        ("possible angles", f"multiples of {360 / (zs + zr):.6g} deg from planet 1"),
    ]
    clear = clearance_mm(stage, pairing.center_distance_mm, scene.planet.tip_diameter_mm)  # type: ignore[union-attr]
    if np.isfinite(clear):
        rows.append(("clearance of neighbouring planets", f"{clear:.4f} mm"))
    rows += [
        ("phases of the meshes with the sun", f"{_listed(pairing.sun_phases)} pitches"),
        ("phases of the meshes with the ring", f"{_listed(pairing.ring_phases)} pitches"),
        (
            "orders that survive without errors",
            _orders(pairing.count, zs, even=pairing.equally_spaced),
        ),
        ("orders of the orbit of the sun", _orbit(pairing.count, zs, even=pairing.equally_spaced)),
        ("floating", f"{stage.floating}"),
    ]
    errors = 1000.0 * pairing.path_errors(assembly.errors.pins_mm)
    if errors.any():
        rows.append(("errors of the pins along the paths", f"{_listed(errors)} um"))
    if any(stage.play_mm):
        clearances = 2000.0 * np.array(stage.play_mm)
        rows.append(("clearances of the bearings on the pins", f"{_listed(clearances)} um"))
    return rows


def _listed(values: Floats) -> str:
    """Numbers with up to six digits; phases at both ends of a pitch are alike."""
    return ", ".join(f"{round(float(value), 6) + 0.0:g}" for value in values)


def _orders(count: int, sun_teeth: int, *, even: bool) -> str:
    if not even:
        return "all, since the planets are not equally spaced"
    order = surviving_order(count, sun_teeth)
    return "all" if order == 1 else f"multiples of {order} ({order}, {2 * order}, {3 * order}, ...)"


def _orbit(count: int, sun_teeth: int, *, even: bool) -> str:
    if not even:
        return "all, since the planets are not equally spaced"
    found = orbit_orders(count, sun_teeth, HIGHEST_ORDER)
    if not found:
        return "none: a floating sun stays in the middle"
    return ", ".join(f"{order:+d}" for order in found[:4]) + ", ..."


def data_sheet(scene: Scene) -> DataSheet:
    """Drawing data of sun and ring, of the planets, and of the stage."""
    assembly = assemble(scene)
    sun, planet, ring = (
        rows_of_profile_and_body(body, getattr(scene, name), scene)
        for name, body in zip(NAMES, assembly.bodies, strict=True)
    )
    meshes = assembly.pairing.meshes
    rows = [SheetRow("number of planets", "", f"{assembly.pairing.count}")]
    rows += [SheetRow(f"planet: {row.name}", row.symbol, row.value) for row in planet]
    for mesh, name in ((meshes[0], "sun"), (meshes[-1], "ring")):
        rows += rows_of_mesh(mesh.gears, f"with the {name}")
    return DataSheet(("sun", "ring"), (tuple(sun), tuple(ring)), tuple(rows))
