"""Error over CPU seconds for each discretization parameter, and the Pareto front of all runs."""

from __future__ import annotations

from math import ceil
from typing import TYPE_CHECKING, Any

from matplotlib import rc_context
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from flankload.plot.figures import note
from flankload.plot.style import COLOURS, GREY, STYLE, new_figure, png_of, short, write_pictures
from flankload.studies.accuracy.quantities import MEANINGS
from flankload.studies.accuracy.study_text import GROUPS, NAMED, PARAMETER_LABELS

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from matplotlib.axes import Axes

    from flankload.studies.accuracy import AccuracyStudy, Row

    Points = list[tuple[float, float]]

#: Size of a panel, inches.
PANEL = (4.6, 3.5)
#: Smaller errors are roundoff, or the reference itself, and are not drawn.
LEAST_ERROR = 1e-7
LEAST_SHOWN = 1e-6
#: The upper edge of this shaded area is the uncertainty of the reference.
SHADE = "#ececec"
#: Colour and mark of each parameter; cells and slices never meet.
LOOKS = {
    parameter: (COLOURS[colour], mark)
    for parameter, colour, mark in zip(
        PARAMETER_LABELS, (0, 1, 2, 3, 2, 3, 5, 4), "osD^h<>v", strict=True
    )
}
LEVEL_MARKS = {"lumped": "P", "nodes": "X", "plane": "d", "coarse": "p", "default": "*"}
TITLES = {
    "transmission_error": "Transmission error",
    "transmission_error_mean": "Its mean",
    "transmission_error_peak_to_peak": "Its peak to peak",
    "load_share": "Load share",
    "peak_pressure": "Peak pressure off corners",
    "stiffness": "Stiffness",
    "face_load_factor": "Face load factor",
}


def plot_work_precision(study: AccuracyStudy) -> Figure:
    """A panel per error quantity: a curve per parameter, the Pareto front, tolerances, uncertainty.

    The curve of a parameter is its own error over the seconds of a run with the other parameters at
    their default; all other points are whole errors of runs. The shaded area is the uncertainty of
    the limit itself.

    Parameters
    ----------
    study : AccuracyStudy

    Returns
    -------
    matplotlib.figure.Figure
    """
    names = [m for m in study.measures if any(m in row.errors for row in study.rows)]
    names = names or list(study.measures[:1])
    columns = min(2, len(names))
    lines = ceil(len(names) / columns)
    with rc_context(STYLE):
        figure = new_figure((PANEL[0] * columns, PANEL[1] * lines + 0.9))
        panels = figure.subplots(lines, columns, squeeze=False, sharex=True)
        for axes, name in zip(panels.flat, names, strict=False):
            _panel(axes, study, name)
        for axes in panels.flat[len(names) :]:
            axes.set_visible(False)
        for axes in panels[-1]:
            axes.set_xlabel("CPU seconds of a run")
        title = f"{short(study.name)}: error over CPU seconds"
        figure.suptitle(title, x=0.01, ha="left", fontsize=11)
        figure.legend(handles=_legend(study), loc="outside lower center", ncols=4)
        return figure


def write_work_precision(study: AccuracyStudy, directory: str | Path) -> Path:
    """Write the plot.

    Parameters
    ----------
    study : AccuracyStudy
    directory : path
        Created if it does not exist.

    Returns
    -------
    Path
        work_precision.png.
    """
    drawn = {"work_precision.png": png_of(plot_work_precision(study))}
    return write_pictures(directory, drawn)[0]


def _panel(axes: Axes, study: AccuracyStudy, name: str) -> None:
    axes.set_title(TITLES[name])
    axes.loglog()
    axes.set_ylim(LEAST_SHOWN, 1.0)
    axes.set_ylabel("relative error")
    look: dict[str, Any] = {"ha": "right", "va": "top", "fontsize": 7}
    note(axes, MEANINGS[name], (0.99, 0.98), "axes fraction", **look)
    doubt = min(1.0, max(LEAST_SHOWN, study.doubts.get(name, 0.0)))
    axes.axhspan(LEAST_SHOWN, doubt, color=SHADE, zorder=0)
    for tolerance in NAMED:
        axes.axhline(tolerance, color=GREY, linewidth=0.7, linestyle=":")
    axes.axhline(study.tolerance, color=GREY, linewidth=1.2, linestyle=(0, (6, 3)))
    for parameter, (colour, mark) in LOOKS.items():
        look = {"color": colour, "marker": mark}
        even, adaptive = _ladder(study, parameter, name)
        _points(axes, even, linestyle="-", **look)
        _points(axes, adaptive, markerfacecolor="white", **look)
    _points(axes, _errors(study.rows, name), color="#bbbbbb", marker=".", zorder=1)
    front = {"linestyle": "-", "linewidth": 1.2}
    _points(axes, _errors(study.front(name), name), color="black", marker=".", **front)
    for level, mark in LEVEL_MARKS.items():
        rows = [row for row in study.rows if row.group == level]
        _points(axes, _errors(rows, name), color="black", marker=mark, markersize=8)
    axes.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    for axis in (axes.xaxis, axes.yaxis):  # other formatters write powers as formulas
        axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        axis.set_minor_formatter(NullFormatter())


def _ladder(study: AccuracyStudy, parameter: str, name: str) -> tuple[Points, Points]:
    """Even and adaptive steps: seconds with the others at default, error of this parameter."""
    parts: tuple[Points, Points] = ([], [])
    for row in study.steps.get(parameter, ()):
        seconds, error = study.seconds_at_default(row, parameter), row.alone.get(name)
        if seconds is not None and error is not None:
            parts[row.run.discretization.adaptive is not None].append((seconds, error))
    return sorted(parts[0]), sorted(parts[1])


def _errors(rows: Sequence[Row], name: str) -> Points:
    return [(row.run.cpu_s, row.errors[name]) for row in rows if name in row.errors]


def _points(axes: Axes, points: Points, **style: Any) -> None:
    """Seconds and errors, without errors that are roundoff."""
    known = [(x, y) for x, y in points if y > LEAST_ERROR]
    if known:
        seconds, errors = zip(*known, strict=True)
        look: dict[str, Any] = {"linestyle": "none", "markersize": 5, "linewidth": 1.4}
        axes.plot(seconds, errors, **(look | style))


def _legend(study: AccuracyStudy) -> list[Line2D]:
    groups = {row.group for row in study.rows}
    looks: list[tuple[str, dict[str, Any]]] = [
        (PARAMETER_LABELS[parameter], {"color": colour, "marker": mark, "markersize": 5})
        for parameter, (colour, mark) in LOOKS.items()
        if study.steps.get(parameter)
    ]
    if any(row.run.discretization.adaptive is not None for row in study.steps.get("count", ())):
        colour, mark = LOOKS["count"]
        hollow = {"color": colour, "marker": mark, "markerfacecolor": "white"}
        looks.append(("adaptive positions", {**hollow, "linestyle": "none"}))
    for level, mark in LEVEL_MARKS.items():
        if level in groups:
            alone = {"color": "black", "marker": mark, "linestyle": "none"}
            looks.append((GROUPS[level], alone))
    tolerance = {"color": GREY, "linestyle": (0, (6, 3)), "linewidth": 1.2}
    looks += [
        ("Pareto front", {"color": "black", "marker": ".", "linewidth": 1.2}),
        (f"tolerance of the scene, {study.tolerance:g}", tolerance),
        ("uncertainty of the limit", {"color": SHADE, "linewidth": 8}),
    ]
    return [Line2D([], [], label=label, **({"linewidth": 1.4} | look)) for label, look in looks]
