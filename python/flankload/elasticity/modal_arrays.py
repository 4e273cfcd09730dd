"""Arrays of a flankload compliance file, which `bodies.imported.modal_file` reads."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from flankload.bodies.free_corner import corner_angles
from flankload.bodies.imported.compliance import CORNER_ANGLES
from flankload.bodies.imported.modal_file import AXIAL, FORMAT, INVOLUTE

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from flankload.bodies import Body
    from flankload.elasticity.compliance import BodyCompliance


def modal_arrays(
    body: Body, compliance: BodyCompliance, *, plane: str
) -> Mapping[str, NDArray[Any]]:
    """Arrays of the compliance file of an elastic body; plane is "strain" or "stress"."""
    curve = body.curve
    arrays: dict[str, Any] = {
        "format": FORMAT,
        "version": _version(body, compliance),
        "kind": body.kind,
        "teeth": body.teeth,
        "young_modulus_MPa": body.material.young_modulus_MPa,
        "poisson_ratio": body.material.poisson_ratio,
        "plane": plane,
        "curve_breaks": curve.breaks,
        "curve_coefficients": curve.coefficients,
        "curve_labels": np.array(curve.labels, dtype=np.str_),
        "curve_corners": curve.corners,
        "mode_range_mm": compliance.modes.range_mm,
        "smooth": compliance.smooth,
        "kernel": compliance.near.kernel,
        "asymmetry": compliance.job.asymmetry,
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
    if any(compliance.near.wedge):
        arrays |= dict(zip(CORNER_ANGLES, corner_angles(body), strict=True))
    if compliance.modes.tip is not None:
        arrays["tip_modes"] = compliance.modes.tip
    if compliance.tangential is not None:
        arrays |= {"smooth_nt": compliance.tangential, "kernel_nt": compliance.near.jump}
    if body.involute is not None:
        for name, part in INVOLUTE.items():
            arrays[name] = getattr(body.involute, part.name)
    if not body.axial.plane:
        axial = compliance.modes.axial
        numbers = body.axial.width_mm, axial.degree, axial.twist
        arrays |= dict(zip(AXIAL, numbers, strict=True))
    return {name: np.asarray(value) for name, value in arrays.items()}


def _version(body: Body, compliance: BodyCompliance) -> int:
    """Lowest version of the format for a compliance."""
    if not body.axial.plane:
        return 4
    if any(compliance.near.wedge) or compliance.modes.tip is not None:
        return 3
    return 1 if compliance.tangential is None else 2
