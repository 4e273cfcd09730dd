"""Plots of a chain on its sprocket: rollers and their forces, tensions around the wrap."""

from __future__ import annotations

from math import degrees
from typing import TYPE_CHECKING

import numpy as np
from matplotlib import rc_context

from flankload.plot.style import (
    COLOURS,
    GREY,
    SIZE,
    STEEL,
    STYLE,
    draw_forces,
    new_figure,
    write_heading,
)
from flankload.result.drive import ChainDrive

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    from flankload.result import Result

#: Number of positions whose tensions are drawn.
N_CURVES = 5


def _drive(result: Result) -> ChainDrive:
    assert isinstance(result.drive, ChainDrive)
    return result.drive


def plot_chain_on_sprocket(result: Result, position: int | None = None) -> Figure:
    """Sprocket, rollers and the forces on these.

    Parameters
    ----------
    result : Result
        Result of a chain.
    position : int, optional
        Index of the position; by default the one with the largest tight tension.

    Returns
    -------
    matplotlib.figure.Figure
    """
    drive, drawing = _drive(result), result.drawing
    p = int(np.argmax(drive.tight_tension_N)) if position is None else position
    pitch = 2 * np.pi / drawing.teeth_1
    there = np.flatnonzero(np.isfinite(drive.roller_height_um[p]))
    radius = result.reference_radius_mm + drive.roller_height_um[p, there] / 1000.0
    polar = drawing.angle_1[p] + pitch * np.arange(there.size) + result.rotation_rad[p]
    centers = radius[:, None] * np.column_stack([np.cos(polar), np.sin(polar)])
    with rc_context(STYLE):
        figure = new_figure((6.4, 6.0))
        axes = figure.add_subplot()
        turns = drawing.angle_1[p] + pitch * np.arange(drawing.teeth_1)
        points = np.vstack([drawing.outline_1 @ _turn(turn).T for turn in turns])
        axes.fill(*points.T, color=STEEL[0], ec="#7a8791", lw=0.8)
        length = 4.0 * float(result.pitch_rad) * result.reference_radius_mm
        wrap = drive.wrap_angle_rad
        strands = np.array([[0.0, -1.0], [-np.sin(wrap), np.cos(wrap)]])
        for end, along in zip(centers[[0, -1]], strands, strict=True):
            axes.plot(*np.column_stack([end, end + length * along]), color="#404040", lw=1.2)
        axes.plot(*centers.T, color="#404040", lw=1.2)
        for center in centers:
            axes.fill(*(center + drawing.outline_2).T, color=STEEL[1], ec="#7a6f57", lw=0.8)
        force = result.site_force_N[p, there]
        angle = np.radians(np.nan_to_num(drive.force_angle_deg[p, there]))
        way = np.column_stack([np.cos(polar + angle), np.sin(polar + angle)])
        scale = 2.2 * pitch * result.reference_radius_mm / max(float(force.max()), 1e-300)
        tips = centers + scale * force[:, None] * way
        draw_forces(axes, centers[force > 0], tips[force > 0])
        for site, center in zip(result.sites[there], centers, strict=True):
            x, y = center * (1 - 1.1 * pitch)
            axes.text(x, y, f"{site}", ha="center", va="center", fontsize=8, color=GREY)
        most = int(np.argmax(force))
        x, y = tips[most]
        axes.text(x, y, f"{force[most]:.4g} N", ha="center", va="bottom", color=COLOURS[1])
        axes.set_aspect("equal")
        axes.margins(0.08)
        axes.autoscale_view()
        axes.set_xlabel("mm")
        axes.grid(visible=False)
        second = f"tight {drive.tight_tension_N[p]:.4g} N, slack {drive.slack_tension_N[p]:.4g} N"
        _title(figure, result, f"Forces on the rollers at {degrees(result.position_rad[p]):.4g}°")
        axes.set_title(second, fontsize=9, fontweight="normal", color=GREY, loc="left")
        return figure


def plot_tensions(result: Result) -> Figure:
    """Tension of the links around the wrap at some positions.

    Parameters
    ----------
    result : Result
        Result of a chain.

    Returns
    -------
    matplotlib.figure.Figure
    """
    drive = _drive(result)
    count = result.position_rad.size
    shown = np.unique(np.linspace(0, count - 1, min(N_CURVES, count)).astype(int))
    with rc_context(STYLE):
        figure = new_figure(SIZE)
        axes = figure.add_subplot()
        for k, p in enumerate(shown):
            there = np.isfinite(drive.tension_behind_N[p])
            tension = np.append(drive.tension_behind_N[p, there], drive.slack_tension_N[p])
            axes.plot(
                np.arange(tension.size),
                tension,
                marker="o",
                markersize=3.5,
                lw=1.4,
                color=COLOURS[k % len(COLOURS)],
                label=f"{degrees(result.position_rad[p]):.4g}°",
            )
        most = float(drive.tight_tension_N.max())
        steps = np.arange(tension.size)
        axes.plot(steps, most * drive.tension_ratio**steps, color=GREY, lw=1, linestyle=(0, (6, 3)))
        axes.text(
            2.2,
            most * drive.tension_ratio**2.2,
            f"  falls by q = {drive.tension_ratio:.3f}\n  (worn chain)",
            fontsize=9,
            color=GREY,
            ha="right",
            va="top",
        )
        axes.set_ylim(0, None)
        axes.set_xlabel("link, from the tight strand (0) to the slack one")
        axes.set_ylabel("tension in N")
        axes.legend(title="position", ncols=2)
        _title(figure, result, "Tension around the sprocket")
        return figure


def _turn(angle: float) -> NDArray[np.float64]:
    cosine, sine = np.cos(angle), np.sin(angle)
    return np.array([[cosine, -sine], [sine, cosine]])


def _title(figure: Figure, result: Result, title: str) -> None:
    write_heading(figure, title, result)
