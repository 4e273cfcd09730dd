"""Roller chains by name (ISO 606, ASME B29.1), and estimates of their stiffness."""

from math import pi
from typing import Literal, NamedTuple

from flankload.scene.belt_profiles import Estimate

ChainName = Literal[
    "05B",
    "06B",
    "08B",
    "10B",
    "12B",
    "16B",
    "20B",
    "24B",
    "28B",
    "32B",
    "25",
    "35",
    "41",
    "40",
    "50",
    "60",
    "80",
    "100",
    "120",
    "140",
    "160",
]
#: Steel of plates and pins; modulus in MPa.
YOUNG_MODULUS_MPA, POISSON_RATIO = 206000.0, 0.3
#: Thickness, and height of the outer plates, over the pitch (ASME B29.1).
PLATE_THICKNESS, PLATE_HEIGHT = 0.125, 0.82
#: Shear correction of a full circle.
SHEAR_CORRECTION = 0.9
#: Stiffness of a steel roller on a plane, N/mm^(17/9) (ISO/TS 16281).
ROLLER_STIFFNESS = 35948.0
#: Working tension over the minimum tensile strength.
WORKING_TENSION = 1.0 / 8.0
INCH = 25.4


class ChainSize(NamedTuple):
    """A roller chain of one strand.

    Attributes
    ----------
    pitch_mm, roller_diameter_mm : float
    inner_width_mm : float
        Minimum width between the inner plates.
    pin_diameter_mm : float
    tensile_strength_kN : float
        Minimum tensile strength.
    """

    pitch_mm: float
    roller_diameter_mm: float
    inner_width_mm: float
    pin_diameter_mm: float
    tensile_strength_kN: float

    @property
    def link_stiffness_N(self) -> float:
        """Tension per unit of strain of two plates in series with the pins.

        Per pitch p and tension: p/(E 2 t (h - d)) + [t/(k G A) + t³/(12 E I)]/2, Timoshenko beam
        of the length t between the middle planes of the plates, guided at both ends.
        """
        thickness = PLATE_THICKNESS * self.pitch_mm
        pin, modulus = self.pin_diameter_mm, YOUNG_MODULUS_MPA
        section = 2 * thickness * (PLATE_HEIGHT * self.pitch_mm - pin)
        shear = modulus / (2 * (1 + POISSON_RATIO)) * SHEAR_CORRECTION * 0.25 * pi * pin**2
        bending = 12 * modulus * pi * pin**4 / 64
        beam = thickness / shear + thickness**3 / bending
        return self.pitch_mm / (self.pitch_mm / (modulus * section) + 0.5 * beam)

    @property
    def contact_stiffness_N_per_mm(self) -> float:
        """Secant stiffness of a roller between pocket and bush at the working tension.

        F = 35948 L^(8/9) d^(10/9) for each of the two contacts in series, ISO/TS 16281.
        """
        force = 1000.0 * WORKING_TENSION * self.tensile_strength_kN
        one = ROLLER_STIFFNESS**0.9 * self.inner_width_mm**0.8 * force**0.1
        return 0.5 * one

    @property
    def estimates(self) -> dict[str, Estimate]:
        """Keys of the chain that catalogues do not print."""
        return {
            "link_stiffness_N": Estimate(
                float(f"{self.link_stiffness_N:.3g}"),
                "plates of p/8 x 0.82 p with the pin's hole, and pins as Timoshenko beams",
            ),
            "contact_stiffness_N_per_mm": Estimate(
                float(f"{self.contact_stiffness_N_per_mm:.3g}"),
                "roller on pocket and bush, F = 35948 L^(8/9) d^(10/9) (ISO/TS 16281) at an eighth "
                "of the tensile strength",
            ),
        }


def _inches(pitch: float, roller: float, width: float, pin: float, strength_lb: float) -> ChainSize:
    return ChainSize(
        round(INCH * pitch, 3),
        round(INCH * roller, 3),
        round(INCH * width, 3),
        round(INCH * pin, 3),
        round(4.448222e-3 * strength_lb, 1),
    )


#: ISO 606, series B; series A by its number in ASME B29.1.
CHAIN_SIZES = {
    "05B": ChainSize(8.0, 5.0, 3.0, 2.31, 4.4),
    "06B": ChainSize(9.525, 6.35, 5.72, 3.28, 8.9),
    "08B": ChainSize(12.7, 8.51, 7.75, 4.45, 17.8),
    "10B": ChainSize(15.875, 10.16, 9.65, 5.08, 22.2),
    "12B": ChainSize(19.05, 12.07, 11.68, 5.72, 28.9),
    "16B": ChainSize(25.4, 15.88, 17.02, 8.28, 60.0),
    "20B": ChainSize(31.75, 19.05, 19.56, 10.19, 95.0),
    "24B": ChainSize(38.1, 25.4, 25.4, 14.63, 160.0),
    "28B": ChainSize(44.45, 27.94, 30.99, 15.9, 200.0),
    "32B": ChainSize(50.8, 29.21, 30.99, 17.81, 250.0),
    "25": _inches(0.25, 0.130, 0.125, 0.0905, 780.0),
    "35": _inches(0.375, 0.200, 0.188, 0.141, 1760.0),
    "41": _inches(0.5, 0.306, 0.250, 0.141, 1500.0),
    "40": _inches(0.5, 0.312, 0.312, 0.156, 3125.0),
    "50": _inches(0.625, 0.400, 0.375, 0.200, 4880.0),
    "60": _inches(0.75, 0.469, 0.500, 0.234, 7030.0),
    "80": _inches(1.0, 0.625, 0.625, 0.312, 12500.0),
    "100": _inches(1.25, 0.750, 0.750, 0.375, 19530.0),
    "120": _inches(1.5, 0.875, 1.000, 0.437, 28125.0),
    "140": _inches(1.75, 1.000, 1.000, 0.500, 38280.0),
    "160": _inches(2.0, 1.125, 1.250, 0.562, 50000.0),
}
