"""Plots of bodies with contact all around: load per tooth, pressure along the flank."""

from __future__ import annotations

from math import degrees
from typing import TYPE_CHECKING, Any

import numpy as np

from flankload.plot.figures import note
from flankload.plot.picture import at_largest_force, figure_of, picture
from flankload.plot.style import FORCE, GREY, INK, PALE, SLATE

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    from flankload.plot.picture import Results
    from flankload.result import Result

    Floats = NDArray[np.float64]


def _where(result: Result, p: int) -> str:
    if result.position_rad.size == 1 and result.position_rad[p] == 0:
        return ""
    return f" at {degrees(result.position_rad[p]):.4g}°"


def _beside_mean(result: Result, p: int) -> str:
    force = result.site_force_N[p] / 1e3
    mean = float(force.mean())
    coast = "" if result.coast is None else "; coast flanks pale"
    largest = force.max() / mean if mean else 0
    return f"mean {mean:.3g} kN (line), largest {largest:.2f} times that{coast}"


@picture(at_largest_force)
def draw_load_per_tooth(axes: Axes, results: Results, *, position: int | None = None) -> None:
    """Draw the force on each tooth: around the axis on polar Axes, else over the tooth number."""
    result, p = at_largest_force(results, position)
    force = result.site_force_N[p] / 1e3
    coast = None if result.coast is None else result.coast.force_N[p] / 1e3
    if axes.name == "polar":
        _draw_around(axes, result, p, force, coast)
        return
    _draw_bars(axes, 1.0 * result.sites, force, coast, 0.0, 1.0)
    axes.axhline(float(force.mean()), color=FORCE, linewidth=1.2)
    axes.set_xlabel("tooth")
    axes.set_ylabel("force in kN")


@picture(at_largest_force)
def plot_load_per_tooth(results: Results, position: int | None = None) -> Figure:
    """Figure of the force on each tooth, around the axis."""
    result, p = at_largest_force(results, position)
    return figure_of(
        draw_load_per_tooth,
        result,
        f"Load per tooth{_where(result, p)}",
        second=_beside_mean(result, p),
        pad=24.0,
        size=(6.2, 5.6),
        projection="polar",
        position=p,
    )


def _draw_around(axes: Axes, result: Result, p: int, force: Floats, coast: Floats | None) -> None:
    teeth = result.sites.size
    angle = 2 * np.pi * result.sites / teeth + result.drawing.angle_1[p]
    largest = max(float(force.max()), 0.0 if coast is None else float(coast.max())) or 1.0
    # From a ring, not from a point: near the axis bars would have no width.
    bottom = 0.45 * largest
    _draw_bars(axes, angle, force, coast, bottom, 2 * np.pi / teeth)
    axes.set_ylim(0, bottom + 1.05 * largest)
    turn = np.linspace(0, 2 * np.pi, 361)
    mean = bottom + float(force.mean())
    axes.plot(turn, np.full(turn.size, mean), color=FORCE, linewidth=1.2)
    axes.plot(turn, np.full(turn.size, bottom), color="#404040", linewidth=0.8)
    carrying = f"{result.loaded_pairs[p]} of {teeth}\nteeth carry load"
    axes.text(0.0, 0.0, carrying, ha="center", va="center", fontsize=9, color=GREY)
    step = max(1, round(teeth / 24))
    axes.set_xticks(angle[::step], [f"{site}" for site in result.sites[::step]])
    ticks = _round_steps(largest)
    axes.set_yticks(bottom + ticks, [f"{value:g} kN" if value else "" for value in ticks])
    axes.tick_params(axis="y", labelsize=8, colors=GREY)
    # The labels are placed where they cover least.
    around = force + np.roll(force, 1) + np.roll(force, -1)
    axes.set_rlabel_position(  # type: ignore[attr-defined]
        degrees(angle[int(np.argmin(around))])
    )
    for label in axes.get_yticklabels():
        label.set_zorder(5)


def _draw_bars(
    axes: Axes,
    place: NDArray[Any],
    force: Floats,
    coast: Floats | None,
    bottom: float,
    pitch: float,
) -> None:
    parts = [(force, SLATE, 0.0)]
    if coast is not None:
        parts = [(force, SLATE, 0.25), (coast, PALE, -0.25)]
    for height, colour, beside in parts:
        axes.bar(
            place + 0.8 * beside * pitch,
            height,
            width=0.8 * pitch / len(parts),
            bottom=bottom,
            color=colour,
            edgecolor="white",
            linewidth=0.5,
        )


def _most_of_all(result: Result, p: int) -> str:
    s = int(np.argmax(result.site_force_N[p]))
    corner = "; peaks on a sharp corner, not meaningful" if result.corner_contact[p, s] else ""
    return f"{result.site_force_N[p, s] / 1e3:.2f} kN, the most of all teeth{corner}"


@picture(at_largest_force)
def draw_flank_pressure(axes: Axes, results: Results, *, position: int | None = None) -> None:
    """Draw the pressure over the height of the flank of the tooth with the largest force."""
    result, p = at_largest_force(results, position)
    s = int(np.argmax(result.site_force_N[p]))
    table = result.pairs(p)
    rows = np.flatnonzero(table.site == result.sites[s])
    rows = rows[np.argsort(table.arc_length_1_mm[rows], kind="stable")]
    if rows.size:
        # each cell at its width: cells are fine near the edges
        half, along = 0.5 * table.cell_mm[rows], table.arc_length_1_mm[rows]
        radius = np.interp(
            np.append(along - half, along[-1] + half[-1]), along, table.radius_mm[rows]
        )
        axes.stairs(table.pressure_MPa[rows], radius, fill=True, color=SLATE, alpha=0.2)
        axes.plot(table.radius_mm[rows], table.pressure_MPa[rows], color=INK)
        length = float(table.cell_mm[rows][table.force_N[rows] > 0].sum())
        mean = result.site_force_N[p, s] / (length * result.face_width_mm) if length else 0.0
        axes.axhline(mean, color=GREY, linewidth=1, linestyle=(0, (6, 3)))
        text, coords = f"mean {mean:.0f} MPa (dashed)", ("axes fraction", "data")
        note(axes, text, (0.5, mean), coords, ha="center", va="bottom")
    axes.set_ylim(0, None)
    axes.set_xlabel("distance from the axis of body 1 in mm (tip of body 1 →)")
    axes.set_ylabel("pressure in MPa")


@picture(at_largest_force)
def plot_flank_pressure(results: Results, position: int | None = None) -> Figure:
    """Figure of the pressure over the height of the flank of the tooth with the largest force."""
    result, p = at_largest_force(results, position)
    tooth = result.sites[np.argmax(result.site_force_N[p])]
    title = f"Pressure on tooth {tooth}{_where(result, p)}"
    return figure_of(draw_flank_pressure, result, title, second=_most_of_all(result, p), position=p)


def _round_steps(largest: float) -> NDArray[np.float64]:
    """0 and two or more round values up to the largest."""
    power = 10.0 ** np.floor(np.log10(largest))
    step = next(part * power for part in (0.5, 0.2, 0.1) if largest >= 2 * part * power)
    step *= max(1, round(largest / step / 4))
    return np.arange(0.0, largest * 1.0001, step)
