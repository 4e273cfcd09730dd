"""The pictures of a page: curves, bars and maps with their sources, the bodies, the trail."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from bokeh.models import (
    BoxZoomTool,
    ColumnDataSource,
    CustomJS,
    HoverTool,
    LinearColorMapper,
    Range1d,
    ResetTool,
    SaveTool,
    TapTool,
)
from bokeh.plotting import figure

from flankload.explorer.bodies import INK, bodies_of, words_of
from flankload.explorer.tables import FIGURES, number_of

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

    from flankload.base.arrays import Floats
    from flankload.explorer.bodies import Window
    from flankload.explorer.worker import Answer
    from flankload.result import Result

    Columns = dict[str, Any]
    #: Called with a model and its new properties, which a page sends together.
    Send = Callable[..., None]

#: Colours that are legible on light and on dark ground.
NOW, PINNED, FRONT, LINES = "#2f86d1", "#98a0a8", "#e08214", "#8a939c"
#: Height of a picture and of the bodies, pixels.
HEIGHT, TALL = 220, 330
#: Title, and labels of both axes, of each picture; that of a map has its largest value.
PICTURES = {
    "error": ("Transmission error", "angle, °", "µm"),
    "share": ("Load share", "place in mesh pitches from the pitch point", "%"),
    "sites": ("Force of each {}, at the largest one", "number", "N"),
    "pressure": ("Largest pressure", "place in mesh pitches from the pitch point", "MPa"),
    "spectrum": ("Spectrum of the transmission error", "mesh order", "µm"),
    "pattern": ("Contact pattern: black 0, yellow {:.0f} MPa", "axial position, mm",
                "diameter on body 1, mm"),
    "line_load": ("Line load: black 0, yellow {:.0f} N/mm", "place in mesh pitches",
                  "axial position, mm"),
}  # fmt: skip
#: The window of the bodies, without distortion: it grows in one direction.
UNDISTORTED = """
const [left, right, low, high] = figure.tags;
const {x_range, y_range, inner_width, inner_height} = figure;
if (!(inner_width > 0 && right > left)) return;
const scale = Math.max((right - left) / inner_width, (high - low) / inner_height);
const [x, y, w, h] = [left + right, low + high, scale * inner_width, scale * inner_height];
x_range.setv({start: (x - w) / 2, end: (x + w) / 2});
y_range.setv({start: (y - h) / 2, end: (y + h) / 2});
"""
BARS, MAPS = ("sites", "spectrum"), ("pattern", "line_load")
#: Pictures over the angle of the position, where pairs do not advance.
OVER_POSITIONS = ("error", "share", "pressure", "line_load")
#: Space beside curves, as part of their range.
MARGIN = 0.1
#: Columns of a curve without points, of no areas, and of a map without values.
NO_CURVE: Columns = {"x": [], "y": [], "corner": []}
NO_AREAS: Columns = {"xs": [], "ys": [], "fill": [], "alpha": [], "line": []}
NO_MAP: Columns = {"image": [], "x": [], "y": [], "dw": [], "dh": []}


class Picture:
    """Curves, bars or a map, with those of the pinned design behind.

    Ranges are set with the data: those that follow the data draw each picture twice.
    """

    def __init__(self, name: str, send: Send) -> None:
        self._title, x, y = PICTURES[name]
        self.figure = empty_figure(self._title, x, y, HEIGHT)
        self.figure.x_range, self.figure.y_range = Range1d(0.0, 1.0), Range1d(0.0, 1.0)
        self._is_map, self._is_bars, self._name = name in MAPS, name in BARS, name
        self._send = send
        self._has_zero = not self._is_map and name != "error"
        self._empty = NO_MAP if self._is_map else NO_CURVE
        self._behind = dict(self._empty)
        self._now, self._pinned = (ColumnDataSource(dict(self._empty)) for _ in range(2))
        if self._is_map:
            self._colors = LinearColorMapper(palette="Inferno256", low=0.0, high=1.0,
                                             nan_color="rgba(0, 0, 0, 0)")  # fmt: skip
            self.figure.image("image", x="x", y="y", dw="dw", dh="dh", source=self._now,
                              color_mapper=self._colors)  # fmt: skip
            return
        if self._is_bars:
            self.figure.vbar(x="x", top="y", width=0.8, source=self._pinned, color=PINNED,
                             fill_alpha=0.4, line_alpha=0.0)  # fmt: skip
            self.figure.vbar(x="x", top="y", width=0.45, source=self._now, color=NOW)
        else:
            look = {"line_color": PINNED, "line_width": 2.5, "line_alpha": 0.8}
            self.figure.line("x", "y", source=self._pinned, **look)
            self.figure.line("x", "corner", source=self._now, line_color=NOW, line_dash="dotted")
            self.figure.line("x", "y", source=self._now, line_color=NOW, line_width=2)
        self.figure.add_tools(HoverTool(tooltips=[("", "$x{0.000}, $y{0.0000}")]))

    def show(self, columns: Columns | None, result: Result | None) -> None:
        """Show columns of a result; nothing without columns, and no picture if it has none."""
        send = self._send
        absent = ["absent"] * (columns is None and result is not None)
        send(self.figure, css_classes=absent)
        if columns is None or result is None:
            send(self._now, data=dict(self._empty))
            return
        send(self._now, data=columns if self._is_map else _curve(columns))
        if self._is_map:
            high = float(np.nanmax(columns["image"][0], initial=1e-9))
            send(self._colors, high=high)
            send(self.figure.title, text=self._title.format(high))
            ends = iter([(columns[at][0], columns[at][0] + columns[size][0])
                         for at, size in (("x", "dw"), ("y", "dh"))])  # fmt: skip
        else:
            ends = self._ends(columns)
        for axis, (low, high) in zip((self.figure.x_range, self.figure.y_range), ends, strict=True):
            send(axis, start=low, end=high, reset_start=low, reset_end=high)
        engagement = result.engagement
        if self._name in OVER_POSITIONS and not engagement.pairs_advance:
            send(self.figure.xaxis[0], axis_label=f"{engagement.position_angle}, °")
        if self._name == "sites":
            send(self.figure.title, text=self._title.format(engagement.words_for_sites[0]))

    def _ends(self, columns: Columns) -> Iterator[tuple[float, float]]:
        """Ends of both axes around curves or bars; values on corners mean nothing."""
        for name in ("x", "y"):
            values = np.concatenate([columns[name], self._behind[name]])
            values = values[np.isfinite(values)]
            low, high = (values.min(), values.max()) if values.size else (0.0, 1.0)
            if name == "x" and self._is_bars:
                yield float(low - 0.6), float(high + 0.6)
                continue
            margin = MARGIN * (high - low) or 0.5 * abs(high) or 0.5
            if name == "y" and self._has_zero:
                low, margin = 0.0, MARGIN * high or 0.5
                yield 0.0, float(high + margin)
            else:
                yield float(low - margin), float(high + margin)

    def pin(self, columns: Columns) -> None:
        """Keep columns behind those to come."""
        if not self._is_map:
            self._behind = _curve(columns)
            self._send(self._pinned, data=self._behind)


class Bodies:
    """Both bodies at a position, with the loads on their flanks."""

    def __init__(self, send: Send) -> None:
        self.figure = empty_figure("Loaded bodies", "", "", TALL)
        self.figure.axis.visible, self.figure.grid.visible = False, False
        self.figure.min_border = self.figure.min_border_left = self.figure.min_border_bottom = 0
        self._areas = ColumnDataSource(dict(NO_AREAS))
        self.figure.patches("xs", "ys", source=self._areas, fill_color="fill", fill_alpha="alpha",
                            line_color="line", line_width=0.7)  # fmt: skip
        self.figure.x_range, self.figure.y_range = Range1d(0.0, 1.0), Range1d(0.0, 1.0)
        undistorted = CustomJS(args={"figure": self.figure}, code=UNDISTORTED)
        for name in ("inner_width", "inner_height", "tags"):
            self.figure.js_on_change(name, undistorted)
        self._shown: Window | None = None
        self._send = send

    def show(self, result: Result, p: int, shown: Window) -> None:
        """Show a position; the picture moves only with its window."""
        if self._shown is not shown:
            self._shown = shown
            (left, low), (right, high) = shown.corners.tolist()
            self._send(self.figure, tags=[left, right, low, high])
        self._send(self._areas, data=bodies_of(result, p, shown))
        self._send(self.figure, css_classes=[])
        self._send(self.figure.title, text=words_of(result, p))

    def clear(self) -> None:
        """Show nothing."""
        self._send(self._areas, data=dict(NO_AREAS))


class Trail:
    """The designs so far in two figures, with those that no other one beats in both.

    Parameters
    ----------
    send : callable
    go : callable
        Called with the values of a design that is clicked.
    """

    def __init__(self, send: Send, go: Callable[[dict[str, float]], None]) -> None:
        self.figure = empty_figure("Designs so far", "", "", TALL)
        self.figure.add_tools(TapTool())
        self._all = ColumnDataSource({"x": [], "y": [], "color": []})
        self._front = ColumnDataSource({"x": [], "y": []})
        self.figure.line("x", "y", source=self._front, color=FRONT, line_width=2)
        self.figure.scatter("x", "y", source=self._all, color="color", size=9)
        self._all.selected.on_change("indices", self._on_tap)
        self._send, self._go, self._values = send, go, list[dict[str, float]]()

    def show(self, trail: Sequence[Answer], y: str, x: str) -> None:
        """Show designs at rest; `x` and `y` are figures, which are better the smaller they are."""
        known = []
        for answer in trail:
            assert answer.result is not None
            at = (number_of(answer.result, x), number_of(answer.result, y))
            if None not in at:
                known.append((*at, dict(answer.request.values)))
        points = np.array([place[:2] for place in known], dtype=float).reshape(-1, 2)
        self._values = [values for *_, values in known]
        best = pareto(points)
        colours = [FRONT if k in best else PINNED for k in range(len(points))]
        colours[-1:] = [NOW] * bool(colours)
        columns = {"x": points[:, 0], "y": points[:, 1], "color": colours}
        self._send(self._all, data=columns)
        self._send(self._front, data={"x": points[best, 0], "y": points[best, 1]})
        self._send(self.figure, css_classes=[])
        for axis, name in ((self.figure.xaxis[0], x), (self.figure.yaxis[0], y)):
            words, unit = FIGURES.get(name, ("", ""))
            self._send(axis, axis_label=f"{words}, {unit}" if unit else words)

    def _on_tap(self, attr: str, old: Any, new: list[int]) -> None:
        if new:
            self._all.selected.indices = []
            self._go(self._values[new[0]])


def pareto(points: Floats) -> list[int]:
    """Indices of the points (n, 2) that no other one beats in both columns, by ascending x."""
    found: list[int] = []
    for k in np.lexsort((points[:, 1], points[:, 0])).tolist():
        if not found or points[k, 1] < points[found[-1], 1]:
            found.append(k)
    return found


def pictures(send: Send) -> dict[str, Picture]:
    """All pictures by name; each is shown where a result has it."""
    return {name: Picture(name, send) for name in PICTURES}


def empty_figure(title: str, x: str, y: str, height: int) -> Any:
    """A figure without ground, legible in both modes."""
    made = figure(
        title=title, x_axis_label=x, y_axis_label=y, height=height,
        sizing_mode="stretch_width", tools=[BoxZoomTool(), ResetTool(), SaveTool()],
        background_fill_alpha=0.0, border_fill_alpha=0.0,
        outline_line_color=None,  # Bokeh 3.9 strokes the last path of the drawing before with it
        toolbar_location="right", min_width=100,
        min_border_left=64, min_border_bottom=44,  # labels that grow move nothing
    )  # fmt: skip
    made.css_classes = ["absent"]  # until there are data
    made.toolbar.autohide, made.toolbar.logo, made.toolbar.active_drag = True, None, None
    made.title.text_color = INK
    made.grid.grid_line_color, made.grid.grid_line_alpha = LINES, 0.25
    for axis in made.axis:
        axis.update(axis_label_text_color=INK, major_label_text_color=INK, axis_line_color=LINES,
                     major_tick_line_color=LINES, minor_tick_line_color=None,
                     axis_label_text_font_style="normal")  # fmt: skip
    return made


def _curve(columns: Columns) -> Columns:
    """Columns with the values on corners."""
    corner = columns.get("corner")
    return {**columns, "corner": np.full(len(columns["x"]), np.nan) if corner is None else corner}
