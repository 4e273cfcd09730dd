"""The pictures of a page: curves, bars and maps with their sources, and the trail of designs."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from bokeh.models import (
    BoxZoomTool,
    ColumnDataSource,
    HoverTool,
    LinearColorMapper,
    Range1d,
    ResetTool,
    SaveTool,
    TapTool,
)
from bokeh.plotting import figure

from flankload.explorer.tables import label_of, number_of
from flankload.plot.study_table import pareto_front

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from flankload.explorer.worker import Answer
    from flankload.result import Result

    Columns = dict[str, Any]
    #: Called with a model and its new properties, which a page sends together.
    Send = Callable[..., None]

#: Colours that are legible on light and on dark ground.
NOW, PINNED, FRONT, LINES, INK = "#2f86d1", "#98a0a8", "#e08214", "#8a939c", "#7b848d"
#: Height of a picture and of the trail, pixels.
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
BARS, MAPS = ("sites", "spectrum"), ("pattern", "line_load")
#: Pictures over the angle of the position, where pairs do not advance.
OVER_POSITIONS = ("error", "share", "pressure", "line_load")
#: Space beside curves, as part of their range; beside the middle of the outer bars.
MARGIN, BESIDE = 0.1, 0.6
#: Columns of a curve without points, and of a map without values.
NO_CURVE: Columns = {"x": [], "y": [], "corner": []}
NO_MAP: Columns = {"image": [], "x": [], "y": [], "dw": [], "dh": []}


class Picture:
    """Curves, bars or a map, with those of the pinned design behind.

    Ranges are set with the data: those that follow the data draw each picture twice.
    """

    def __init__(self, name: str, send: Send) -> None:
        self._name, self._send = name, send
        self._title, x, y = PICTURES[name]
        self.figure = empty_figure(self._title, x, y, HEIGHT)
        self._empty = NO_MAP if name in MAPS else NO_CURVE
        self._behind = self._empty
        self._now, self._pinned = (ColumnDataSource(dict(self._empty)) for _ in range(2))
        if name in MAPS:
            self._colors = LinearColorMapper(palette="Inferno256", low=0.0, high=1.0,
                                             nan_color="rgba(0, 0, 0, 0)")  # fmt: skip
            self.figure.image("image", x="x", y="y", dw="dw", dh="dh", source=self._now,
                              color_mapper=self._colors)  # fmt: skip
            return
        if name in BARS:
            self.figure.xaxis[0].ticker.min_interval = 1
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
        """Show columns of a result; no picture without columns, no curves without a result."""
        send = self._send
        send(self._now, data=columns or dict(self._empty))
        if result is not None:
            send(self.figure, css_classes=["absent"] * (columns is None))
        if columns is None or result is None:
            return
        engagement, (x, y) = result.engagement, (self.figure.x_range, self.figure.y_range)
        words: Any = engagement.words_for_sites[0]
        if self._name in MAPS:
            words = float(np.nanmax(columns["image"][0], initial=1e-9))
            send(self._colors, high=words)
        send(self.figure.title, text=self._title.format(words))
        for axis, name in ((x, "x"), (y, "y")):
            low, high = self._ends(columns, name)
            send(axis, start=low, end=high, reset_start=low, reset_end=high)
        if self._name in OVER_POSITIONS and not engagement.pairs_advance:
            send(self.figure.xaxis[0], axis_label=f"{engagement.position_angle}, °")

    def _ends(self, columns: Columns, name: str) -> tuple[float, float]:
        """Ends of an axis around curves, bars or a map; on corners if there are no other values."""
        if self._name in MAPS:
            (low,), (size,) = columns[name], columns[f"d{'w' if name == 'x' else 'h'}"]
            return low, low + size
        has_values = np.isfinite(columns[name]).any()
        values = np.concatenate([columns[name if has_values else "corner"], self._behind[name]])
        values = values[np.isfinite(values)]
        low, high = (float(values.min()), float(values.max())) if values.size else (0.0, 1.0)
        if name == "x" and self._name in BARS:
            return low - BESIDE, high + BESIDE
        if name == "y" and self._name != "error":
            return 0.0, (1.0 + MARGIN) * high or 0.5
        margin = MARGIN * (high - low) or 0.5 * abs(high) or 0.5
        return low - margin, high + margin

    def pin(self, columns: Columns) -> None:
        """Keep columns behind those to come."""
        if self._name not in MAPS:
            self._behind = columns
            self._send(self._pinned, data=columns)


class Trail:
    """The designs so far in two figures, with those that no other one beats in both.

    Parameters
    ----------
    send : callable
    go : callable
        Called with the values of a design that is clicked.
    """

    def __init__(self, send: Send, go: Callable[[dict[str, float]], None]) -> None:
        self.figure = empty_figure("Designs so far", "", "", TALL, fixed=False)
        self.figure.add_tools(TapTool())
        self._all = ColumnDataSource({"x": [], "y": [], "color": []})
        self._front = ColumnDataSource({"x": [], "y": []})
        self.figure.line("x", "y", source=self._front, color=FRONT, line_width=2)
        self.figure.scatter("x", "y", source=self._all, color="color", size=9)
        self._all.selected.on_change("indices", self._on_tap)
        self._send, self._go, self._values = send, go, list[dict[str, float]]()

    def show(self, trail: Sequence[Answer], y: str, x: str) -> None:
        """Show designs at rest; `x` and `y` are figures, which are better the smaller they are."""
        known = [
            (at, dict(answer.request.values))
            for answer in trail
            if answer.result is not None
            and None not in (at := (number_of(answer.result, x), number_of(answer.result, y)))
        ]
        points = np.array([at for at, _ in known], dtype=float).reshape(-1, 2)
        self._values = [values for _, values in known]
        best = pareto_front(points)
        colors = np.where(np.isin(np.arange(len(points)), best), FRONT, PINNED).tolist()
        colors[-1:] = [NOW] * bool(colors)
        self._send(self._all, data={"x": points[:, 0], "y": points[:, 1], "color": colors})
        self._send(self._front, data={"x": points[best, 0], "y": points[best, 1]})
        self._send(self.figure, css_classes=[])
        for axis, name in ((self.figure.xaxis[0], x), (self.figure.yaxis[0], y)):
            self._send(axis, axis_label=label_of(name))

    def _on_tap(self, attr: str, old: Any, new: list[int]) -> None:
        if new:
            self._all.selected.indices = []
            self._go(self._values[new[0]])


def empty_figure(title: str, x: str, y: str, height: int, *, fixed: bool = True) -> Any:
    """A figure without ground, legible in both modes; its ranges are set or follow the data."""
    ranges = {"x_range": Range1d(), "y_range": Range1d()} if fixed else {}
    made = figure(
        title=title, x_axis_label=x, y_axis_label=y, height=height, **ranges,
        sizing_mode="stretch_width", tools=[BoxZoomTool(), ResetTool(), SaveTool()],
        background_fill_alpha=0.0, border_fill_alpha=0.0,
        outline_line_color=None,  # Bokeh 3.9 strokes the last path of the drawing before with it
        toolbar_location="right", min_width=100,
        min_border_left=64, min_border_bottom=44,  # labels that grow move nothing
        html_attributes={"role": "figure", "aria-label": title.partition(":")[0]},
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
