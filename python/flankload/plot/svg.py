"""Plots as SVG inside a page: unique ids, no addresses, and the curves as numbers beside them."""

from __future__ import annotations

import io
import re
import warnings
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from matplotlib import rc_context
from matplotlib.collections import QuadMesh

from flankload.plot.figures import empty_figure, fit
from flankload.plot.style import STYLE

if TYPE_CHECKING:
    from collections.abc import Callable

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

#: Text remains text: it can be searched and copied, and the file is smaller.
IN_PAGE = {**STYLE, "svg.fonttype": "none"}
#: Fewer points than this are marks or straight lines, not a curve to read values from.
LEAST_POINTS = 3
#: More points than this in a curve are thinned.
MOST_POINTS = 600
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
class PlottedCurve:
    """A curve of a plot.

    Attributes
    ----------
    name : str
        Its label; empty if the plot names none.
    x, y : (n,) arrays
        Data; NaN where the curve is interrupted.
    """

    name: str
    x: NDArray[np.float64]
    y: NDArray[np.float64]


@dataclass(frozen=True)
class PlottedAxes:
    """Axes of a plot in the units of its SVG.

    Attributes
    ----------
    box : (float, float, float, float)
        Left, top, width and height.
    x_range, y_range : (float, float)
        Data at the left and right, and at the bottom and top.
    x_label, y_label : str
    curves : tuple of PlottedCurve
    """

    box: tuple[float, float, float, float]
    x_range: tuple[float, float]
    y_range: tuple[float, float]
    x_label: str
    y_label: str
    curves: tuple[PlottedCurve, ...]


@dataclass(frozen=True)
class Panel:
    """A plot for a page.

    Attributes
    ----------
    name : str
        Prefix of its ids.
    svg : str
        An element <svg>, as wide as the page allows.
    axes : tuple of PlottedAxes
        Rectangular axes with linear scales that have curves.
    """

    name: str
    svg: str
    axes: tuple[PlottedAxes, ...]


def panel_of(
    draw: Callable[[Axes], None],
    name: str,
    size: tuple[float, float],
) -> Panel:
    """Draw on new axes and return the plot for a page.

    Parameters
    ----------
    draw : callable
        Draws on axes.
    name : str
        Prefix of the ids, unique in the page.
    size : (float, float)
        Width and height, inches.

    Returns
    -------
    Panel
    """
    with rc_context(IN_PAGE):
        figure = empty_figure(size)
        draw(figure.add_subplot())
        fit(figure)
        return panel(figure, name)


def panel(figure: Figure, name: str) -> Panel:
    """Return a figure for a page.

    Parameters
    ----------
    figure : Figure
    name : str
        Prefix of the ids, unique in the page.

    Returns
    -------
    Panel
    """
    out = io.StringIO()
    for axes in figure.axes:
        for artist in axes.collections:
            # an image: cells drawn one by one are large and have seams
            artist.set_rasterized(isinstance(artist, QuadMesh))
    with rc_context(IN_PAGE), warnings.catch_warnings():
        warnings.filterwarnings("ignore", r"Glyph \d+ .* missing from", UserWarning)
        warnings.filterwarnings("ignore", r"Matplotlib currently does not support", UserWarning)
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


def _axes_of(figure: Figure) -> tuple[PlottedAxes, ...]:
    width, height = (POINTS * length for length in figure.get_size_inches())
    found = []
    for axes in figure.axes:
        curves = _curves(axes)
        straight = {axes.get_xscale(), axes.get_yscale()} == {"linear"}
        if axes.name != "rectilinear" or not straight or not curves:
            continue
        place = axes.get_position()
        found.append(
            PlottedAxes(
                (place.x0 * width, (1 - place.y1) * height, place.width * width,
                 place.height * height),
                axes.get_xlim(),
                axes.get_ylim(),
                axes.get_xlabel(),
                axes.get_ylabel().replace("\n", " "),
                curves,
            )
        )  # fmt: skip
    return tuple(found)


def _curves(axes: Axes) -> tuple[PlottedCurve, ...]:
    """Curves in data units over ascending abscissas: those with names, if there are any."""
    found: list[PlottedCurve] = []
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
        found.append(PlottedCurve(name, x[::step], y[::step]))
    named = tuple(curve for curve in found if curve.name)
    return named or tuple(found)
