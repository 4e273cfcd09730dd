"""Plots of a chain on its sprocket: rollers and their forces, tensions around the wrap."""

from __future__ import annotations

from math import degrees
from typing import TYPE_CHECKING

import numpy as np
from matplotlib import rc_context

from flankload.plot.figures import empty_figure, fit, heaviest, one_panel, set_title
from flankload.plot.style import FORCE, GREY, STEEL, STYLE, draw_forces
from flankload.plot.wheel import (
    DARK,
    DRAWING,
    EDGE,
    directions,
    draw_wheel,
    number_sites,
    scaled_alike,
)
from flankload.result.drives import ChainDrive

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from flankload.result import Result

#: Number of positions whose tensions are drawn.
N_CURVES = 5


def _drive(result: Result) -> ChainDrive:
    assert isinstance(result.drive, ChainDrive)
    return result.drive


def _shown(result: Result, position: int | None) -> int:
    """The position to draw; by default the one with the largest tight tension."""
    return int(np.argmax(_drive(result).tight_tension_N)) if position is None else position


def plot_chain_on_sprocket(
    results: Result | Sequence[Result], position: int | None = None
) -> Figure:
    """Sprocket, rollers and the forces on these.

    Parameters
    ----------
    results : Result, or sequence of Result
        Of a chain; the one of the largest torque is drawn.
    position : int, optional
        Index of the position; by default the one with the largest tight tension.
    """
    result = heaviest(results)
    drive, p = _drive(result), _shown(result, position)
    with rc_context(STYLE):
        figure = empty_figure(DRAWING)
        axes = figure.add_subplot()
        draw_chain_on_sprocket(axes, (result,), position=p)
        second = f"tight {drive.tight_tension_N[p]:.4g} N, slack {drive.slack_tension_N[p]:.4g} N"
        at = f"{degrees(result.position_rad[p]):.4g}°"
        set_title(figure, result, f"Forces on the rollers at {at}")
        axes.set_title(second, fontsize=9, fontweight="normal", color=GREY, loc="left")
        fit(figure)
        return figure


def draw_chain_on_sprocket(
    axes: Axes, results: Sequence[Result], *, position: int | None = None
) -> None:
    """Draw the sprocket, the rollers and the forces on these.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
    results : sequence of Result
        Of a chain; the one of the largest torque is drawn.
    position : int, optional
        Index of the position; by default the one with the largest tight tension.
    """
    result = heaviest(results)
    drive, p = _drive(result), _shown(result, position)
    there = np.flatnonzero(np.isfinite(drive.roller_height_um[p]))
    wrap, pitch_mm = drive.wrap_angle_rad, result.pitch_rad * result.reference_radius_mm
    angles = draw_wheel(axes, result, p)
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
    axes.text(x, y, f"{force[most]:.4g} N", ha="center", va="bottom", color=FORCE)
    scaled_alike(axes)


def plot_tensions(results: Result | Sequence[Result]) -> Figure:
    """Tension of the links around the wrap at some positions."""
    return one_panel(draw_tensions, heaviest(results), "Tension around the sprocket")


def draw_tensions(axes: Axes, results: Sequence[Result]) -> None:
    """Draw the tension of the links around the wrap at some positions.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
    results : sequence of Result
        Of a chain; the one of the largest torque is drawn.
    """
    result = heaviest(results)
    drive = _drive(result)
    count = result.position_rad.size
    shown = np.unique(np.linspace(0, count - 1, min(N_CURVES, count)).astype(int))
    greys = np.linspace(0.70, 0.10, shown.size) if shown.size > 1 else [0.10]
    for grey, p in zip(greys, shown, strict=True):
        there = np.isfinite(drive.tension_behind_N[p])
        tension = np.append(drive.tension_behind_N[p, there], drive.slack_tension_N[p])
        axes.plot(
            np.arange(tension.size),
            tension,
            marker="o",
            markersize=3.5,
            lw=1.4,
            color=f"{grey:.3f}",
            label=f"{degrees(result.position_rad[p]):.4g}°",
        )
    most = float(drive.tight_tension_N.max())
    steps = np.arange(tension.size)
    dashes, words = (0, (6, 3)), f"falls by q = {drive.tension_ratio:.3f} (worn chain)"
    worn = most * drive.tension_ratio**steps
    axes.plot(steps, worn, color=FORCE, lw=1, linestyle=dashes, label=words)
    axes.set_ylim(0, None)
    axes.set_xlabel("link, from the tight strand (0) to the slack one")
    axes.set_ylabel("tension in N")
    axes.legend(title="position")
