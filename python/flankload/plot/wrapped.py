"""Plots of belts and chains on their wheels: teeth, rollers, forces, tension around the wrap."""

from __future__ import annotations

from math import degrees
from typing import TYPE_CHECKING, Any

import numpy as np

from flankload.base.rotation import all_around, directions, turned
from flankload.plot.picture import at, at_largest_force, figure_of, largest, panels, picture
from flankload.plot.style import FORCE, GREY, INK, SIZE, SLATE, STEEL
from flankload.result.drives import BeltDrive, ChainDrive

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    from flankload.base.arrays import Floats
    from flankload.plot.picture import Results
    from flankload.result import Result


#: Size of a drawing, inches.
DRAWING = (6.4, 6.0)
#: Colours of strands, and of the edges of body 2.
DARK, EDGE = "#404040", "#7a6f57"
#: Drawn length of the free strands, in pitches.
BELT_STRAND, CHAIN_STRAND = 3.0, 4.0
#: Number of positions whose tensions are drawn.
N_CURVES = 5
TOOTH = "tooth, from the tight strand"


def _belt(result: Result) -> BeltDrive:
    assert isinstance(result.drive, BeltDrive)
    return result.drive


def _chain(result: Result) -> ChainDrive:
    assert isinstance(result.drive, ChainDrive)
    return result.drive


def _of_largest_tension(result: Result) -> int:
    """Position of the largest tension of the tight strand."""
    return int(np.argmax(_chain(result).tight_tension_N))


_at_largest_tension = at(_of_largest_tension)


def _at(result: Result, p: int, before: str) -> str:
    """The position, if there are several."""
    several = result.position_rad.size > 1
    return f"{before}{degrees(result.position_rad[p]):.4g}°" if several else ""


@picture(at_largest_force)
def draw_belt_on_pulley(axes: Axes, results: Results, *, position: int | None = None) -> None:
    """Draw the pulley, the belt and the circumferential forces of its teeth."""
    result, p = at_largest_force(results, position)
    drive = _belt(result)
    there = np.flatnonzero(np.isfinite(drive.tension_behind_N[p]))
    radius, wrap = result.reference_radius_mm, drive.wrap_angle_rad
    angles = _draw_wheel(axes, result, p)[there]
    for angle in angles:
        tooth = turned(result.drawing.outline_2, angle)
        axes.fill(*tooth.T, color=STEEL[1], ec=EDGE, lw=0.6)
    around = radius * directions(np.linspace(0.0, wrap, 200))
    pitch_mm = result.pitch_rad * radius
    reach = BELT_STRAND * pitch_mm * _strands(wrap)
    cord = np.vstack([around[0] + reach[0], around, around[-1] + reach[1]])
    axes.plot(*cord.T, color=DARK, lw=1.4)
    force = result.site_force_N[p, there]
    starts = (1.0 + 0.35 * result.pitch_rad) * radius * directions(angles)
    _draw_forces(axes, starts, angles + 0.5 * np.pi, force, 2.0 * pitch_mm)
    places = np.where(force[:, None] > 0, 1.12, 1.06) * starts
    _number_sites(axes, result.sites[there], places)
    for (x, y), tension in zip(
        cord[[0, -1]], (drive.tight_tension_N[p], drive.slack_tension_N[p]), strict=True
    ):
        axes.text(x, y, f" {tension:.4g} N", va="top", fontsize=9)
    _scale_alike(axes)


@picture(at_largest_force)
def plot_belt_on_pulley(results: Results, position: int | None = None) -> Figure:
    """Figure of the pulley, the belt and the circumferential forces of its teeth."""
    result, p = at_largest_force(results, position)
    return figure_of(
        draw_belt_on_pulley,
        result,
        f"Forces on the teeth of the belt{_at(result, p, ' at ')}",
        size=DRAWING,
        position=p,
    )


@picture(at_largest_force)
def plot_load_around_wrap(results: Results, position: int | None = None) -> Figure:
    """Figure of the forces of the teeth, the tension of the cord and the forces of the lands."""
    result, p = at_largest_force(results, position)
    with panels(
        result,
        f"Around {degrees(_belt(result).wrap_angle_rad):.4g}° of wrap{_at(result, p, ', at ')}",
        (SIZE[0], 1.35 * SIZE[1]),
    ) as figure:
        upper, lower = figure.subplots(2, 1, sharex=True)
        draw_load_around_wrap(upper, result, position=p)
        draw_tension_around_wrap(lower, result, position=p)
        upper.set_xlabel("")
    return figure


