"""What sampled positions miss of a rotation and of stiffnesses: the curve through them says.

Where a flank pair begins or ends to carry, the rotation has a kink and the tangent stiffness a
step. The curve finds the kink where it goes on from both sides until they meet; what the mean of
the samples lacks of the mean of the curve is their error, with its sign. In doubt is a part of
that, and what intervals leave open in which no kink was found, or two.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from flankload.analysis.adaptive_positions import Window
    from flankload.contact.sweep import Sweep
    from flankload.result.interpolant import PositionCurve

    Floats = NDArray[np.float64]
    Flags = NDArray[np.bool_]

#: Places in an interval between positions at which a curve is looked at.
BETWEEN = 16
#: Part of what a curve adds to the samples that is in doubt; in the mean, and in the peak to peak.
DOUBT_MEAN, DOUBT_PEAK_TO_PEAK = 0.8, 0.8
#: The same of the doubt that the curve itself has in intervals in which the loaded pairs change.
DOUBT_KINKS = 0.15
#: A step whose place is known is in doubt by this part of its interval, twice the standard
#: deviation; one whose place is not known may be anywhere in it.
STEP_FOUND, STEP_ANYWHERE = 0.2, 1.0 / np.sqrt(3.0)
#: Positions from which on an open window is looked at.
LEAST_OPEN = 3
#: One pair comes and one goes in the same interval: between, there is one more or one less. By this
#: part of an interval they may be apart, and by this part of what that makes in the stiffness does
#: the rotation differ from its curve.
HIDDEN, HIDDEN_ROTATION = 0.5, 0.06


def between_positions(
    part: Sweep, window: Window, position_rad: Floats
) -> dict[str, tuple[float, float]]:
    """What samples leave in quantities that follow from all positions.

    Parameters
    ----------
    part : Sweep
    window : Window
        What the positions run over. Where curves do not close over it nothing is known of the
        interval behind the last position but that they go on as they come.
    position_rad : (P,) array

    Returns
    -------
    dict
        By name: error of what follows from the samples, with its sign, and its doubt, both
        relative.
    """
    if not window.closed:
        return _open_window(part)
    loaded = part.site_force_N != 0
    changes = window.changes(loaded)
    rotation = part.rotation_rad
    hidden = _hidden(loaded, changes) if window.sites.size > 1 else 0.0

    def curve(values: Floats) -> PositionCurve:
        return window.curve_of(position_rad, values, loaded)

    def of_mean(values: Floats) -> tuple[float, float]:
        through, mean = curve(values), values.mean()
        missed = mean - through.mean()
        open_kinks = through.doubt_integrals()[changes].sum() / through.length
        doubts = (
            DOUBT_MEAN * missed,
            DOUBT_KINKS * open_kinks,
            HIDDEN_ROTATION * hidden * mean,
        )
        return _relative(missed, float(np.linalg.norm(doubts)), mean)

    through = curve(rotation)
    between = np.ptp(through.values(np.linspace(*through.ends, BETWEEN * rotation.size)))
    missed = float(np.ptp(rotation) - between)
    found = {
        "transmission_error_mean": of_mean(rotation),
        "transmission_error_peak_to_peak": _relative(
            missed, DOUBT_PEAK_TO_PEAK * abs(missed), np.ptp(rotation)
        ),
    }
    secant = mean_stiffness(part.turned_rad)
    if secant is not None:
        found["stiffness_secant"] = of_mean(secant)
    tangent = mean_stiffness(part.tangent_rad_per_Nmm)
    if tangent is not None:
        missed, doubt = _steps(tangent, position_rad, through, changes)
        mean = tangent.mean()
        doubt = float(np.hypot(doubt, HIDDEN * hidden * mean))
        found["stiffness_tangent"] = _relative(missed, doubt, mean)
    return found


def _open_window(part: Sweep) -> dict[str, tuple[float, float]]:
    """The same where curves do not close: what the mean misses of the last interval, in doubt."""
    rotation = part.rotation_rad
    if rotation.size < LEAST_OPEN:
        return {}
    found = {}
    for name, values in (
        ("transmission_error_mean", rotation),
        ("stiffness_secant", mean_stiffness(part.turned_rad)),
        ("stiffness_tangent", mean_stiffness(part.tangent_rad_per_Nmm)),
    ):
        if values is not None:
            missed = 0.5 * (values[0] - _next(values)) / values.size
            found[name] = _relative(missed, abs(missed), values.mean())
    missed = float(np.ptp(rotation) - np.ptp([*rotation, _next(rotation)]))
    between = 0.5 * float(np.abs(np.diff(rotation, 2)).max())
    found["transmission_error_peak_to_peak"] = _relative(missed, between, np.ptp(rotation))
    return found


def _next(values: Floats) -> float:
    """What follows on a straight line."""
    return float(2 * values[-1] - values[-2])


def mean_stiffness(softness: Floats) -> Floats | None:
    """What is inverse to rotation over torque; None where that is not known everywhere."""
    return 1.0 / softness if (softness > 0).all() else None


def _steps(
    tangent: Floats, position_rad: Floats, rotation: PositionCurve, changes: Flags
) -> tuple[float, float]:
    """What samples of a stiffness with steps miss of its mean, and its doubt."""
    step = np.diff(tangent, append=tangent[0])[changes]
    start = position_rad[changes]
    width = np.diff(position_rad, append=position_rad[0] + rotation.length)[changes]
    kink = rotation.kinks()[changes]
    # samples count as if the step were in the middle of its interval
    early = np.where(np.isnan(kink), 0.0, 0.5 - (kink - start) / width)
    doubt = np.where(np.isnan(kink), STEP_ANYWHERE, STEP_FOUND) * step
    return -float(early @ step) / tangent.size, float(np.linalg.norm(doubt)) / tangent.size


def _hidden(loaded: Flags, changes: Flags) -> float:
    """Intervals in which one pair comes and one goes: its part of all, over the positions."""
    count = loaded.sum(axis=1)
    alike = changes & (count == np.roll(count, -1))
    return float(np.linalg.norm(1.0 / np.maximum(count[alike], 1)) / count.size)


def _relative(error: float, doubt: float, whole: float | np.floating) -> tuple[float, float]:
    size = abs(float(whole))
    return (error / size, doubt / size) if size > 0 else (0.0, 0.0)
