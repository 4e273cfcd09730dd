"""Reading of flankload's compliance files: a body with the compliance of its flanks.

`elasticity.modal_arrays` writes the file; `docs/guide/compliance_files.md` describes the arrays.
Except for its elements, the body is identical to the one that was written.
"""

from __future__ import annotations

from dataclasses import MISSING, fields
from math import pi
from typing import TYPE_CHECKING, Any

import numpy as np

from flankload.bodies.axial_shape import PLANE_SHAPE, AxialShape
from flankload.bodies.body import Body
from flankload.bodies.imported.compliance import (
    CORNER_ANGLES,
    ModalCompliance,
    read_corner_angles,
    read_material,
)
from flankload.bodies.profile.involute import Involute
from flankload.bodies.tip_modes import LEAST_TIP_MODES, Tip
from flankload.flank import FlankCurve
from flankload.scene.table import LARGEST_LENGTH, MOST_TEETH, SMALLEST_LENGTH

if TYPE_CHECKING:
    from flankload.base.arrays import Floats
    from flankload.meshes.io.named_arrays import NamedArrays

FORMAT = "flankload flank compliance"
#: Latest version, for bodies in three dimensions. Plane bodies with a free corner or a rounded or
#: chamfered tip have version 3, others version 2, or without friction version 1.
VERSION = 4

#: Names of the arrays of a body in three dimensions.
AXIAL = ("face_width_mm", "axial_degree", "twist_rad_per_mm")
#: Names of the arrays, without those of the involute.
NAMES = (
    "format", "version", "kind", "teeth", "young_modulus_MPa", "poisson_ratio", "plane",
    "curve_breaks", "curve_coefficients", "curve_labels", "curve_corners", "mode_range_mm",
    *CORNER_ANGLES, "tip_modes", "turned", "smooth", "kernel", "smooth_nt", "kernel_nt",
    "asymmetry", "reference_radius_mm", "flank_angle_known", "pitch_errors_um", "flanks",
    "flank_turns_rad", "named_teeth", "outline", "bore_radius_mm", "notes", *AXIAL,
)  # fmt: skip
#: Fields of `Involute`, by their names in the file.
INVOLUTE = {f"involute_{field.name}": field for field in fields(Involute)}

#: Largest degree of modes along the axis, and rotation of the section along it, rad/mm.
LARGEST_DEGREE, LARGEST_TWIST = 60, 10.0
#: Largest gap between intervals of the curve, mm.
LARGEST_JUMP = 1e-6
#: Largest deviation of the curve's speed from 1, its value for arc length.
LARGEST_STRETCH = 1e-3


def read_modal(found: NamedArrays) -> Body:
    """Body of a file, checked.

    Raises
    ------
    ComplianceFileError
        If an array is missing, has a wrong shape, is not finite or contradicts another one; names
        file and array.
    """
    found.check_names(*NAMES, *INVOLUTE)
    teeth = found.integer("teeth", least=3, most=MOST_TEETH)
    curve = _read_curve(found)
    low, high = found.numbers("mode_range_mm", 2)
    if not 0.0 <= low < high <= curve.length_mm:
        expected = f"two ascending arc lengths from 0 to {curve.length_mm:g}"
        found.refuse("mode_range_mm", expected, f"{low:g} and {high:g}")
    flanks, named = _read_teeth(found, "flanks", teeth), _read_teeth(found, "named_teeth", teeth)
    if named and flanks != named:
        found.refuse("named_teeth", "none, or the teeth of flanks", f"{len(named)} others")
    turns = _read_per_tooth(found, "flank_turns_rad", teeth)
    if (np.abs(turns) > pi).any():
        found.refuse("flank_turns_rad", "angles from -pi to pi", f"{np.abs(turns).max():g}")
    imported = _read_compliance(found, flanks, teeth, (float(high), curve.length_mm))
    errors = _read_per_tooth(found, "pitch_errors_um", teeth)
    return Body(
        kind=found.text("kind"),
        curve=curve,
        teeth=teeth,
        material=read_material(found),
        rigid=False,
        mode_range_mm=(float(low), float(high)),
        reference_radius_mm=found.number("reference_radius_mm", above=0.0, most=LARGEST_LENGTH),
        involute=_read_involute(found),
        flank_angle_known=bool(found.integer("flank_angle_known", least=0, most=1)),
        pitch_errors_um=tuple(errors.tolist()),
        outline=_read_outline(found),
        bore_radius_mm=found.number("bore_radius_mm", least=0.0, most=LARGEST_LENGTH),
        notes=found.texts("notes"),
        flank_turns_rad=tuple(turns.tolist()),
        named_teeth=named,
        imported=imported,
        axial=_read_axial(found),
    )


