"""Rows of `flankload check` for a gear train, and its data sheet."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flankload.mechanisms.data_sheet import DataSheet, SheetRow
from flankload.mechanisms.flank_pair.data_sheet import rows_of_mesh, rows_of_profile_and_body
from flankload.mechanisms.flank_pair.description import rows_of_body
from flankload.mechanisms.premises import require_premises
from flankload.mechanisms.protocol import Description
from flankload.mechanisms.several.premises import broken_by_geometry
from flankload.mechanisms.train.assembly import NAMES, TrainAssembly, assemble
from flankload.pairing.gear_pair import describe_gears

if TYPE_CHECKING:
    from flankload.mechanisms.protocol import Rows
    from flankload.scene import Scene

#: Roles of the bodies by the kind of train.
ROLES = {
    "idler": ("driver", "driven", "idler"),
    "two_pinions": ("wheel", "pinion", "second pinion"),
    "double_helical": ("pinion", "wheel"),
}


def describe(scene: Scene) -> Description:
    """Describe bodies, meshes, phases and forces; raises a SceneError if they are impossible."""
    assert scene.train is not None
    assembly = assemble(scene)
    roles = ROLES[scene.train.kind]
    rows = {
        f"{name}: {role}": rows_of_body(body, getattr(scene, name))
        for name, role, body in zip(assembly.names, roles, assembly.bodies, strict=True)
    }
    for _, _, mesh in assembly.different_meshes:
        rows[" and ".join(mesh.names)] = list(describe_gears(mesh.gears))
    rows["train"] = _rows_of_train(scene, assembly)
    broken = require_premises(scene, broken_by_geometry(assembly))
    return Description(rows, (*assembly.notes, *(one.note for one in broken)))


def _rows_of_train(scene: Scene, assembly: TrainAssembly) -> Rows:
    train, pairing = scene.train, assembly.pairing
    assert train is not None
    if train.is_double_helical:
        moves = "without resistance"
        if train.axial_stiffness_N_per_um is not None:
            moves = f"on {train.axial_stiffness_N_per_um:g} N/um"
        rows = [
            ("face width of a half", f"{assembly.face_width_mm:g} mm"),
            ("width of the groove", f"{train.groove_width_mm:g} mm"),
        ]
        if train.groove_diameter_mm is not None:
            rows.append(("diameter of body_1 in the groove", f"{train.groove_diameter_mm:g} mm"))
        return [*rows, ("body_1 moves along its axis", moves)]
    common = NAMES[pairing.common]
    rows = [
        ("face width", f"{assembly.face_width_mm:g} mm"),
        (f"angle at {common}", f"{train.angle_deg:g} deg"),
    ]
    for name, center in zip(NAMES, pairing.axes_mm, strict=True):
        x, y = np.round(center, 6) + 0.0
        rows.append((f"axis of {name}", f"{x:g}, {y:g} mm"))
    phases = ", ".join(f"{round(mesh.phase, 6) + 0.0:g}" for mesh in pairing.meshes)
    rows.append(("phases of the meshes", f"{phases} pitches"))
    one, two = (mesh.push for mesh in pairing.meshes)
    both = float(np.hypot(*(one - two if pairing.is_idler else one + two)))
    rows.append((f"force on the bearings of {common}", f"{both:.4f} of the force of a mesh"))
    if train.kind == "two_pinions":
        rows.append((f"{common} floats", "yes" if train.floating else "no"))
    return rows


def data_sheet(scene: Scene) -> DataSheet:
    """Drawing data of bodies 1 and 2, of body 3, and of both meshes."""
    assembly = assemble(scene)
    one, two, *third = (
        rows_of_profile_and_body(body, getattr(scene, name), scene)
        for name, body in zip(assembly.names, assembly.bodies, strict=True)
    )
    rows = [
        SheetRow(f"body 3: {row.name}", row.symbol, row.value) for three in third for row in three
    ]
    for _, _, mesh in assembly.different_meshes:
        rows += rows_of_mesh(mesh.gears, f"of {' and '.join(mesh.names)}")
    return DataSheet(("gear", "gear"), (tuple(one), tuple(two)), tuple(rows))
