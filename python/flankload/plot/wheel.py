"""Common parts of the plots of belts and chains: a wheel with teeth."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flankload.plot.style import GREY, STEEL, turned

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from numpy.typing import NDArray

    from flankload.result import Result

    Floats = NDArray[np.float64]


#: Size of a drawing, inches.
DRAWING = (6.4, 6.0)
#: Colours of strands, and of the edges of body 2.
DARK, EDGE = "#404040", "#7a6f57"


def directions(angles: Floats) -> Floats:
    """(n, 2) Unit vectors at polar angles."""
    return np.column_stack([np.cos(angles), np.sin(angles)])


def draw_wheel(axes: Axes, result: Result, p: int) -> Floats:
    """Draw body 1 at a position; angles of its teeth from the tight strand on."""
    drawing = result.drawing
    angles = drawing.angle_1[p] + 2 * np.pi / drawing.teeth_1 * np.arange(drawing.teeth_1)
    wheel = np.vstack([turned(drawing.outline_1, angle) for angle in angles])
    axes.fill(*wheel.T, color=STEEL[0], ec="#7a8791", lw=0.8)
    axes.set_xlabel("x in mm, from the axis of body 1")
    axes.set_ylabel("y in mm")
    axes.grid(visible=False)
    return angles


def scaled_alike(axes: Axes) -> None:
    """Fit the axes of a complete drawing to it, with the same scale in both directions."""
    axes.set_aspect("equal")
    axes.margins(0.08)
    axes.autoscale_view()


def number_sites(axes: Axes, sites: NDArray[np.int64], places: Floats) -> None:
    """Write the number of each site at its place (n, 2)."""
    for site, (x, y) in zip(sites, places, strict=True):
        axes.text(x, y, f"{site}", ha="center", va="center", fontsize=8, color=GREY)
