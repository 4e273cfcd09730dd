"""Error of lumped contacts by cells at the deciding positions; of flanks that conform, measured.

The same bodies and positions with cells, half as many as those of a run, show what one unknown for
each place of contact omits: edges of contacts, corners, roundings, and pressures where contact
lines end. Such places enter and leave contact from one position to the next, so that pairs are
compared at twice as many positions as other sources.
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
    from flankload.base.arrays import Floats, Numbers
    from flankload.contact.sweep import Sweep

#: The change by cells is the error with its sign; at other positions there may be three quarters
#: more, or a quarter.
CELLS = Rule(-1.0, 0.75, 0.75)
#: Error of slices of flanks that conform, of which one unknown spreads the force over the height:
#: of rotations and shares, pressures and load factors, line loads; measured beside unknowns on ten
#: strips of the height, with crownings of 20 um, misalignments up to 5 mrad, pitch errors, offsets.
SPREAD, SPREAD_PRESSURE, SPREAD_LINE_LOAD = 0.005, 0.01, 0.08


def error_beside_cells(part: Sweep, cells: Sweep, weights: Floats) -> dict[str, RemainingError]:
    """Errors of lumped contacts, by quantity.

    `part` are some positions of a sweep, `cells` the same with cells, `weights` (P,) the parts of
    the positions in means over the period.
    """
    errors = remaining_errors(CELLS, part, part, cells, weights)
    errors[LARGEST_PRESSURE] = at_largest_peak(errors[PEAK_PRESSURE], part)
    # the tangent of cells is that of fixed zones
    if "stiffness_secant" in errors:
        errors["stiffness_tangent"] = errors["stiffness_secant"]
    return errors


def worst_beside(whole: RemainingError, nearest: Numbers) -> RemainingError:
    """Errors (n, …) at some positions: the largest ones of the positions that are nearest to each.

    `nearest` (P,) are the indices of the nearest positions, `whole` the errors (P, …) at all of
    them; one that does not depend on the position stays.
    """
    if np.ndim(whole.error) == 0:
        return whole
    parts = tuple(np.asarray(part) for part in whole)
    found = []
    for i in range(int(nearest.max()) + 1):
        error, doubt = (part[nearest == i] for part in parts)
        worst = np.abs(error).argmax(axis=0)[np.newaxis]
        found.append([np.take_along_axis(part, worst, axis=0)[0] for part in (error, doubt)])
    return RemainingError(*(np.array(part) for part in zip(*found, strict=True)))


def spread_error() -> dict[str, RemainingError]:
    """Errors of slices of flanks that conform, which have no cells, by quantity."""
    errors = {
        **dict.fromkeys(("transmission_error", "load_share", *OVERALL), SPREAD),
        **dict.fromkeys((PEAK_PRESSURE, FACE_LOAD, LINE_FACTOR), SPREAD_PRESSURE),
        **dict.fromkeys((LINE_LOAD, PEAK_LINE), SPREAD_LINE_LOAD),
    }
    return {name: RemainingError(0.0, error) for name, error in errors.items()}
