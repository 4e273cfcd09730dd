"""Belt profiles by name: dimensions of the tooth, and estimates of the stiffness.

Dimensions are nominal values of the standards, ISO 17396 and DIN 7721 for the T and AT series, ISO
13050 for HTD. A dimension that no published table confirms is absent, and the scene has to set it.
"""

from math import radians, tan
from typing import Literal, NamedTuple

ProfileName = Literal[
    "T2.5", "T5", "T10", "T20", "AT5", "AT10", "AT20", "HTD 3M", "HTD 5M", "HTD 8M", "HTD 14M"
]

#: Shore D hardness of the polyurethane of timing belts (92 Shore A).
SHORE_D = 40.0
#: Radius of a belt tooth over that of its groove, from HTD 5M (1.49 and 1.56 mm).
TOOTH_PER_GROOVE = 0.955


class Estimate(NamedTuple):
    """A value that catalogues do not print.

    Attributes
    ----------
    value : float
    reason : str
        Formula and source.
    """

    value: float
    reason: str


class BeltProfile(NamedTuple):
    """A profile of timing belts.

    Attributes
    ----------
    pitch_mm : float
    belt : dict of str to float
        Keys of the belt, printed values.
    estimates : dict of str to Estimate
        Further keys of the belt.
    source : str
        Sources of the printed values.
    """

    pitch_mm: float
    belt: dict[str, float]
    estimates: dict[str, Estimate]
    source: str


def shore_modulus(shore_d: float) -> float:
    """Young's modulus of an elastomer, MPa.

    log10 E = 0.0235 (D + 50) - 0.6403, H. J. Qi, K. Joyce, M. C. Boyce, Rubber Chem. Technol. 76
    (2003) 419.
    """
    return float(10.0 ** (0.0235 * (shore_d + 50.0) - 0.6403))


POLYURETHANE = Estimate(
    round(shore_modulus(SHORE_D), 1),
    "polyurethane of 92 Shore A = 40 Shore D, log10 E = 0.0235 (D + 50) - 0.6403 (Qi et al. 2003)",
)


def _cord(value: float, reason: str) -> dict[str, Estimate]:
    return {
        "cord_stiffness_N_per_mm": Estimate(value, f"steel cords, {reason}"),
        "young_modulus_MPa": POLYURETHANE,
    }


def _printed(newton: float, width: float) -> dict[str, Estimate]:
    value = newton / width
    return _cord(value, f"spring rate {newton:g} N at {width:g} mm width (catalogue of Elatech)")


def _scaled(value: float, how: str) -> dict[str, Estimate]:
    return _cord(value, f"{how}, since the cords grow with the pitch")


def _round_tooth(groove_radius: float) -> dict[str, Estimate]:
    diameter = round(2 * TOOTH_PER_GROOVE * groove_radius, 3)
    reason = f"diameter {TOOTH_PER_GROOVE:g} of that of the groove, as with HTD 5M"
    return {"tooth_width_mm": Estimate(diameter, reason)}


def _trapezoid(height: float, width: float, **more: float) -> dict[str, float]:
    return {"tooth_height_mm": height, "tooth_width_mm": width, "flank_angle_deg": 20.0, **more}


def _wide(height: float, head: float, **more: float) -> dict[str, float]:
    """A tooth of the AT series, by the width at its tip."""
    width = round(head + 2 * height * tan(radians(25.0)), 3)
    return {"tooth_height_mm": height, "tooth_width_mm": width, "flank_angle_deg": 25.0, **more}


def _round(height: float, belt_height: float, cord: float, **more: float) -> dict[str, float]:
    back = round(belt_height - height, 2)
    return {"tooth_height_mm": height, "back_mm": back, "land_distance_mm": cord, **more}


_T = "ISO 17396, DIN 7721-1; SDP/SI handbook D265"
_AT = "ISO 17396"
_HTD = "ISO 13050; SDP/SI handbook D265"

BELT_PROFILES = {
    "T2.5": BeltProfile(2.5, _trapezoid(0.7, 1.5, land_distance_mm=0.3, back_mm=0.6),
                        _scaled(4500.0, "half of that of T5"), _T),
    "T5": BeltProfile(5.0, _trapezoid(1.2, 2.65, land_distance_mm=0.5, back_mm=1.0),
                      _printed(90000.0, 10.0), _T),
    "T10": BeltProfile(10.0, _trapezoid(2.5, 5.3, land_distance_mm=1.0, back_mm=2.0),
                       _scaled(17700.0, "between T5 (9000) and T20 (35200)"), _T),
    "T20": BeltProfile(20.0, _trapezoid(5.0, 10.15), _printed(880000.0, 25.0), "ISO 17396"),
    "AT5": BeltProfile(5.0, _wide(1.2, 2.5, land_distance_mm=0.6), _printed(437500.0, 25.0),
                       f"{_AT}; pulleys TTPA of Misumi"),
    "AT10": BeltProfile(10.0, _wide(2.5, 5.0, land_distance_mm=0.9),
                        _scaled(29300.0, "between AT5 (17500) and AT20 (52800)"), _AT),
    "AT20": BeltProfile(20.0, _wide(5.0, 10.0, back_mm=3.0), _printed(1320000.0, 25.0),
                        f"{_AT}; catalogue of Elatech"),
    "HTD 3M": BeltProfile(3.0, _round(1.21, 2.4, 0.381),
                          {**_printed(127500.0, 15.0), **_round_tooth(0.91)}, _HTD),
    "HTD 5M": BeltProfile(5.0, _round(2.08, 3.8, 0.572, tooth_width_mm=2.98),
                          _printed(220000.0, 10.0), _HTD),
    "HTD 8M": BeltProfile(8.0, _round(3.38, 6.0, 0.686),
                          {**_scaled(35200.0, "8/5 of that of HTD 5M"), **_round_tooth(2.57)},
                          "ISO 13050"),
    "HTD 14M": BeltProfile(14.0, _round(6.02, 10.0, 1.397),
                           {**_scaled(61600.0, "14/5 of that of HTD 5M"), **_round_tooth(4.65)},
                           "ISO 13050"),
}  # fmt: skip