def _read_axial(found: NamedArrays) -> AxialShape:
    """Width and helix of a body in three dimensions, about the middle of its width."""
    if not any(name in found for name in AXIAL):
        return PLANE_SHAPE
    half = 0.5 * found.number("face_width_mm", least=SMALLEST_LENGTH, most=LARGEST_LENGTH)
    twist = found.number("twist_rad_per_mm", least=-LARGEST_TWIST, most=LARGEST_TWIST)
    return AxialShape((-half, half), twist)


def _read_per_tooth(found: NamedArrays, name: str, teeth: int) -> Floats:
    """A number for each tooth, or none."""
    numbers = found.numbers(name, None)
    if numbers.size not in (0, teeth):
        found.refuse(name, f"no entries or {teeth}", f"{numbers.size}")
    return numbers


def _read_compliance(
    found: NamedArrays, flanks: tuple[int, ...], teeth: int, ends_mm: tuple[float, float]
) -> ModalCompliance:
    """The matrices of the modes; `ends_mm`: arc lengths at the ends of the flank and the curve."""
    blocks = len(flanks) ** 2 if flanks else teeth
    smooth = found.numbers("smooth", blocks, None, None)
    if smooth.shape[1] != smooth.shape[2] or not smooth.shape[1]:
        found.refuse("smooth", f"an array of shape ({blocks}, p, p), p >= 1", f"{smooth.shape}")
    tangential, jump = _read_tangential(found, smooth.shape)
    degree = None
    if any(name in found for name in AXIAL):
        degree = found.integer("axial_degree", least=0, most=LARGEST_DEGREE)
        if smooth.shape[1] % (degree + 1):
            expected = f"a multiple of {degree + 1} modes, as many as along the axis"
            found.refuse("smooth", expected, smooth.shape[1])
    along = smooth.shape[1] // (1 + (degree or 0))
    return ModalCompliance(
        file=found.file,
        plane=found.text("plane", "strain", "stress"),
        smooth=smooth,
        kernel=found.number("kernel", above=0.0),
        asymmetry=found.number("asymmetry", least=0.0),
        flanks=flanks,
        tangential=tangential,
        jump=jump,
        corner_angles_deg=read_corner_angles(found),
        tip=_read_tip(found, *ends_mm, along),
        axial_degree=degree,
    )


def _read_tip(found: NamedArrays, high: float, end: float, n_modes: int) -> Tip | None:
    """The tip behind a flank, between two arc lengths; None without one."""
    if "tip_modes" not in found:
        return None
    tip, power, turn = found.numbers("tip_modes", 3)
    if not high < tip <= end * (1.0 + LARGEST_STRETCH) or power not in (0, 1) or not 0 < turn < pi:
        expected = f"an arc length from {high:g} to {end:g}, 0 or 1, and an angle up to pi"
        found.refuse("tip_modes", expected, f"{tip:g}, {power:g} and {turn:g}")
    if n_modes <= LEAST_TIP_MODES:
        found.refuse("smooth", f"more than the {LEAST_TIP_MODES} modes of the tip", f"{n_modes}")
    return Tip(float(tip), int(power), float(turn))


