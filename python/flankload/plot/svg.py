"""Plots as SVG inside a page: unique ids, no addresses, and the curves as numbers beside them."""

from __future__ import annotations

import io
import re
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib import rc_context
from matplotlib.collections import QuadMesh

from flankload.plot.figures import empty_figure, fit
from flankload.plot.positions import OVER_POSITIONS
from flankload.plot.style import STYLE, missing_letters_are_boxes

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

#: Text remains text: it can be searched and copied, and the file is smaller.
IN_PAGE = {**STYLE, "svg.fonttype": "none"}
#: Fewer points than this are marks or straight lines, not a curve to read values from.
LEAST_POINTS = 3
#: More points than this in a curve are thinned.
MOST_POINTS = 600
#: Significant digits of the curves.
DIGITS = 4
#: Points (1/72 inch) per inch: the unit of matplotlib's SVG.
POINTS = 72.0

DECLARATION = re.compile(r"^.*?(?=<svg)", re.DOTALL)
NAMESPACES = re.compile(r'\s+xmlns(:\w+)?="[^"]*"')
SIZE = re.compile(r'\s(?:width|height)="[^"]*"')
ID = re.compile(r'\s+id="([^"]*)"')
REFERENCE = re.compile(r'(?:url\(#|href="#)([^")]*)')
NUMBERS = re.compile(r'(?<=[ "])(?:d|x|y|points)="[^"]*"')
LONG = re.compile(r"(\d\.\d\d)\d+")


@dataclass(frozen=True)
class Panel:
    """A plot for a page.

    Attributes
    ----------
    name : str
        Prefix of its ids.
    svg : str
        An element <svg>, as wide as the page allows.
    axes : tuple of dict
        Rectangular axes with linear scales that have curves, in the units of the SVG: `box` (left,
        top, width, height), `x` and `y` (ranges), `label` (of the ordinate), `position` (whether
        the abscissa is the position) and `curves` (name, x, y; None where interrupted).
    """

    name: str
    svg: str
    axes: tuple[dict[str, Any], ...]


def panel_of(draw: Callable[[Axes], None], name: str, size: tuple[float, float]) -> Panel:
    """Draw on new axes and return the plot for a page.

    Parameters
    ----------
    draw : callable
        Draws on axes.
    name : str
        Prefix of the ids, unique in the page.
    size : (float, float)
        Width and height, inches.
    """
    out = io.StringIO()
    with rc_context(IN_PAGE), missing_letters_are_boxes():
        figure = empty_figure(size)
        draw(figure.add_subplot())
        fit(figure)
        for axes in figure.axes:
            for artist in axes.collections:
                # an image: cells drawn one by one are large and have seams
                artist.set_rasterized(isinstance(artist, QuadMesh))
        empty = dict.fromkeys(("Creator", "Date", "Format", "Type"))
        figure.savefig(out, format="svg", metadata=empty)
    return Panel(name, _in_page(out.getvalue(), name), _axes_of(figure))


def _in_page(text: str, name: str) -> str:
    """Leave the drawing alone, with ids of its own and two decimals."""
    text = DECLARATION.sub("", text)
    text = NAMESPACES.sub("", text).replace("xlink:href", "href")
    head, rest = text.split(">", 1)
    head = SIZE.sub("", head)
    text = f'{head} role="img" aria-label="{name}">{rest}'
    used = set(REFERENCE.findall(text))
    text = ID.sub(lambda found: f' id="{name}-{found[1]}"' if found[1] in used else "", text)
    text = re.sub(r"url\(#", f"url(#{name}-", text)
    text = re.sub(r'href="#', f'href="#{name}-', text)
    text = NUMBERS.sub(lambda found: LONG.sub(r"\1", found[0]), text)
    return re.sub(r"\s*\n\s*", "\n", text).strip()


def _axes_of(figure: Figure) -> tuple[dict[str, Any], ...]:
    width, height = (POINTS * length for length in figure.get_size_inches())
    found = []
    for axes in figure.axes:
        curves = _curves(axes)
        straight = {axes.get_xscale(), axes.get_yscale()} == {"linear"}
        if axes.name != "rectilinear" or not straight or not curves:
            continue
        at = axes.get_position()
        box = (at.x0 * width, (1 - at.y1) * height, at.width * width, at.height * height)
        found.append(
            {
                "box": [round(float(value), 2) for value in box],
                "x": _numbers(axes.get_xlim()),
                "y": _numbers(axes.get_ylim()),
                "label": axes.get_ylabel().replace("\n", " "),
                "position": axes.get_label() == OVER_POSITIONS,
                "curves": curves,
            }
        )
    return tuple(found)


def _curves(axes: Axes) -> list[list[Any]]:
    """Curves in data units over ascending abscissas: those with names, if there are any."""
    found = []
    for line in axes.lines:
        x, y = (np.asarray(values, dtype=float) for values in line.get_data())
        known = x[np.isfinite(x)]
        if np.all(np.diff(known) <= 0):
            x, y, known = x[::-1], y[::-1], known[::-1]
        if line.get_transform() != axes.transData or np.isfinite(y).sum() < LEAST_POINTS:
            continue
        if line.get_linestyle() == "None" or np.any(np.diff(known) < 0):
            continue
        label = str(line.get_label())
        step = -(-x.size // MOST_POINTS)
        name = "" if label.startswith("_") else label
        found.append([name, _numbers(x[::step], DIGITS + 1), _numbers(y[::step])])
    return [curve for curve in found if curve[0]] or found


def _numbers(values: Iterable[float], digits: int = DIGITS) -> list[float | None]:
    """Values with few significant digits; None where they are not finite."""
    return [float(f"{value:.{digits}g}") if np.isfinite(value) else None for value in values]
