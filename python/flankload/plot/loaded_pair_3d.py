"""The loaded pair in three dimensions: teeth over the face width, line load on their flanks."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.colors import Normalize, to_rgb

from flankload.plot.figures import note
from flankload.plot.loaded_teeth import loaded_teeth
from flankload.plot.style import GREY, STEEL

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes

    from flankload.base.arrays import Floats
    from flankload.plot.loaded_teeth import LoadedTeeth
    from flankload.result import Result


LOAD_MAP = "YlOrRd"
#: Points per inch; points for the title of a body, and for the text at an end of its face width.
POINTS, TITLE, TEXT = 72.0, 22.0, np.array([60.0, 13.0])
#: Iterations for the scale of a drawing with texts.
SCALE_STEPS = 4
EDGE = "#404040"


def draw_loaded_bodies(axes: Axes, result: Result, p: int, bodies: tuple[int, ...]) -> None:
    """Draw the teeth of bodies at position p, and the line load on their flanks.

    Each body is drawn from the side of its loaded flanks, its mate as contours of both end faces;
    both have the same scale and are beside or above each other, whichever is larger.
    """
    axes.set_axis_off()
    axes.figure.colorbar(
        ScalarMappable(Normalize(0.0, _most(result, p)), LOAD_MAP),
        ax=axes,
        orientation="horizontal",
        label="line load in N per mm face width" + _largest(result, p),
        fraction=0.04,
        aspect=40.0,
        pad=0.02,
    )
    place = np.array(axes.bbox.size) * POINTS / axes.figure.dpi
    drawn = [loaded_teeth(result, p, body) for body in bodies]
    outlines = [(teeth.outline, teeth.ends) for teeth in drawn]
    panels, scale = _arrangement(outlines, place)
    for body, teeth, panel, outline in zip(bodies, drawn, panels, outlines, strict=True):
        inset = axes.inset_axes((panel[0], panel[1], panel[2], panel[3]))
        _draw_body(inset, teeth, body, _most(result, p))
        inset.set_title(_words(result, body), color=EDGE, fontsize=10, loc="center")
        low, high = _with_texts(outline, scale)
        half = 0.5 * scale * place * panel[2:]
        (left, bottom), (right, top) = 0.5 * (low + high) - half, 0.5 * (low + high) + half
        inset.set(xlim=(left, right), ylim=(bottom, top))


def _with_texts(outline: tuple[Floats, Floats], scale: float) -> tuple[Floats, Floats]:
    """Lower left and upper right corner of a body and the texts at its ends.

    The scale is that of the drawing, mm per point.
    """
    points, (at_small_z, at_large_z) = outline
    texts = [at_small_z - scale * TEXT, at_large_z - scale * TEXT * [0.5, 1.0]]
    texts.append(at_large_z + scale * TEXT * [0.5, 0.0])
    points = np.vstack([points, texts])
    return points.min(axis=0), points.max(axis=0)


def _arrangement(
    outlines: Sequence[tuple[Floats, Floats]], place: Floats
) -> tuple[list[Floats], float]:
    """Left, bottom, width and height of the panels as parts of a place, and mm per point.

    Parameters
    ----------
    outlines : sequence of tuple
        As for `_outline`, per body.
    place : (2,) array
        Width and height, points.
    """
    found = []
    count = len(outlines)
    for step in (np.array([1.0, 0.0]), np.array([0.0, -1.0])):  # beside, above each other
        panel = np.where(step, 1.0 / count, 1.0)
        panel[1] -= TITLE / place[1]
        scale = 0.0
        for _ in range(SCALE_STEPS):  # texts have a size of their own
            corners = [_with_texts(outline, scale) for outline in outlines]
            scale = float(np.max([(high - low) / (place * panel) for low, high in corners]))
        first = np.array([0.0, 1.0 - 1.0 / count]) if step[1] else np.zeros(2)
        starts = [first + k * step / count for k in range(count)]
        found.append((scale, [np.concatenate([start, panel]) for start in starts]))
    scale, panels = min(found, key=lambda each: each[0])
    return panels, scale


def _draw_body(axes: Axes, teeth: LoadedTeeth, body: int, most: float) -> None:
    """Draw the teeth of a body over its width, contours of its mate, and the line load."""
    own, mate = STEEL[body - 1], STEEL[2 - body]
    colours = teeth.shade[:, None] * to_rgb(own)
    parts = [
        PolyCollection([teeth.far], facecolors=[mate], edgecolors=GREY, linewidths=0.6),
        PolyCollection(list(teeth.facets), facecolors=colours, edgecolors=colours, linewidths=0.4),
        PolyCollection(
            list(teeth.bands), array=teeth.load_N_per_mm, cmap=LOAD_MAP, clim=(0.0, most),
            edgecolors=EDGE, linewidths=0.25,
        ),
        PolyCollection([teeth.face], facecolors=[own], edgecolors=EDGE, linewidths=0.8),
        LineCollection([teeth.near], colors=GREY, linewidths=0.8, linestyles="dotted"),
    ]  # fmt: skip
    for order, part in enumerate(parts, start=1):
        part.set_zorder(order)
        axes.add_collection(part)
    if teeth.load_N_per_mm.size:
        ring = teeth.bands[teeth.load_N_per_mm.argmax()].mean(axis=0)
        axes.plot(*ring, marker="o", markersize=9, mfc="none", mec=EDGE, zorder=7)
    for (x, y), z, side in zip(teeth.ends, teeth.z_mm, ("right", "center"), strict=True):
        text = f"z = {z:g} mm".replace("-", "−")
        note(axes, text, (x, y), offset=(0, -3), ha=side, va="top", fontsize=8)
    axes.set_aspect("equal")
    axes.set_axis_off()
    axes.autoscale_view()


def _most(result: Result, p: int) -> float:
    """Largest line load of a position, N/mm; 1 without load."""
    return float(result.width_loads.line_load_N_per_mm[p].max(initial=0.0)) or 1.0


def _largest(result: Result, p: int) -> str:
    """The meaning of the ring; nothing without load."""
    load = result.width_loads.line_load_N_per_mm[p]
    if not load.any():
        return ""
    z = result.slice_z_mm[load.max(axis=0).argmax()]
    return f"; ○ largest: {load.max():.0f} at z = {z:.1f} mm".replace("-", "−")


def _words(result: Result, body: int) -> str:
    """Number, teeth and hand of a body."""
    shape = result.drawing.axial[body - 1]
    teeth = (result.drawing.teeth_1, result.drawing.teeth_2)[body - 1]
    hand = ("spur", "right hand", "left hand")[shape.hand_sign]
    return f"Body {body}, {teeth} teeth, {hand}"
