"""Flank tolerances of cylindrical gears by ISO 1328-1:2013."""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, floor, hypot, radians, sqrt

from flankload.base.arguments import require_number
from flankload.scene.refusal import refuse

#: Ranges of the formulas, which 5.2.1 forbids to extrapolate.
LARGEST_CLASS, DIAMETER_MM = 11, (5.0, 15000.0)
RANGES = {
    "teeth": (5, 1000),
    "module_mm": (0.5, 70.0),
    "face_width_mm": (4.0, 1200.0),
    "helix_angle_deg": (0.0, 45.0),
}


@dataclass(frozen=True)
class FlankTolerances:
    """Tolerances of the flanks of a gear, um; from `iso_1328`.

    Attributes
    ----------
    tolerance_class : int
        1 to 11.
    single_pitch_um, total_pitch_um : float
        f_pT, F_pT: along the arc of the reference circle.
    profile_slope_um, profile_form_um, total_profile_um : float
        f_HαT, f_fαT, F_αT.
    helix_slope_um, helix_form_um, total_helix_um : float
        f_HβT, f_fβT, F_βT: along the base tangent of the transverse section.
    """

    tolerance_class: int
    single_pitch_um: float
    total_pitch_um: float
    profile_slope_um: float
    profile_form_um: float
    total_profile_um: float
    helix_slope_um: float
    helix_form_um: float
    total_helix_um: float


def iso_1328(
    tolerance_class: int,
    *,
    teeth: int,
    module_mm: float,
    face_width_mm: float,
    helix_angle_deg: float = 0.0,
) -> FlankTolerances:
    """Flank tolerances of a gear by its class.

    Parameters
    ----------
    tolerance_class : int
        A, 1 (finest) to 11.
    teeth : int
        z, 5 to 1000.
    module_mm : float
        Normal module m_n, 0.5 to 70 mm.
    face_width_mm : float
        b, 4 to 1200 mm.
    helix_angle_deg : float
        On the reference cylinder, up to 45 deg. The reference diameter d = z m_n / cos(beta) must
        be 5 to 15000 mm.

    Returns
    -------
    FlankTolerances
        Rounded by 5.2.3: to 1 um above 10 um, to 0.5 um from 5 um, to 0.1 um below.

    Raises
    ------
    SceneError
        If a number is outside the range of the standard.

    Notes
    -----
    ISO 1328-1:2013, Cylindrical gears - ISO system of flank tolerance classification - Part 1,
    5.3, formulas (5) to (12).
    """
    if isinstance(tolerance_class, bool) or tolerance_class not in range(1, LARGEST_CLASS + 1):
        refuse("class", "an integer from 1 to 11 (ISO 1328-1)", tolerance_class)
    values = (teeth, module_mm, face_width_mm, helix_angle_deg)
    for (key, (least, most)), value in zip(RANGES.items(), values, strict=True):
        require_number(key, value)
        if not least <= value <= most:
            refuse(key, f"a number from {least:g} to {most:g}, the range of ISO 1328-1", value)
    d = teeth * module_mm / cos(radians(helix_angle_deg))
    if not DIAMETER_MM[0] <= d <= DIAMETER_MM[1]:
        expected = "a reference diameter from 5 to 15000 mm, the range of ISO 1328-1"
        refuse("module_mm", expected, f"{d:.6g} mm")
    found = _formulas(d, module_mm, face_width_mm, sqrt(2.0) ** (tolerance_class - 5))  # 5.2.2
    return FlankTolerances(tolerance_class, *(_rounded(value) for value in found))


def _formulas(d: float, m: float, b: float, factor: float) -> tuple[float, ...]:
    """Formulas (5) to (12) in order, um, not rounded."""
    profile = (
        factor * (0.4 * m + 0.001 * d + 4.0),  # formula (7)
        factor * (0.55 * m + 5.0),  # formula (8)
    )
    helix = (
        factor * (0.05 * sqrt(d) + 0.35 * sqrt(b) + 4.0),  # formula (10)
        factor * (0.07 * sqrt(d) + 0.45 * sqrt(b) + 4.0),  # formula (11)
    )
    return (
        factor * (0.001 * d + 0.4 * m + 5.0),  # formula (5)
        factor * (0.002 * d + 0.55 * sqrt(d) + 0.7 * m + 12.0),  # formula (6)
        *profile,
        hypot(*profile),  # formula (9), of values that are not rounded
        *helix,
        hypot(*helix),  # formula (12)
    )


def _rounded(value_um: float) -> float:
    """A tolerance rounded by 5.2.3; halves are rounded up."""
    step = 1.0 if value_um > 10.0 else 0.5 if value_um >= 5.0 else 0.1
    return round(step * floor(value_um / step + 0.5), 1)
