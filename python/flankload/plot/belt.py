"""Plots of a timing belt on its pulley: teeth, tension and lands around the wrap."""

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
    turned,
)
from flankload.plot.wheel import (
    DARK,
    EDGE,
    directions,
    drawn_wheel,
    number_sites,
    scaled_alike,
)
from flankload.result.belt import BeltDrive

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    from flankload.result import Result

    Floats = NDArray[np.float64]

#: Drawn length of the free strands, in pitches.
STRAND_PITCHES = 3.0


def _drive(result: Result) -> BeltDrive:
    assert isinstance(result.drive, BeltDrive)
    return result.drive


def _shown(result: Result, position: int | None) -> int:
    """The position to draw; by default the one with the largest tooth force."""
    return int(np.argmax(result.site_force_N.max(axis=1))) if position is None else position


def plot_belt_on_pulley(result: Result, position: int | None = None) -> Figure:
    """Pulley, belt and the circumferential forces of its teeth.

    Parameters
    ----------
    result : Result
        Result of a belt.
    position : int, optional
        Index of the position; by default the one with the largest tooth force.
    """
    drive, p = _drive(result), _shown(result, position)
    there = np.flatnonzero(np.isfinite(drive.tension_behind_N[p]))
    radius, wrap = result.reference_radius_mm, drive.wrap_angle_rad
    with rc_context(STYLE):
        figure, axes, angles = drawn_wheel(result, p)
        for angle in angles[there]:
            tooth = turned(result.drawing.outline_2, angle)
            axes.fill(*tooth.T, color=STEEL[1], ec=EDGE, lw=0.6)
        around = radius * directions(np.linspace(0.0, wrap, 200))
        reach = STRAND_PITCHES * result.pitch_rad * radius
        slack = around[-1] + reach * np.array([-np.sin(wrap), np.cos(wrap)])
        cord = np.vstack([[radius, -reach], around, slack])
        axes.plot(*cord.T, color=DARK, lw=1.4)
        _forces(axes, result, angles, there, p)
        for (x, y), tension in zip(
            cord[[0, -1]], (drive.tight_tension_N[p], drive.slack_tension_N[p]), strict=True
        ):
            axes.text(x, y, f" {tension:.4g} N", va="top", fontsize=9)
        scaled_alike(axes)
        at = f" at {degrees(result.position_rad[p]):.4g}°" if result.position_rad.size > 1 else ""
        set_title(figure, result, f"Forces on the teeth of the belt{at}")
        return figure


def plot_load_around_wrap(result: Result, position: int | None = None) -> Figure:
    """Forces of the teeth, tension of the cord and forces of the lands around the wrap.

    Parameters
    ----------
    result : Result
        Result of a belt.
    position : int, optional
        Index of the position; by default the one with the largest tooth force.
    """
    drive, p = _drive(result), _shown(result, position)
    there = np.isfinite(drive.tension_behind_N[p])
    with rc_context(STYLE):
        figure = new_figure((SIZE[0], 1.35 * SIZE[1]))
        upper, lower = figure.subplots(2, 1, sharex=True)
        upper.bar(result.sites, result.site_force_N[p], width=0.55, color=COLOURS[0])
        for site, force, share in zip(
            result.sites, result.site_force_N[p], result.load_share[p], strict=True
        ):
            if force > 0:
                upper.text(site, force, f"{100 * share:.1f}", ha="center", va="bottom", fontsize=8)
        upper.set_ylabel("force of the tooth in N\n(above the bar: share in %)")
        edges = np.append(result.sites, result.sites[-1] + 1) - 0.5
        tension = np.append(drive.tension_behind_N[p, there], drive.slack_tension_N[p])
        before = np.append(result.sites[there], result.sites[there][-1] + 1) - 0.5
        lower.plot(before, tension, marker="o", ms=3.5, color=COLOURS[1], label="tension")
        lands, lifting = drive.lands_N[p], drive.lifting[p]
        lower.plot(edges, lands, marker="s", ms=3.5, color=COLOURS[2], label="force of the land")
        if lifting.any():
            lower.plot(edges[lifting], lands[lifting], "x", ms=9, color=COLOURS[3], label="lifts")
        lower.axhline(0.0, color=GREY, lw=0.6)
        lower.set_ylabel("N")
        lower.set_xlabel("tooth, from the tight strand")
        lower.set_xticks(result.sites)
        lower.legend(ncols=3)
        at = f", at {degrees(result.position_rad[p]):.4g}°" if result.position_rad.size > 1 else ""
        set_title(figure, result, f"Around {degrees(drive.wrap_angle_rad):.4g}° of wrap{at}")
        return figure


def plot_force_through_wrap(result: Result) -> Figure:
    """Force of a tooth on its way through the wrap, from all positions.

    Parameters
    ----------
    result : Result
        Result of a belt at several positions.
    """
    drive = _drive(result)
    with rc_context(STYLE):
        figure = new_figure(SIZE)
        axes = figure.add_subplot()
        way = (result.sites + 0.5) + (result.position_rad / result.pitch_rad)[:, None]
        there = np.isfinite(drive.tension_behind_N)
        order = np.argsort(way[there], kind="stable")
        axes.plot(way[there][order], result.site_force_N[there][order], color=COLOURS[0], lw=1.2)
        axes.plot(way[there], result.site_force_N[there], ".", ms=3.5, color=COLOURS[0])
        pitches = drive.wrap_angle_rad / result.pitch_rad
        for end in (0.0, pitches):
            axes.axvline(end, color=GREY, lw=0.8, linestyle=(0, (6, 3)))
        axes.set_xlim(-0.4, pitches + 0.4)
        axes.set_ylim(0, None)
        axes.set_xlabel("middle of the tooth behind the tight strand's tangent point, in pitches")
        axes.set_ylabel("force of the tooth in N")
        set_title(figure, result, "A tooth on its way through the wrap")
        return figure


def _forces(axes: Axes, result: Result, angles: Floats, there: NDArray[np.intp], p: int) -> None:
    """An arrow in the circumferential direction for each loaded tooth."""
    force, radius = result.site_force_N[p, there], result.reference_radius_mm
    angles, most = angles[there], float(force.max())
    if most <= 0.0:
        return
    at = (1.0 + 0.35 * result.pitch_rad) * radius * directions(angles)
    size = 2.0 * result.pitch_rad * radius * (force / most)[:, None]
    tips = at + size * directions(angles + 0.5 * np.pi)
    draw_forces(axes, at[force > 0], tips[force > 0])
    number_sites(axes, result.sites[there], np.where(force[:, None] > 0, 1.12, 1.06) * at)
