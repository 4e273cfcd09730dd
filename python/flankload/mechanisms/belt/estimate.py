"""Error estimates of a timing belt: element size and sampling of positions.

elements
    Near the sharp corners of teeth and lands the error decreases to 0.6 of its value when the
    element length is halved, to 0.7 on round teeth. The remaining error is therefore estimated as
    twice the change between elements of double length and those of the run. (On ten belts with
    trapezoids and arcs, with 6 and 12 elements on a flank, the distance to the limit from 24 and 40
    elements was 0.5 to 1.03 of that estimate in the rotation, once 0.1; in shares 0.02 to 0.8, once
    1.7.) Both bodies are independent sources, whose squares are added. The error varies little with
    position, so two positions are examined: those on both sides of the place where a tooth engages,
    between which the rotation decreases most.
positions
    Over a pitch the rotation is a sawtooth: the tight strand stretches until a tooth engages.
    Between two such places the curve is smooth and is extrapolated from the positions up to the
    discontinuity on both sides. The difference of the samples from the mean and from the peak to
    peak of that curve is their error, with its sign. The uncertainty is the bend of the curve
    between positions. Single angles, or one position, give no estimate for the region beside them;
    one position has no peak to peak.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import hypot
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import NDArray

    from flankload.mechanisms.belt.contact import BeltState
    from flankload.mechanisms.belt.row import StripResponse

    Floats = NDArray[np.float64]
    #: Source, and the quantity compared: a response with elements twice as long, with another
    #: response or, if None, with the state found.
    Coarser = tuple[str, StripResponse | None, StripResponse]

#: Remaining element error, relative to the change between elements of double length and those of
#: the run.
LEFT = 2.0
#: Relative error of the largest load share, divided by that of the rotation: if teeth and cord are
#: both too stiff, the load sharing hardly changes, and the change of shares may vanish.
SHARES = 0.25
#: Positions closer than this part of a pitch are equal.
SAME = 1e-9
#: Uncertainty of a linear extrapolation, relative to its amount, in addition to the bends; the
#: whole amount if there are only two positions.
DOUBT = 0.25


@dataclass(frozen=True)
class Change:
    """Change by longer elements at a position, relative to the value found there or to the load.

    Attributes
    ----------
    rotation_rad : float
    compliance, share : float
    largest_share : float
        Largest share at the position.
    """

    rotation_rad: float
    compliance: float
    share: float
    largest_share: float

    @classmethod
    def between(cls, one: BeltState, two: BeltState) -> Change:
        """Change from one state to another one."""
        whole = one.tooth_N_per_mm.sum()
        return cls(
            two.rotation_rad - one.rotation_rad,
            _over(two.compliance_rad_per_N - one.compliance_rad_per_N, one.compliance_rad_per_N),
            _over(float(np.abs(two.tooth_N_per_mm - one.tooth_N_per_mm).max()), whole),
            _over(float(one.tooth_N_per_mm.max()), whole),
        )


def estimate_belt(
    tried: Sequence[tuple[BeltState, Sequence[Coarser]]],
    states: Sequence[BeltState],
    phases: Floats | None,
    solve: Callable[[StripResponse], BeltState],
) -> dict[str, object]:
    """Estimated errors under a torque, as a result shows them.

    Parameters
    ----------
    tried : sequence of (BeltState, sequence of Coarser)
        States at some positions, and the comparisons there, the same at each. The largest change
        with the same source counts.
    states : sequence of BeltState
        States at all positions.
    phases : (P,) array or None
        Phase of the middle of the first land at each position, beyond the tangent point, from -1/2
        to 1/2 pitch; None for single angles.
    solve : callable
        Computes the state from a response.

    Returns
    -------
    dict
        Errors of rotation, shares and stiffness, and all contributions by source.
    """
    changes: dict[tuple[int, str], list[Change]] = {}
    for state, coarser in tried:
        for n, (source, as_found, other) in enumerate(coarser):
            one = solve(as_found) if as_found is not None else state
            changes.setdefault((n, source), []).append(Change.between(one, solve(other)))
    rotation = np.array([state.rotation_rad for state in states])
    by_source: dict[str, dict[str, float]] = {}
    for (_, source), row in changes.items():
        left = {name: LEFT * error for name, error in _of_elements(row, rotation).items()}
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


def _of_elements(row: Sequence[Change], rotation: Floats) -> dict[str, float]:
    """Change by longer elements in each quantity."""
    turned = np.array([change.rotation_rad for change in row])
    mean = _over(abs(float(turned.mean())), abs(float(rotation.mean())))
    # an increasing torque deforms the bodies as the whole torque does, on other parts of flanks
    others = abs(float(np.mean([change.compliance for change in row])))
    largest = _over(float(np.abs(turned).max()), float(np.abs(rotation).max()))
    return {
        "transmission_error": largest,
        "load_share": max(
            hypot(change.share, SHARES * largest * change.largest_share) for change in row
        ),
        "transmission_error_mean": mean,
        "transmission_error_peak_to_peak": _over(float(np.ptp(turned)), float(np.ptp(rotation))),
        "stiffness_secant": mean,
        "stiffness_tangent": mean + others,
    }


def between_places(phases: Floats, rotation: Floats, tangent: Floats) -> dict[str, float]:
    """Sampling errors of positions that cover a pitch.

    Parameters
    ----------
    phases : (P,) array
        From -1/2 to 1/2 pitch; a tooth engages at the ends, where the curves are discontinuous;
        further pitches repeat these.
    rotation, tangent : (P,) arrays
        The rotation, and its derivative with respect to the torque.

    Returns
    -------
    dict of str to float
        By quantity; unknown ones are omitted.
    """
    order = np.argsort(phases, kind="stable")
    once = order[np.diff(phases[order], prepend=-np.inf) > SAME]
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
    missed = float(values.mean() - np.trapezoid(through, at))
    part = _bend(places, values) * (1.0 / 12.0 + 1.0 / values.size)
    return _over(abs(missed) + _doubt(values, missed, part), abs(float(values.mean())))


def _of_peak_to_peak(places: Floats, values: Floats) -> float:
    _, through = _to_the_breaks(places, values)
    missed = float(np.ptp(values) - np.ptp(through))
    doubt = _doubt(values, missed, _bend(places, values))
    return _over(abs(missed) + doubt, float(np.ptp(values)))


def _doubt(values: Floats, missed: float, bend: float) -> float:
    return abs(missed) if values.size == 2 else float(hypot(DOUBT * missed, bend))


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
