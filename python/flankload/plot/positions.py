"""Axes and curves over the positions."""

from __future__ import annotations

from math import degrees, isclose
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator, MultipleLocator

from flankload.plot.figures import legend_below
from flankload.plot.style import GREY
from flankload.result.harmonics import over_positions

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from numpy.typing import NDArray

    from flankload.result import Result

#: Name of Axes over the positions, which is not shown.
OVER_POSITIONS = "over the positions"
#: A whole turn, and its ticks, degrees.
TURN, TICKS = 360.0, 45.0
#: Largest number of uneven positions with markers; more of them look like a line.
MOST_MARKS = 400
#: Largest number of pairs that are named one by one.
MOST_NAMED = 12
#: Points of a plotted curve on each of its pieces.
CURVE_STEPS = 8


def label_positions(axes: Axes, result: Result) -> None:
    """Range, ticks and label of the axis of positions, in degrees."""
    label = f"{result.engagement.position_angle} in degrees"
    axes.set_label(OVER_POSITIONS)
    axes.set_xlabel(label)
    angles = result.position_deg
    if is_closed(result):
        axes.set_xlim(0, result.period_deg)
        if isclose(result.period_deg, TURN):
            axes.xaxis.set_major_locator(MultipleLocator(TICKS))
        else:
            axes.xaxis.set_major_locator(MaxNLocator(nbins=10, steps=[1, 2, 2.5, 5, 10]))
        if result.engagement.pairs_advance:
            axes.set_xlabel(f"{label} (one pitch = {result.pitch_deg:.4g}°)")
    elif np.ptp(angles) > 0:
        margin = 0.02 * np.ptp(angles)  # markers at both ends remain complete
        axes.set_xlim(angles.min() - margin, angles.max() + margin)


def places_on_way(result: Result) -> NDArray[np.float64]:
    """(P, S) Places of the pairs in mesh pitches from the pitch point.

    Pair j is j pitches further along than pair 0, so all pairs together are the way of one pair.
    """
    return np.asarray(result.sites + result.position_rad[:, None] / result.pitch_rad)


def label_way(axes: Axes, result: Result, beside: float = 0.1) -> None:
    """Label of the axis of these places, and its range: places with load, and some beside.

    The axis of positions if the pairs do not advance.
    """
    if not result.engagement.pairs_advance:
        label_positions(axes, result)
        return
    axes.set_xlabel(result.engagement.way)
    loaded = places_on_way(result)[result.site_force_N > 0]
    if loaded.size:
        axes.set_xlim(loaded.min() - beside, loaded.max() + beside)


def marks(result: Result) -> dict[str, Any]:
    """Markers for few or uneven positions: a line alone would hide them."""
    if result.position_rad.size > 12 and (is_closed(result) or not _gaps(result).size):
        if result.position_rad.size > MOST_MARKS or over_positions(result).regular:
            return {}
        return {"marker": "o", "markersize": 2.5}
    return {"marker": "o", "markersize": 4.5}


def curve(result: Result, values: NDArray[Any]) -> tuple[NDArray[Any], NDArray[Any]]:
    """Angles in degrees and values; closed over the period, else ascending with gaps."""
    angle = np.degrees(result.position_rad)
    if is_closed(result):
        return np.append(angle, degrees(result.period_rad)), np.append(values, values[0])
    order = np.argsort(angle, kind="stable")
    gaps = _gaps(result)
    return np.insert(angle[order], gaps, np.nan), np.insert(1.0 * values[order], gaps, np.nan)


def through_uneven(
    result: Result, values: NDArray[Any]
) -> tuple[NDArray[Any], NDArray[Any]] | None:
    """Angles in degrees and values of the curve through uneven positions, with its kinks."""
    over = over_positions(result)
    curve = over.curve(values)
    if curve is None or not (result.closed or over.contiguous):
        return None
    steps = np.linspace(0.0, 1.0, CURVE_STEPS, endpoint=False)
    places = (curve.low[:, None] + (curve.high - curve.low)[:, None] * steps).ravel()
    places = np.append(places, curve.high[-1])
    return np.degrees(places), curve.values(places)


def is_closed(result: Result) -> bool:
    """Whether the curve is closed; one position is a point, since a line would be invented."""
    return result.closed and result.position_rad.size > 1


def _gaps(result: Result) -> NDArray[np.int64]:
    """Positions after which a line would cross more than half a pitch without data."""
    steps = np.diff(np.sort(result.position_rad))
    return np.asarray(np.flatnonzero(steps > 0.5001 * result.pitch_rad) + 1)


def pair_curve(
    result: Result, values: NDArray[Any], s: int, closing: float = 0.0
) -> tuple[NDArray[Any], NDArray[Any]]:
    """Curve of one pair: a period later it has the place of another pair."""
    angle, along = curve(result, values[:, s])
    if is_closed(result):
        after = result.site_after_period(s)
        along[-1] = closing if after is None else values[0, after]
    return angle, along


def way_curve(
    result: Result, values: NDArray[Any], closing: float = 0.0
) -> tuple[NDArray[Any], NDArray[Any]]:
    """Curve of a quantity of the pairs (P, S) on the way of a pair through the mesh.

    If the period has several pitches, whose pairs differ, their curves lie above each other.

    Returns
    -------
    place : (n,) array
        Pitches, as labelled by `label_way`; positions in degrees if the pairs do not advance.
    value : (n,) array
        NaN between separate curves.
    """
    pieces = []
    for s, site in enumerate(result.sites):
        angle, along = pair_curve(result, values, s, closing)
        place = site + angle / result.pitch_deg if result.engagement.pairs_advance else angle
        pieces.append(np.array([place, along]))
        if result.period_pitches > 1 or not is_closed(result):
            pieces.append(np.full((2, 1), np.nan))
    place, along = np.concatenate(pieces, axis=1)
    return place, along


def lifted(values: NDArray[Any]) -> NDArray[Any]:
    """Values without the parts at which a pair is open, so that no curve follows the axis."""
    carries = values > 0
    near = carries.copy()
    near[1:] |= carries[:-1]
    near[:-1] |= carries[1:]
    return np.where(near, values, np.nan)


def legend_of_pairs(axes: Axes, more: dict[str, Line2D] | None = None) -> None:
    handles, labels = axes.get_legend_handles_labels()
    shown = dict(zip(labels, handles, strict=True))
    pairs = [label for label in labels if label.startswith("pair ")]
    if len(pairs) > MOST_NAMED:
        # one name for all: their curves follow each other
        shown = {label: handle for label, handle in shown.items() if label not in pairs}
        ends = " to ".join(pair.removeprefix("pair ") for pair in (pairs[-1], pairs[0]))
        shown = {f"pairs {ends}, from left to right": Line2D([], [], color=GREY), **shown}
    shown |= more or {}
    if shown:
        legend_below(axes, shown.values(), shown.keys(), ncols=min(len(shown), 5))
