"""The loaded bodies at a position as areas, in the section or in three dimensions."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
from bokeh.palettes import Inferno256

from flankload.base.rotation import all_around, directions
from flankload.plot.loaded_pair import is_drawn_over_width
from flankload.plot.loaded_teeth import loaded_teeth
from flankload.report.turning import (
    OFF,
    drawn_bodies,
    load_shape,
    positions_of,
    scales_of,
    thinned,
    window,
)

if TYPE_CHECKING:
    from collections.abc import Iterator

    from flankload.base.arrays import Floats
    from flankload.result import Result

#: Colours of the bodies, of loads and of contours: legible on light and on dark ground.
BODIES, LOAD, INK = ("#7fa7c9", "#c9a67f"), "#e0352b", "#7b848d"
#: Opacity of bodies in the section.
ALPHA = 0.45
#: Points of the circle of a bore.
CIRCLE = 120
#: Facets of a tooth along its contour and along z, positions at which the window must hold it.
FACETS, HELD = (16, 3), 4
#: Width over height of the picture, and space between both bodies as part of their size.
ASPECT, SPACE = 1.4, 0.05


@dataclass(frozen=True)
class Window:
    """Lower left and upper right corner of the picture, mm, and the shift (2, 2) of each body."""

    corners: Floats
    shifts: Floats


def window_of(result: Result) -> Window:
    """Window in which the bodies of a result turn."""
    order = positions_of(result)
    if not is_drawn_over_width(result):
        return Window(np.array(window([result], order)), np.zeros((2, 2)))
    shown = order[:: max(1, len(order) // HELD)]
    outlines = [
        np.vstack([loaded_teeth(result, p, body, *FACETS).outline for p in shown])
        for body in (1, 2)
    ]
    low = np.array([outline.min(axis=0) for outline in outlines])
    size = np.array([np.ptp(outline, axis=0) for outline in outlines])
    width, height = size.T
    # beside or above each other, whichever is larger
    beside = max(width.sum(), ASPECT * height.max()) < max(width.max(), ASPECT * height.sum())
    along, across = (0, 1) if beside else (1, 0)
    place = np.zeros((2, 2))
    place[1 if beside else 0, along] = size[0 if beside else 1, along] + SPACE * size.max()
    place[:, across] = 0.5 * (size[:, across].max() - size[:, across])
    far = (place + size).max(axis=0)
    margin = SPACE * far.max()
    return Window(np.array([[-margin, -margin], far + margin]), place - low)


def bodies_of(result: Result, p: int, shown: Window) -> dict[str, Any]:
    """Columns of the areas of all bodies and their loads at a position, from back to front."""
    parts = _teeth if is_drawn_over_width(result) else _section
    outlines, fill, alpha, line = zip(*parts(result, p, shown), strict=True)
    ends = np.cumsum([len(outline) for outline in outlines]).tolist()
    x, y = np.vstack(outlines).round(3).T.tolist()
    pieces = list(pairwise([0, *ends]))
    return {
        "xs": [x[one:two] for one, two in pieces], "ys": [y[one:two] for one, two in pieces],
        "fill": list(fill), "alpha": list(alpha), "line": list(line),
    }  # fmt: skip


def _section(result: Result, p: int, shown: Window) -> Iterator[tuple[Floats, str, float, str]]:
    """Points, colour, opacity and colour of the contour of each area in the transverse section."""
    size = float(np.ptp(shown.corners, axis=0).max())
    # opposite to the contour: one of both is a hole
    circle, between = directions(np.linspace(0, -2 * np.pi, CIRCLE)), np.full((1, 2), np.nan)
    for body in drawn_bodies(result):
        contour = all_around(thinned(body.outline, OFF * size), body.teeth, body.angle[p])
        outlines = np.vstack([contour, between, (body.hole_mm or 0.0) * circle])
        yield body.center_mm + outlines, BODIES[body.number - 1], ALPHA, INK
    table, scales = result.pairs(p), scales_of([result])
    for s in np.flatnonzero(result.site_force_N[p] > 0).tolist():
        yield load_shape(result, table, p, s, scales, size)[0], LOAD, 0.8, LOAD


def _teeth(result: Result, p: int, shown: Window) -> Iterator[tuple[Floats, str, float, str]]:
    """The same of the teeth over their width, with the line load on their flanks."""
    most = float(result.width_loads.line_load_N_per_mm.max(initial=0.0)) or 1.0
    for body, shift in enumerate(shown.shifts, start=1):
        teeth = loaded_teeth(result, p, body, *FACETS)
        own, mate = BODIES[body - 1], BODIES[2 - body]
        yield teeth.far + shift, mate, ALPHA, INK
        light = np.frombuffer(bytes.fromhex(own[1:]), dtype=np.uint8)
        shades = (teeth.shade[:, None] * light).astype(np.uint8)
        loads = (256 * teeth.load_N_per_mm / most).astype(int).clip(max=255).tolist()
        colours = [f"#{shade.tobytes().hex()}" for shade in shades]
        colours += [Inferno256[load] for load in loads]
        areas = np.concatenate([teeth.facets, teeth.bands]) + shift
        yield from ((*area, 1.0, area[1]) for area in zip(areas, colours, strict=True))
        yield teeth.face + shift, own, 1.0, INK


def position_at(result: Result, part: float) -> int:
    """Index of the position at a part of their range."""
    order = positions_of(result)
    return order[min(int(part * len(order)), len(order) - 1)]


def words_of(result: Result, p: int) -> str:
    """What the picture of the bodies shows at a position."""
    at = f"at {result.position_deg[p]:.2f}°"
    if not is_drawn_over_width(result):
        return f"Loaded bodies {at}"
    load = result.width_loads.line_load_N_per_mm
    return f"Line load {at}: up to {load[p].max():.0f} N/mm, of all positions {load.max():.0f}"
