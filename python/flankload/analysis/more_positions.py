"""Sampling errors in three dimensions, from four times as many positions with lumped contacts.

States of slices cost a thousandth of the bodies. Their slices enter contact in turn, so that curves
over the positions have neither the kinks nor the steps by which the error of a plane sweep is
estimated, and their largest line loads are those of short peaks.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flankload.analysis.error_rules import (
    FACE_LOAD,
    LINE_FACTOR,
    PEAK_LINE,
    RemainingError,
    stiffnesses,
)
from flankload.analysis.load_factors import face_load_factor, largest_line_loads, line_load_factors
from flankload.contact.sweep import join_sweeps

if TYPE_CHECKING:
    from flankload.base.arrays import Floats
    from flankload.contact.sweep import Sweep

#: Ratio of both numbers of positions.
TIMES = 4


def more_positions(position_rad: Floats, period_rad: float) -> Floats:
    """Evenly spaced positions (P, TIMES), of which the first column are those given (P,)."""
    step = period_rad / (TIMES * position_rad.size)
    return np.asarray(position_rad[:, None] + step * np.arange(TIMES))


def with_known(found: Sweep, more: Sweep) -> Sweep:
    """The states of all `more_positions`, from those given and those of the other columns."""
    n = found.status.size
    order = np.column_stack([np.arange(n), n + np.arange(more.status.size).reshape(n, -1)])
    return join_sweeps([found, more], order.ravel())


def beside_more_positions(
    many: Sweep, curve: dict[str, RemainingError]
) -> dict[str, RemainingError]:
    """Errors of every fourth position of a sweep, by quantity.

    The change is the error with its sign, and is in doubt as a whole, since a peak or a step may be
    anywhere between two positions. `curve` has the errors between `many` positions, where known.
    """
    few = join_sweeps([many], np.arange(0, many.status.size, TIMES))
    one, two = _over_period(few), _over_period(many)
    errors = {}
    for name in (name for name in one if name in two):
        rest = curve[name].size if name in curve else 0.0
        change = one[name] - two[name]
        doubt = float(np.hypot(change, rest * two[name]))
        errors[name] = RemainingError.relative(change, doubt, one[name])
    return errors


def _over_period(part: Sweep) -> dict[str, float]:
    """Values over evenly spaced positions, by quantity."""
    even = np.full(part.status.size, 1.0 / part.status.size)
    return {
        "transmission_error_mean": float(part.rotation_rad.mean()),
        "transmission_error_peak_to_peak": float(np.ptp(part.rotation_rad)),
        PEAK_LINE: float(largest_line_loads(part).max()),
        LINE_FACTOR: float(line_load_factors(part).max()),
        FACE_LOAD: face_load_factor(part, even),
        **{name: float(values.mean()) for name, values in stiffnesses(part).items()},
    }
