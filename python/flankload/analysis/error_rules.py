"""Estimates of the remaining error from the change between two sweeps of the same positions.

Each source has a rule from measurements: the mean ratio of error to change, with its sign, and the
largest deviation from that, the doubt. Errors of several sources are added with their signs; doubts
are independent and are added as squares.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from flankload.analysis.load_factors import line_loads, loads_over_period, relative_loads
from flankload.contact.status import on_corner

if TYPE_CHECKING:
    from flankload.base.arrays import Flags, Floats
    from flankload.contact.sweep import Sweep


#: Additional quantity if coast flanks can carry load.
COAST = "coast_force"
#: Error of the largest pressure, beside that of the peak pressures at all positions.
PEAK_PRESSURE, LARGEST_PRESSURE = "peak_pressure", "largest_pressure"
#: Error of the largest root tension, if the scene asks for root stress.
ROOT_STRESS = "root_stress"
#: Additional quantities in three dimensions.
LINE_LOAD, PEAK_LINE = "line_load", "peak_line_load"
FACE_LOAD, LINE_FACTOR = "face_load_factor", "line_load_factor"
#: Largest relative change of a tangent in the plane that shows an error: at larger ones, the pairs
#: in contact change. With a width, slices that enter contact in turn are an error of the tangent.
LARGEST_KINK = 5e-3


@dataclass(frozen=True)
class Rule:
    """Relation between a change of the result and the remaining error.

    Attributes
    ----------
    part : float
        Mean measured ratio of error to change, with its sign.
    doubt, doubt_pressure : float
        Deviation of an error at one position from that, relative to the change there; the same for
        a pressure.
    shares : float
        Doubt of load shares over that of rotations: shares are ratios of two flanks, which may err
        in opposite directions.
    """

    part: float
    doubt: float
    doubt_pressure: float
    shares: float = 1.0

    @classmethod
    def of_order(cls, ratio: float, order: float) -> Rule:
        """Rule of a source that converges with a power of a number, compared at 1/ratio of it.

        Rotations are stationary and may err by twice that; load shares and pressures may converge
        with half the order, rotations compared with a larger number likewise.
        """
        part, slow = (1.0 / (ratio**power - 1.0) for power in (order, 0.5 * order))
        rest = abs(slow - part)
        doubt = min(abs(part), rest)
        return cls(part, doubt, rest, shares=rest / doubt)


#: Half as many cells, on which pressures are linear.
STRIPS = Rule.of_order(2.0, 2.0)
#: Order of the error in the number of pressure modes, and omitted ones, as in `scene.steps`.
MODES_ORDER, OMITTED_MODES = 3.0, 2


def rule_of_modes(modes: int, *, slow: bool) -> Rule:
    """Rule of a number of pressure modes along a profile, compared with fewer of them.

    If contacts cover most of a flank, their terms hardly decrease: `slow` is half the order.
    """
    left = max(modes - OMITTED_MODES, 1)
    return Rule.of_order(1.0 + OMITTED_MODES / left, MODES_ORDER * (0.5 if slow else 1.0))


#: Contacts are wide if they cover more than this part of a flank.
COVERED = 0.5
#: Half as many nodes or slices: if the error is only proportional to their distance, it equals the
#: change.
NODES = Rule(0.5, 0.5, 0.5)
#: Order of the error in the number of slices, as in `scene.steps`.
SLICES_ORDER = 1.5
#: Without the two highest modes along the profile or degrees along the axis. Rotations and load
#: shares converge like a geometric series, of which a quarter of the last steps remains. Line loads
#: and pressures at an end converge with the second power of these numbers, so that from 3 to 5
#: degrees a half of the change remains; signs vary, and changes of two sources may cancel.
SERIES = Rule(0.0, 0.25, 0.75, shares=2.0)
#: Smoothed stresses give 0.5 to 1.0 of the error under pressures that the flank elements hardly
#: resolve.
ELEMENTS = Rule(-1.45, 1.0, 2.0, shares=2.0)
#: A half-ellipse of pressure with its middle on the edge of two cells appears lower by 0.5 % with
#: five cells on its half-width. If a peak changes by more than twice that, half as many cells do
#: not resolve some feature (a kink, a small rounding), and the whole change is in doubt.
LARGEST_SMOOTH_CHANGE = 0.01


class RemainingError(NamedTuple):
    """Remaining error of one source in a quantity, or in a quantity at many places.

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
        """Largest possible error."""
        return float(np.max(np.abs(self.error) + self.doubt, initial=0.0))

    @classmethod
    def of(cls, parts: list[RemainingError]) -> RemainingError:
        """Sum over several sources: errors with their signs, doubts as squares."""
        doubt = np.sqrt(sum(np.square(part.doubt) for part in parts))
        return cls(sum(part.error for part in parts), doubt)

    @classmethod
    def relative(cls, error: float, doubt: float, whole: float | np.floating) -> RemainingError:
        """Error and doubt of a number relative to its magnitude; none if that is 0."""
        size = abs(float(whole))
        return cls(error / size, doubt / size) if size > 0 else cls(0.0, 0.0)


