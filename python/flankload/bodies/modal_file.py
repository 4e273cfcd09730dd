"""flankload's own compliance file: a body with the compliance of its flanks, number by number.

`docs/compliance_files.md` says what each array is. Read back, a body is the one that was written,
bit by bit, except that it has no elements any more.
"""

from __future__ import annotations

from dataclasses import MISSING, fields
from math import pi
from typing import TYPE_CHECKING, Any

import numpy as np

from flankload.bodies.body import Body
from flankload.bodies.free_corner import corner_angles
from flankload.bodies.given import (
    CORNER_ANGLES,
    ModalCompliance,
    read_corner_angles,
    read_material,
)
from flankload.bodies.involute import Involute
from flankload.flank_curve import FlankCurve
from flankload.scene.table import LARGEST_LENGTH, MOST_TEETH
from flankload.tip_modes import TIP_MODES, Tip

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from flankload.compliance import BodyCompliance
    from flankload.named_arrays import NamedArrays

FORMAT = "flankload flank compliance"
#: The latest version, of bodies with a free corner or a rounded or chamfered tip. A file without
#: one is of version 2, without friction of version 1, which earlier flankloads read.
VERSION = 3

#: The arrays, beside those of the involute.
NAMES = (
    "format",
    "version",
    "kind",
    "teeth",
    "young_modulus_MPa",
    "poisson_ratio",
    "plane",
    "curve_breaks",
    "curve_coefficients",
    "curve_labels",
    "curve_corners",
    "mode_range_mm",
    *CORNER_ANGLES,
    "tip_modes",
    "smooth",
    "kernel",
    "smooth_nt",
    "kernel_nt",
    "asymmetry",
    "reference_radius_mm",
    "flank_angle_known",
    "pitch_errors_um",
    "flanks",
    "flank_turns_rad",
    "named_teeth",
    "outline",
    "bore_radius_mm",
    "notes",
)
#: The fields of `Involute`, by their names in the file.
INVOLUTE = {f"involute_{field.name}": field for field in fields(Involute)}

#: Parts of the curve may lie this far apart where they meet, mm.
LARGEST_JUMP = 1e-6
#: The curve runs by its own arc length to this relative difference.
LARGEST_STRETCH = 1e-3


def modal_arrays(
    body: Body, compliance: BodyCompliance, *, plane: str
) -> Mapping[str, NDArray[Any]]:
    """What the file of a body holds.

    Parameters
    ----------
    body : Body
    compliance : BodyCompliance
        Of an elastic body.
    plane : {"strain", "stress"}

    Returns
    -------
    mapping of str to array
    """
    curve = body.curve
    arrays: dict[str, Any] = {
        "format": FORMAT,
        "version": _version(compliance),
        "kind": body.kind,
        "teeth": body.teeth,
        "young_modulus_MPa": body.material.young_modulus_MPa,
        "poisson_ratio": body.material.poisson_ratio,
        "plane": plane,
        "curve_breaks": curve.breaks,
        "curve_coefficients": curve.coefficients,
        "curve_labels": np.array(curve.labels, dtype=np.str_),
        "curve_corners": curve.corners,
        "mode_range_mm": compliance.mode_range_mm,
        "smooth": compliance.smooth,
        "kernel": compliance.kernel,
        "asymmetry": compliance.asymmetry,
        "reference_radius_mm": body.reference_radius_mm,
        "flank_angle_known": int(body.flank_angle_known),
        "pitch_errors_um": np.array(body.pitch_errors_um, dtype=float),
        "flanks": np.array(compliance.flanks, dtype=np.int64),
        "flank_turns_rad": np.array(body.flank_turns_rad, dtype=float),
        "named_teeth": np.array(body.named_teeth, dtype=np.int64),
        "outline": body.outline,
        "bore_radius_mm": body.bore_radius_mm,
        "notes": np.array(body.notes, dtype=np.str_),
    }
    if compliance.tangential is not None:
        arrays |= {"smooth_nt": compliance.tangential, "kernel_nt": compliance.jump}
    if any(compliance.wedge):
        arrays |= dict(zip(CORNER_ANGLES, corner_angles(body), strict=True))
    if compliance.tip is not None:
        arrays["tip_modes"] = compliance.tip
    if body.involute is not None:
        for name, part in INVOLUTE.items():
            arrays[name] = getattr(body.involute, part.name)
    return {name: np.asarray(value) for name, value in arrays.items()}


