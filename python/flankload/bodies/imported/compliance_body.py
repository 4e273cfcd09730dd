"""Bodies of kind "compliance": a compliance imported from flankload or another program."""

from __future__ import annotations

from dataclasses import replace
from math import pi
from pathlib import Path
from typing import TYPE_CHECKING

from flankload.base.files import path_of
from flankload.base.rounding import TIE
from flankload.bodies.body import checked_pitch_errors
from flankload.bodies.imported import modal_file, nodal_file
from flankload.errors import SceneError
from flankload.meshes.io.named_arrays import read_arrays
from flankload.scene.involute import LARGEST_PITCH_ERROR

if TYPE_CHECKING:
    from flankload.bodies.body import Body
    from flankload.meshes.io.named_arrays import NamedArrays
    from flankload.scene import ComplianceBody

#: Latest version and reader of each file format.
READERS = {
    modal_file.FORMAT: (modal_file.VERSION, modal_file.read_modal),
    nodal_file.FORMAT: (nodal_file.VERSION, nodal_file.read_nodal),
}


def build_compliance_body(
    spec: ComplianceBody, key: str, *, folder: Path, ends_mm: tuple[float, float] | None
) -> Body:
    """Build a body from a compliance file; `ends_mm`: ends of its width in three dimensions.

    Raises
    ------
    ComplianceFileError
        If the file is missing, unreadable, of an unknown version, or does not describe a body.
    SceneError
        If the scene's pitch errors do not fit the number of teeth.
    """
    found = read_arrays(folder / path_of(spec.file), f"{key}.file")
    latest, read = READERS[found.text("format", *READERS)]
    version = int(found.integers("version"))
    if not 1 <= version <= latest:
        found.refuse(
            "version", f"at most {latest}, the latest version that this flankload reads", version
        )
    body = read(found)
    _check_width(found, body, ends_mm)
    slopes = spec.tooth_helix_slope_um
    if slopes and len(slopes) != body.teeth:
        expected = f"one entry per tooth: {body.teeth}, as in {found.file.name}"
        raise SceneError(
            key=f"{key}.tooth_helix_slope_um", expected=expected, found=f"{len(slopes)} entries"
        )
    named = checked_pitch_errors(spec.pitch_errors_um, body.teeth, key)
    errors = named or body.pitch_errors_um
    largest = LARGEST_PITCH_ERROR * 2000 * pi * body.reference_radius_mm / body.teeth
    if any(abs(error) > largest for error in errors):
        expected = f"at most {LARGEST_PITCH_ERROR:g} of the base pitch, {largest:.0f} um"
        worst = f"{max(errors, key=abs):g}"
        if not named:
            found.refuse("pitch_errors_um", expected, worst)
        raise SceneError(key=f"{key}.pitch_errors_um", expected=expected, found=worst)
    return replace(
        body,
        kind="compliance",
        rigid=spec.rigid,
        pitch_errors_um=errors,
        imported=None if spec.rigid else body.imported,
    )


def _check_width(found: NamedArrays, body: Body, ends_mm: tuple[float, float] | None) -> None:
    """Check that the file has a plane body in the plane, else a solid one of the same width."""
    if ends_mm is None:
        if not body.axial.plane:
            expected = "nothing, since the scene is plane (effects.dimension = 3 makes it "
            expected += "three-dimensional)"
            found.refuse("face_width_mm", expected, f"{body.axial.width_mm:g}")
        return
    width = ends_mm[1] - ends_mm[0]
    if body.axial.plane:
        expected = f"{width:g}, as flankload compliance writes it for a three-dimensional scene"
        found.refuse("face_width_mm", expected, "nothing: the compliance of a plane body")
    if abs(body.axial.width_mm - width) > TIE * width:
        expected = f"{width:.9g}, the face width of the body in the scene"
        found.refuse("face_width_mm", expected, f"{body.axial.width_mm:.9g}")
