"""The plot of a gear train: its bodies with the forces of both meshes and on the bearings."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from flankload.base.rotation import all_around, directions
from flankload.plot.figures import legend_below
from flankload.plot.picture import at, figure_of, picture
from flankload.plot.style import BODIES, FORCE, INK, STEEL

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from flankload.plot.picture import Results
    from flankload.result import Result
    from flankload.result.train import TwoMeshes

#: Size of a drawing, inches.
DRAWING = (6.4, 5.0)
#: Length of the largest force, as part of the width of the drawing.
LONGEST = 0.22
#: Distance of the words from the bore, as part of its height.
BESIDE = 0.01


def _train(result: Result) -> TwoMeshes:
    assert result.train is not None
    return result.train


_at_largest = at(lambda result: int(np.argmax(_train(result).common_force_N)))


@picture(_at_largest)
def draw_gear_train(axes: Axes, results: Results, *, position: int | None = None) -> None:
    """Draw the gears, the forces of both meshes and those on the bearings."""
    result, p = _at_largest(results, position)
    train, table = _train(result), result.pairs(p)
    low, high = result.drawing.extent_mm([p])
    for body in result.drawing.bodies:
        contour = body.center_mm + all_around(body.outline, body.teeth, body.angle[p])
        axes.fill(*contour.T, color=STEEL[0], ec=BODIES[0], lw=0.5)
        hole = body.center_mm + (body.hole_mm or 0.0) * directions(np.linspace(0, 2 * np.pi, 91))
        axes.fill(*hole.T, color="white", ec=BODIES[0], lw=0.5)
    arrows = []
    for site in result.sites:
        own = table.site == site
        force = table.force_N[own]
        if force.sum() > 0.0:
            arrows.append((force @ table.point_mm[own] / force.sum(),
                           force @ table.normal[own], FORCE))  # fmt: skip
    drawn = result.drawing.bodies
    height = float(high[1] - low[1])
    places = zip(train.centers_mm, train.bearing_force_N[p], strict=True)
    for number, (center, force) in enumerate(places, 1):
        arrows.append((center, force, INK))
        name = f"body {number}\n{np.hypot(*force) / 1000.0:.3g} kN"
        # beside the bore, on the side to which the force does not point
        side = 1.0 if force[1] < 0.0 else -1.0
        own = next(one for one in drawn if np.allclose(one.center_mm, center))
        beside = float(center[1]) + side * ((own.hole_mm or 0.0) + BESIDE * height)
        anchor = "bottom" if side > 0.0 else "top"
        axes.text(float(center[0]), beside, name, ha="center", va=anchor, fontsize=9, zorder=5)
    largest = max(float(np.hypot(*force)) for _, force, _ in arrows) or 1.0
    scale = LONGEST * float((high - low).max()) / largest
    for start, force, colour in arrows:
        style: dict[str, Any] = {"arrowstyle": "-|>", "color": colour, "lw": 1.6}
        tip = start + scale * force
        axes.annotate("", xy=tuple(tip), xytext=tuple(start), arrowprops=style, zorder=4)
        axes.update_datalim([tip])
    axes.plot([], [], color=FORCE, label="force of a mesh on its driven gear")
    axes.plot([], [], color=INK, label="force of a gear on its bearings")
    legend_below(axes, ncols=2)
    axes.set_aspect("equal")
    axes.grid(visible=False)
    axes.set_axis_off()


@picture(_at_largest)
def plot_gear_train(results: Results, position: int | None = None) -> Figure:
    """Figure of the gears of a train with forces."""
    result, p = _at_largest(results, position)
    force = _train(result).common_force_N[p]
    title = f"bearings of body {_train(result).common_gear}: {force:.5g} N"
    title += f" at {result.position_deg[p]:.4g}°"
    return figure_of(draw_gear_train, result, title, size=DRAWING, position=p)