def read_modal(found: NamedArrays) -> Body:
    """Body of a file, checked.

    Parameters
    ----------
    found : NamedArrays

    Returns
    -------
    Body

    Raises
    ------
    ComplianceFileError
        If something is missing, has another shape, is not finite or contradicts the rest; names
        file and array.
    """
    found.check_names(*NAMES, *INVOLUTE)
    teeth = found.integer("teeth", least=3, most=MOST_TEETH)
    curve = _read_curve(found)
    low, high = found.numbers("mode_range_mm", 2)
    if not 0.0 <= low < high <= curve.length_mm:
        found.refuse(
            "mode_range_mm",
            f"two ascending arc lengths from 0 to {curve.length_mm:g}",
            f"{low:g} and {high:g}",
        )
    flanks, named = _read_teeth(found, "flanks", teeth), _read_teeth(found, "named_teeth", teeth)
    if named and flanks != named:
        found.refuse("named_teeth", "none, or the teeth of flanks", f"{len(named)} others")
    turns = found.numbers("flank_turns_rad", None)
    if turns.size not in (0, teeth):
        found.refuse("flank_turns_rad", f"no entries or {teeth}", f"{turns.size}")
    if (np.abs(turns) > pi).any():
        found.refuse("flank_turns_rad", "angles from -pi to pi", f"{np.abs(turns).max():g}")
    blocks = len(flanks) ** 2 if flanks else teeth
    smooth = found.numbers("smooth", blocks, None, None)
    if smooth.shape[1] != smooth.shape[2] or not smooth.shape[1]:
        found.refuse("smooth", f"an array of shape ({blocks}, p, p), p >= 1", f"{smooth.shape}")
    tangential, jump = _read_tangential(found, smooth.shape)
    given = ModalCompliance(
        file=found.file,
        plane=found.text("plane", "strain", "stress"),
        smooth=smooth,
        kernel=found.number("kernel", above=0.0),
        asymmetry=found.number("asymmetry", least=0.0),
        flanks=flanks,
        tangential=tangential,
        jump=jump,
        corner_angles_deg=read_corner_angles(found),
        tip=_read_tip(found, float(high), curve.length_mm, smooth.shape[1]),
    )
    errors = found.numbers("pitch_errors_um", None)
    if errors.size not in (0, teeth):
        found.refuse("pitch_errors_um", f"no entries or {teeth}", f"{errors.size}")
    return Body(
        kind=found.text("kind"),
        curve=curve,
        teeth=teeth,
        material=read_material(found),
        rigid=False,
        mesh=None,
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
        given=given,
    )


def _version(compliance: BodyCompliance) -> int:
    """The least version that says all of a compliance."""
    if any(compliance.wedge) or compliance.tip is not None:
        return 3
    return 1 if compliance.tangential is None else 2


def _read_tip(found: NamedArrays, high: float, end: float, n_modes: int) -> Tip | None:
    """Where the modes of a tip end behind those of the flank, their lowest power, and the turn."""
    if "tip_modes" not in found:
        return None
    tip, power, turn = found.numbers("tip_modes", 3)
    if not high < tip <= end * (1.0 + LARGEST_STRETCH) or power not in (0, 1) or not 0 < turn < pi:
        found.refuse(
            "tip_modes",
            f"an arc length from {high:g} to {end:g}, 0 or 1, and an angle up to pi",
            f"{tip:g}, {power:g} and {turn:g}",
        )
    if n_modes <= TIP_MODES:
        found.refuse("smooth", f"more than the {TIP_MODES} modes of the tip", f"{n_modes}")
    return Tip(float(tip), int(power), float(turn))


def _read_tangential(
    found: NamedArrays, shape: tuple[int, ...]
) -> tuple[NDArray[np.float64] | None, float]:
    """Response to loads along the flank and strength of its jump, both or neither."""
    names = ("smooth_nt", "kernel_nt")
    if not any(name in found for name in names):
        return None, 0.0
    tangential = found.numbers("smooth_nt", None, None, None)
    if tangential.shape != shape:
        found.refuse("smooth_nt", f"an array of shape {shape} like smooth", f"{tangential.shape}")
    return tangential, found.number("kernel_nt", least=0.0)


def _read_teeth(found: NamedArrays, name: str, teeth: int) -> tuple[int, ...]:
    """Teeth by number, ascending, the first one among them; or none."""
    numbers = found.integers(name, None)
    ascending = (np.diff(numbers) > 0).all()
    if numbers.size and not (ascending and numbers[0] == 0 and numbers[-1] < teeth):
        found.refuse(
            name,
            f"nothing, or ascending numbers from 0 to at most {teeth - 1}",
            ", ".join(f"{number}" for number in numbers[:8]),
        )
    return tuple(numbers.tolist())


def _read_outline(found: NamedArrays) -> NDArray[np.float64]:
    outline = found.numbers("outline", None, 2)
    if len(outline) < 3:
        found.refuse("outline", "at least 3 places", f"{len(outline)}")
    return outline


def _read_curve(found: NamedArrays) -> FlankCurve:
    """The flank's curve: ascending, without gaps, from root to tip."""
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
        found.refuse(
            "curve_coefficients",
            "a curve by its own arc length (speed 1)",
            f"a speed of {speed[k]:.4g} at break {k}",
        )
    return curve


def _read_involute(found: NamedArrays) -> Involute | None:
    """All that is known of the involute, or nothing."""
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
