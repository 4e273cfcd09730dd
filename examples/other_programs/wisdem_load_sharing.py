"""Mass of a wind turbine's gearbox in WISDEM, with the K_gamma of flankload for its first stage.

flankload run examples/other_programs/wind_5mw_stage_1.toml --json floating.json
flankload run examples/other_programs/wind_5mw_stage_1.toml --json fixed.json \
    --set stage.floating=none
python wisdem_load_sharing.py floating.json fixed.json

Needs wisdem, in any environment. WISDEM sizes a stage for its most loaded planet: K_gamma is 1.1 up
to four planets and 1.35 beyond. Prints the mass with these constants and with the computed K_gamma
of each file; the second stage keeps its constant.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np
import openmdao.api as om
from wisdem.drivetrainse import gearbox

#: The 5 MW reference turbine.
RATIO, TORQUE_NM, RATING_KW, ROTOR_DIAMETER_M = 96.354, 3.946e6, 5000.0, 126.0
PLANETS_OF_STAGE_2 = 3
#: WISDEM's function of the volume of two planetary stages and a parallel one.
VOLUME = gearbox.volumeEEP


def constant(planets: int) -> float:
    """The K_gamma of WISDEM."""
    return 1.1 if planets < 5 else 1.35


def require_constants(planets: int) -> None:
    """End this program if WISDEM has other constants."""
    ratios, torque = np.array([4.0, 5.0, 3.0]), 1.0
    shares = torque / np.cumprod(ratios)
    counts = (planets, PLANETS_OF_STAGE_2)
    expected = shares[2] * gearbox.V_parallel(ratios[2]) / np.prod(ratios)
    for share, ratio, count in zip(shares, ratios, counts, strict=False):
        expected += share * constant(count) * gearbox.V_planetary(ratio, count, gearbox.Kr)
    found = VOLUME(ratios, np.array([*counts, 1.0]), torque)
    if abs(2.0 * expected / found - 1.0) > 1e-12:
        raise SystemExit("this version of WISDEM has other constants K_gamma")


def mass_kg(planets: int, load_factor: float) -> float:
    """Mass of the gearbox with a K_gamma of the first stage."""

    def volume(x, n_planets, torque):
        excess = load_factor - constant(planets)
        stage = gearbox.V_planetary(x[0], planets, gearbox.Kr)
        return VOLUME(x, n_planets, torque) + 2.0 * torque / x[0] * excess * stage

    problem = om.Problem(reports=False)
    problem.model.add_subsystem("gearbox", gearbox.Gearbox(direct_drive=False), promotes=["*"])
    problem.setup()
    values = {
        "gear_configuration": "eep",
        "planet_numbers": [planets, PLANETS_OF_STAGE_2, 0],
        "gear_ratio": RATIO,
        "rated_torque": TORQUE_NM,
        "machine_rating": RATING_KW,
        "rotor_diameter": ROTOR_DIAMETER_M,
    }
    for name, value in values.items():
        problem.set_val(name, value)
    gearbox.volumeEEP = volume
    try:
        problem.run_model()
    finally:
        gearbox.volumeEEP = VOLUME
    return float(problem.get_val("gearbox_mass")[0])


def main(paths: list[Path]) -> None:
    """A line for each file."""
    for path in paths:
        result = json.loads(path.read_text("utf-8"))
        planets = len(result["sites"])
        require_constants(planets)
        found = result["summary"]["mesh_load_factor_max"]
        masses = [mass_kg(planets, factor) / 1000.0 for factor in (constant(planets), found)]
        print(
            f"{path.stem}, {planets} planets: K_gamma {constant(planets):g} of WISDEM, gearbox "
            f"{masses[0]:.1f} t; computed {found:.3f}, {masses[1]:.1f} t"
        )


if __name__ == "__main__":
    main([Path(name) for name in sys.argv[1:]])
