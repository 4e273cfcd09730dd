"""Sampling errors of rotation and stiffnesses, from the curve through the positions.

At a position where a flank pair begins or ceases to carry load, the rotation has a kink and the
tangent stiffness a step. The secant stiffness has another kink where another pair begins to touch
without torque. The kink is the intersection of the curves from both sides. The error is the mean in
the summary (of even positions the mean of the samples, otherwise that of the curve with the kinks
of the rotation only) minus the mean of the curve with all kinks, with its sign. The doubt is a part
of that, plus the uncertainty of intervals in which no kink, or two kinks, were found.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flankload.analysis.adaptive_positions import overshoot
from flankload.analysis.error_rules import RemainingError, stiffnesses

if TYPE_CHECKING:
    from flankload.analysis.adaptive_positions import Window
    from flankload.base.arrays import Flags, Floats
    from flankload.contact.sweep import Sweep
    from flankload.result.interpolant import PositionCurve


#: Places in an interval between positions at which a curve is evaluated.
BETWEEN = 16
#: Doubt relative to the difference between curve and samples, in the mean and in the peak to peak.
DOUBT_MEAN, DOUBT_PEAK_TO_PEAK = 0.8, 0.8
#: The same relative to the doubt of the curve itself in intervals with a change of loaded pairs.
DOUBT_KINKS = 0.15
#: Doubt of the place of a step, relative to its interval (twice the standard deviation): with a
#: known kink, and anywhere in the interval.
STEP_FOUND, STEP_ANYWHERE = 0.2, 1.0 / np.sqrt(3.0)
#: Least number of positions for an estimate in an open window.
LEAST_OPEN = 3
#: If one pair begins and one ceases to carry load in the same interval, there is one pair more or
#: less in between. Assumed distance of both events relative to the interval, and effect on the
#: rotation relative to that on the stiffness.
HIDDEN, HIDDEN_ROTATION = 0.5, 0.06


def between_positions(
    part: Sweep, window: Window, position_rad: Floats, *, adaptive: bool = False
) -> dict[str, RemainingError]:
    """Sampling errors of quantities that depend on all positions, by quantity.

    Parameters
    ----------
    part : Sweep
    window : Window
        Range of the positions. If curves do not close over it, they are extrapolated over the
        interval after the last position.
    position_rad : (P,) array
    adaptive : bool
        Whether positions were added where the rotation is in doubt: its harmonics and its peak to
        peak have an estimate of their own then, and are missing here like the tangent stiffness.
    """
    if not window.closed:
        return {} if adaptive else _open_window(part)
    loaded = part.site_force_N != 0
    changes = window.changes(loaded)
    rotation = part.rotation_rad
    hidden = _hidden(loaded, changes) if window.sites.size > 1 else 0.0
    through = window.curve_of(position_rad, rotation, changes)

    def of_mean(values: Floats, curve: PositionCurve, kinks: Flags) -> RemainingError:
        mean = window.curve_of(position_rad, values, changes).mean() if adaptive else values.mean()
        missed = mean - curve.mean()
        open_kinks = curve.doubt_integrals()[kinks].sum() / curve.length
        doubts = DOUBT_MEAN * missed, DOUBT_KINKS * open_kinks, HIDDEN_ROTATION * hidden * mean
        return RemainingError.relative(missed, float(np.linalg.norm(doubts)), mean)

    found = {"transmission_error_mean": of_mean(rotation, through, changes)}
    known = stiffnesses(part)
    if (secant := known.get("stiffness_secant")) is not None:
        kinks = changes
        if part.unloaded is not None:
            kinks = changes | window.changes(part.unloaded.touches)
        found["stiffness_secant"] = of_mean(
            secant, window.curve_of(position_rad, secant, kinks), kinks
        )
    if adaptive:
        return found
    soft = not part.slices.plane or not changes.any()
    smooth = window.curve_of(position_rad, rotation, np.zeros_like(changes)) if soft else None
    found["transmission_error_peak_to_peak"] = _of_peak_to_peak(rotation, through, smooth)
    if (tangent := known.get("stiffness_tangent")) is not None:
        missed, doubt = _steps(tangent, position_rad, through, changes)
        mean = tangent.mean()
        doubt = float(np.hypot(doubt, HIDDEN * hidden * mean))
        found["stiffness_tangent"] = RemainingError.relative(missed, doubt, mean)
    return found


def _of_peak_to_peak(
    rotation: Floats, through: PositionCurve, smooth: PositionCurve | None
) -> RemainingError:
    """Error of the peak to peak of the samples, which the curve through them exceeds.

    Kinks over the width are soft: the curve is between those with kinks and without (`smooth`).
    """
    whole, fine = float(np.ptp(rotation)), np.linspace(*through.ends, BETWEEN * rotation.size)
    sharp = whole - float(np.ptp([*rotation, *through.values(fine)]))
    if smooth is None:
        return RemainingError.relative(sharp, DOUBT_PEAK_TO_PEAK * abs(sharp), whole)
    least = whole - float(np.ptp(smooth.values(fine)))
    bound = sum(float(one.max()) for one in overshoot(smooth, rotation))
    doubt = float(np.hypot(0.5 * (sharp - least), bound))
    return RemainingError.relative(0.5 * (sharp + least), doubt, whole)


def _open_window(part: Sweep) -> dict[str, RemainingError]:
    """The same if curves do not close: the doubt is the contribution of the last interval."""
    rotation = part.rotation_rad
    if rotation.size < LEAST_OPEN:
        return {}
    found = {}
    for name, values in {"transmission_error_mean": rotation, **stiffnesses(part)}.items():
        missed = 0.5 * (values[0] - _next(values)) / values.size
        found[name] = RemainingError.relative(missed, abs(missed), values.mean())
    missed = float(np.ptp(rotation) - np.ptp([*rotation, _next(rotation)]))
    between = 0.5 * float(np.abs(np.diff(rotation, 2)).max())
    found["transmission_error_peak_to_peak"] = RemainingError.relative(
        missed, between, np.ptp(rotation)
    )
    return found


def _next(values: Floats) -> float:
    """Next value by linear extrapolation."""
    return float(2 * values[-1] - values[-2])


def _steps(
    tangent: Floats, position_rad: Floats, rotation: PositionCurve, changes: Flags
) -> tuple[float, float]:
    """Sampling error of the mean of a stiffness with steps, and its doubt."""
    step = np.diff(tangent, append=tangent[0])[changes]
    start = position_rad[changes]
    width = np.diff(position_rad, append=position_rad[0] + rotation.length)[changes]
    kink = rotation.kinks()[changes]
    # samples count as if the step were in the middle of its interval
    early = np.where(np.isnan(kink), 0.0, 0.5 - (kink - start) / width)
    doubt = np.where(np.isnan(kink), STEP_ANYWHERE, STEP_FOUND) * step
    return -float(early @ step) / tangent.size, float(np.linalg.norm(doubt)) / tangent.size


def _hidden(loaded: Flags, changes: Flags) -> float:
    """Relative effect of intervals in which one pair begins and one ceases to carry load."""
    count = loaded.sum(axis=1)
    alike = changes & (count == np.roll(count, -1))
    return float(np.linalg.norm(1.0 / np.maximum(count[alike], 1)) / count.size)
