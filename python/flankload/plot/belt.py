"""Plots of a timing belt on its pulley: teeth, tension and lands around the wrap."""

from __future__ import annotations

from math import degrees
from typing import TYPE_CHECKING

import numpy as np
from matplotlib import rc_context

from flankload.plot.figures import empty_figure, fit, heaviest, one_panel, set_title
from flankload.plot.style import (
    FORCE,
    GREY,
    INK,
    SIZE,
    SLATE,
    STEEL,
    STYLE,
    draw_forces,
    turned,
)
from flankload.plot.wheel import (
    DARK,
    DRAWING,
    EDGE,
    directions,
    draw_wheel,
    number_sites,
    scaled_alike,
)
from flankload.result.drives import BeltDrive

if TYPE_CHECKING:
    from collections.abc import Sequence

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


def plot_belt_on_pulley(results: Result | Sequence[Result], position: int | None = None) -> Figure:
    """Pulley, belt and the circumferential forces of its teeth.

    Parameters
    ----------
    results : Result, or sequence of Result
        Of a belt; the one of the largest torque is drawn.
    position : int, optional
        Index of the position; by default the one with the largest tooth force.
    """
    result = heaviest(results)
    p = _shown(result, position)
    title = f"Forces on the teeth of the belt{_at(result, p, ' at ')}"
    return one_panel(draw_belt_on_pulley, result, title, DRAWING, position=p)


def draw_belt_on_pulley(
    axes: Axes, results: Sequence[Result], *, position: int | None = None
) -> None:
    """Draw the pulley, the belt and the circumferential forces of its teeth.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
    results : sequence of Result
        Of a belt; the one of the largest torque is drawn.
    position : int, optional
        Index of the position; by default the one with the largest tooth force.
    """
    result = heaviest(results)
    drive, p = _drive(result), _shown(result, position)
    there = np.flatnonzero(np.isfinite(drive.tension_behind_N[p]))
    radius, wrap = result.reference_radius_mm, drive.wrap_angle_rad
    angles = draw_wheel(axes, result, p)
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


def plot_load_around_wrap(
    results: Result | Sequence[Result], position: int | None = None
) -> Figure:
    """Forces of the teeth, tension of the cord and forces of the lands around the wrap.

    Parameters
    ----------
    results : Result, or sequence of Result
        Of a belt; the one of the largest torque is drawn.
    position : int, optional
        Index of the position; by default the one with the largest tooth force.
    """
    result = heaviest(results)
    p = _shown(result, position)
    wrap = degrees(_drive(result).wrap_angle_rad)
    with rc_context(STYLE):
        figure = empty_figure((SIZE[0], 1.35 * SIZE[1]))
        upper, lower = figure.subplots(2, 1, sharex=True)
        draw_load_around_wrap(upper, (result,), position=p)
        draw_tension_around_wrap(lower, (result,), position=p)
        upper.set_xlabel("")
        set_title(figure, result, f"Around {wrap:.4g}° of wrap{_at(result, p, ', at ')}")
        fit(figure)
        return figure


def draw_load_around_wrap(
    axes: Axes, results: Sequence[Result], *, position: int | None = None
) -> None:
    """Draw the forces of the teeth around the wrap, with their shares.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
    results : sequence of Result
        Of a belt; the one of the largest torque is drawn.
    position : int, optional
        Index of the position; by default the one with the largest tooth force.
    """
    result = heaviest(results)
    p = _shown(result, position)
    axes.bar(result.sites, result.site_force_N[p], width=0.55, color=SLATE)
    for site, force, share in zip(
        result.sites, result.site_force_N[p], result.load_share[p], strict=True
    ):
        if force > 0:
            axes.text(site, force, f"{100 * share:.1f}", ha="center", va="bottom", fontsize=8)
    axes.set_ylabel("force of the tooth in N\n(above the bar: share in %)")
    axes.set_xlabel("tooth, from the tight strand")
    axes.set_xticks(result.sites)


def draw_tension_around_wrap(
    axes: Axes, results: Sequence[Result], *, position: int | None = None
) -> None:
    """Draw the tension of the cord and the forces of the lands around the wrap.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
    results : sequence of Result
        Of a belt; the one of the largest torque is drawn.
    position : int, optional
        Index of the position; by default the one with the largest tooth force.
    """
    result = heaviest(results)
    drive, p = _drive(result), _shown(result, position)
    there = np.isfinite(drive.tension_behind_N[p])
    edges = np.append(result.sites, result.sites[-1] + 1) - 0.5
    tension = np.append(drive.tension_behind_N[p, there], drive.slack_tension_N[p])
    before = np.append(result.sites[there], result.sites[there][-1] + 1) - 0.5
    axes.plot(before, tension, marker="o", ms=3.5, color=INK, label="tension")
    lands, lifting = drive.lands_N[p], drive.lifting[p]
    axes.plot(edges, lands, marker="s", ms=3.5, color=SLATE, label="force of the land")
    if lifting.any():
        axes.plot(edges[lifting], lands[lifting], "x", ms=9, color=FORCE, label="lifts")
    axes.axhline(0.0, color=GREY, lw=0.6)
    axes.set_ylabel("force in N")
    axes.set_xlabel("tooth, from the tight strand")
    axes.set_xticks(result.sites)
    axes.legend(ncols=3)


def plot_force_through_wrap(results: Result | Sequence[Result]) -> Figure:
    """Force of a tooth on its way through the wrap, from all positions."""
    title = "A tooth on its way through the wrap"
    return one_panel(draw_force_through_wrap, heaviest(results), title)


def draw_force_through_wrap(axes: Axes, results: Sequence[Result]) -> None:
    """Draw the force of a tooth on its way through the wrap, from all positions.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
    results : sequence of Result
        Of a belt at several positions; the one of the largest torque is drawn.
    """
    result = heaviest(results)
    drive = _drive(result)
    way = (result.sites + 0.5) + (result.position_rad / result.pitch_rad)[:, None]
    there = np.isfinite(drive.tension_behind_N)
    order = np.argsort(way[there], kind="stable")
    axes.plot(way[there][order], result.site_force_N[there][order], color=INK, lw=1.2)
    axes.plot(way[there], result.site_force_N[there], ".", ms=3.5, color=INK)
    pitches = drive.wrap_angle_rad / result.pitch_rad
    for end in (0.0, pitches):
        axes.axvline(end, color=GREY, lw=0.8, linestyle=(0, (6, 3)))
    axes.set_xlim(-0.4, pitches + 0.4)
    axes.set_ylim(0, None)
    axes.set_xlabel("middle of the tooth behind the tight strand's tangent point, in pitches")
    axes.set_ylabel("force of the tooth in N")


def _at(result: Result, p: int, before: str) -> str:
    """The position, if there are several."""
    several = result.position_rad.size > 1
    return f"{before}{degrees(result.position_rad[p]):.4g}°" if several else ""


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
