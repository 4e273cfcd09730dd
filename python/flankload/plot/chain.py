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
    set_title,
)
from flankload.plot.wheel import (
    DARK,
    EDGE,
    directions,
    drawn_wheel,
    number_sites,
    scaled_alike,
)
from flankload.result.chain import ChainDrive

if TYPE_CHECKING:
    from matplotlib.figure import Figure

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
    """
    drive = _drive(result)
    p = int(np.argmax(drive.tight_tension_N)) if position is None else position
    there = np.flatnonzero(np.isfinite(drive.roller_height_um[p]))
    wrap, pitch_mm = drive.wrap_angle_rad, result.pitch_rad * result.reference_radius_mm
    with rc_context(STYLE):
        figure, axes, angles = drawn_wheel(result, p)
        polar = angles[: there.size] + result.rotation_rad[p]
        radius = result.reference_radius_mm + drive.roller_height_um[p, there] / 1000.0
        centers = radius[:, None] * directions(polar)
        strands = np.array([[0.0, -1.0], [-np.sin(wrap), np.cos(wrap)]])
        for end, along in zip(centers[[0, -1]], strands, strict=True):
            axes.plot(*np.column_stack([end, end + 4.0 * pitch_mm * along]), color=DARK, lw=1.2)
        axes.plot(*centers.T, color=DARK, lw=1.2)
        for center in centers:
            axes.fill(*(center + result.drawing.outline_2).T, color=STEEL[1], ec=EDGE, lw=0.8)
        force = result.site_force_N[p, there]
        angle = np.radians(np.nan_to_num(drive.force_angle_deg[p, there]))
        scale = 2.2 * pitch_mm / max(float(force.max()), 1e-300)
        tips = centers + scale * force[:, None] * directions(polar + angle)
        draw_forces(axes, centers[force > 0], tips[force > 0])
        number_sites(axes, result.sites[there], centers * (1 - 1.1 * result.pitch_rad))
        most = int(np.argmax(force))
        x, y = tips[most]
        axes.text(x, y, f"{force[most]:.4g} N", ha="center", va="bottom", color=COLOURS[1])
        scaled_alike(axes)
        second = f"tight {drive.tight_tension_N[p]:.4g} N, slack {drive.slack_tension_N[p]:.4g} N"
        at = f"{degrees(result.position_rad[p]):.4g}°"
        set_title(figure, result, f"Forces on the rollers at {at}")
        axes.set_title(second, fontsize=9, fontweight="normal", color=GREY, loc="left")
        return figure


def plot_tensions(result: Result) -> Figure:
    """Tension of the links around the wrap at some positions.

    Parameters
    ----------
    result : Result
        Result of a chain.
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
        set_title(figure, result, "Tension around the sprocket")
        return figure
