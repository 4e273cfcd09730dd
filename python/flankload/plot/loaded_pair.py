"""The loaded pair at one position: teeth in mesh, pressure on the flanks, forces."""

from __future__ import annotations

from dataclasses import dataclass
from math import degrees
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.patches import PathPatch, Polygon
from matplotlib.path import Path

from flankload.base.rotation import all_around
from flankload.plot.loaded_pair_3d import draw_loaded_bodies
from flankload.plot.picture import at, of_largest_line_load, panels, picture
from flankload.plot.style import (
    INK,
    SLATE,
    STEEL,
    at_corner,
    coast_sites,
    colour_of,
    loaded_sites,
    pair_name,
)

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    from flankload.base.arrays import Floats
    from flankload.plot.picture import Results
    from flankload.result import PairTable, Result


#: Points of the pressure curve of a lumped contact.
HERTZ_POINTS = 41


def _representative(result: Result) -> int:
    """Position of most pairs, most even sharing, largest pressure (3D: largest line load)."""
    return view_of(result).representative(result)


def _of_most_pairs(result: Result) -> int:
    """Position of most pairs, most even sharing, largest pressure."""
    share, pressure = result.load_share.max(axis=1), result.peak_pressure_MPa.max(axis=1)
    # off corners if possible
    order = np.lexsort((-pressure, share, at_corner(result), -result.loaded_pairs))
    return int(order[0])


_at_representative = at(_representative)


@picture(_at_representative)
def plot_loaded_pair(
    results: Results, position: int | None = None, body: int | None = None
) -> Figure:
    """Figure of the teeth in mesh at one position with pressures on the flanks, and each pressure.

    Three-dimensional bodies are drawn over their face width, with the line load on their flanks.
    """
    result, p = _at_representative(results, position)
    title = f"Loaded pair at {degrees(result.position_rad[p]):.4g}°"
    with panels(result, title, (7.2, 4.8)) as figure:
        view_of(result).plot(figure, result, p, body)
    return figure


@picture(_at_representative)
def draw_loaded_pair(
    axes: Axes, results: Results, *, position: int | None = None, body: int | None = None
) -> None:
    """Draw the teeth in mesh at one position with pressures on the flanks, forces on a spline.

    Three-dimensional bodies: the teeth of both, or of one, over their face width, with the line
    load on their flanks; of splines a section as in the plane.
    """
    result, p = _at_representative(results, position)
    view_of(result).draw(axes, result, p, body)


def _plot_over_width(figure: Figure, result: Result, p: int, body: int | None) -> None:
    """The teeth over their face width."""
    figure.set_size_inches(7.2, 4.4)
    figure.subplots_adjust(left=0.01, right=0.99, top=0.92, bottom=0.1)
    _draw_over_width(figure.add_subplot(), result, p, body)


def _draw_over_width(axes: Axes, result: Result, p: int, body: int | None) -> None:
    """The teeth of both bodies, or of one, with the line load on their flanks."""
    draw_loaded_bodies(axes, result, p, (1, 2) if body is None else (body,))


def _plot_in_section(figure: Figure, result: Result, p: int, body: int | None) -> None:
    """The teeth in a section, and the pressure of each pair if the drawing has pressures."""
    carrying = _carrying(result, p)
    if not (carrying and result.engagement.draws_pressures):
        if result.engagement.draws_whole_bodies:
            figure.set_size_inches(6.2, 6.4)
        _draw_in_section(figure.add_subplot(), result, p, body)
        return
    grid = figure.add_gridspec(len(carrying), 2, width_ratios=(1.55, 1.0))
    _draw_in_section(figure.add_subplot(grid[:, 0]), result, p, body)
    # The panels have the same vertical order as the pairs in the drawing, and the same axes, so
    # that widths and heights can be compared.
    curves = [_pressure_along(result, p, site) for _, site in carrying]
    reach = max((1.6 * float(np.abs(x[y > 0]).max()) for x, y in curves), default=0.0)
    upwards = carrying if not result.drawing.is_around else carrying[::-1]
    for row, (s, site) in enumerate(reversed(upwards)):
        axes = figure.add_subplot(grid[row, 1])
        _draw_pressure(axes, result, p, s, site, reach)
        if row < len(carrying) - 1:
            axes.set_xlabel("")
            axes.tick_params(labelbottom=False)


def _draw_in_section(axes: Axes, result: Result, p: int, _: int | None) -> None:
    """Both bodies in a section, with pressures on the flanks or forces."""
    _draw_bodies(axes, result, p)
    draw = _draw_pressures if result.engagement.draws_pressures else _draw_forces
    draw(axes, result, p)


@dataclass(frozen=True)
class View:
    """How the teeth in mesh are drawn: bodies with a drawing of their own, position by default.

    `plot` fills a figure and `draw` axes with a result at a position, with both bodies or one.
    """

    one_by_one: tuple[int, ...]
    representative: Callable[[Result], int]
    plot: Callable[[Figure, Result, int, int | None], None]
    draw: Callable[[Axes, Result, int, int | None], None]