@picture(at_largest_force)
def draw_load_around_wrap(axes: Axes, results: Results, *, position: int | None = None) -> None:
    """Draw the forces of the teeth of a belt around the wrap, with their shares."""
    result, p = at_largest_force(results, position)
    axes.bar(result.sites, result.site_force_N[p], width=0.55, color=SLATE)
    for site, force, share in zip(
        result.sites, result.site_force_N[p], result.load_share[p], strict=True
    ):
        if force > 0:
            axes.text(site, force, f"{100 * share:.1f}", ha="center", va="bottom", fontsize=8)
    axes.set_ylabel("force of the tooth in N\n(above the bar: share in %)")
    axes.set_xlabel(TOOTH)
    axes.set_xticks(result.sites)


@picture(at_largest_force)
def draw_tension_around_wrap(axes: Axes, results: Results, *, position: int | None = None) -> None:
    """Draw the tension of the cord and the forces of the lands of a belt around the wrap."""
    result, p = at_largest_force(results, position)
    drive = _belt(result)
    tension = _tension_behind(drive, p)
    edges = np.append(result.sites, result.sites[-1] + 1) - 0.5
    first = int(np.argmax(np.isfinite(drive.tension_behind_N[p])))
    before = edges[first : first + tension.size]
    axes.plot(before, tension, marker="o", ms=3.5, color=INK, label="tension")
    lands, lifting = drive.lands_N[p], drive.lifting[p]
    axes.plot(edges, lands, marker="s", ms=3.5, color=SLATE, label="force of the land")
    if lifting.any():
        axes.plot(edges[lifting], lands[lifting], "x", ms=9, color=FORCE, label="lifts")
    axes.axhline(0.0, color=GREY, lw=0.6)
    axes.set_ylabel("force in N")
    axes.set_xlabel(TOOTH)
    axes.set_xticks(result.sites)
    axes.legend(ncols=3)


@picture(largest)
def draw_force_through_wrap(axes: Axes, results: Results) -> None:
    """Draw the force of a tooth of a belt on its way through the wrap, from all positions."""
    result = largest(results)
    drive = _belt(result)
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


@picture(largest)
def plot_force_through_wrap(results: Results) -> Figure:
    """Figure of the force of a tooth of a belt on its way through the wrap, from all positions."""
    return figure_of(
        draw_force_through_wrap, largest(results), "A tooth on its way through the wrap"
    )


def _strand_tensions(result: Result, p: int) -> str:
    drive = _chain(result)
    return f"tight {drive.tight_tension_N[p]:.4g} N, slack {drive.slack_tension_N[p]:.4g} N"


@picture(_at_largest_tension)
def draw_chain_on_sprocket(axes: Axes, results: Results, *, position: int | None = None) -> None:
    """Draw the sprocket, the rollers of the chain and the forces on these."""
    result, p = _at_largest_tension(results, position)
    drive = _chain(result)
    there = np.flatnonzero(np.isfinite(drive.roller_height_um[p]))
    pitch_mm = result.pitch_rad * result.reference_radius_mm
    polar = _draw_wheel(axes, result, p)[: there.size] + result.rotation_rad[p]
    radius = result.reference_radius_mm + drive.roller_height_um[p, there] / 1000.0
    centers = radius[:, None] * directions(polar)
    for end, along in zip(centers[[0, -1]], _strands(drive.wrap_angle_rad), strict=True):
        strand = np.column_stack([end, end + CHAIN_STRAND * pitch_mm * along])
        axes.plot(*strand, color=DARK, lw=1.2)
    axes.plot(*centers.T, color=DARK, lw=1.2)
    for center in centers:
        axes.fill(*(center + result.drawing.outline_2).T, color=STEEL[1], ec=EDGE, lw=0.8)
    force = result.site_force_N[p, there]
    angle = np.radians(np.nan_to_num(drive.force_angle_deg[p, there]))
    tips = _draw_forces(axes, centers, polar + angle, force, 2.2 * pitch_mm)
    _number_sites(axes, result.sites[there], centers * (1 - 1.1 * result.pitch_rad))
    most = int(np.argmax(force))
    x, y = tips[most]
    axes.text(x, y, f"{force[most]:.4g} N", ha="center", va="bottom", color=FORCE)
    _scale_alike(axes)


