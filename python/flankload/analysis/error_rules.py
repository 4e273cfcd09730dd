"""What a change between two sweeps of the same positions tells of the error that is left.

Each source has a rule, taken from what was measured: the part of the change that the error is in
the middle, with its sign, and how far it may be off that. Errors of several sources add up with
their signs, doubts are independent and add up by their squares.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from flankload.analysis.sampling_error import between_positions, mean_stiffness
from flankload.analysis.tangent import LARGEST_KINK

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from flankload.analysis.adaptive_positions import Window
    from flankload.contact.sweep import Sweep

    Floats = NDArray[np.float64]

#: The quantity that there is where coast flanks can carry.
COAST = "coast_force"


@dataclass(frozen=True)
class Rule:
    """What a change of the answer tells of the error that is left.

    Attributes
    ----------
    part : float
        Error over change, in the middle of what was measured, with its sign.
    doubt, doubt_pressure : float
        How far an error at one position may be off that, over the change there; that of a pressure.
    doubt_overall : float
        The same in means over the change of the mean.
    doubt_scatter : float
        What means may be off besides, over the mean of the changes without their signs.
    doubt_share : float or None
        The first doubt of a load share, where that is another one.
    """

    part: float
    doubt: float
    doubt_pressure: float
    doubt_overall: float
    doubt_scatter: float = 0.0
    doubt_share: float | None = None


#: A parabola through half as many cells leaves a third of what it adds.
STRIPS = Rule(1 / 3, 2 / 3, 2 / 3, 1 / 3)
#: What follows the two highest modes. Terms alternate along the flank, and near a tip, where the
#: compliance grows like a logarithm towards a corner, they hardly fall until the contact is
#: resolved.
MODES = Rule(0.4, 2.3, 1.0, 1.0, 0.1)
#: The same where the corners of all flanks have images, which take that logarithm up: on elements a
#: third as long, five modes left 0.1 to 1.1 of the largest change of rotation, 0.1 to 2.1 of that
#: of load shares (27 gears and rings); rounded or chamfered, they left up to 3.6 and 5.9. Their
#: means nearly cancel, and are off by up to 0.4 of what single positions change by.
MODES_WITH_IMAGES = Rule(0.4, 0.7, 1.0, 1.0, 0.4, doubt_share=1.7)
#: Of pressures the two highest modes tell next to nothing: their curvature near the ends of a flank
#: is not that of those that follow. What these leave goes with the largest change of the load share
#: (over 112 gears and rings: correlation of the logarithms 0.45, of the peaks' own change 0.29,
#: which says nothing beside the share).
SHARE_TO_PEAK = 3.0
#: Half as many nodes: where the error falls only in proportion to their distance, the change is it.
NODES = Rule(0.5, 0.5, 0.5, 0.5)
#: Two degrees less along the axis, half as many slices: the change bounds what is left.
AXIAL = SLICES = Rule(0.0, 1.0, 1.0, 1.0)
#: Smoothed stresses tell 0.5 to 1.0 of the loss under pressures that the flank elements hardly
#: resolve.
ELEMENTS = Rule(-1.45, 1.0, 2.0, 1.0)
#: A change of a share that is rounding.
SAME_SHARE = 1e-9
#: Part of the changes at the largest and the smallest rotation that their difference may keep.
EXTREMES = 0.35
#: A half-ellipse of pressure whose middle lies on the edge of two cells seems lower by 0.5 % with
#: five cells on its half. A peak that changes by more than twice that has something in it that half
#: as many cells do not resolve (a kink, a small rounding): all of the change is in doubt then.
LARGEST_SMOOTH_CHANGE = 0.01


@dataclass(frozen=True)
class Left:
    """What a source leaves in a quantity, or in one at many places.

    Attributes
    ----------
    error : array or float
        With its sign.
    doubt : array or float
    """

    error: Floats | float
    doubt: Floats | float

    @property
    def size(self) -> float:
        """The largest of what may be left."""
        return float(np.max(np.abs(self.error) + self.doubt, initial=0.0))

    @classmethod
    def of(cls, parts: list[Left]) -> Left:
        """Of several sources: errors with their signs, doubts as squares."""
        doubt = np.sqrt(sum(np.square(part.doubt) for part in parts))
        return cls(sum(part.error for part in parts), doubt)


def what_is_left(rule: Rule, found: Sweep, base: Sweep, other: Sweep) -> dict[str, Left]:
    """What a source leaves in the quantities of a sweep.

    Parameters
    ----------
    rule : Rule
        Of the source.
    found : Sweep
        The sweep in question.
    base, other : Sweep
        The same without and with what the source changes.

    Returns
    -------
    dict
        By quantity.
    """
    unloaded = found.rotation_rad - found.turned_rad
    rotation, change = found.rotation_rad, other.rotation_rad - base.rotation_rad
    left = {
        "transmission_error": _at_each(rule, change, np.abs(rotation).max()),
        "load_share": _at_each(_of_shares(rule), _shares(other) - _shares(base), 1.0),
        "peak_pressure": _at_each(
            replace(rule, doubt=rule.doubt_pressure),
            _peak_change(found, base, other),
            _largest_peak(found),
        ),
        "transmission_error_mean": _of_mean(rule, change, rotation),
        "transmission_error_peak_to_peak": _of_peak_to_peak(rule, change, rotation),
    }
    for name, softness in (
        ("stiffness_secant", [s.rotation_rad - unloaded for s in (found, base, other)]),
        ("stiffness_tangent", [s.tangent_rad_per_Nmm for s in (found, base, other)]),
    ):
        stiffness = [mean_stiffness(values) for values in softness]
        one, two, three = stiffness
        if one is not None and two is not None and three is not None:
            change = np.where(np.abs(three - two) <= LARGEST_KINK * one, three - two, 0.0)
            left[name] = _of_mean(rule, change, one)
    if found.coast is not None:
        change = _coast_shares(other) - _coast_shares(base)
        left[COAST] = _at_each(_of_shares(rule), change, 1.0)
    return left


def of_positions(found: Sweep, window: Window, position_rad: Floats) -> dict[str, Left]:
    """Errors of quantities that depend on the curve between the positions.

    Parameters
    ----------
    found : Sweep
    window : Window
        Range of the positions.
    position_rad : (P,) array

    Returns
    -------
    dict
        By quantity.
    """
    errors = between_positions(found, window, position_rad)
    return {name: Left(*both) for name, both in errors.items()}


def _of_shares(rule: Rule) -> Rule:
    """The rule with its doubt of load shares."""
    return rule if rule.doubt_share is None else replace(rule, doubt=rule.doubt_share)


def _at_each(rule: Rule, change: Floats, whole: float | np.floating) -> Left:
    """Of a quantity at each position."""
    relative = change / whole if whole > 0 else np.zeros_like(change)
    return Left(rule.part * relative, rule.doubt * np.abs(relative))


def _of_mean(rule: Rule, change: Floats, values: Floats) -> Left:
    """Of a mean over the positions."""
    whole = abs(float(values.mean()))
    if whole == 0:
        return Left(0.0, 0.0)
    mean, scatter = float(change.mean()) / whole, float(np.abs(change).mean()) / whole
    doubt = float(np.hypot(rule.doubt_overall * mean, rule.doubt_scatter * scatter))
    return Left(rule.part * mean, doubt)


def _of_peak_to_peak(rule: Rule, change: Floats, rotation: Floats) -> Left:
    whole = float(np.ptp(rotation))
    if whole == 0:
        return Left(0.0, 0.0)
    error = whole - float(np.ptp(rotation - rule.part * change))
    apart = np.abs(change - change.mean())
    of_extremes = apart[rotation.argmax()] + apart[rotation.argmin()]
    doubt = EXTREMES * rule.doubt * float(of_extremes)
    return Left(error / whole, doubt / whole)


def _shares(part: Sweep) -> Floats:
    return part.site_force_N / _whole_force(part)


def _coast_shares(part: Sweep) -> Floats:
    assert part.coast is not None
    return part.coast.site_force_N / _whole_force(part)


def _whole_force(part: Sweep) -> Floats:
    """Of the working flanks, (P, 1)."""
    total = part.site_force_N.sum(axis=1, keepdims=True)
    return np.asarray(np.maximum(total, np.finfo(float).tiny))


def _smooth(*parts: Sweep) -> NDArray[np.bool_]:
    """Where a site carries in the first of several sweeps, in none of them on a sharp corner."""
    off = [part.site_corner <= 0 for part in parts]
    return np.asarray(np.logical_and.reduce(off) & (parts[0].site_peak_N_per_mm > 0))


def _largest_peak(found: Sweep) -> float:
    return float(np.max(found.site_peak_N_per_mm, initial=0.0, where=_smooth(found)))


def any_smooth_peak(found: Sweep) -> bool:
    """Whether a site carries off sharp corners anywhere."""
    return _largest_peak(found) > 0.0


def _peak_change(found: Sweep, base: Sweep, other: Sweep) -> Floats:
    """Change of the peaks off sharp corners."""
    change = other.site_peak_N_per_mm - base.site_peak_N_per_mm
    return np.where(_smooth(found, base, other), change, 0.0)


def peak_of_modes(found: Sweep, base: Sweep, other: Sweep) -> Left:
    """What modes leave in the peaks off sharp corners.

    Parameters
    ----------
    found, base, other : Sweep
        The sweep in question, the same where modes are looked at, and with fewer of them.

    Returns
    -------
    Left
    """
    changes = np.abs(_shares(other) - _shares(base))
    change = float(changes.max(initial=0.0))
    largest = _largest_peak(found)
    if change < SAME_SHARE:  # one pair carries alone throughout
        doubt = replace(MODES, doubt=MODES.doubt_pressure)
        return _at_each(doubt, _peak_change(found, base, other), largest)
    peak = np.where(_smooth(found, base, other), found.site_peak_N_per_mm, 0.0)
    part = peak / largest if largest > 0 else np.zeros_like(peak)
    # the peak of a line contact goes with the root of its force: that of a pair that has just begun
    # to carry may be a multiple
    share = np.maximum(_shares(found), np.finfo(float).tiny)
    begun = np.sqrt(1.0 + (MODES.part + MODES.doubt) * changes / share) - 1.0
    return Left(np.zeros_like(part), np.maximum(SHARE_TO_PEAK * change, begun) * part)


def peak_of_cells(found: Sweep, coarse: Sweep) -> Left:
    """What cells leave in the peaks off sharp corners.

    Parameters
    ----------
    found, coarse : Sweep
        The sweep in question, and the same with half as many cells.

    Returns
    -------
    Left
    """
    change, largest = _peak_change(found, found, coarse), _largest_peak(found)
    left = _at_each(STRIPS, change, largest)
    rough = np.abs(change) > LARGEST_SMOOTH_CHANGE * found.site_peak_N_per_mm
    whole = np.abs(change) / largest if largest > 0 else np.zeros_like(change)
    return Left(np.where(rough, 0.0, left.error), np.where(rough, whole, left.doubt))
