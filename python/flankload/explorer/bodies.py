"""The loaded bodies at a position as an SVG drawing, in the section or in three dimensions."""

from __future__ import annotations

from dataclasses import dataclass
from math import degrees
from typing import TYPE_CHECKING

import numpy as np
from bokeh.palettes import Inferno256

from flankload.plot.loaded_pair import is_drawn_over_width
from flankload.plot.loaded_teeth import loaded_teeth
from flankload.report.turning import (
    body_path,
    drawn_bodies,
    load_shape,
    path_text,
    positions_of,
    scales_of,
    window,
)

if TYPE_CHECKING:
    from collections.abc import Iterator

    from flankload.base.arrays import Floats
    from flankload.result import Result

#: Colours of both bodies over their width: legible on light and on dark ground.
BODIES = ("#7fa7c9", "#c9a67f")
#: Facets of a tooth along its contour and along z, positions at which the window must hold it.
FACETS, HELD = (16, 3), 4
#: Width over height of the picture, and space between both bodies as part of their size.
ASPECT, SPACE = 1.4, 0.05


@dataclass(frozen=True)
class Window:
    """Lower left and upper right corner of the drawing, mm, and the shift (2, 2) of each body."""

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


def drawing_of(result: Result | None, part: float, shown: Window) -> str:
    """Drawing of the bodies at a part of their positions, with its title; without result empty."""
    words, paths = "Loaded bodies", ""
    if result is not None:
        order = positions_of(result)
        p = order[min(int(part * len(order)), len(order) - 1)]
        over_width = is_drawn_over_width(result)
        paths = "".join((_teeth if over_width else _section)(result, p, shown))
        words = f"Loaded bodies at {result.position_deg[p]:.2f}°"
        if over_width:
            load = result.width_loads.line_load_N_per_mm
            words += f": up to {load[p].max():.0f} N/mm, of all positions {load.max():.0f}"
    (left, low), (right, high) = shown.corners.tolist()
    box = f"{left:.3f} {-high:.3f} {right - left:.3f} {high - low:.3f}"
    return (
        f'<h2>{words}</h2><svg viewBox="{box}" role="img" aria-label="{words}">'
        f'<g transform="scale(1 -1)">{paths}</g></svg>'
    )


def _section(result: Result, p: int, shown: Window) -> Iterator[str]:
    """Paths of the bodies and their loads in the transverse section."""
    size = float(np.ptp(shown.corners, axis=0).max())
    for body in drawn_bodies(result):
        x, y = body.center_mm
        place = f"translate({x:.3f} {y:.3f}) rotate({degrees(body.angle[p]):.4f})"
        yield (
            f'<path class="body-{body.number}" fill-rule="evenodd" transform="{place}" '
            f'd="{body_path(body, size)}"/>'
        )
    table, scales = result.pairs(p), scales_of([result])
    for s in np.flatnonzero(result.site_force_N[p] > 0).tolist():
        shape = load_shape(result, table, p, s, scales, size)[0]
        yield f'<path class="load" d="M{path_text(shape)}Z"/>'


def _teeth(result: Result, p: int, shown: Window) -> Iterator[str]:
    """Paths of the teeth over their width from back to front, with the line load on the flanks."""
    most = float(result.width_loads.line_load_N_per_mm.max(initial=0.0)) or 1.0
    for body, shift in enumerate(shown.shifts, start=1):
        teeth = loaded_teeth(result, p, body, *FACETS)
        own, mate = BODIES[body - 1], BODIES[2 - body]
        yield f'<path fill="{mate}" fill-opacity=".45" d="M{path_text(teeth.far + shift)}Z"/>'
        light = np.frombuffer(bytes.fromhex(own[1:]), dtype=np.uint8)
        shades = (teeth.shade[:, None] * light).astype(np.uint8)
        loads = (256 * teeth.load_N_per_mm / most).astype(int).clip(max=255).tolist()
        colours = [f"#{shade.tobytes().hex()}" for shade in shades]
        colours += [Inferno256[load] for load in loads]
        areas = np.concatenate([teeth.facets, teeth.bands]) + shift
        for area, colour in zip(areas, colours, strict=True):
            yield f'<path fill="{colour}" stroke="{colour}" d="M{path_text(area)}Z"/>'
        yield f'<path fill="{own}" d="M{path_text(teeth.face + shift)}Z"/>'
