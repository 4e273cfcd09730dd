"""Error of lumped contacts by cells at the deciding positions; of flanks that conform, measured.

The same bodies, slices and positions with cells, half as many as those of a run, show what one
unknown for each place of contact omits: edges of contacts, corners, roundings, and pressures where
contact lines end.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flankload.analysis.error_rules import (
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

if TYPE_CHECKING:
    from flankload.base.arrays import Floats
    from flankload.contact.sweep import Sweep

#: The change by cells is the error itself where it is known; other positions may have three
#: quarters more, in their pressures twice that.
CELLS = Rule(0.0, 1.75, 2.0, 0.0, doubt_scatter=2.0)
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
    """Errors of lumped contacts, by quantity.

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


def spread_error() -> dict[str, RemainingError]:
    """Errors of slices of flanks that conform, which have no cells, by quantity."""
    errors = SPREAD | dict.fromkeys(OVERALL, SPREAD["transmission_error"])
    return {name: RemainingError(0.0, error) for name, error in errors.items()}
