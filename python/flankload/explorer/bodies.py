"""The loaded bodies at a position as an SVG drawing, in the section or in three dimensions."""

from __future__ import annotations

from math import degrees
from typing import TYPE_CHECKING

import numpy as np
from bokeh.palettes import Inferno256

from flankload.plot.loaded_pair import view_of
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
#: Space around the bodies, as part of their size.
SPACE = 0.05


def windows_of(result: Result) -> tuple[Floats, ...]:
    """Lower left and upper right corner of the drawing, mm; of each body that is over its width.

    All positions are within; drawings of several bodies have one size, thus one scale.
    """
    order = positions_of(result)
    bodies = view_of(result).one_by_one
    if not bodies:
        return (np.array(window([result], order)),)
    shown = order[:: max(1, len(order) // HELD)]
    outlines = (
        np.vstack([loaded_teeth(result, p, body, *FACETS).outline for p in shown])
        for body in bodies
    )
    ends = np.array([(outline.min(axis=0), outline.max(axis=0)) for outline in outlines])
    half = (0.5 + SPACE) * np.ptp(ends, axis=1).max(axis=0)
    return tuple(np.array([middle - half, middle + half]) for middle in ends.mean(axis=1))


def drawing_of(result: Result | None, part: float, windows: tuple[Floats, ...]) -> str:
    """Title and drawings of the bodies at a part of their positions; without result empty."""
    words, drawn = "Loaded bodies", [""] * len(windows)
    if result is not None:
        order = positions_of(result)
        p = order[min(int(part * len(order)), len(order) - 1)]
        words = f"Loaded bodies at {result.position_deg[p]:.2f}°"
        if bodies := view_of(result).one_by_one:
            load = result.width_loads.line_load_N_per_mm
            words += f": up to {load[p].max():.0f} N/mm, of all positions {load.max():.0f}"
            drawn = ["".join(_teeth(result, p, body)) for body in bodies]
        else:
            drawn = ["".join(_section(result, p, float(np.ptp(windows[0], axis=0).max())))]
    found = f"<h2>{words}</h2>"
    for (low, high), paths in zip(windows, drawn, strict=True):
        box = f"{low[0]:.3f} {-high[1]:.3f} {high[0] - low[0]:.3f} {high[1] - low[1]:.3f}"
        found += f'<svg viewBox="{box}" role="img" aria-label="{words}">'
        found += f'<g transform="scale(1 -1)">{paths}</g></svg>'
    return found


def _section(result: Result, p: int, size: float) -> Iterator[str]:
    """Paths of the bodies and their loads in the transverse section, for a size of the drawing."""
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


def _teeth(result: Result, p: int, body: int) -> Iterator[str]:
    """Paths of teeth over their width from back to front, with the line load on the flanks."""
    most = float(result.width_loads.line_load_N_per_mm.max(initial=0.0)) or 1.0
    teeth = loaded_teeth(result, p, body, *FACETS)
    own, mate = BODIES[body - 1], BODIES[2 - body]
    yield f'<path fill="{mate}" fill-opacity=".45" d="M{path_text(teeth.far)}Z"/>'
    light = np.frombuffer(bytes.fromhex(own[1:]), dtype=np.uint8)
    shades = (teeth.shade[:, None] * light).astype(np.uint8)
    loads = (256 * teeth.load_N_per_mm / most).astype(int).clip(max=255).tolist()
    colours = [f"#{shade.tobytes().hex()}" for shade in shades]
    colours += [Inferno256[load] for load in loads]
    for area, colour in zip([*teeth.facets, *teeth.bands], colours, strict=True):
        yield f'<path fill="{colour}" stroke="{colour}" d="M{path_text(area)}Z"/>'
    yield f'<path fill="{own}" d="M{path_text(teeth.face)}Z"/>'
