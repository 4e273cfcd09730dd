"""Units of REXS as those of a scene; the unit is that of the file, never that of the database."""

from __future__ import annotations

from math import pi

#: By the unit in which a scene counts: factors from the units that a file may name. Spellings are
#: those of the database ("mum", "N / mm^2", "°" up to REXS 1.3) and the usual ones beside them.
FACTORS: dict[str, dict[str, float]] = {
    "": {"": 1.0, "none": 1.0},
    "mm": {"mm": 1.0, "m": 1e3, "cm": 10.0, "mum": 1e-3, "um": 1e-3, "µm": 1e-3, "μm": 1e-3},
    "um": {"mum": 1.0, "um": 1.0, "µm": 1.0, "μm": 1.0, "mm": 1e3, "m": 1e6},
    "deg": {"deg": 1.0, "°": 1.0, "rad": 180.0 / pi},
    "N m": {"N m": 1.0, "Nm": 1.0, "N mm": 1e-3, "kN m": 1e3},
    "MPa": {"N / mm^2": 1.0, "N/mm^2": 1.0, "MPa": 1.0, "Pa": 1e-6, "GPa": 1e3},
}
#: Digits of a converted number: 0.023 mm is 23 um, not 23.000000000000004.
DIGITS = 14


def converted(value: float, unit: str, wanted: str) -> float | None:
    """A number in the unit of a scene, a key of `FACTORS`; None for another kind of unit."""
    factor = FACTORS[wanted].get(" ".join(unit.split()))
    if factor is None:
        return None
    return value if factor == 1.0 else float(f"{value * factor:.{DIGITS}g}")
