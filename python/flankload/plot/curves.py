"""Curves over the positions and over the torque: motion, loads, stiffness."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.lines import Line2D

from flankload.base.number_text import percent
from flankload.plot.figures import label_torques, legend_below, note
from flankload.plot.picture import all_torques, figure_of, largest, panels, picture
from flankload.plot.positions import (
    MOST_MARKS,
    curve,
    label_positions,
    label_way,
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
    INK,
    SIZE,
    at_corner,
    coast_sites,
    colour_of,
    loaded_sites,
    pair_name,
    torque_colours,
)
from flankload.result.harmonics import over_positions

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    from flankload.plot.picture import Results
    from flankload.result import Result

#: Least range of a plot of transmission errors, um, and as part of their mean: smaller variations
#: are roundoff.
LEAST_SPAN_UM = 1e-3
LEAST_SPAN_PART = 5e-3
#: Lines at values that mean nothing.
DASHED: dict[str, Any] = {"linewidth": 1.1, "linestyle": (0, (3, 2))}
#: Largest mesh order of a spectrum, and part of an order that the bars of all torques cover.
MOST_ORDERS, COVERED = 10, 0.8
#: Place of a second axis beside the labels of the curves, as part of the width of the panel.
BESIDE_LABELS = 1.17
ON_SHARP = "a pair carries on a sharp corner"
ON_CORNER = "dashed: on a sharp corner, not meaningful"


@picture(all_torques)
def draw_transmission_error(axes: Axes, results: Results) -> None:
    """Draw the transmission error over the positions, a curve per torque.

    One torque: with its mean and peak to peak.
    """
    results = all_torques(results)
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
    label_torques(axes, results, ends, [f"p-p {span:.2f} µm" for span in spans])


@picture(all_torques)
def plot_transmission_error(results: Results) -> Figure:
    """Figure of the transmission error over the positions, a curve per torque."""
    return figure_of(draw_transmission_error, results, "Transmission error")


def _mark_corners(axes: Axes, result: Result, colour: Any) -> None:
    """Hollow marks at positions with contact on a sharp corner; one entry in the legend."""
    corner = at_corner(result)
    if not corner.any():
        return
    few = corner.size <= MOST_MARKS
    look: dict[str, Any] = {"linestyle": "none", "marker": "o", "markersize": 5 if few else 1.5}

    def colours(edge: Any) -> dict[str, Any]:
        return {"markeredgecolor": edge, "markerfacecolor": "white" if few else edge}

    x, y = curve(result, np.where(corner, result.transmission_error_um, np.nan))
    axes.plot(x, y, label=ON_SHARP, **look, **colours(colour))
    if axes.get_legend() is None:
        legend_below(axes, [Line2D([], [], **look, **colours(GREY))], [ON_SHARP])


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
    text = f"mean {mean:.2f} µm (dashed)\npeak to peak {span:.2f} µm"
    note(axes, text, (0.99, 0.97), "axes fraction", ha="right", va="top", linespacing=1.4)


@picture(all_torques)
def draw_load_sharing(axes: Axes, results: Results) -> None:
    """Draw the load share of each pair over the positions, with forces on a second axis.

    Several torques: the share of a pair on its way through the mesh, a curve per torque.
    """
    results = all_torques(results)
    axes.set_ylim(0, 108)
    axes.set_yticks(range(0, 101, 20))
    axes.set_ylabel("load share in %")
    if len(results) > 1:
        _draw_on_way(axes, results, [100 * result.load_share for result in results])
        label_torques(axes, results, [100.0] * len(results))
        return
    (result,) = results
    label_positions(axes, result)
    for s, site in loaded_sites(result):
        angle, share = pair_curve(result, 100 * result.load_share, s)
        label = pair_name(site)
        axes.plot(angle, lifted(share), color=colour_of(result, site), label=label, **marks(result))
    # the sum of the forces is almost constant over the positions
    total = float(result.site_force_N.sum(axis=1).mean()) / 1e3
    if total > 0:
        _add_axis(axes, total / 100, f"force in kN (all pairs: {total:.2f} kN)")
    legend_of_pairs(axes)


@picture(all_torques)
def plot_load_sharing(results: Results) -> Figure:
    """Figure of the load share of each pair over the positions, with forces on a second axis."""
    return figure_of(draw_load_sharing, results, "Load sharing")


def _draw_on_way(
    axes: Axes, results: Sequence[Result], values: Sequence[NDArray[Any]], *, corners: bool = False
) -> list[float]:
    """A curve per torque on the way of a pair through the mesh, dashed on corners.

    Returns
    -------
    list of float
        Largest value of each curve off corners.
    """
    label_way(axes, results[-1])
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


def _explain_jumps(
    axes: Axes, result: Result, place: tuple[float, float], note_of: str = ""
) -> None:
    """Say why the curves of helical teeth jump."""
    if not result.width_loads.enter_in_turn:
        return
    width = result.width_loads.width_mm.max()
    text = f"steps come from slices of {width:.2g} mm that enter and leave"
    look: dict[str, Any] = {"va": "top" if place[1] > 0.5 else "bottom", "fontsize": 8}
    note(axes, text + note_of, place, "axes fraction", **look)


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


def _add_axis(axes: Axes, factor: float, label: str, place: float = 1.0) -> None:
    """A second vertical axis of values that are a multiple of the first."""
    turns = (lambda value: value * factor, lambda value: value / factor)
    second = axes.secondary_yaxis(place, functions=turns)
    second.set_ylabel(label)
    second.spines["right"].set_visible(True)


@picture(all_torques)
def draw_peak_pressure(axes: Axes, results: Results) -> None:
    """Draw the peak pressure of each pair over the positions, dashed on sharp corners.

    Several torques: the pressure of a pair on its way through the mesh, a curve per torque.
    """
    results = all_torques(results)
    axes.set_ylabel("peak pressure in MPa")
    error = (results[-1].estimate or {}).get("peak_pressure")
    error_note = "" if error is None else f" (estimated error {percent(error)})"
    _explain_jumps(axes, results[-1], (0.01, 0.98), error_note)
    # meaningless values must not compress the range of the others
    smooth = max(result.summary["peak_pressure_MPa"] or 0.0 for result in results)
    axes.set_ylim(0, 1.25 * smooth if smooth > 0 else None)
    if len(results) > 1:
        pressures = [result.peak_pressure_MPa for result in results]
        tops = _draw_on_way(axes, results, pressures, corners=True)
        label_torques(axes, results, tops, [f"{top:.0f} MPa" for top in tops])
        explain_dashes(axes, results)
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


@picture(all_torques)
def plot_peak_pressure(results: Results) -> Figure:
    """Figure of the peak pressure of each pair over the positions, dashed on sharp corners."""
    return figure_of(draw_peak_pressure, results, "Peak pressure")


def explain_dashes(axes: Axes, results: Sequence[Result]) -> None:
    """Legend of curves that are dashed on corners, if any is."""
    if any(result.corner_contact.any() for result in results):
        (dashed,) = axes.plot([], [], color=GREY, **DASHED)
        legend_below(axes, [dashed], [ON_CORNER])


@picture(largest)
def draw_follower_motion(axes: Axes, results: Results) -> None:
    """Draw the angle of a follower over a turn of its cam, and the contact force.

    Raises
    ------
    ValueError
        If there is no cam.
    """
    result = largest(results)
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


@picture(largest)
def plot_follower_motion(results: Results) -> Figure:
    """Figure of the angle of a follower over a turn of its cam, and the contact force.

    Raises
    ------
    ValueError
        If there is no cam.
    """
    return figure_of(draw_follower_motion, largest(results), "Follower motion")


@picture(largest)
def draw_flank_forces(axes: Axes, results: Results) -> None:
    """Draw the force of each pair over the positions, on coast flanks dashed.

    Raises
    ------
    ValueError
        If coast flanks cannot carry load.
    """
    result = largest(results)
    if result.coast is None:
        raise ValueError("result: expected contact on coast flanks, found none")
    label_positions(axes, result)
    named: set[int] = set()
    for sites, force, line in (
        (loaded_sites(result), result.site_force_N, "-"),
        (coast_sites(result), result.coast.force_N, "--"),
    ):
        for s, site in sites:
            angle, along = pair_curve(result, force / 1e3, s)
            look: dict[str, Any] = {"color": colour_of(result, site), **marks(result)}
            label = None if site in named else pair_name(site)
            axes.plot(angle, lifted(along), line, label=label, **look)
            named.add(site)
    legend_of_pairs(axes, {"dashed: coast flank": Line2D([], [], color=GREY, linestyle="--")})
    axes.set_ylim(0, None)
    axes.set_ylabel("force in kN")


@picture(largest)
def plot_flank_forces(results: Results) -> Figure:
    """Figure of the force of each pair over the positions, on coast flanks dashed.

    Raises
    ------
    ValueError
        If coast flanks cannot carry load.
    """
    return figure_of(draw_flank_forces, largest(results), "Forces on both flanks")


@picture(all_torques)
def draw_transmission_error_spectrum(axes: Axes, results: Results) -> None:
    """Draw the amplitudes of the transmission error over the mesh orders, a bar per torque.

    If the period has several pitches, the orders between the mesh orders are those of a period.
    The positions cover the period. Marks are at the orders of equal planets without errors.
    """
    results = all_torques(results)
    pitches = results[0].period_pitches
    width = COVERED / (len(results) * pitches)
    for k, (result, colour) in enumerate(zip(results, torque_colours(len(results)), strict=True)):
        order, amplitude = spectrum(result)
        beside = (k - 0.5 * (len(results) - 1)) * width
        label = f"{result.torque_Nm:g} N m"
        axes.bar(order + beside, amplitude, width=width, color=colour, label=label)
    axes.set_xticks(range(1, int(order.max()) + 1))
    axes.set_xlim(min(0.5, order[0] - 0.5 / pitches), order[-1] + 0.5)
    axes.grid(visible=False, axis="x")
    axes.set_xlabel("mesh order (multiple of the tooth mesh frequency)")
    axes.set_ylabel("amplitude in µm")
    last = axes.get_xlim()[1]
    marked = [order for order in results[0].engagement.marked_orders if order <= last]
    if marked:
        at_top = axes.get_xaxis_transform()
        words = "survives without errors"
        axes.plot(marked, [1.0] * len(marked), "v", color=INK, transform=at_top, clip_on=False,
                  label=words)  # fmt: skip
    if len(results) > 1 or marked:
        legend_below(axes, ncols=min(len(results) + bool(marked), 5))


@picture(all_torques)
def plot_transmission_error_spectrum(results: Results) -> Figure:
    """Figure of the amplitudes of the transmission error over the mesh orders, a bar per torque."""
    return figure_of(
        draw_transmission_error_spectrum, results, "Spectrum of the transmission error"
    )


def spectrum(result: Result) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Mesh orders and amplitudes of the transmission error, as far as the positions resolve them.

    Parameters
    ----------
    result : Result

    Returns
    -------
    order, amplitude_um : (n,) arrays
        Empty if the positions do not cover the period.
    """
    pitches = result.period_pitches
    count = min(MOST_ORDERS * pitches, (result.position_rad.size - 1) // 2)
    error = result.transmission_error_um
    found = over_positions(result).harmonics(error, count=count) if count > 0 else None
    known = [amplitude for amplitude in found or () if amplitude is not None]
    return np.arange(1, len(known) + 1) / pitches, np.array(known)


@picture(all_torques)
def draw_stiffness(axes: Axes, results: Results) -> None:
    """Draw the stiffness over the positions, along the line of action and torsional.

    One torque: tangent and secant stiffness; several torques: a curve of the tangent stiffness
    for each.
    """
    results = all_torques(results)
    label_positions(axes, results[0])
    colours = torque_colours(len(results))
    _explain_jumps(axes, results[-1], (0.01, 0.03))
    # N/um times mm² is N m/rad
    factor, label = results[0].reference_radius_mm ** 2 / 1e3, "torsional stiffness in kN m/rad"
    if len(results) == 1:
        _draw_both(axes, results[0], colours[0])
        _add_axis(axes, factor, label)
        return
    axes.set_ylabel("tangent stiffness in N/µm")
    ends = []
    for result, colour in zip(results, colours, strict=True):
        angle, shown = curve(result, result.stiffness_tangent_N_per_um)
        axes.plot(angle, shown, color=colour, **marks(result))
        ends.append(float(shown[-1]))
    axes.margins(y=0.1)
    label_torques(axes, results, ends)
    _add_axis(axes, factor, label, BESIDE_LABELS)


@picture(all_torques)
def plot_stiffness(results: Results) -> Figure:
    """Figure of the stiffness over the positions, along the line of action and torsional."""
    return figure_of(draw_stiffness, results, "Stiffness")


def _draw_both(axes: Axes, result: Result, colour: Any) -> None:
    """Tangent and secant stiffness of one torque, with their means."""
    curves = {
        "tangent": result.stiffness_tangent_N_per_um,
        "secant": result.stiffness_secant_N_per_um,
    }
    for kind, values in curves.items():
        mean = result.summary[f"stiffness_{kind}_mean_N_per_um"]
        label = kind if mean is None else f"{kind}, mean {mean:.1f} N/µm"
        angle, shown = curve(result, values)
        style = "solid" if kind == "tangent" else (0, (5, 2))
        axes.plot(angle, shown, color=colour, label=label, linestyle=style, **marks(result))
    known = np.concatenate([values[np.isfinite(values)] for values in curves.values()])
    top = float(known.max(initial=0.0)) or 1.0
    axes.set_ylim(0, 1.1 * top)
    axes.set_ylabel("stiffness in N/µm")
    legend_below(axes, ncols=2)


def _largest_force(result: Result) -> float:
    return float(result.site_force_N.max())


#: Quantities over the torque: label with unit, and key of the summary or function of a result.
QUANTITIES: dict[str, tuple[str, str | Callable[[Result], float]]] = {
    "transmission_error_peak_to_peak": (
        "transmission error,\npeak to peak in µm",
        "transmission_error_peak_to_peak_um",
    ),
    "transmission_error_mean": ("transmission error,\nmean in µm", "transmission_error_mean_um"),
    "peak_pressure": ("peak pressure off\ncorners in MPa", "peak_pressure_MPa"),
    "stiffness": ("tangent stiffness,\nmean in N/µm", "stiffness_tangent_mean_N_per_um"),
    "tooth_force": ("largest force on\na tooth in N", _largest_force),
}


@picture(all_torques)
def plot_torque_sweep(results: Results, quantity: str | None = None) -> Figure:
    """Figure of transmission error, pressure or force, and stiffness over the torque."""
    results = all_torques(results)
    with panels(results, "Over the torque") as figure:
        if quantity is not None:
            draw_torque_sweep(figure.add_subplot(), results, quantity=quantity)
            return figure
        third = "peak_pressure" if results[0].engagement.has_pressures else "tooth_force"
        names = ("transmission_error_peak_to_peak", "transmission_error_mean", third, "stiffness")
        figure.set_size_inches(SIZE[0], 1.25 * SIZE[1])
        for axes, name in zip(figure.subplots(2, 2).flat, names, strict=True):
            draw_torque_sweep(axes, results, quantity=name)
    return figure


@picture(all_torques)
def draw_torque_sweep(
    axes: Axes, results: Results, *, quantity: str = "transmission_error_peak_to_peak"
) -> None:
    """Draw a key figure over the torque.

    Raises
    ------
    ValueError
        If the quantity is none of `QUANTITIES`.
    """
    results = all_torques(results)
    if quantity not in QUANTITIES:
        expected = ", ".join(QUANTITIES)
        raise ValueError(f"quantity: expected one of {expected}, found {quantity!r}")
    label, key = QUANTITIES[quantity]
    values = [result.summary[key] if isinstance(key, str) else key(result) for result in results]
    torques = np.array([result.torque_Nm for result in results])
    numbers = np.array([np.nan if value is None else value for value in values], dtype=float)
    colours = torque_colours(len(results))
    axes.plot(torques, numbers, color="#9a9a9a", linewidth=1.2, zorder=1)
    axes.scatter(torques, numbers, c=colours, s=34, zorder=2)
    axes.set_xlabel("torque on body 1 in N m")
    axes.set_ylabel(label)
    known = numbers[np.isfinite(numbers)]
    if known.size and known.min() >= 0:
        axes.set_ylim(0, 1.12 * known.max() or 1.0)
    axes.set_xlim(min(0.0, torques.min()), 1.06 * torques.max() or 1.0)
