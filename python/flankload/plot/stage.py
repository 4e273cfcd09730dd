"""Plots of planetary stages: members with forces, shares of the planets, orbit, K_gamma."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from flankload.base.rotation import all_around, directions
from flankload.plot.figures import legend_below
from flankload.plot.picture import all_torques, at, figure_of, largest, picture
from flankload.plot.positions import curve, label_positions
from flankload.plot.style import BODIES, COLOURS, FORCE, GREY, INK, STEEL, torque_colours

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from flankload.plot.picture import Results
    from flankload.result import Result
    from flankload.result.stage import StageLoads

#: Size of a drawing, inches.
DRAWING = (6.4, 6.0)
#: Length of the largest force, as part of the radius of the ring.
LONGEST = 0.35
#: Distance of the share of a planet from the arrow on its pin, as part of that radius.
BESIDE = 0.05
#: Mesh load factors of ABS (Guide for the gears of propulsion systems) by number of planets.
STANDARD = {3: 1.0, 4: 1.2, 5: 1.3, 6: 1.4}


def _stage(result: Result) -> StageLoads:
    assert result.stage is not None
    return result.stage


def _of_largest_factor(result: Result) -> int:
    """Position of the largest mesh load factor."""
    return int(np.nanargmax(_stage(result).mesh_load_factor))


_at_largest_factor = at(_of_largest_factor)


@picture(_at_largest_factor)
def draw_planetary_stage(axes: Axes, results: Results, *, position: int | None = None) -> None:
    """Draw sun, planets and ring, the forces of the sun on the planets and those on the pins."""
    result, p = _at_largest_factor(results, position)
    stage = _stage(result)
    sun, ring, *planets = result.drawing.bodies
    rim = float(ring.hole_mm or np.hypot(*ring.outline.T).max())
    axes.fill(*(rim * directions(np.linspace(0.0, 2 * np.pi, 181))).T, color=STEEL[1])
    inside = all_around(ring.outline, ring.teeth, ring.angle[p])
    axes.fill(*inside.T, color="white", ec=BODIES[1], lw=0.5)
    for body in (sun, *planets):
        contour = body.center_mm + all_around(body.outline, body.teeth, body.angle[p])
        axes.fill(*contour.T, color=STEEL[0], ec=BODIES[0], lw=0.5)
    largest_N = max(
        float(np.hypot(*force.T).max()) for force in (stage.planet_force_N[p], stage.pin_force_N[p])
    )
    scale = LONGEST * rim / (largest_N or 1.0)
    for j, body in enumerate(planets):
        center = body.center_mm
        away = center / stage.center_distance_mm
        share = 100.0 * result.load_share[p, j]
        pin = stage.pin_force_N[p, j]
        behind = -pin / (np.hypot(*pin) or 1.0)
        # words beside an arrow that is level begin or end behind it
        anchor = ("right", "center", "left")[int(np.rint(behind[0])) + 1]
        x, y = center + BESIDE * rim * behind
        words = f"{j + 1}: {share:.1f} %"
        axes.text(x, y, words, ha=anchor, va="center", fontsize=9, zorder=5)
        at_mesh = (
            stage.center_distance_mm * stage.teeth[0] / (stage.teeth[0] + stage.teeth[1])
        ) * away
        for start, force, colour in (
            (at_mesh, stage.planet_force_N[p, j], FORCE),
            (center, stage.pin_force_N[p, j], INK),
        ):
            if np.hypot(*force) > 0:
                axes.annotate(
                    "", tuple(start + scale * force), tuple(start),
                    arrowprops={"arrowstyle": "-|>", "color": colour, "lw": 1.6}, zorder=4,
                )  # fmt: skip
    axes.plot([], [], color=FORCE, label="force of the sun on a planet")
    axes.plot([], [], color=INK, label="force of a planet on its pin")
    legend_below(axes, ncols=2)
    axes.set_aspect("equal")
    axes.grid(visible=False)
    axes.set_axis_off()


@picture(_at_largest_factor)
def plot_planetary_stage(results: Results, position: int | None = None) -> Figure:
    """Figure of sun, planets and ring with forces."""
    result, p = _at_largest_factor(results, position)
    factor = _stage(result).mesh_load_factor[p]
    title = f"K_gamma {factor:.3f} at {result.position_deg[p]:.4g}°"
    return figure_of(draw_planetary_stage, result, title, size=DRAWING, position=p)


@picture(largest)
def draw_planet_load_share(axes: Axes, results: Results) -> None:
    """Draw the share of each planet over the positions."""
    result = largest(results)
    label_positions(axes, result)
    axes.set_ylabel("share of the planet in %")
    for j in range(_stage(result).count):
        look: dict[str, Any] = {
            "color": COLOURS[j % len(COLOURS)],
            "ls": "-" if j < len(COLOURS) else "--",
        }
        axes.plot(*curve(result, 100.0 * result.load_share[:, j]), label=f"planet {j + 1}", **look)
    equal = 100.0 / _stage(result).count
    axes.axhline(equal, color=GREY, lw=1, ls=(0, (6, 3)), zorder=0)
    legend_below(axes, ncols=min(6, _stage(result).count))


@picture(largest)
def plot_planet_load_share(results: Results) -> Figure:
    """Figure of the share of each planet over the positions."""
    return figure_of(draw_planet_load_share, largest(results), "Load shares of the planets")


@picture(all_torques)
def draw_sun_orbit(axes: Axes, results: Results) -> None:
    """Draw the path of the axis of the sun, a curve per torque."""
    results = all_torques(results)
    for result, colour in zip(results, torque_colours(len(results)), strict=True):
        x, y = (curve(result, part)[1] for part in _stage(result).sun_orbit_um.T)
        axes.plot(x, y, color=colour, marker="o", ms=2.5, label=f"{result.torque_Nm:g} N m")
    axes.plot(0.0, 0.0, marker="+", color=GREY, ms=9)
    axes.set_xlabel("x in µm")
    axes.set_ylabel("y in µm")
    axes.set_aspect("equal", adjustable="datalim")
    if len(results) > 1:
        legend_below(axes, ncols=min(5, len(results)))


@picture(all_torques)
def plot_sun_orbit(results: Results) -> Figure:
    """Figure of the path of the axis of the sun, a curve per torque."""
    return figure_of(draw_sun_orbit, results, "Orbit of the sun", size=DRAWING)


@picture(all_torques)
def draw_mesh_load_factor(axes: Axes, results: Results) -> None:
    """Draw the largest K_gamma over the torque, with that of equal springs and of a standard.

    Springs with the stiffness of the largest torque: for errors of the pins, K_gamma - 1 is
    inversely proportional to the torque.
    """
    results = all_torques(results)
    torques = np.array([result.torque_Nm for result in results])
    factors = np.array([result.summary["mesh_load_factor_max"] for result in results])
    axes.plot(torques, factors, color="#9a9a9a", lw=1.2, zorder=1)
    axes.scatter(torques, factors, c=torque_colours(len(results)), s=34, zorder=2)
    fine = np.linspace(torques.min(), torques.max(), 200)
    springs = 1.0 + (factors[-1] - 1.0) * torques[-1] / fine
    axes.plot(
        fine,
        np.minimum(springs, 1.15 * factors.max()),
        color=INK,
        lw=1,
        ls=(0, (3, 2)),
        label="equal springs, 1 + c/torque",
    )
    n = _stage(results[-1]).count
    if n in STANDARD:
        axes.axhline(STANDARD[n], color=GREY, lw=1, ls=(0, (6, 3)), label=f"ABS, {n} planets")
    axes.set_xlabel("torque on the sun in N m")
    axes.set_ylabel("largest K_gamma")
    legend_below(axes, ncols=2)


@picture(all_torques)
def plot_mesh_load_factor(results: Results) -> Figure:
    """Figure of the largest K_gamma over the torque."""
    return figure_of(draw_mesh_load_factor, results, "Mesh load factor over the torque")
