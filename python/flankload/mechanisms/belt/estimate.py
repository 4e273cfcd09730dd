"""Error estimates of a timing belt: element size and sampling of positions.

elements
    Near the sharp corners of teeth and lands the error decreases to 0.6 of its value when the
    element length is halved, to 0.7 on round teeth. The remaining error is therefore estimated as
    twice the change between elements of double length and those of the run. (On ten belts with
    trapezoids and arcs, with 6 and 12 elements on a flank, the distance to the limit from 24 and 40
    elements was 0.5 to 1.03 of that estimate in the rotation, once 0.1; in shares 0.02 to 0.8, once
    1.7.) Both bodies are independent sources, whose squares are added. The error varies little with
    position, so two positions are examined: those before and after a tooth engages, between which
    the rotation decreases most.
positions
    Over a pitch the rotation is a sawtooth: the tight strand stretches until a tooth engages. The
    smooth curve in between is extrapolated to the discontinuities. The signed differences between
    the samples and this curve in mean and peak to peak are their errors. The uncertainty is the
    change of the curve's slope between positions. Single angles, or one position, give no estimate
    for the region beyond them; one position has no peak to peak.
"""

from __future__ import annotations

from math import hypot
from typing import TYPE_CHECKING

import numpy as np

from flankload.base.rounding import TIE

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flankload.base.arrays import Floats
    from flankload.mechanisms.belt.contact import BeltState

#: Remaining element error, relative to the change between elements of double length and those of
#: the run.
REMAINING = 2.0
#: Least relative error of the largest load share, divided by that of the rotation: the change of
#: shares may vanish if teeth and cord are both too stiff.
SHARE_ERROR = 0.25
#: Uncertainty of a linear extrapolation, relative to its amount, beside that of the bends; 1 with
#: only two positions.
EXTRAPOLATION_ERROR = 0.25


def estimate_belt(
    compared: Sequence[tuple[str, Sequence[tuple[BeltState, BeltState]]]],
    states: Sequence[BeltState],
    phases: Floats | None,
) -> dict[str, object]:
    """Estimated errors under a torque and all contributions by source, as a result shows them.

    Each source in `compared` has pairs of states at some positions, the second with longer
    elements; the largest change per source counts. `states` are at all positions, with `phases`
    (P,) from `row.phases`; None for single angles.
    """
    rotation = np.array([state.rotation_rad for state in states])
    by_source: dict[str, dict[str, float]] = {}
    for source, pairs in compared:
        left = {name: REMAINING * error for name, error in _of_elements(pairs, rotation).items()}
        before = by_source.get(source, left)
        by_source[source] = {name: max(before[name], error) for name, error in left.items()}
    if phases is not None and rotation.size > 1:
        tangent = np.array([state.compliance_rad_per_N for state in states])
        by_source["positions"] = between_places(phases, rotation, tangent)
    if rotation.size == 1:
        for errors in by_source.values():
            del errors["transmission_error_peak_to_peak"]
    sums: dict[str, float] = {}
    for errors in by_source.values():
        for quantity, error in errors.items():
            sums[quantity] = hypot(sums.get(quantity, 0.0), error)
    dominant = {
        quantity: max(by_source, key=lambda name: by_source[name].get(quantity, 0.0))
        for quantity in sums
    }
    return {**sums, "dominant_source": dominant, "by_source": by_source}


def _of_elements(
    pairs: Sequence[tuple[BeltState, BeltState]], rotation: Floats
) -> dict[str, float]:
    """Change by longer elements in each quantity."""
    turned = np.array([two.rotation_rad - one.rotation_rad for one, two in pairs])
    mean = _over(abs(float(turned.mean())), abs(float(rotation.mean())))
    # an additional torque deforms the bodies like the whole torque, on other parts of flanks
    first, second = np.array([[state.compliance_rad_per_N for state in pair] for pair in pairs]).T
    others = abs(float(np.mean([*map(_over, second - first, first)])))
    largest = _over(float(np.abs(turned).max()), float(np.abs(rotation).max()))
    return {
        "transmission_error": largest,
        "load_share": max(_of_shares(one, two, SHARE_ERROR * largest) for one, two in pairs),
        "transmission_error_mean": mean,
        "transmission_error_peak_to_peak": _over(float(np.ptp(turned)), float(np.ptp(rotation))),
        "stiffness_secant": mean,
        "stiffness_tangent": mean + others,
    }


def _of_shares(one: BeltState, two: BeltState, least: float) -> float:
    """Change of a load share, at least `least` times the largest share."""
    force, whole = one.tooth_N_per_mm, float(one.tooth_N_per_mm.sum())
    change = float(np.abs(two.tooth_N_per_mm - force).max())
    return hypot(_over(change, whole), least * _over(float(force.max()), whole))


def between_places(phases: Floats, rotation: Floats, tangent: Floats) -> dict[str, float]:
    """Sampling errors, by quantity, of positions that cover a pitch; unknown ones are omitted.

    A tooth engages at the ends of the phases (P,), -1/2 and 1/2 pitch, where the curves of the
    rotation and its derivative with respect to the torque (P,) are discontinuous; further pitches
    repeat these.
    """
    order = np.argsort(phases, kind="stable")
    once = order[np.diff(phases[order], prepend=-np.inf) > TIE]
    if once.size < 2:
        return {}
    places = phases[once]
    found = {
        "transmission_error_mean": _of_mean(places, rotation[once]),
        "transmission_error_peak_to_peak": _of_peak_to_peak(places, rotation[once]),
    }
    for name, softness in (("stiffness_secant", rotation), ("stiffness_tangent", tangent)):
        if (softness > 0).all():
            found[name] = _of_mean(places, 1.0 / softness[once])
    return found


def _of_mean(places: Floats, values: Floats) -> float:
    at, through = _to_the_breaks(places, values)
    error = float(values.mean() - np.trapezoid(through, at))
    part = _bend(places, values) * (1.0 / 12.0 + 1.0 / values.size)
    return _over(abs(error) + _doubt(values, error, part), abs(float(values.mean())))


def _of_peak_to_peak(places: Floats, values: Floats) -> float:
    _, through = _to_the_breaks(places, values)
    error = float(np.ptp(values) - np.ptp(through))
    doubt = _doubt(values, error, _bend(places, values))
    return _over(abs(error) + doubt, float(np.ptp(values)))


def _doubt(values: Floats, error: float, bend: float) -> float:
    return abs(error) if values.size == 2 else float(hypot(EXTRAPOLATION_ERROR * error, bend))


def _to_the_breaks(places: Floats, values: Floats) -> tuple[Floats, Floats]:
    """Piecewise linear curve from one discontinuity to the next."""
    steps = np.diff(values) / np.diff(places)
    first = values[0] + steps[0] * (-0.5 - places[0])
    last = values[-1] + steps[-1] * (0.5 - places[-1])
    return np.array([-0.5, *places, 0.5]), np.array([first, *values, last])


def _bend(places: Floats, values: Floats) -> float:
    """Largest deviation of the curve from a line through two neighbours, up to the next one."""
    steps = np.diff(values) / np.diff(places)
    return float((np.abs(np.diff(steps)) * np.diff(places)[1:]).max(initial=0.0))


def _over(part: float, whole: float) -> float:
    return part / whole if whole != 0 else 0.0