def mean_stiffness(softness: Floats) -> Floats | None:
    """Inverse of rotation over torque; None if it is unknown at a position."""
    return 1.0 / softness if (softness > 0).all() else None


def stiffnesses(part: Sweep) -> dict[str, Floats]:
    """Stiffnesses (P,) of a sweep that are known at all positions, by quantity."""
    every = {
        "stiffness_secant": mean_stiffness(part.turned_rad),
        "stiffness_tangent": mean_stiffness(part.tangent_rad_per_Nmm),
    }
    return {name: values for name, values in every.items() if values is not None}


def remaining_errors(
    rule: Rule,
    found: Sweep,
    base: Sweep,
    other: Sweep,
    weights: Floats,
) -> dict[str, RemainingError]:
    """Remaining errors of one source in the quantities of a sweep.

    Parameters
    ----------
    rule : Rule
    found : Sweep
        The sweep whose errors are estimated.
    base, other : Sweep
        Sweeps without and with the change by the source.
    weights : (P,) array
        Parts of the positions in the mean load over the face width.
    """
    rotation, change = found.rotation_rad, other.rotation_rad - base.rotation_rad
    sharing = replace(rule, doubt=rule.shares * rule.doubt)
    errors = {
        "transmission_error": _at_each(rule, change, np.abs(rotation).max()),
        "load_share": _at_each(sharing, load_shares(other) - load_shares(base), 1.0),
        "peak_pressure": _at_each(
            _of_pressures(rule), _peak_change(found, base, other), largest_peak(found)
        ),
        "transmission_error_mean": _of_mean(rule, change, rotation),
        "transmission_error_peak_to_peak": _of_peak_to_peak(rule, change, rotation),
    }
    kink = LARGEST_KINK if found.slices.plane else np.inf
    unloaded = found.rotation_rad - found.turned_rad
    own = unloaded if other.unloaded is None else other.rotation_rad - other.turned_rad
    turned = [found.turned_rad, base.rotation_rad - unloaded, other.rotation_rad - own]
    for name, softness, largest in (
        ("stiffness_secant", turned, np.inf),
        # in the plane with steps where the loaded pairs change
        ("stiffness_tangent", [s.tangent_rad_per_Nmm for s in (found, base, other)], kink),
    ):
        stiffness = [mean_stiffness(values) for values in softness]
        one, two, three = stiffness
        if one is not None and two is not None and three is not None:
            change = np.where(np.abs(three - two) <= largest * one, three - two, 0.0)
            errors[name] = _of_mean(rule, change, one)
    if found.coast is not None:
        change = _coast_shares(other) - _coast_shares(base)
        errors[COAST] = _at_each(sharing, change, 1.0)
    if not found.slices.plane:
        errors |= _of_line_loads(rule, found, base, other, weights)
    return errors


def _of_line_loads(
    rule: Rule, found: Sweep, base: Sweep, other: Sweep, weights: Floats
) -> dict[str, RemainingError]:
    """Errors of single line loads, of the largest one, and of both load factors.

    They are compared on the wider slices.
    """
    edges = min(found.slices.edges_mm, other.slices.edges_mm, key=np.size)
    around = np.searchsorted(edges, found.slices.edges_mm[1:]) - 1
    smooth = ~on_corner(found.slices.corner)
    found, base, other = (_on_slices(edges, part) for part in (found, base, other))
    one, two, three = (part.slices.force_N / np.diff(edges) for part in (found, base, other))
    change = np.where(smooth, (three - two)[..., around], 0.0)
    errors = {LINE_LOAD: _at_each(_of_pressures(rule), change, one.max())}
    for name, loads_of in (
        (FACE_LOAD, partial(loads_over_period, weights=weights)),
        (LINE_FACTOR, relative_loads),
        (PEAK_LINE, line_loads),
    ):
        one, two, three = (loads_of(part) for part in (found, base, other))
        each = _at_each(_of_pressures(rule), three - two, one.max())
        errors[name] = of_largest(each, one / one.max())
    return errors


def _on_slices(edges_mm: Floats, part: Sweep) -> Sweep:
    """A sweep with the forces on other slices, whose edges are among its own."""
    first = np.searchsorted(part.slices.edges_mm, edges_mm[:-1])
    force = np.add.reduceat(part.slices.force_N, first, axis=2)
    return replace(part, slices=replace(part.slices, edges_mm=edges_mm, force_N=force))


def _of_pressures(rule: Rule) -> Rule:
    """The rule with its doubt for pressures."""
    return replace(rule, doubt=rule.doubt_pressure)


