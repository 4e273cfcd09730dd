"""Curves over the positions: transmission error, load sharing, peak pressure."""

from __future__ import annotations

from math import degrees
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib import rc_context
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator, MultipleLocator

from flankload.plot.style import (
    COLOURS,
    GREY,
    SIZE,
    STYLE,
    at_corner,
    colour_of,
    loaded_sites,
    new_figure,
    pair_name,
    subtitle,
)
from flankload.result.harmonics import over_positions

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from numpy.typing import NDArray

    from flankload.result import Result

#: Least range of a plot of transmission errors, um, and as part of their mean: smaller variations
#: are roundoff.
LEAST_SPAN_UM = 1e-3
LEAST_SPAN_PART = 5e-3
#: Largest number of uneven positions with markers; more of them look like a line.
MOST_MARKS = 400
#: Largest number of pairs that are named one by one.
MOST_NAMED = 12
#: Points of a plotted curve on each of its pieces.
CURVE_STEPS = 8


def plot_transmission_error(result: Result) -> Figure:
    """Transmission error over the positions, with its mean and peak to peak.

    Parameters
    ----------
    result : Result

    Returns
    -------
    matplotlib.figure.Figure
    """
    with rc_context(STYLE):
        figure, axes = figure_over_positions(result, "Transmission error")
        angle, error = curve(result, result.transmission_error_um)
        if (smooth := _through_uneven(result, result.transmission_error_um)) is not None:
            axes.plot(*smooth, color=COLOURS[0])
            axes.plot(angle, error, color=COLOURS[0], linestyle="none", **marks(result))
        else:
            axes.plot(angle, error, color=COLOURS[0], **marks(result))
        summary = result.summary
        mean = summary["transmission_error_mean_um"]
        span = summary["transmission_error_peak_to_peak_um"]
        axes.axhline(mean, color=GREY, linewidth=1, linestyle=(0, (6, 3)))
        corner = at_corner(result)
        if corner.any():
            x, y = curve(result, np.where(corner, result.transmission_error_um, np.nan))
            axes.plot(
                x,
                y,
                linestyle="none",
                marker="o",
                markersize=6 if corner.size <= MOST_MARKS else 1.5,
                markerfacecolor="white" if corner.size <= MOST_MARKS else COLOURS[1],
                markeredgecolor=COLOURS[1],
                label="a pair carries on a sharp corner",
            )
            axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.16))
        # head-room for the numbers, so that they never cover the curve; roundoff is not magnified
        shown = max(span, LEAST_SPAN_UM, LEAST_SPAN_PART * abs(mean))
        low, high = mean - 0.5 * (shown - span), mean + 0.5 * (shown - span)
        low, high = min(low, np.nanmin(error)), max(high, np.nanmax(error))
        axes.set_ylim(low - 0.12 * shown, high + 0.30 * shown)
        axes.text(
            0.99,
            0.97,
            f"mean {mean:.2f} µm (dashed)\npeak to peak {span:.2f} µm",
            transform=axes.transAxes,
            ha="right",
            va="top",
            fontsize=9,
            color=GREY,
            linespacing=1.4,
        )
        axes.set_ylabel("transmission error in µm")
        return figure


def plot_load_sharing(result: Result) -> Figure:
    """Load share of each pair over the positions, forces on a second axis.

    Parameters
    ----------
    result : Result

    Returns
    -------
    matplotlib.figure.Figure
    """
    with rc_context(STYLE):
        figure, axes = figure_over_positions(result, "Load sharing")
        shares = 100 * result.load_share
        for s, site in loaded_sites(result):
            angle, share = pair_curve(result, shares, s)
            axes.plot(
                angle,
                lifted(share),
                color=colour_of(result, site),
                label=pair_name(site),
                **marks(result),
            )
        axes.set_ylim(0, 108)
        axes.set_yticks(range(0, 101, 20))
        axes.set_ylabel("load share in %")
        _add_force_axis(axes, result)
        legend_of_pairs(axes)
        return figure


def _add_force_axis(axes: Axes, result: Result) -> None:
    """A second axis in kN; the sum of the forces is almost constant over the positions."""
    total = float(result.site_force_N.sum(axis=1).mean()) / 1e3
    if total <= 0:
        return

    def force(share: Any) -> Any:
        return share * total / 100

    def share(force: Any) -> Any:
        return force * 100 / total

    second = axes.secondary_yaxis("right", functions=(force, share))
    second.set_ylabel(f"force in kN (all pairs: {total:.2f} kN)")
    second.spines["right"].set_visible(True)


