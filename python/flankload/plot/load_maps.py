"""Maps of the load: on the pairs over the positions, over the face width, and on the flanks."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.ticker import MaxNLocator

from flankload.plot.figures import BOX, legend_below, note
from flankload.plot.picture import (
    at_largest_line_load,
    figure_of,
    largest,
    panels,
    picture,
)
from flankload.plot.positions import (
    is_closed,
    label_positions,
    label_way,
    pair_curve,
    places_on_way,
)
from flankload.plot.style import BODIES, GREY, SIZE, colour_of, loaded_sites, pair_name
from flankload.result.quantities import plus_minus

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    from flankload.base.arrays import Floats
    from flankload.plot.picture import Results
    from flankload.result import Result
    from flankload.result.pairs import PairTable


#: Points of a contact pattern along a flank.
PATTERN_POINTS = 240
#: Contacts of two positions are parts of one path if they are no further apart, in half-widths.
CONNECTED = 4.0
#: Maps of colours: the larger a value, the darker its colour, in all pictures.
FORCE_MAP, LOAD_MAP, PATTERN_MAP = "viridis_r", "viridis_r", "inferno_r"
#: Height of a text in a panel as part of the height of a flank.
TEXT_HEIGHT = 0.07
#: Up to this number of pairs, each one is a tick.
MOST_TICKS = 12


@picture(largest)
def draw_load_map(axes: Axes, results: Results) -> None:
    """Draw the force of each pair (vertical) at each position (horizontal) as a colour.

    A pair without load is blank.
    """
    result = largest(results)
    columns = [s for s, _ in loaded_sites(result)] or [0]
    rows = range(columns[0], columns[-1] + 1)
    curves = [pair_curve(result, result.site_force_N, s) for s in rows]
    angle, force = curves[0][0], np.array([force for _, force in curves]) / 1e3
    sites = result.sites[rows.start : rows.stop]
    shown = axes.pcolormesh(
        _angle_edges(result, angle),
        np.append(sites - 0.5, sites[-1] + 0.5),
        np.where(force > 0, force, np.nan),
        cmap=FORCE_MAP,
        vmin=0.0,
    )
    label_positions(axes, result)
    axes.grid(visible=False)
    if len(rows) <= MOST_TICKS:
        axes.set_yticks(sites, [f"{site}".replace("-", "−") for site in sites])
    else:
        axes.yaxis.set_major_locator(MaxNLocator(integer=True))
    axes.set_ylabel(result.words_for_sites[0])
    axes.figure.colorbar(shown, ax=axes, label="force in kN", pad=0.02)


@picture(largest)
def plot_load_map(results: Results) -> Figure:
    """Figure of the force of each pair (vertical) at each position (horizontal) as a colour."""
    result = largest(results)
    return figure_of(
        draw_load_map, result, f"Load of the {result.words_for_sites[1]}", size=(SIZE[0], 3.6)
    )


def _angle_edges(result: Result, angle: NDArray[np.float64]) -> NDArray[np.float64]:
    """Boundaries between positions; a gap has no colour of its own."""
    known = np.where(np.isnan(angle), 0.5 * (np.roll(angle, 1) + np.roll(angle, -1)), angle)
    middle = 0.5 * (known[1:] + known[:-1])
    if is_closed(result):
        return np.concatenate([known[:1], middle, known[-1:]])
    half = 0.5 * np.degrees(result.pitch_rad) / max(result.position_rad.size, 1)
    first, last = (middle[0], middle[-1]) if middle.size else (known[0] + half, known[0] - half)
    return np.concatenate([[2 * known[0] - first], middle, [2 * known[-1] - last]])


@picture(at_largest_line_load)
def draw_line_load(axes: Axes, results: Results, *, position: int | None = None) -> None:
    """Draw the line load of a three-dimensional result over the face width, per flank pair."""
    result, p = at_largest_line_load(results, position)
    slices = result.width_loads
    load = slices.mean_line_load_N_per_mm
    ends = _edges(slices.z_mm, slices.width_mm)
    for s, site in loaded_sites(result):
        if not load[p, s].any():
            continue
        force = result.site_force_N[p, s] / 1000.0
        label = f"{pair_name(site)}: {force:.2f} kN, largest {load[p, s].max():.0f} N/mm"
        axes.stairs(
            np.where(load[p, s] > 0, load[p, s], np.nan),
            ends,
            color=colour_of(result, site),
            linewidth=1.8,
            label=label,
        )
    summed = load[p].sum(axis=0)
    if np.count_nonzero(load[p].any(axis=1)) > 1:
        axes.stairs(summed, ends, color=GREY, linewidth=1.0, label="all pairs")
    mean = float(slices.force_N[p].sum() / slices.width_mm.sum())
    dashes, words = (0, (4, 2)), f"mean {mean:.0f} N/mm"
    axes.axhline(mean, color=GREY, linewidth=1.0, linestyle=dashes, label=words)
    length = slices.line_load_length_mm
    title = f"at this position {slices.relative_line_load[p].max():.3f}"
    if result.position_rad.size > 1 and slices.directions is None:
        averaged = np.tensordot(slices.weights, load.sum(axis=1), axes=1)
        words = "all pairs, averaged over the mesh"
        axes.stairs(averaged, ends, color=GREY, linewidth=1.4, linestyle=(0, (1, 1)), label=words)
        factor = f"{slices.face_load_factor:.3f}"
        factor += plus_minus(result.estimate, "face_load_factor", "±")
        title += f", averaged over the mesh {factor} (K_Hβ)"
    axes.set_xlim(ends[0], ends[-1])
    axes.set_ylim(bottom=0.0)
    axes.set_xlabel("axial position z in mm")
    axes.set_ylabel("line load in N/mm")
    legend_below(axes, ncols=2, title=f"largest over mean: {title}; means over {length:.3g} mm")


@picture(at_largest_line_load)
def plot_line_load(results: Results, position: int | None = None) -> Figure:
    """Figure of the line load of a three-dimensional result over the face width, per flank pair."""
    result, p = at_largest_line_load(results, position)
    return figure_of(
        draw_line_load,
        result,
        f"Line load at {np.degrees(result.position_rad[p]):.2f}°",
        position=p,
    )


@picture(largest)
def draw_line_load_map(axes: Axes, results: Results) -> None:
    """Draw the line load of a tooth over its way through the mesh and the face width.

    Pair j is j pitches further along than pair 0: all pairs together are the way of one tooth.
    """
    result = largest(results)
    slices = result.width_loads
    place = places_on_way(result)
    order = np.argsort(place, axis=None, kind="stable")
    along = place.ravel()[order]
    load = slices.mean_line_load_N_per_mm.reshape(-1, slices.z_mm.size)[order]
    axes.grid(visible=False)
    shown = axes.pcolormesh(
        _midpoints(along),
        _edges(slices.z_mm, slices.width_mm),
        np.where(load > 0, load, np.nan).T,
        cmap=LOAD_MAP,
        vmin=0.0,
    )
    label_way(axes, result)
    axes.set_ylabel("axial position z in mm")
    most = f"{load.max():.0f}{plus_minus(result.estimate, 'peak_line_load', '±')}"
    axes.figure.colorbar(shown, ax=axes, label=f"line load in N/mm, up to {most}")


@picture(largest)
def plot_line_load_map(results: Results) -> Figure:
    """Figure of the line load of a tooth over its way through the mesh and the face width."""
    return figure_of(draw_line_load_map, largest(results), "Line load of a tooth")


@picture(largest)
def plot_contact_pattern(results: Results, body: int | None = None) -> Figure:
    """Figure of the largest pressure at each place of both flanks over all positions."""
    result = largest(results)
    with panels(result, "Contact pattern", (SIZE[0], 0.9 * SIZE[1])) as figure:
        bodies = (1, 2) if body is None else (body,)
        most = max(contact_pattern(result, each)[1].max() for each in (1, 2))
        for each, axes in zip(
            bodies, figure.subplots(1, len(bodies), squeeze=False).flat, strict=True
        ):
            key = each == bodies[-1]
            draw_contact_pattern(axes, result, body=each, largest_MPa=most, key=key)
            axes.set_title(f"body {each}", color=BODIES[each - 1])
    return figure


@picture(largest)
def draw_contact_pattern(
    axes: Axes,
    results: Results,
    *,
    body: int = 1,
    largest_MPa: float | None = None,
    key: bool = True,
) -> None:
    """Draw the largest pressure at each place of a flank over all positions, in slices."""
    result = largest(results)
    slices = result.width_loads
    diameter, pressure = contact_pattern(result, body)
    axes.grid(visible=False)
    shown = axes.pcolormesh(
        _edges(slices.z_mm, slices.width_mm),
        _midpoints(diameter),
        np.where(pressure > 0, pressure, np.nan),
        cmap=PATTERN_MAP,
        vmin=0.0,
        vmax=largest_MPa or pressure.max(),
    )
    _mark_profile(axes, result, body)
    axes.set_xlabel("axial position z in mm")
    axes.set_ylabel(f"diameter on body {body} in mm")
    if key:
        axes.figure.colorbar(shown, ax=axes, label="largest pressure in MPa")


def _mark_profile(axes: Axes, result: Result, body: int) -> None:
    """Diameters at which the profile changes, and the whole height of the flank."""
    profile = result.drawing.profiles[body - 1]
    if profile is None:
        return
    names = {
        2.0 * float(np.hypot(profile.base_radius_mm, roll)): name for name, roll in profile.marks
    }
    low, high = min(names), max(names)
    above = np.inf
    for diameter in sorted(names, reverse=True):
        axes.axhline(diameter, color=GREY, linewidth=0.8, linestyle=(0, (4, 2)))
        # below its line if the text would cover the line above it
        under = above - diameter < TEXT_HEIGHT * (high - low)
        look = {"fontsize": 8, "bbox": {**BOX, "alpha": 0.7, "pad": 0.8}}
        text, place = f"{names[diameter]} ⌀ {diameter:.2f}", (0.02, diameter)
        shift, side = (-2, "top") if under else (2, "bottom")
        note(axes, text, place, ("axes fraction", "data"), (0, shift), va=side, **look)
        above = diameter
    axes.set_ylim(low - 0.03 * (high - low), high + 0.06 * (high - low))


def contact_pattern(result: Result, body: int) -> tuple[Floats, Floats]:
    """Largest pressure over all positions on a grid of diameters and slices.

    Parameters
    ----------
    result : Result
        Three-dimensional result.
    body : int
        1 or 2.

    Returns
    -------
    diameter_mm : (n,) array
        By ascending arc length of the flank.
    pressure_MPa : (n, J) array
        Hertz pressure of the lumped contacts, or that of the cells; 0 where there was no contact.
    """
    tables = [table for table in result.pair_tables if len(table)]
    place, half, pressure, z, radius = (
        np.concatenate(parts)
        for parts in zip(*(_rows(result, table, body) for table in tables), strict=True)
    )
    carries = pressure > 0
    place, half, pressure, z, radius = (
        values[carries] for values in (place, half, pressure, z, radius)
    )
    grid = np.linspace((place - half).min(), (place + half).max(), PATTERN_POINTS)
    pattern = np.zeros((grid.size, result.slice_z_mm.size))
    for j, middle in enumerate(result.slice_z_mm):
        rows = np.flatnonzero(z == middle)
        rows = rows[np.argsort(place[rows], kind="stable")]
        inside = 1.0 - ((grid - place[rows, None]) / half[rows, None]) ** 2
        peaks = pressure[rows, None] * np.sqrt(np.maximum(inside, 0.0))
        pattern[:, j] = peaks.max(axis=0, initial=0.0)
        # between two positions the contact moves on: each place has its largest pressure there
        for one, two in pairwise(rows):
            if place[two] - place[one] > CONNECTED * (half[one] + half[two]):
                continue
            inside = (grid >= place[one]) & (grid <= place[two])
            passed = np.interp(grid[inside], place[[one, two]], pressure[[one, two]])
            pattern[inside, j] = np.maximum(pattern[inside, j], passed)
    for table in tables if tables[0].half_width_mm is None else ():
        _add_cells(result, table, body, grid, pattern)
    order = np.argsort(place)
    return 2.0 * np.interp(grid, place[order], radius[order]), pattern


def _rows(result: Result, table: PairTable, body: int) -> tuple[Floats, ...]:
    """Arc length, half-width, pressure, axial position and radius of the places of a position.

    For cells: the place of the largest pressure in each slice of a flank, with half of the loaded
    width.
    """
    assert table.z_mm is not None
    x = table.x_mm - (result.drawing.center_distance_mm if body == 2 else 0.0)
    arc_length = table.arc_length_1_mm if body == 1 else table.arc_length_2_mm
    radius = np.hypot(x, table.y_mm)
    if table.half_width_mm is not None:
        return arc_length, table.half_width_mm, table.pressure_MPa, table.z_mm, radius
    runs = _contacts(table)
    peaks = np.array([run[table.pressure_MPa[run].argmax()] for run in runs], dtype=int)
    width = np.array([table.cell_mm[run][table.force_N[run] > 0].sum() for run in runs])
    return (
        arc_length[peaks],
        np.maximum(0.5 * width, table.cell_mm[peaks]),
        table.pressure_MPa[peaks],
        table.z_mm[peaks],
        radius[peaks],
    )


def _contacts(table: PairTable) -> list[NDArray[np.int64]]:
    """Rows of the cells of each slice of a flank."""
    assert table.z_mm is not None
    begins = (np.diff(table.site) != 0) | (np.diff(table.z_mm) != 0)
    return np.split(np.arange(len(table)), np.flatnonzero(begins) + 1)


def _add_cells(result: Result, table: PairTable, body: int, grid: Floats, pattern: Floats) -> None:
    """Add the pressures of the cells of a position to a contact pattern."""
    assert table.z_mm is not None
    arc_length = table.arc_length_1_mm if body == 1 else table.arc_length_2_mm
    for run in _contacts(table):
        j = int(np.searchsorted(result.slice_z_mm, table.z_mm[run[0]]))
        order = run[np.argsort(arc_length[run])]
        passed = np.interp(grid, arc_length[order], table.pressure_MPa[order], left=0.0, right=0.0)
        pattern[:, j] = np.maximum(pattern[:, j], passed)


def _edges(z_mm: Floats, width_mm: Floats) -> Floats:
    """Ends (J + 1,) of the slices."""
    return np.append(z_mm - 0.5 * width_mm, z_mm[-1] + 0.5 * width_mm[-1])


def _midpoints(values: Floats) -> Floats:
    """Edges (n + 1,) between values (n,)."""
    inner = 0.5 * (values[1:] + values[:-1])
    return np.concatenate([[values[0]], inner, [values[-1]]])