def _read_tangential(found: NamedArrays, shape: tuple[int, ...]) -> tuple[Floats | None, float]:
    """Response to tangential loads and coefficient of its jump, both or neither."""
    names = ("smooth_nt", "kernel_nt")
    if not any(name in found for name in names):
        return None, 0.0
    tangential = found.numbers("smooth_nt", None, None, None)
    if tangential.shape != shape:
        found.refuse("smooth_nt", f"an array of shape {shape} like smooth", f"{tangential.shape}")
    return tangential, found.number("kernel_nt", least=0.0)


def _read_teeth(found: NamedArrays, name: str, teeth: int) -> tuple[int, ...]:
    """Ascending tooth numbers from 0, or none."""
    numbers = found.integers(name, None)
    ascending = (np.diff(numbers) > 0).all()
    if numbers.size and not (ascending and numbers[0] == 0 and numbers[-1] < teeth):
        expected = f"nothing, or ascending numbers from 0 to at most {teeth - 1}"
        found.refuse(name, expected, ", ".join(f"{number}" for number in numbers[:8]))
    return tuple(numbers.tolist())


def _read_outline(found: NamedArrays) -> Floats:
    outline = found.numbers("outline", None, 2)
    if len(outline) < 3:
        found.refuse("outline", "at least 3 places", f"{len(outline)}")
    return outline


def _read_curve(found: NamedArrays) -> FlankCurve:
    """The flank curve, checked: ascending breaks, no gaps."""
    breaks = found.numbers("curve_breaks", None)
    if breaks.size < 2 or breaks[0] != 0.0 or (np.diff(breaks) <= 0.0).any():
        found.refuse("curve_breaks", "arc lengths that ascend from 0", "others")
    parts = breaks.size - 1
    coefficients = found.numbers("curve_coefficients", parts, 2, None)
    labels = found.texts("curve_labels")
    if len(labels) != parts:
        found.refuse("curve_labels", f"{parts}, one for each interval", f"{len(labels)}")
    corners = found.flags("curve_corners", breaks.size)
    curve = FlankCurve(breaks, coefficients, labels, corners)
    steps = np.diff(breaks)
    powers = steps[:, None] ** np.arange(coefficients.shape[2])
    ends = np.einsum("nik,nk->ni", coefficients, powers)
    apart = np.linalg.norm(ends[:-1] - coefficients[1:, :, 0], axis=1)
    if (apart > LARGEST_JUMP).any():
        k = int(apart.argmax())
        found.refuse(
            "curve_coefficients",
            "intervals that meet at their ends",
            f"intervals {k} and {k + 1} {apart[k]:.3g} mm apart",
        )
    speed = np.linalg.norm(curve.derivatives(breaks)[1], axis=1)
    if (np.abs(speed - 1.0) > LARGEST_STRETCH).any():
        k = int(np.abs(speed - 1.0).argmax())
        expected = "a curve by its own arc length (speed 1)"
        found.refuse("curve_coefficients", expected, f"a speed of {speed[k]:.4g} at break {k}")
    return curve


def _read_involute(found: NamedArrays) -> Involute | None:
    """The complete involute, or None."""
    if not any(name in found for name in INVOLUTE):
        return None
    values: dict[str, Any] = {}
    for name, part in INVOLUTE.items():
        if name not in found and part.default is not MISSING:
            continue
        if part.name == "outward":
            values[part.name] = int(found.integers(name))
            if abs(values[part.name]) != 1:
                found.refuse(name, "1 (teeth outwards) or -1 (inwards)", values[part.name])
        elif name.endswith("_mm"):
            values[part.name] = found.number(name, above=0.0, most=LARGEST_LENGTH)
        else:
            values[part.name] = found.number(name, least=-2 * pi, most=2 * pi)
    involute = Involute(**values)
    heights = np.array([involute.root_radius_mm, involute.form_radius_mm, involute.tip_radius_mm])
    if (np.diff(involute.outward * heights) < 0).any():
        sense = "ascend" if involute.outward > 0 else "descend"
        found.refuse(
            "involute_form_radius_mm",
            f"radii that {sense} from the root over the form to the tip circle",
            " ".join(f"{radius:g}" for radius in heights),
        )
    return involute
