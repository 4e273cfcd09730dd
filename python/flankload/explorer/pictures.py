"""The pictures of a page: curves, bars and maps with their sources, the bodies, the trail."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from bokeh.models import (
    BoxZoomTool,
    ColorBar,
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

from flankload.explorer.tables import FIGURES, number_of

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from flankload.base.arrays import Floats
    from flankload.explorer.worker import Answer
    from flankload.result import Result

    Columns = dict[str, Any]

#: Colours that are legible on light and on dark ground.
NOW, PINNED, INK, LINES = "#2f86d1", "#98a0a8", "#7b848d", "#8a939c"
BODIES, LOAD, FRONT = ("#7fa7c9", "#c9a67f"), "#e0352b", "#e08214"
#: Height of a picture and of the bodies, pixels.
HEIGHT, TALL = 220, 330
#: Title, and labels of both axes, of each picture.
PICTURES = {
    "error": ("Transmission error", "angle, °", "µm"),
    "share": ("Load share", "place in mesh pitches from the pitch point", "%"),
    "sites": ("Force of each tooth, at the largest one", "number", "N"),
    "pressure": ("Largest pressure", "place in mesh pitches from the pitch point", "MPa"),
    "spectrum": ("Spectrum of the transmission error", "mesh order", "µm"),
    "pattern": ("Contact pattern, body 1, MPa", "axial position, mm", "diameter, mm"),
    "line_load": ("Line load, N/mm", "place in mesh pitches", "axial position, mm"),
}
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
#: Columns of a curve without points, and of a map without values.
NO_CURVE: Columns = {"x": [], "y": [], "corner": []}
NO_MAP: Columns = {"image": [], "x": [], "y": [], "dw": [], "dh": []}


class Picture:
    """Curves, bars or a map, with those of the pinned design behind."""

    def __init__(self, name: str) -> None:
        title, x, y = PICTURES[name]
        self.figure = empty_figure(title, x, y, HEIGHT)
        self._is_map, self._is_bars, self._name = name in MAPS, name in BARS, name
        empty = NO_MAP if self._is_map else NO_CURVE
        self._now, self._pinned = ColumnDataSource(dict(empty)), ColumnDataSource(dict(empty))
        if self._is_map:
            self._colors = LinearColorMapper(palette="Inferno256", low=0.0, high=1.0,
                                             nan_color="rgba(0, 0, 0, 0)")  # fmt: skip
            self.figure.image("image", x="x", y="y", dw="dw", dh="dh", source=self._now,
                              color_mapper=self._colors)  # fmt: skip
            self.figure.add_layout(
                ColorBar(color_mapper=self._colors, width=8, background_fill_alpha=0.0,
                         major_label_text_color=INK), "right",
            )  # fmt: skip
        elif self._is_bars:
            self.figure.vbar(x="x", top="y", width=0.8, source=self._pinned, color=PINNED,
                             fill_alpha=0.4, line_alpha=0.0)  # fmt: skip
            self.figure.vbar(x="x", top="y", width=0.45, source=self._now, color=NOW)
        else:
            look = {"line_color": PINNED, "line_width": 2.5, "line_alpha": 0.8}
            behind = self.figure.line("x", "y", source=self._pinned, **look)
            self.figure.line("x", "corner", source=self._now, line_color=NOW, line_dash="dotted")
            now = self.figure.line("x", "y", source=self._now, line_color=NOW, line_width=2)
            self.figure.y_range.renderers = [behind, now]  # values on corners mean nothing
        if not self._is_map and name != "error":
            self.figure.y_range.start = 0.0
        if not self._is_map:
            self.figure.add_tools(HoverTool(tooltips=[("", "$x{0.000}, $y{0.0000}")]))

    def show(self, columns: Columns | None, result: Result | None) -> None:
        """Show columns of a result; nothing without columns, and no picture if it has none."""
        absent = ["absent"] if columns is None and result is not None else []
        if self.figure.css_classes != absent:
            self.figure.css_classes = absent
        empty = NO_MAP if self._is_map else NO_CURVE
        if columns is None:
            self._now.data = dict(empty)
            return
        if self._is_map:
            self._colors.high = float(np.nanmax(columns["image"][0], initial=1e-9))
        self._now.data = columns if self._is_map else _curve(columns)
        if result is not None and not result.engagement.pairs_advance:
            self.figure.xaxis.axis_label = f"{result.engagement.position_angle}, °"

    def pin(self, columns: Columns) -> None:
        """Keep columns behind those to come."""
        if not self._is_map:
            self._pinned.data = _curve(columns)


class Bodies:
    """Both bodies at a position, with the loads on their flanks."""

    def __init__(self) -> None:
        self.figure = empty_figure("Loaded bodies", "mm", "", TALL)
        self._areas = [ColumnDataSource({"x": [], "y": []}) for _ in BODIES]
        self._edges = ColumnDataSource({"x": [], "y": []})
        self._loads = ColumnDataSource({"xs": [], "ys": []})
        for source, colour in zip(self._areas, BODIES, strict=True):
            self.figure.patch("x", "y", source=source, color=colour, fill_alpha=0.45,
                              line_alpha=0.0)  # fmt: skip
        self.figure.line("x", "y", source=self._edges, color=INK)
        self.figure.patches("xs", "ys", source=self._loads, color=LOAD, fill_alpha=0.8)
        self.figure.x_range, self.figure.y_range = Range1d(0.0, 1.0), Range1d(0.0, 1.0)
        undistorted = CustomJS(args={"figure": self.figure}, code=UNDISTORTED)
        for name in ("inner_width", "inner_height"):
            self.figure.js_on_change(name, undistorted)
        self.figure.y_range.js_on_change("end", undistorted)
        self._corners: Floats | None = None

    def show(self, found: dict[str, Columns], corners: Floats, degrees: float) -> None:
        """Show the columns of `bodies_of`; the window moves only with its corners."""
        if self._corners is None or not np.array_equal(corners, self._corners):
            self._corners = corners
            (left, low), (right, high) = corners
            self.figure.x_range.update(start=left, end=right)
            self.figure.y_range.update(start=low, end=high)
            self.figure.tags = [left, right, low, high]
        for z, source in enumerate(self._areas, start=1):
            source.data = found.get(f"body_{z}", {"x": [], "y": []})
        self._edges.data, self._loads.data = found["edges"], found["loads"]
        self.figure.title.text = f"Loaded bodies at {degrees:.2f}°"

    def clear(self) -> None:
        """Show nothing."""
        for source in (*self._areas, self._edges):
            source.data = {"x": [], "y": []}
        self._loads.data = {"xs": [], "ys": []}


class Trail:
    """The designs so far in two figures, with those that no other one beats in both.

    Parameters
    ----------
    go : callable
        Called with the values of a design that is clicked.
    """

    def __init__(self, go: Callable[[dict[str, float]], None]) -> None:
        self.figure = empty_figure("Designs so far", "", "", TALL)
        self.figure.add_tools(TapTool())
        self._all = ColumnDataSource({"x": [], "y": [], "color": []})
        self._front = ColumnDataSource({"x": [], "y": []})
        self.figure.line("x", "y", source=self._front, color=FRONT, line_width=2)
        self.figure.scatter("x", "y", source=self._all, color="color", size=9)
        self._go, self._values = go, list[dict[str, float]]()
        self._all.selected.on_change("indices", self._on_tap)

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
        self._all.data = {"x": points[:, 0], "y": points[:, 1], "color": colours}
        self._front.data = {"x": points[best, 0], "y": points[best, 1]}
        for axis, name in ((self.figure.xaxis, x), (self.figure.yaxis, y)):
            words, unit = FIGURES.get(name, ("", ""))
            axis.axis_label = f"{words}, {unit}" if unit else words

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


def pictures() -> dict[str, Picture]:
    """All pictures by name; each is shown where a result has it."""
    return {name: Picture(name) for name in PICTURES}


def empty_figure(title: str, x: str, y: str, height: int) -> Any:
    """A figure without ground, legible in both modes."""
    made = figure(
        title=title, x_axis_label=x, y_axis_label=y, height=height,
        sizing_mode="stretch_width", tools=[BoxZoomTool(), ResetTool(), SaveTool()],
        background_fill_alpha=0.0, border_fill_alpha=0.0, outline_line_color=LINES,
        outline_line_alpha=0.5, toolbar_location="right", min_width=100,
        min_border_left=64, min_border_bottom=44,  # labels that grow move nothing
    )  # fmt: skip
    made.css_classes = ["absent"]  # until there are data: axes without any leave marks behind
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