@picture(_at_largest_tension)
def plot_chain_on_sprocket(results: Results, position: int | None = None) -> Figure:
    """Figure of the sprocket, the rollers of the chain and the forces on these."""
    result, p = _at_largest_tension(results, position)
    return figure_of(
        draw_chain_on_sprocket,
        result,
        f"Forces on the rollers at {degrees(result.position_rad[p]):.4g}°",
        second=_strand_tensions(result, p),
        size=DRAWING,
        position=p,
    )


@picture(largest)
def draw_tensions(axes: Axes, results: Results) -> None:
    """Draw the tension of the links of a chain around the wrap at some positions."""
    result = largest(results)
    drive = _chain(result)
    count = result.position_rad.size
    shown = np.unique(np.linspace(0, count - 1, min(N_CURVES, count)).astype(int))
    greys = np.linspace(0.70, 0.10, shown.size) if shown.size > 1 else [0.10]
    for grey, p in zip(greys, shown, strict=True):
        tension = _tension_behind(drive, p)
        name = f"{degrees(result.position_rad[p]):.4g}°"
        look: dict[str, Any] = {"marker": "o", "markersize": 3.5, "lw": 1.4, "color": f"{grey:.3f}"}
        axes.plot(np.arange(tension.size), tension, label=name, **look)
    most = float(drive.tight_tension_N.max())
    steps = np.arange(tension.size)
    dashes, words = (0, (6, 3)), f"falls by q = {drive.tension_ratio:.3f} (worn chain)"
    worn = most * drive.tension_ratio**steps
    axes.plot(steps, worn, color=FORCE, lw=1, linestyle=dashes, label=words)
    axes.set_ylim(0, None)
    axes.set_xlabel("link, from the tight strand (0) to the slack one")
    axes.set_ylabel("tension in N")
    axes.legend(title="position")


@picture(largest)
def plot_tensions(results: Results) -> Figure:
    """Figure of the tension of the links of a chain around the wrap at some positions."""
    return figure_of(draw_tensions, largest(results), "Tension around the sprocket")


def _tension_behind(drive: BeltDrive | ChainDrive, p: int) -> Floats:
    """Tension between the sites on the wheel, from the tight strand to the slack one."""
    behind = drive.tension_behind_N[p]
    return np.append(behind[np.isfinite(behind)], drive.slack_tension_N[p])


def _strands(wrap_rad: float) -> Floats:
    """(2, 2) Directions of the tight and the slack strand away from the wheel."""
    return np.array([[0.0, -1.0], [-np.sin(wrap_rad), np.cos(wrap_rad)]])


def _draw_wheel(axes: Axes, result: Result, p: int) -> Floats:
    """Draw body 1 at a position; angles of its teeth from the tight strand on."""
    drawing = result.drawing
    angles = drawing.angle_1[p] + 2 * np.pi / drawing.teeth_1 * np.arange(drawing.teeth_1)
    wheel = all_around(drawing.outline_1, drawing.teeth_1, drawing.angle_1[p])
    axes.fill(*wheel.T, color=STEEL[0], ec="#7a8791", lw=0.8)
    axes.set_xlabel("x in mm, from the axis of body 1")
    axes.set_ylabel("y in mm")
    axes.grid(visible=False)
    return angles


def _draw_forces(
    axes: Axes, starts: Floats, angles: Floats, force: Floats, longest_mm: float
) -> Floats:
    """An arrow for each loaded site, the largest of the given length; tips of all.

    The heads of short arrows are smaller.
    """
    size = longest_mm * force / (float(force.max()) or 1.0)
    tips = np.asarray(starts + size[:, None] * directions(angles))
    loaded = force > 0
    axes.update_datalim(tips[loaded])
    axes.quiver(
        *starts[loaded].T,
        *(tips - starts)[loaded].T,
        angles="xy",
        scale_units="xy",
        scale=1.0,
        color=FORCE,
        units="dots",
        width=3.5,
        headwidth=4.0,
        headlength=4.5,
        headaxislength=4.5,
        minshaft=1.6,
        minlength=0.3,
        zorder=3,
    )
    return tips


def _number_sites(axes: Axes, sites: NDArray[np.int64], places: Floats) -> None:
    """Write the number of each site at its place (n, 2)."""
    for site, (x, y) in zip(sites, places, strict=True):
        axes.text(x, y, f"{site}", ha="center", va="center", fontsize=8, color=GREY)


def _scale_alike(axes: Axes) -> None:
    """Fit the axes of a complete drawing to it, with the same scale in both directions."""
    axes.set_aspect("equal")
    axes.margins(0.08)
    axes.autoscale_view()
