"""Error of lumped contacts: in slices by cells at the deciding positions, else from measurements.

The same bodies, slices and positions with cells show what one unknown for each place of contact
omits: edges of contacts, corners, roundings, and pressures where contact lines end.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flankload.analysis.error_rules import (
    COAST,
    FACE_LOAD,
    LARGEST_PRESSURE,
    LINE_FACTOR,
    LINE_LOAD,
    PEAK_LINE,
    PEAK_PRESSURE,
    RemainingError,
    Rule,
    at_largest_peak,
    remaining_errors,
)
from flankload.analysis.estimate import OVERALL
from flankload.contact.status import is_marked
from flankload.scene.discretization import Grid

if TYPE_CHECKING:
    from flankload.base.arrays import Floats
    from flankload.contact.sweep import Sweep
    from flankload.elasticity.compliance import BodyCompliance

#: Cells for this comparison: two thirds of those of a run change the rotation by 0.02 % and line
#: loads by 0.7 % at most, in less than half of the time.
FEW_CELLS = Grid(4.0, 6.0, 2.0)
#: The change by cells is the error itself where it is known; other positions may have twice that.
CELLS = Rule(0.0, 2.0, 2.0, 0.0, doubt_scatter=2.0)
#: Error of lumped contacts, with h/L the largest half-width over the length of the shorter flank:
#: (h/L)² times the first number plus the second; at a corner, a kink or a rounding at least h/L
#: times the third (pressures there are not estimated).
#: Measured against resolved contacts on gears, rings and cams, sharp, rounded and relieved, under
#: 0.03 to 3 times their torque.
LUMPED = {
    "transmission_error": (0.7, 1e-4, 0.3),
    "load_share": (0.32, 0.0, 0.2),
    "peak_pressure": (3.0, 0.003, 0.0),
}
#: Error of slices of flanks that conform, of which one unknown spreads the force over the height:
#: measured beside unknowns on ten strips of the height, with crownings of 20 um, misalignments up
#: to 5 mrad, pitch errors and offsets.
SPREAD = {
    "transmission_error": 0.0035,
    "load_share": 0.005,
    "peak_pressure": 0.01,
    LINE_LOAD: 0.08,
    PEAK_LINE: 0.08,
    FACE_LOAD: 0.01,
    LINE_FACTOR: 0.01,
}


def error_beside_cells(part: Sweep, cells: Sweep, weights: Floats) -> dict[str, RemainingError]:
    """Errors of lumped contacts in slices, by quantity.

    `part` and `cells` are the same positions without and with cells, `weights` (P,) the parts of
    the positions in means over the period.
    """
    errors = remaining_errors(CELLS, part, part, cells, weights)
    errors[LARGEST_PRESSURE] = at_largest_peak(errors[PEAK_PRESSURE], part)
    change = cells.rotation_rad - part.rotation_rad
    errors["transmission_error_peak_to_peak"] = RemainingError.relative(
        0.0, CELLS.doubt * float(np.ptp(change)), np.ptp(part.rotation_rad)
    )
    # the tangent of cells is that of fixed zones
    if "stiffness_secant" in errors:
        errors["stiffness_tangent"] = errors["stiffness_secant"]
    return {name: RemainingError(0.0, error.size) for name, error in errors.items()}


def measured_error(
    found: Sweep, compliances: tuple[BodyCompliance, ...]
) -> dict[str, RemainingError]:
    """Errors of lumped contacts without cells, from measurements, by quantity."""
    errors = lumped_error(found, compliances)
    return {name: RemainingError(0.0, error) for name, error in errors.items()}


def lumped_error(found: Sweep, compliances: tuple[BodyCompliance, ...]) -> dict[str, float]:
    """Error of a sweep (with its pairs) under lumped contacts in the plane, or of splines."""
    if found.slices.conforming:
        return SPREAD | dict.fromkeys(OVERALL, SPREAD["transmission_error"])
    loaded = found.pairs.column("force") > 0
    half_width = np.max(found.pairs.column("cell") * (2.0 / np.pi), initial=0.0, where=loaded)
    length = min(high - low for low, high in (c.modes.range_mm for c in compliances))
    ratio = float(half_width / length)
    shaped = bool((is_marked(found.site_corner) & (found.site_force_N > 0)).any())
    errors = {
        quantity: max(square * ratio**2 + least, linear * ratio * shaped)
        for quantity, (square, least, linear) in LUMPED.items()
    }
    if found.coast is not None:
        errors[COAST] = errors["load_share"]
    return errors | dict.fromkeys(OVERALL, errors["transmission_error"])