OVER_WIDTH = View((1, 2), of_largest_line_load, _plot_over_width, _draw_over_width)
IN_SECTION = View((), _of_most_pairs, _plot_in_section, _draw_in_section)


def view_of(result: Result) -> View:
    """How the teeth of a result are drawn; whole bodies in a section even if they have a width."""
    if result.slices is None or result.engagement.draws_whole_bodies:
        return IN_SECTION
    return OVER_WIDTH


def _carrying(result: Result, p: int) -> list[tuple[int, int]]:
    """(Column, number) of the pairs that carry load at a position."""
    table = result.pairs(p)
    return [
        (s, site)
        for s, site in loaded_sites(result)
        if result.site_force_N[p, s] > 0 and (table.site == site).any()
    ]


def _loaded_flanks(result: Result, p: int) -> Iterator[tuple[PairTable, int, float, bool]]:
    """Table, number and force of the flanks that carry; whether they are coast flanks."""
    for s, site in _carrying(result, p):
        yield result.pairs(p), site, result.site_force_N[p, s], False
    if result.coast is not None:
        for s, site in coast_sites(result):
            if result.coast.force_N[p, s] > 0:
                yield result.coast.pair_tables[p], site, result.coast.force_N[p, s], True


def _draw_forces(axes: Axes, result: Result, p: int) -> None:
    """A bar for the force on each flank that carries."""
    flanks = list(_loaded_flanks(result, p))
    largest = max((force for _, _, force, _ in flanks), default=0.0)
    part = 0.08 if result.coast is None else 0.05  # less space between two flanks
    for table, site, force, on_coast in flanks:
        colour = SLATE if on_coast else INK
        _draw_force_on_flank(axes, table, site, force / largest, colour, part)


def _draw_pressures(axes: Axes, result: Result, p: int) -> None:
    """The pressure on each flank that carries."""
    for table, site, force, on_coast in _loaded_flanks(result, p):
        label = f"{'coast ' * on_coast}{force / 1e3:.2f} kN"
        _draw_pressure_on_flank(axes, result, p, table, site, label)


def _draw_bodies(axes: Axes, result: Result, p: int) -> None:
    drawing = result.drawing
    low, high = _window(result, p)
    axes.set_xlim(low[0], high[0])
    axes.set_ylim(low[1], high[1])
    axes.set_aspect("equal")
    axes.grid(visible=False)
    for side in ("top", "right"):
        axes.spines[side].set_visible(True)
    axes.set_xlabel("x in mm, from the axis of body 1")
    axes.set_ylabel("y in mm")
    bodies = (
        (drawing.outline_1, drawing.teeth_1, drawing.angle_1[p], 0.0),
        (drawing.outline_2, drawing.teeth_2, drawing.angle_2[p], drawing.center_distance_mm),
    )
    rims = (drawing.bore_radius_1_mm, drawing.bore_radius_2_mm)
    for z, (outline, teeth, angle, centre) in enumerate(bodies):
        shape = [all_around(outline, teeth, angle)]
        if rims[z]:
            turn = np.linspace(0.0, -2 * np.pi, 721)  # clockwise: one of both is a hole
            shape.append(rims[z] * np.stack([np.cos(turn), np.sin(turn)], axis=1))
        # not `add_patch`, which needs the time of a whole picture for limits that are known
        axes.add_artist(
            PathPatch(
                Path.make_compound_path(
                    *(Path(part + np.array([centre, 0.0]), closed=True) for part in shape)
                ),
                facecolor=STEEL[z],
                edgecolor="#404040",
                linewidth=0.9,
            )
        )
        same_way = z == 0 or drawing.is_around or drawing.cam_turns_clockwise is False
        text = f"body {z + 1} {'↺' if same_way else '↻'}"
        look: dict[str, Any] = {"fontweight": "bold", "color": "#404040"}
        if z == 0 and drawing.is_around and result.engagement.draws_whole_bodies:
            root = float(np.hypot(*outline.T).min())
            middle = -0.5 * (root + (rims[z] or 0.0))
            axes.text(centre, middle, text, ha="center", va="center", **look)
            continue
        at_left = (z == 0) != drawing.is_around
        place, ha = (0.03, "left") if at_left else (0.97, "right")
        axes.text(place, 0.03, text, transform=axes.transAxes, ha=ha, **look)


def _window(result: Result, p: int) -> tuple[Floats, Floats]:
    """Corners of the drawing: all contacts of the position with a margin of about a tooth.

    For whole bodies, both of them with space for their names below.
    """
    drawing = result.drawing
    if result.engagement.draws_whole_bodies:
        low, high = drawing.extent_mm([p])
        room = 0.05 * float((high - low).max())
        return low - np.array([room, 2 * room]), high + room
    tip_1 = float(np.max(np.hypot(*drawing.outline_1.T)))
    radii_2 = np.hypot(*drawing.outline_2.T)
    # the teeth meet between the axes, or, for an internal gear, beyond the axis of body 1
    side, tip_2 = (-1.0, radii_2.min()) if drawing.is_around else (1.0, radii_2.max())
    pitch = 2 * np.pi * tip_1 / drawing.teeth_1
    middle = np.array([(side * tip_1 + drawing.center_distance_mm - tip_2) / 2, 0.0])
    table = result.pairs(p)
    places = table.point_mm[table.force_N > 0]
    reach = float(np.abs(places[:, 1]).max()) if len(places) else 0.0
    half = np.array([1.15, 1.25]) * max(pitch, reach + 0.35 * pitch)
    return middle - half, middle + half


