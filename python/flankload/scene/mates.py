"""Rules between the involute profiles of two bodies that mesh."""

from __future__ import annotations

from math import cos
from typing import TYPE_CHECKING

from flankload.base.involute import PITCH_TOLERANCE
from flankload.scene.form import fields_of
from flankload.scene.involute import InvoluteKeys
from flankload.scene.refusal import refuse

if TYPE_CHECKING:
    from flankload.scene.table import BodyTable

#: Largest relative difference of modules that are one in the normal, one in the transverse section:
#: one of them is rounded.
ROUNDED_MODULE = 1e-3


def check_base_pitches(
    body_1: BodyTable, body_2: BodyTable, names: tuple[str, str] = ("body_1", "body_2")
) -> None:
    """Check that two profiles of gears have the same base pitch; the key that differs is refused.

    Bodies without the keys of a profile, and splines, are checked when they are paired.
    """
    (inside_1, one), (inside_2, two) = body_1.flank_keys, body_2.flank_keys
    if body_1.conforms or not isinstance(one, InvoluteKeys) or not isinstance(two, InvoluteKeys):
        return
    same_module = one.module_mm == two.module_mm
    if same_module and one.pressure_angle_deg == two.pressure_angle_deg:
        return  # helix angles are compared by their lead
    if abs(two.base_pitch_mm / one.base_pitch_mm - 1.0) <= PITCH_TOLERANCE:
        return
    name_1, name_2 = f"{names[0]}.{inside_1}", f"{names[1]}.{inside_2}"
    if same_module:
        expected = f"{one.pressure_angle_deg:g}, as in {name_1}pressure_angle_deg, since base "
        expected += "pitches (module times cos of the pressure angle) must be equal"
        default = fields_of(type(two))["pressure_angle_deg"].default
        found = f"{two.pressure_angle_deg:g}" + ", the default" * (
            default == two.pressure_angle_deg
        )
        refuse(f"{name_2}pressure_angle_deg", expected, found)
    for key, table, mate in ((name_1, one, two), (name_2, two, one)):
        normal = table.module_mm * cos(table.helix_rad)
        if table.helix_rad and abs(normal / mate.module_mm - 1.0) <= ROUNDED_MODULE:
            expected = f"{mate.module_mm:g}, the normal module, as of the other body"
            refuse(f"{key}module_mm", expected, f"{table.module_mm:g}, the transverse module")
    expected = f"{one.module_mm:g}, as in {name_1}module_mm: the base pitch of {names[0]}, "
    expected += f"{one.base_pitch_mm:.6f} mm (module times cos of the pressure angle)"
    found = f"{two.module_mm:g}, a base pitch of {two.base_pitch_mm:.6f} mm"
    refuse(f"{name_2}module_mm", expected, found)
