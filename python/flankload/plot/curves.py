"""Curves over the positions: transmission error, load sharing, peak pressure, follower."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.lines import Line2D

from flankload.plot.figures import heaviest, label_curves, legend_below, one_panel
from flankload.plot.positions import (
    MOST_MARKS,
    curve,
    label_positions,
    legend_of_pairs,
    lifted,
    marks,
    pair_curve,
    through_uneven,
    way_curve,
)
from flankload.plot.style import (
    BODIES,
    FORCE,
    GREY,
    at_corner,
    colour_of,
    loaded_sites,
    pair_name,
    torque_colours,
)

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    from flankload.result import Result

#: Least range of a plot of transmission errors, um, and as part of their mean: smaller variations
#: are roundoff.
LEAST_SPAN_UM = 1e-3
LEAST_SPAN_PART = 5e-3
#: Lines at values that mean nothing.
DASHED: dict[str, Any] = {"linewidth": 1.1, "linestyle": (0, (3, 2))}
ON_SHARP = "a pair carries on a sharp corner"
ON_CORNER = "dashed: on a sharp corner, not meaningful"


def plot_transmission_error(results: Result | Sequence[Result]) -> Figure:
    """Transmission error over the positions, with its mean and peak to peak; a curve per torque."""
    return one_panel(draw_transmission_error, results, "Transmission error")


def draw_transmission_error(axes: Axes, results: Sequence[Result]) -> None:
    """Draw the transmission error over the positions, a curve per torque.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
    results : sequence of Result
        One per torque, by ascending torque.
    """
    label_positions(axes, results[0])
    axes.set_ylabel("transmission error in µm")
    colours = torque_colours(len(results))
    for result, colour in zip(results, colours, strict=True):
        error = result.transmission_error_um
        if (smooth := through_uneven(result, error)) is not None:
            axes.plot(*smooth, color=colour)
            axes.plot(*curve(result, error), color=colour, linestyle="none", **marks(result))
        else:
            axes.plot(*curve(result, error), color=colour, **marks(result))
    for result, colour in zip(results, colours, strict=True):
        _mark_corners(axes, result, colour)
    if len(results) == 1:
        _note_mean(axes, results[0])
        return
    ends = [float(curve(result, result.transmission_error_um)[1][-1]) for result in results]
    spans = [result.summary["transmission_error_peak_to_peak_um"] for result in results]
    texts = [
        f"{result.torque_Nm:g} N m\np-p {span:.2f} µm"
        for result, span in zip(results, spans, strict=True)
    ]
    label_curves(axes, ends, texts, colours)


def _mark_corners(axes: Axes, result: Result, colour: Any) -> None:
    """Hollow marks at positions with contact on a sharp corner; one entry in the legend."""
    corner = at_corner(result)
    if not corner.any():
        return
    few = corner.size <= MOST_MARKS
    named = axes.get_legend() is not None
    x, y = curve(result, np.where(corner, result.transmission_error_um, np.nan))
    (marked,) = axes.plot(
        x,
        y,
        linestyle="none",
        marker="o",
        markersize=5 if few else 1.5,
        markerfacecolor="white" if few else colour,
        markeredgecolor=colour,
        label=ON_SHARP,
    )
    if not named:
        key = Line2D([], [])
        key.update_from(marked)
        key.set(markeredgecolor=GREY, markerfacecolor="white" if few else GREY)
        legend_below(axes, [key], [ON_SHARP])


def _note_mean(axes: Axes, result: Result) -> None:
    """Mean and peak to peak of one torque, above the curve; roundoff is not magnified."""
    mean = result.summary["transmission_error_mean_um"]
    span = result.summary["transmission_error_peak_to_peak_um"]
    axes.axhline(mean, color=GREY, linewidth=1, linestyle=(0, (6, 3)))
    error = result.transmission_error_um
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


def plot_load_sharing(results: Result | Sequence[Result]) -> Figure:
    """Load share of each pair over the positions; of several torques, of a pair on its way."""
    return one_panel(draw_load_sharing, results, "Load sharing")


def draw_load_sharing(axes: Axes, results: Sequence[Result]) -> None:
    """Draw the load share of each pair over the positions, with forces on a second axis.

    Several torques: the share of a pair on its way through the mesh, a curve per torque.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
    results : sequence of Result
        One per torque, by ascending torque.
    """
    axes.set_ylim(0, 108)
    axes.set_yticks(range(0, 101, 20))
    axes.set_ylabel("load share in %")
    if len(results) > 1:
        _draw_on_way(axes, results, [100 * result.load_share for result in results])
        label_curves(axes, [100.0] * len(results), *_torque_labels(results))
        return
    (result,) = results
    label_positions(axes, result)
    for s, site in loaded_sites(result):
        angle, share = pair_curve(result, 100 * result.load_share, s)
        label = pair_name(site)
        axes.plot(angle, lifted(share), color=colour_of(result, site), label=label, **marks(result))
    _add_force_axis(axes, result)
    legend_of_pairs(axes)


def _torque_labels(results: Sequence[Result]) -> tuple[list[str], list[Any]]:
    return [f"{result.torque_Nm:g} N m" for result in results], torque_colours(len(results))


def _draw_on_way(
    axes: Axes, results: Sequence[Result], values: Sequence[NDArray[Any]], *, corners: bool = False
) -> list[float]:
    """A curve per torque on the way of a pair through the mesh, dashed on corners.

    Returns
    -------
    list of float
        Largest value of each curve off corners.
    """
    if results[0].has_cam:
        label_positions(axes, results[0])
    else:
        axes.set_xlabel("place of the pair in mesh pitches from the pitch point")
        places = results[-1].sites + results[-1].position_rad[:, None] / results[-1].pitch_rad
        loaded = places[results[-1].site_force_N > 0]
        if loaded.size:
            axes.set_xlim(loaded.min() - 0.1, loaded.max() + 0.1)
    tops = []
    for result, value, colour in zip(results, values, torque_colours(len(results)), strict=True):
        place, whole = way_curve(result, value)
        on_corner = np.zeros(whole.size, dtype=bool)
        if corners:
            on_corner = way_curve(result, result.corner_contact.astype(float))[1] > 0
        tops.append(float(np.nanmax(np.where(on_corner, np.nan, whole), initial=0.0)))
        look = {"color": colour, "label": f"{result.torque_Nm:g} N m", **marks(result)}
        draw_off_corners(axes, place, whole, on_corner, **look)
    return tops


def draw_off_corners(
    axes: Axes, x: NDArray[Any], y: NDArray[Any], on_corner: NDArray[np.bool_], **look: Any
) -> None:
    """A curve that is dashed and thin where values mean nothing, blank where a pair is open."""
    # a segment is dashed if one of its ends lies on a corner
    beside = on_corner.copy()
    beside[1:] |= on_corner[:-1]
    beside[:-1] |= on_corner[1:]
    shown = lifted(y)
    axes.plot(x, np.where(on_corner, np.nan, shown), **look)
    if on_corner.any():
        axes.plot(x, np.where(beside, shown, np.nan), color=look["color"], **DASHED)


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


def plot_peak_pressure(results: Result | Sequence[Result]) -> Figure:
    """Peak pressure of each pair over the positions; of several torques, of a pair on its way."""
    return one_panel(draw_peak_pressure, results, "Peak pressure")


def draw_peak_pressure(axes: Axes, results: Sequence[Result]) -> None:
    """Draw the peak pressure of each pair over the positions, dashed on sharp corners.

    Several torques: the pressure of a pair on its way through the mesh, a curve per torque.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
    results : sequence of Result
        One per torque, by ascending torque.
    """
    axes.set_ylabel("peak pressure in MPa")
    # meaningless values must not compress the range of the others
    smooth = max(result.summary["peak_pressure_off_corners_MPa"] for result in results)
    axes.set_ylim(0, 1.25 * smooth if smooth > 0 else None)
    if len(results) > 1:
        pressures = [result.peak_pressure_MPa for result in results]
        tops = _draw_on_way(axes, results, pressures, corners=True)
        names, colours = _torque_labels(results)
        texts = [f"{name}\n{top:.0f} MPa" for name, top in zip(names, tops, strict=True)]
        label_curves(axes, tops, texts, colours)
        if any(result.corner_contact.any() for result in results):
            axes.plot([], [], color=GREY, **DASHED, label=ON_CORNER)
            legend_below(axes, [axes.lines[-1]], [ON_CORNER])
        return
    (result,) = results
    label_positions(axes, result)
    for s, site in loaded_sites(result):
        angle, whole = pair_curve(result, result.peak_pressure_MPa, s)
        _, corner = pair_curve(result, result.corner_contact.astype(float), s)
        look = {"color": colour_of(result, site), "label": pair_name(site), **marks(result)}
        draw_off_corners(axes, angle, whole, corner > 0, **look)
    if result.corner_contact.any():
        axes.plot([], [], color=GREY, **DASHED, label=ON_CORNER)
    legend_of_pairs(axes)


def plot_follower_motion(results: Result | Sequence[Result]) -> Figure:
    """Angle of a follower over a turn of its cam, and the contact force.

    Raises
    ------
    ValueError
        If there is no cam.
    """
    return one_panel(draw_follower_motion, heaviest(results), "Follower motion")


def draw_follower_motion(axes: Axes, results: Sequence[Result]) -> None:
    """Draw the angle of a follower over a turn of its cam, and the contact force.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
    results : sequence of Result
        The force is that of the largest torque.

    Raises
    ------
    ValueError
        If there is no cam.
    """
    result = heaviest(results)
    if result.follower_angle_rad is None:
        raise ValueError("result: expected a follower on its cam, found none")
    label_positions(axes, result)
    angle, turned = curve(result, np.degrees(result.follower_angle_rad))
    axes.plot(angle, turned, color=BODIES[0], **marks(result))
    axes.set_ylabel("follower angle in degrees", color=BODIES[0])
    if (result.site_force_N > 0).any():
        second = axes.twinx()
        second.spines["right"].set_visible(True)
        second.grid(visible=False)
        angle, force = curve(result, result.site_force_N.sum(axis=1) / 1e3)
        second.plot(angle, force, color=FORCE, linestyle=(0, (6, 3)), **marks(result))
        second.set_ylim(0, 1.25 * float(np.nanmax(force)))
        second.set_ylabel("force in kN (dashed)", color=FORCE)