def _at_each(rule: Rule, change: Floats, whole: float | np.floating) -> RemainingError:
    """Error of a quantity at each position."""
    relative = change / whole if whole > 0 else np.zeros_like(change)
    return RemainingError(rule.part * relative, rule.doubt * np.abs(relative))


def _of_mean(rule: Rule, change: Floats, values: Floats) -> RemainingError:
    """Error of a mean over the positions."""
    whole = abs(float(values.mean()))
    if whole == 0:
        return RemainingError(0.0, 0.0)
    mean = float(change.mean()) / whole
    return RemainingError(rule.part * mean, rule.doubt * abs(mean))


def _of_peak_to_peak(rule: Rule, change: Floats, rotation: Floats) -> RemainingError:
    whole = float(np.ptp(rotation))
    error = whole - float(np.ptp(rotation - rule.part * change))
    apart = np.abs(change - change.mean())
    of_extremes = np.hypot(apart[rotation.argmax()], apart[rotation.argmin()])
    return RemainingError.relative(error, rule.doubt * float(of_extremes), whole)


def load_shares(part: Sweep) -> Floats:
    """Parts (P, S) of the forces on the working flanks."""
    return part.site_force_N / _whole_force(part)


def _coast_shares(part: Sweep) -> Floats:
    assert part.coast is not None
    return part.coast.site_force_N / _whole_force(part)


def _whole_force(part: Sweep) -> Floats:
    """Sum of the forces on the working flanks, (P, 1)."""
    total = part.site_force_N.sum(axis=1, keepdims=True)
    return np.asarray(np.maximum(total, np.finfo(float).tiny))


def _smooth(*parts: Sweep) -> Flags:
    """Sites that carry load in the first of several sweeps, in none of them on a sharp corner."""
    corners = [on_corner(part.site_corner) for part in parts]
    return np.asarray(~np.logical_or.reduce(corners) & (parts[0].site_peak_N_per_mm > 0))


def largest_peak(found: Sweep) -> float:
    """Largest force over the width of a cell off sharp corners; 0 if there is none."""
    return float(np.max(found.site_peak_N_per_mm, initial=0.0, where=_smooth(found)))


def at_largest_peak(peaks: RemainingError, found: Sweep) -> RemainingError:
    """Error of the largest pressure off sharp corners, from those of all peaks (P, S)."""
    smooth = np.where(_smooth(found), found.site_peak_N_per_mm, 0.0)
    return of_largest(peaks, smooth / max(float(smooth.max()), np.finfo(float).tiny))


def of_largest(each: RemainingError, values: Floats) -> RemainingError:
    """Error of the largest of some values, relative to it, from their errors.

    Another value is the largest if its error exceeds its distance to the largest one.
    """
    error, doubt = (np.broadcast_to(part, values.shape) for part in each)
    most = float((values - 1.0 + np.abs(error) + doubt).max())
    there = float(error.flat[values.argmax()])
    return RemainingError(there, most - abs(there))


def _peak_change(found: Sweep, base: Sweep, other: Sweep) -> Floats:
    """Change of the peaks off sharp corners."""
    change = other.site_peak_N_per_mm - base.site_peak_N_per_mm
    return np.where(_smooth(found, base, other), change, 0.0)


def peak_of_modes(
    rule: Rule, found: Sweep, base: Sweep, other: Sweep, shares: RemainingError
) -> RemainingError:
    """Error of the modes in the peaks off sharp corners; sweeps as in `remaining_errors`.

    `shares` is their error in the load shares: the peak of a line contact is proportional to the
    root of its force, so that of a pair that has just begun to carry load may be a multiple.
    """
    own = _at_each(_of_pressures(rule), _peak_change(found, base, other), largest_peak(found))
    peak = np.where(_smooth(found, base, other), found.site_peak_N_per_mm, 0.0)
    share = np.maximum(load_shares(found), np.finfo(float).tiny)
    of_force = np.sqrt(1.0 + (np.abs(shares.error) + shares.doubt) / share) - 1.0
    relative = peak / max(largest_peak(found), np.finfo(float).tiny)
    return RemainingError(own.error, np.hypot(own.doubt, of_force * relative))


def peak_of_cells(found: Sweep, coarse: Sweep) -> RemainingError:
    """Error of the cells in the peaks off sharp corners; `coarse` has half as many cells."""
    change, largest = _peak_change(found, found, coarse), largest_peak(found)
    remaining = _at_each(_of_pressures(STRIPS), change, largest)
    rough = np.abs(change) > LARGEST_SMOOTH_CHANGE * found.site_peak_N_per_mm
    whole = np.abs(change) / largest if largest > 0 else np.zeros_like(change)
    return RemainingError(
        np.where(rough, 0.0, remaining.error), np.where(rough, whole, remaining.doubt)
    )
