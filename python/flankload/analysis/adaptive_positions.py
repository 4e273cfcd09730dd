"""Adaptive positions: more positions where the curves are uncertain.

Initial positions are solved; further rounds solve positions where the curve through the known ones
is in doubt. All torques share their positions, so that a round is one sweep. A new position is at
an expected kink, or in the middle of an interval without one. The rounds end when the doubt of
harmonics and peak to peak of the rotation is within the tolerance for every torque.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flankload.contact.status import is_marked
from flankload.contact.sweep import Sweep, join_sweeps
from flankload.result.interpolant import curve_through, loaded_pair_changes

if TYPE_CHECKING:
    from collections.abc import Callable

    from flankload.base.arrays import Flags, Floats, Numbers
    from flankload.result.interpolant import PositionCurve

    Run = Callable[[Floats, int], tuple[Sweep, ...]]

#: Harmonics that are limited: of the period and of one pitch.
HARMONICS = (1, 2, 3)
#: Smaller harmonics are judged relative to this part of the largest one …
LEAST_HARMONIC = 0.1
#: … and flat curves as if they varied by this part of their mean: the error of cells is 1e-5 of it.
LEAST_VARIATION = 0.01
#: Factor on the doubt, which is slightly less than the error if kinks are sharp, at light loads. Of
#: 24 random pairs at two loads each, three had errors up to 2.7 times the estimate, all below the
#: tolerance.
SAFETY = 1.5
#: Intervals with at least this part of the largest doubt are refined in the same round.
REFINED_TOGETHER = 0.3
#: A kink this close to the end of its interval, relative to its length, is resolved; the rest of
#: the interval is halved.
RESOLVED = 0.1
#: New positions of several torques that are closer than this part of their interval are merged.
MERGED = 0.05
#: Intervals below this part of a pitch are not divided: the curve has a step there.
LEAST_INTERVAL = 1e-7


@dataclass(frozen=True)
class Window:
    """Range of the positions.

    Attributes
    ----------
    pitch_rad : float
    pitches : int
        Number of pitches in the window.
    closed : bool
        Whether the curves are periodic over the window.
    sites : (S,) array
        Pair numbers.
    cyclic : bool
        Whether the sites are all flanks, so that the first follows the last.
    """

    pitch_rad: float
    pitches: int
    closed: bool
    sites: Numbers
    cyclic: bool

    def curve_of(self, position_rad: Floats, values: Floats, changes: Flags) -> PositionCurve:
        """Values (P,) at positions (P,) over the window, with kinks behind some of them (P,)."""
        period = self.pitches * self.pitch_rad if self.closed else None
        return curve_through(position_rad, values, changes, period_rad=period)

    def changes(self, loaded: Flags) -> Flags:
        """Whether the loaded pairs (P, S) change between a position and the next, (P,)."""
        return loaded_pair_changes(loaded, self.sites, pitches=self.pitches, cyclic=self.cyclic)


@dataclass(frozen=True)
class PositionErrors:
    """Relative doubt of the rotation for one torque.

    Attributes
    ----------
    harmonics : float
        Relative to the smallest of the limited harmonics.
    peak_to_peak : float
        Relative to the peak to peak.
    """

    harmonics: float
    peak_to_peak: float

    @property
    def largest(self) -> float:
        """The larger one."""
        return max(self.harmonics, self.peak_to_peak)


@dataclass(frozen=True)
class AdaptiveSweep:
    """Positions, their solutions and the remaining doubt.

    Attributes
    ----------
    position_rad : (P,) array
        Ascending.
    found : tuple of Sweep, one per torque
    errors : tuple of PositionErrors, one per torque
    rounds : int
    """

    position_rad: Floats
    found: tuple[Sweep, ...]
    errors: tuple[PositionErrors, ...]
    rounds: int


def sweep_adaptively(
    run: Run,
    start_rad: Floats,
    window: Window,
    *,
    tolerance: float,
    most: int,
    least_rad: float,
) -> AdaptiveSweep:
    """Solve positions until the curves between them meet the tolerance.

    Parameters
    ----------
    run : callable
        run(positions, round) solves positions (P,) and returns one sweep per torque.
    start_rad : (P,) array
        Initial positions, ascending from the beginning of the window; to its end if it is not
        closed.
    window : Window
    tolerance : float
        Allowed relative doubt of harmonics and peak to peak.
    most : int
        Largest number of positions.
    least_rad : float
        Curves that vary less are judged as if they varied by this amount.

    Returns
    -------
    AdaptiveSweep
    """
    rounds = [run(start_rad, 0)]
    position_rad, order = start_rad, np.arange(start_rad.size)
    while True:
        known = [_Known.of(parts, order) for parts in zip(*rounds, strict=True)]
        curves = [
            window.curve_of(position_rad, part.rotation_rad, window.changes(part.loaded))
            for part in known
        ]
        errors = tuple(
            _errors(curve, part.rotation_rad, window, least_rad)
            for curve, part in zip(curves, known, strict=True)
        )
        room = most - position_rad.size
        if room <= 0 or all(error.largest <= tolerance for error in errors):
            break
        new = _next_positions(curves, known, errors, tolerance, window, room)
        if new.size == 0:
            break
        rounds.append(run(new, len(rounds)))
        position_rad = np.concatenate([position_rad, new])
        place = np.argsort(position_rad, kind="stable")
        position_rad = position_rad[place]
        order = np.concatenate([order, order.size + np.arange(new.size)])[place]
    found = tuple(join_sweeps(parts, order) for parts in zip(*rounds, strict=True))
    return AdaptiveSweep(position_rad, found, errors, len(rounds))


@dataclass(frozen=True)
class _Known:
    """Data for curves from all rounds: rotation (P,) and sites that carry load (P, S).

    Without torque, the touching site replaces the loaded ones.
    """

    rotation_rad: Floats
    loaded: Flags

    @classmethod
    def of(cls, parts: tuple[Sweep, ...], order: Numbers) -> _Known:
        rotation = np.concatenate([part.rotation_rad for part in parts])
        if parts[0].torque_Nmm > 0:
            carries = np.concatenate([part.site_force_N for part in parts]) != 0
        else:
            carries = is_marked(np.concatenate([part.site_corner for part in parts]))
        return cls(rotation[order], carries[order])


def _errors(
    curve: PositionCurve, rotation: Floats, window: Window, least_rad: float
) -> PositionErrors:
    """Doubt of a curve relative to its harmonics and to its peak to peak."""
    orders = sorted({*HARMONICS, *(window.pitches * k for k in HARMONICS)})
    amplitudes = curve.amplitudes(orders)
    flat = max(least_rad, LEAST_VARIATION * abs(curve.mean()))
    smallest = max(amplitudes.min(), LEAST_HARMONIC * amplitudes.max(), LEAST_HARMONIC * flat)
    doubt = 2.0 / curve.length * curve.doubt_integrals().sum()
    above, below = overshoot(curve, rotation)
    return PositionErrors(
        harmonics=float(SAFETY * doubt / smallest),
        peak_to_peak=float(SAFETY * (above.max() + below.max()) / max(np.ptp(rotation), flat)),
    )


def overshoot(curve: PositionCurve, rotation: Floats) -> tuple[Floats, Floats]:
    """Two (N,) arrays: how far the curve may exceed the largest and the smallest known value."""
    least, greatest = curve.bounds()
    above = np.maximum(0.0, greatest - rotation.max())
    return above, np.maximum(0.0, rotation.min() - least)


def _next_positions(
    curves: list[PositionCurve],
    known: list[_Known],
    errors: tuple[PositionErrors, ...],
    tolerance: float,
    window: Window,
    room: int,
) -> Floats:
    """New positions (n,); those with the largest doubt if not all are allowed."""
    places, weights, widths = [], [], []
    for curve, part, error in zip(curves, known, errors, strict=True):
        weight = np.zeros(curve.n_intervals)
        if error.harmonics > tolerance:
            weight = curve.doubt_integrals()
            weight /= weight.max()
        if error.peak_to_peak > tolerance:
            for over in overshoot(curve, part.rotation_rad):
                if over.max() > 0.25 * tolerance * np.ptp(part.rotation_rad):
                    weight = np.maximum(weight, over / over.max())
        place, width = _inside(curve)
        marked = (weight >= REFINED_TOGETHER) & (width > LEAST_INTERVAL * window.pitch_rad)
        places.append(place[marked])
        weights.append(weight[marked])
        widths.append(width[marked])
    place, weight, width = (np.concatenate(part) for part in (places, weights, widths))
    chosen = np.sort(np.argsort(-weight, kind="stable")[:room])
    order = chosen[np.argsort(place[chosen], kind="stable")]
    place, width = place[order], width[order]
    apart = np.diff(place, prepend=-np.inf) > MERGED * width
    return place[apart]


def _inside(curve: PositionCurve) -> tuple[Floats, Floats]:
    """Place of a new position in each interval (N,), and width of each interval (N,)."""
    low, high = np.full((2, curve.n_intervals), np.nan)
    low[curve.interval[::-1]] = curve.low[::-1]
    high[curve.interval] = curve.high
    width = high - low
    kink = curve.kinks()
    middle = 0.5 * (low + high)
    place = np.where(np.isnan(kink), middle, kink)
    place = np.where(kink - low < RESOLVED * width, 0.5 * (kink + high), place)
    place = np.where(high - kink < RESOLVED * width, 0.5 * (low + kink), place)
    return place, width