def _rows_of_pair(table: PairTable, site: int) -> NDArray[np.int64]:
    """Rows of one flank pair in the table of a position, from root to tip of body 1."""
    rows = np.flatnonzero(table.site == site)
    return np.asarray(rows[np.argsort(table.arc_length_1_mm[rows], kind="stable")])


def _draw_force_on_flank(
    axes: Axes, table: PairTable, site: int, force: float, colour: str, part: float
) -> None:
    """A force relative to the largest, as a bar on the part of the flank in contact."""
    rows = _rows_of_pair(table, site)
    rows = rows[table.force_N[rows] > 0]
    place = table.point_mm[rows]
    normal = table.normal[rows]
    low, high = axes.get_ylim()
    height = part * (high - low) * force
    bar = np.vstack([place, (place + normal * height)[::-1]])
    axes.add_patch(Polygon(bar, closed=True, facecolor=colour, edgecolor=colour))


def _draw_pressure_on_flank(
    axes: Axes, result: Result, p: int, table: PairTable, site: int, force: str
) -> None:
    """The pressure as a filled area along the normals of the flank, with a label of the force."""
    _, place, normal, pressure = _profile(table, site)
    low, high = axes.get_ylim()
    largest = float(np.max(result.pairs(p).pressure_MPa, initial=0.0))
    if result.coast is not None:
        on_coast = result.coast.pair_tables[p].pressure_MPa
        largest = max(largest, float(np.max(on_coast, initial=0.0)))
    height = 0.2 * (high - low) * pressure / largest
    profile = np.vstack([place, (place + normal * height[:, None])[::-1]])
    colour = colour_of(result, site)
    axes.add_patch(
        Polygon(profile, closed=True, facecolor=colour, edgecolor=colour, linewidth=1.0, alpha=0.9)
    )
    peak = int(np.argmax(height))
    end = place[peak] + normal[peak] * height[peak]
    axes.annotate(
        f"{pair_name(site)}\n{force}",
        xy=end,
        xytext=(0.97, float(end[1])),
        textcoords=("axes fraction", "data"),
        color=colour,
        fontweight="bold",
        ha="right",
        va="center",
        bbox={"boxstyle": "round,pad=0.25", "facecolor": "white", "edgecolor": colour},
        arrowprops={"arrowstyle": "-", "color": colour, "linewidth": 0.8},
    )


def _profile(table: PairTable, site: int) -> tuple[Floats, ...]:
    """Arc length on flank 1, place, normal and pressure along one pair.

    The pressure of a lumped contact is the Hertz pressure over its width.
    """
    rows = _rows_of_pair(table, site)
    along, pressure = table.arc_length_1_mm[rows], table.pressure_MPa[rows]
    place = table.point_mm[rows]
    normal = table.normal[rows]
    if table.half_width_mm is None:
        return along, place, normal, pressure
    angle = np.linspace(0.0, np.pi, HERTZ_POINTS)
    aside = -np.outer(table.half_width_mm[rows], np.cos(angle))
    # from root to tip, in the order of increasing arc length
    tangent = np.column_stack([normal[:, 1], -normal[:, 0]])
    return (
        (along[:, None] + aside).ravel(),
        (place[:, None, :] + aside[..., None] * tangent[:, None, :]).reshape(-1, 2),
        np.repeat(normal, HERTZ_POINTS, axis=0),
        np.outer(pressure, np.sin(angle)).ravel(),
    )


def _pressure_along(result: Result, p: int, site: int) -> tuple[Floats, Floats]:
    """Arc length on flank 1 from the centre of force, mm, and pressure of one pair."""
    along, _, _, pressure = _profile(result.pairs(p), site)
    return along - float((along * pressure).sum() / pressure.sum()), pressure


def _draw_pressure(axes: Axes, result: Result, p: int, s: int, site: int, reach: float) -> None:
    """The pressure of one pair along its flank, at its true width."""
    table = result.pairs(p)
    along, pressure = _pressure_along(result, p, site)
    colour = colour_of(result, site)
    axes.fill_between(
        along,
        pressure,
        facecolor=f"{colour}22",
        edgecolor=colour,
        hatch="||||",
        linewidth=0,
    )
    axes.plot(along, pressure, color=colour)
    axes.set_xlim(-reach, reach)
    axes.set_ylim(0, 1.12 * float(table.pressure_MPa.max()))
    corner = result.corner_contact[p, s]
    axes.set_title(
        f"{pair_name(site)}: {result.site_force_N[p, s] / 1e3:.2f} kN, "
        + ("on a sharp corner" if corner else f"{result.peak_pressure_MPa[p, s]:.0f} MPa"),
        fontsize=10,
        color=colour,
    )
    axes.set_ylabel("pressure in MPa")
    axes.set_xlabel("along flank 1 in mm (outwards →)")
