"""Load over the face width: line load of a position and of a mesh cycle, contact pattern."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from matplotlib import rc_context

from flankload.plot.figures import (
    empty_figure,
    fit,
    heaviest,
    legend_below,
    one_panel,
    set_title,
)
from flankload.plot.style import BODIES, GREY, SIZE, STYLE, colour_of, loaded_sites, pair_name

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    from flankload.result import Result
    from flankload.result.pairs import PairTable

    Floats = NDArray[np.float64]

#: Points of a contact pattern along a flank.
PATTERN_POINTS = 240
#: Contacts of two positions are parts of one path if they are no further apart, in half-widths.
CONNECTED = 4.0
LOAD_MAP = "viridis"
PATTERN_MAP = "inferno_r"


def plot_line_load(results: Result | Sequence[Result]) -> Figure:
    """Line load over the face width at the position of the largest one, per flank pair."""
    result = heaviest(results)
    angle = np.degrees(result.position_rad[_of_largest(result)])
    return one_panel(draw_line_load, result, f"Line load at {angle:.2f}°")


def _of_largest(result: Result) -> int:
    """Position of the largest line load."""
    assert result.slices is not None
    return int(result.slices.line_load_N_per_mm.max(axis=(1, 2)).argmax())


def draw_line_load(axes: Axes, results: Sequence[Result]) -> None:
    """Draw the line load over the face width at the position of the largest one, per flank pair.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
    results : sequence of Result
        The one of the largest torque is drawn; it is three-dimensional.
    """
    result = heaviest(results)
    slices = result.slices
    assert slices is not None
    load, p = slices.line_load_N_per_mm, _of_largest(result)
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
    mean = float(summed @ slices.width_mm / slices.width_mm.sum())
    dashes, words = (0, (4, 2)), f"mean {mean:.0f} N/mm"
    axes.axhline(mean, color=GREY, linewidth=1.0, linestyle=dashes, label=words)
    axes.set_xlim(ends[0], ends[-1])
    axes.set_ylim(bottom=0.0)
    axes.set_xlabel("axial position z in mm")
    axes.set_ylabel("line load in N per mm face width")
    legend_below(
        axes, ncols=2, title=f"face load factor of all positions: {slices.face_load_factor:.3f}"
    )


def plot_line_load_map(results: Result | Sequence[Result]) -> Figure:
    """Line load of a tooth over its way through the mesh and the face width."""
    return one_panel(draw_line_load_map, heaviest(results), "Line load of a tooth")


def draw_line_load_map(axes: Axes, results: Sequence[Result]) -> None:
    """Draw the line load of a tooth over its way through the mesh and the face width.

    Pair j is j pitches further along than pair 0: all pairs together are the way of one tooth.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
    results : sequence of Result
        The one of the largest torque is drawn; it is three-dimensional.
    """
    result = heaviest(results)
    slices = result.slices
    assert slices is not None
    place = result.sites + result.position_rad[:, np.newaxis] / result.pitch_rad
    order = np.argsort(place, axis=None, kind="stable")
    along = place.ravel()[order]
    load = slices.line_load_N_per_mm.reshape(-1, slices.z_mm.size)[order]
    edges = np.concatenate([[along[0]], 0.5 * (along[1:] + along[:-1]), [along[-1]]])
    axes.grid(visible=False)
    shown = axes.pcolormesh(
        edges,
        _edges(slices.z_mm, slices.width_mm),
        np.where(load > 0, load, np.nan).T,
        cmap=LOAD_MAP,
        vmin=0.0,
    )
    loaded = along[load.any(axis=1)]
    if loaded.size:
        axes.set_xlim(loaded.min() - 0.1, loaded.max() + 0.1)
    axes.set_xlabel(
        "place of the tooth in pitches around the axis"
        if result.whole_circle
        else "place of the pair in mesh pitches from the pitch point"
    )
    axes.set_ylabel("axial position z in mm")
    axes.figure.colorbar(shown, ax=axes, label="line load in N per mm face width")


def plot_contact_pattern(results: Result | Sequence[Result], body: int | None = None) -> Figure:
    """Largest pressure at each place of both flanks over all positions.

    Parameters
    ----------
    results : Result, or sequence of Result
        The one of the largest torque is drawn; it is three-dimensional.
    body : int, optional
        1 or 2; by default both, in two panels.
    """
    result = heaviest(results)
    bodies = (1, 2) if body is None else (body,)
    with rc_context(STYLE):
        figure = empty_figure((SIZE[0], 0.9 * SIZE[1]))
        largest = max(contact_pattern(result, each)[1].max() for each in (1, 2))
        for column, each in enumerate(bodies):
            axes = figure.add_subplot(1, len(bodies), column + 1)
            key = each == bodies[-1]
            draw_contact_pattern(axes, (result,), body=each, largest_MPa=largest, key=key)
            axes.set_title(f"body {each}", color=BODIES[each - 1])
        set_title(figure, result, "Contact pattern")
        fit(figure)
        return figure


def draw_contact_pattern(
    axes: Axes,
    results: Sequence[Result],
    *,
    body: int = 1,
    largest_MPa: float | None = None,
    key: bool = True,
) -> None:
    """Draw the largest pressure at each place of a flank over all positions.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
    results : sequence of Result
        The one of the largest torque is drawn; it is three-dimensional.
    body : int
        1 or 2.
    largest_MPa : float, optional
        End of the scale of colours; by default the largest pressure on this body.
    key : bool
        Whether to add the scale of colours.
    """
    result = heaviest(results)
    slices = result.slices
    assert slices is not None
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
    diameters = []
    for name, roll in profile.marks:
        diameter = 2.0 * np.hypot(profile.base_radius_mm, roll)
        diameters.append(diameter)
        axes.axhline(diameter, color=GREY, linewidth=0.8, linestyle=(0, (4, 2)))
        axes.annotate(
            f"{name} ⌀ {diameter:.2f}",
            (0.02, diameter),
            xycoords=("axes fraction", "data"),
            xytext=(0, 2),
            textcoords="offset points",
            fontsize=8,
            color=GREY,
            va="bottom",
            bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.7, "pad": 0.8},
        )
    low, high = min(diameters), max(diameters)
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
    assert result.slices is not None
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
        for row in rows:
            inside = 1.0 - ((grid - place[row]) / half[row]) ** 2
            peak = pressure[row] * np.sqrt(np.maximum(inside, 0.0))
            np.maximum(pattern[:, j], peak, out=pattern[:, j])
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

    Of cells, those of the largest pressure in each slice of a flank, with half of the loaded width.
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