def plot_peak_pressure(result: Result) -> Figure:
    """Peak pressure of each pair over the positions; dashed on sharp corners.

    Parameters
    ----------
    result : Result

    Returns
    -------
    matplotlib.figure.Figure
    """
    with rc_context(STYLE):
        figure, axes = figure_over_positions(result, "Peak pressure")
        for s, site in loaded_sites(result):
            colour = colour_of(result, site)
            angle, whole = pair_curve(result, result.peak_pressure_MPa, s)
            _, corner = pair_curve(result, result.corner_contact.astype(float), s, closing=0.0)
            on_corner = corner > 0
            # a segment is dashed if one of its ends lies on a corner
            beside = on_corner.copy()
            beside[1:] |= on_corner[:-1]
            beside[:-1] |= on_corner[1:]
            smooth = np.where(on_corner, np.nan, lifted(whole))
            axes.plot(angle, smooth, color=colour, label=pair_name(site), **marks(result))
            dashed = np.where(beside, lifted(whole), np.nan)
            axes.plot(angle, dashed, color=colour, linewidth=1.1, linestyle=(0, (3, 2)))
        if result.corner_contact.any():
            axes.plot(
                [],
                [],
                color=GREY,
                linewidth=1.1,
                linestyle=(0, (3, 2)),
                label="dashed: on a sharp corner, not meaningful",
            )
        # meaningless values must not compress the range of the others
        smooth = result.summary["peak_pressure_off_corners_MPa"]
        axes.set_ylim(0, 1.25 * smooth if smooth > 0 else None)
        axes.set_ylabel("peak pressure in MPa")
        legend_of_pairs(axes)
        return figure


def plot_follower_motion(result: Result) -> Figure:
    """Angle of a follower over a turn of its cam, and the contact force.

    Parameters
    ----------
    result : Result
        Result of a follower on its cam.

    Returns
    -------
    matplotlib.figure.Figure

    Raises
    ------
    ValueError
        If there is no cam.
    """
    if result.follower_angle_rad is None:
        raise ValueError("result: expected a follower on its cam, found none")
    with rc_context(STYLE):
        figure, axes = figure_over_positions(result, "Follower")
        angle, turned = curve(result, np.degrees(result.follower_angle_rad))
        axes.plot(angle, turned, color=COLOURS[0], **marks(result))
        axes.set_ylabel("follower angle in degrees", color=COLOURS[0])
        if (result.site_force_N > 0).any():
            second = axes.twinx()
            second.spines["right"].set_visible(True)
            second.grid(visible=False)
            angle, force = curve(result, result.site_force_N.sum(axis=1) / 1e3)
            second.plot(angle, force, color=COLOURS[1], linestyle=(0, (6, 3)), **marks(result))
            second.set_ylim(0, 1.25 * float(np.nanmax(force)))
            second.set_ylabel("force in kN (dashed)", color=COLOURS[1])
        return figure


def figure_over_positions(result: Result, title: str) -> tuple[Figure, Axes]:
    figure = new_figure(SIZE)
    axes = figure.add_subplot()
    axes.set_title(title)
    axes.set_title(subtitle(result), loc="right", fontsize=9, fontweight="normal", color=GREY)
    angle = "cam angle in degrees" if result.has_cam else "angle of body 1 in degrees"
    axes.set_xlabel(angle)
    angles = np.degrees(result.position_rad)
    if _is_closed(result):
        axes.set_xlim(0, degrees(result.period_rad))
        if result.has_cam:
            axes.xaxis.set_major_locator(MultipleLocator(45))
            return figure, axes
        axes.xaxis.set_major_locator(MaxNLocator(nbins=10, steps=[1, 2, 2.5, 5, 10]))
        pitch = degrees(result.pitch_rad)
        axes.set_xlabel(f"{angle} (one pitch = {pitch:.4g}°)")
    elif np.ptp(angles) > 0:
        margin = 0.02 * np.ptp(angles)  # markers at both ends remain complete
        axes.set_xlim(angles.min() - margin, angles.max() + margin)
    return figure, axes


def marks(result: Result) -> dict[str, Any]:
    """Markers for few or uneven positions: a line alone would hide them."""
    if result.position_rad.size > 12 and (_is_closed(result) or not _gaps(result).size):
        if result.position_rad.size > MOST_MARKS or over_positions(result).regular:
            return {}
        return {"marker": "o", "markersize": 2.5}
    return {"marker": "o", "markersize": 4.5}


def curve(result: Result, values: NDArray[Any]) -> tuple[NDArray[Any], NDArray[Any]]:
    """Angles in degrees and values; closed over the period, else ascending with gaps."""
    angle = np.degrees(result.position_rad)
    if _is_closed(result):
        return np.append(angle, degrees(result.period_rad)), np.append(values, values[0])
    order = np.argsort(angle, kind="stable")
    gaps = _gaps(result)
    return np.insert(angle[order], gaps, np.nan), np.insert(1.0 * values[order], gaps, np.nan)


def _through_uneven(
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


def _is_closed(result: Result) -> bool:
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
    if not _is_closed(result) or result.has_cam:
        return curve(result, values[:, s])
    after = np.flatnonzero(result.sites == result.sites[s] + result.period_pitches)
    end = values[0, after[0]] if after.size else closing
    angle, _ = curve(result, values[:, s])
    return angle, np.append(values[:, s], end)


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
        axes.legend(
            shown.values(),
            shown.keys(),
            loc="upper center",
            bbox_to_anchor=(0.5, -0.16),
            ncols=min(len(shown), 5),
        )
