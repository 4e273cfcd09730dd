"""Pictures of a design study: map, curves, percentiles, histogram, Pareto front."""

from __future__ import annotations

from functools import partial
from inspect import cleandoc, signature
from math import ceil, sqrt
from textwrap import fill
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
from matplotlib import rc_context
from matplotlib.collections import LineCollection
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.ticker import MaxNLocator

from flankload.plot.figures import set_title
from flankload.plot.picture import with_parameters
from flankload.plot.study_table import StudyTable, label, on_one_grid, pareto_front, unit_of
from flankload.plot.style import COLOURS, SIZE, STYLE, new_figure, png_of, short, write_pictures
from flankload.studies.robustness.samples import Samples

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    from flankload.studies.design import DesignStudy

Draw = TypeVar("Draw", bound="Callable[..., None]")

#: Inches of a panel if there are several.
PANEL = (4.6, 3.9)
#: Torques that get a panel or a line; of more, as many are chosen evenly, with both ends.
MOST_TORQUES = 6
#: Light enough for black lines and numbers on it.
TINTS = LinearSegmentedColormap.from_list("tints", ["#f3f8fb", "#a9cfe6", "#5a9fcb"])
BANDS = (("5 to 95 %", 5, 95, "#d3e5f1"), ("25 to 75 %", 25, 75, "#8fbfde"))
OTHERS = "#b5b5b5"
BEST: dict[str, Any] = {
    "marker": "*", "markersize": 14, "markeredgecolor": "white", "linestyle": "none", "zorder": 5
}  # fmt: skip
NOTHING = "no design has a value"
#: Letters of a line above the axes.
WIDEST = 78
#: Variations below this part of the values are roundoff.
LEAST_SPAN = 1e-9

#: Parameters of the functions, as in their docstrings.
PARAMETERS = {
    "axes": "matplotlib.axes.Axes",
    "study": "DesignStudy",
    "quantity": "str\n    With one number per design and torque; for bands one per position, too.",
    "quantities": "(str, str)\n    As above, along the horizontal and the vertical axis.",
    "variable": "str",
    "variables": "(str, str)\n    Along the horizontal and the vertical axis.",
    "torque": "int\n    Index of the torque.",
}


def described(draw: Draw) -> Draw:
    """Add the parameters to the docstring of a function."""
    texts = {name: PARAMETERS[name] for name in signature(draw).parameters}
    draw.__doc__ = with_parameters(cleandoc(draw.__doc__ or ""), texts)
    return draw


def study_figures(study: DesignStudy) -> dict[str, Callable[[], Figure]]:
    """Pictures that suit a study, by name; each is drawn when it is called.

    Parameters
    ----------
    study : DesignStudy

    Returns
    -------
    dict of callable
        For each quantity: `map_…` (factorial, two or more variables, over the first two) or
        `curve_…` (one variable, or each alone), and `torques_…` for several torques. For random
        and Sobol designs `bands_…` of curves over the positions and `histogram_…`. `pareto` of the
        first two quantities with one number per design.
    """
    table, kind = StudyTable(study), study.designs.kind
    names, drawn = table.variables, kind in ("random", "sobol")
    torques, figure = _chosen_torques(table.torques_Nm.shape[1]), partial(_figure, study)
    found: dict[str, Callable[[], Figure]] = {}

    def add(name: str, title: str, draw: Callable[..., None], *arguments: Any) -> None:
        found[name] = partial(figure, title, [(draw, *arguments, t) for t in torques])

    for quantity in table.numbers:
        if drawn:
            add(f"histogram_{quantity}", "Distribution", draw_histogram, quantity)
        elif kind == "factorial" and len(names) > 1:
            add(f"map_{quantity}", "Map over two variables", draw_map, quantity, names[:2])
        elif names and (kind == "one-at-a-time" or len(names) == 1):
            title = "Curve over one variable" if len(names) == 1 else "Each variable alone"
            panels = [(draw_curve, quantity, name) for name in names]
            found[f"curve_{quantity}"] = partial(figure, title, panels)
        if len(torques) > 1:
            lines = [(draw_over_torque, quantity)]
            found[f"torques_{quantity}"] = partial(figure, "Designs over the torque", lines)
    for quantity in table.curves if drawn else ():
        add(f"bands_{quantity}", "Percentiles over the positions", draw_bands, quantity)
    if len(table.numbers) > 1 and len(table.designs) > 1:
        add("pareto", "Pareto front", draw_pareto, table.numbers[:2])
    return found


def write_study(study: DesignStudy, directory: str | Path) -> tuple[Path, ...]:
    """Write the pictures that suit a study as PNG, all or none.

    Parameters
    ----------
    study : DesignStudy
    directory : path
        Created if it does not exist.

    Returns
    -------
    tuple of Path
        Names of `study_figures` with the suffix .png.

    Raises
    ------
    OSError
        If the directory cannot be created or a file cannot be written.
    """
    drawn = {f"{name}.png": png_of(figure()) for name, figure in study_figures(study).items()}
    return write_pictures(directory, drawn)


def _figure(study: DesignStudy, title: str, panels: list[tuple[Any, ...]]) -> Figure:
    """A figure with a panel for each function and its arguments; two in a row."""
    columns = min(2, len(panels))
    lines = ceil(len(panels) / columns)
    with rc_context(STYLE | {"axes.formatter.useoffset": False}):
        size = SIZE if columns == 1 else (PANEL[0] * columns, PANEL[1] * lines)
        figure = new_figure(size)
        set_title(figure, f"{short(study.name)}, {_counted(len(study.rows))}", title)
        for k, (draw, *arguments) in enumerate(panels):
            draw(figure.add_subplot(lines, columns, k + 1), study, *arguments)
        return figure


@described
def draw_map(
    axes: Axes, study: DesignStudy, quantity: str, variables: tuple[str, str], torque: int = -1
) -> None:
    """Draw a quantity over two variables: cells, contour lines over numbers, the least value.

    A failed design is an empty cell. Each cell is the least over further variables.
    """
    table = StudyTable(study)
    (xs, ys), values = table.gathered(quantity, variables)
    found = np.ma.masked_invalid(values[:, :, torque].T)
    x, y = _places(axes, "x", xs), _places(axes, "y", ys)
    axes.grid(visible=False)
    cells = axes.pcolormesh(_edges(x), _edges(y), found, cmap=TINTS, edgecolor="face", linewidth=0)
    bar = axes.figure.colorbar(cells, ax=axes)
    bar.set_label(label(quantity))
    numbers = all(isinstance(value, int | float) for value in (*xs, *ys))
    if numbers and min(found.shape) > 2 and _spread(found.compressed()):
        lines = axes.contour(x, y, found, levels=7, colors="#333333", linewidths=0.7)
        axes.clabel(lines, fontsize=8, fmt="%g")
    axes.set_xlabel(label(variables[0]))
    axes.set_ylabel(label(variables[1]))
    if found.count():
        j, i = np.unravel_index(found.argmin(), found.shape)
        text = f"least {_shown(found[j, i], quantity)} at ({_short(xs[i])}, {_short(ys[j])})"
        axes.plot(x[i], y[j], color=COLOURS[1], label=text, **BEST)
    more = len(table.variables) > 2 and study.designs.kind == "factorial"
    _key(axes, [table.torque(torque), "least over the other variables" if more else ""])


@described
def draw_curve(axes: Axes, study: DesignStudy, quantity: str, variable: str) -> None:
    """Draw a quantity over a variable, one line per torque, with the least value of each.

    A failed design is a gap. Each point is the least over further variables.
    """
    table = StudyTable(study)
    (xs,), values = table.gathered(quantity, (variable,))
    x = _places(axes, "x", xs)
    for colour, t in enumerate(_chosen_torques(values.shape[1])):
        y, text = values[:, t], table.torque(t)
        axes.plot(x, y, marker="os^Dv<"[colour], markersize=4.5, color=COLOURS[colour])
        if np.isfinite(y).any():
            k = int(np.nanargmin(y))
            text += (
                f"{': ' * bool(text)}least {_shown(y[k], quantity)} at {_shown(xs[k], variable)}"
            )
            axes.plot(x[k], y[k], label=text, color=COLOURS[colour], **BEST)
    axes.set_xlabel(label(variable))
    axes.set_ylabel(label(quantity))
    _key(axes, [])


@described
def draw_over_torque(axes: Axes, study: DesignStudy, quantity: str) -> None:
    """Draw a quantity over the torque, a line per design; the least mean is emphasised.

    A torque without a solution is a gap; such designs are not the best.
    """
    table = StudyTable(study)
    values = table.values(quantity)
    known = np.flatnonzero(np.isfinite(values).any(axis=1))
    solved = np.isfinite(values).any(axis=0)  # without load, some quantities have no value
    means = values[known][:, solved].mean(axis=1)  # NaN if a torque has no solution
    best = int(known[np.nanargmin(means)]) if np.isfinite(means).any() else None
    order = np.argsort(table.torques_Nm[known[0]]) if known.size else np.arange(0)
    lines = {int(g): np.column_stack([table.torques_Nm[g], values[g]])[order] for g in known}
    others = [line for g, line in lines.items() if g != best]
    text = _counted(len(others), "design" if best is None else "other design") if others else None
    axes.add_collection(LineCollection(others, colors=OTHERS, linewidths=0.8, label=text))
    if best is not None:
        text = fill(f"least mean: {table.design(best)}", WIDEST)
        look: dict[str, Any] = {"marker": "o", "markersize": 5, "linewidth": 2.4, "zorder": 4}
        axes.plot(*lines[best].T, color=COLOURS[0], label=text, **look)
    axes.autoscale_view()
    axes.set_xlabel("torque in N m")
    axes.set_ylabel(label(quantity))
    _key(axes, [])


@described
def draw_bands(axes: Axes, study: DesignStudy, quantity: str, torque: int = -1) -> None:
    """Draw percentiles of a curve over the positions: 5, 25, 50, 75 and 95 % of the designs.

    Curves of other positions than those of the first solved design are interpolated linearly.
    Failed designs count as in `Samples`; a band that ends among them is left out.
    """
    table = StudyTable(study)
    curves = table.values(quantity)[:, torque]
    angles = np.degrees(table.values("position_rad")[:, torque])
    solved = np.isfinite(curves).any(axis=1)
    axes.set_xlabel("angle of body 1 in degrees")
    axes.set_ylabel(label(quantity))
    if not solved.any():
        return _key(axes, [table.torque(torque), NOTHING])
    place, found = on_one_grid(angles[solved], curves[solved])
    failed = [np.nan] * int((~solved).sum())
    # a curve that ends before others is no failure beyond its end
    samples = [Samples(np.append(values[np.isfinite(values)], failed)) for values in found.T]
    for text, *percents, colour in BANDS:
        ends = np.array([[at.percentile(percent) for at in samples] for percent in percents])
        if np.isfinite(ends).all(axis=0).any():
            axes.fill_between(place, *ends, color=colour, linewidth=0, label=text)
    middle = np.array([at.percentile(50) for at in samples])
    if np.isfinite(middle).any():
        axes.plot(place, middle, color=COLOURS[0], label="median")
    axes.margins(x=0)
    return _key(axes, [table.torque(torque), _solved(solved)], columns=3)


@described
def draw_histogram(axes: Axes, study: DesignStudy, quantity: str, torque: int = -1) -> None:
    """Draw how many designs have which value, with percentiles.

    Failed designs count as in `Samples`; a percentile among them has no line.
    """
    table = StudyTable(study)
    values = table.values(quantity)[:, torque]
    known = values[np.isfinite(values)]
    axes.set_xlabel(label(quantity))
    axes.set_ylabel("designs")
    if not known.size:
        return _key(axes, [table.torque(torque), NOTHING])
    middle, scale = float(known.mean()), float(abs(known).max()) or 1.0
    ends = None if _spread(known) else (middle - 0.01 * scale, middle + 0.01 * scale)
    counts, edges = np.histogram(known, min(40, max(5, ceil(sqrt(known.size)))), ends)
    axes.stairs(counts, edges, fill=True, facecolor=BANDS[1][3], edgecolor="white", linewidth=0.5)
    samples = Samples(values)
    for percents, line in (((50,), "-"), ((25, 75), (0, (5, 2))), ((5, 95), (0, (1, 1.5)))):
        places = [float(samples.percentile(p)) for p in percents]
        text = " and ".join(f"{p} %" for p in percents) if len(percents) > 1 else "median"
        text += ": " + ", ".join(_short(x) if np.isfinite(x) else "failed" for x in places)
        look: dict[str, Any] = {"color": COLOURS[0], "linestyle": line, "linewidth": 1.6}
        axes.plot([], [], label=text, **look)
        for place in filter(np.isfinite, places):
            axes.axvline(place, **look)
    axes.xaxis.set_major_locator(MaxNLocator(6))
    axes.yaxis.set_major_locator(MaxNLocator(integer=True))
    return _key(axes, [table.torque(torque), _solved(np.isfinite(values))])


@described
def draw_pareto(
    axes: Axes, study: DesignStudy, quantities: tuple[str, str], torque: int = -1
) -> None:
    """Draw designs as dots over two quantities, with the front of those that none surpasses.

    Less is better in both. Right of and above the stepped line, another design is better.
    """
    table = StudyTable(study)
    points = np.column_stack([table.values(name)[:, torque] for name in quantities])
    points = points[np.isfinite(points).all(axis=1)]
    front = points[pareto_front(points)]
    axes.plot(*points.T, "o", color=OTHERS, markersize=4.5, label=_counted(len(points)))
    look: dict[str, Any] = {"color": COLOURS[1], "marker": "o", "markersize": 6, "linewidth": 1.6}
    text = f"Pareto front, {_counted(len(front))}" if len(front) > 1 else "best in both"
    if front.size:
        axes.plot(*front.T, drawstyle="steps-post", label=text, **look)
    axes.set_xlabel(f"{label(quantities[0])}\n(less is better)")
    axes.set_ylabel(f"{label(quantities[1])}\n(less is better)")
    _key(axes, [table.torque(torque)], columns=2)


def _key(axes: Axes, heads: list[str], columns: int = 1) -> None:
    """Names of lines above the axes, where nothing is drawn, after a line of words."""
    axes.legend(
        *axes.get_legend_handles_labels(),
        loc="lower left",
        bbox_to_anchor=(0.0, 1.0),
        borderaxespad=0.2,
        frameon=False,
        fontsize=9,
        ncols=columns,
        title=", ".join(head for head in heads if head),
        title_fontsize=9,
        alignment="left",
    )


def _chosen_torques(torques: int) -> list[int]:
    """Indices of the torques that are drawn."""
    count = min(torques, MOST_TORQUES)
    return sorted({round(k) for k in np.linspace(0, torques - 1, count)})


def _places(axes: Axes, side: str, values: list[Any]) -> NDArray[np.float64]:
    """Places of values on an axis; text is placed in its order and named at the axis."""
    if not any(isinstance(value, str) for value in values):
        return np.array(values, dtype=float)
    axis = axes.xaxis if side == "x" else axes.yaxis
    axis.set_ticks(range(len(values)), [short(value) for value in values])
    return np.arange(len(values), dtype=float)


def _edges(places: NDArray[np.float64]) -> NDArray[np.float64]:
    """Edges (n + 1,) of cells around places (n,)."""
    if places.size == 1:
        return places[0] + np.array([-0.5, 0.5])
    middle = 0.5 * (places[1:] + places[:-1])
    ends = (2 * places[0] - middle[0], 2 * places[-1] - middle[-1])
    return np.array([ends[0], *middle, ends[1]])


def _spread(values: NDArray[np.float64]) -> bool:
    """Whether values differ by more than roundoff."""
    return bool(values.size) and bool(np.ptp(values) > LEAST_SPAN * abs(values).max())


def _solved(solved: NDArray[np.bool_]) -> str:
    failed = int((~solved).sum())
    return _counted(int(solved.sum())) + (f", {failed} without a value" if failed else "")


def _counted(count: int, name: str = "design") -> str:
    return f"{count} {name}" + "s" * (count != 1)


def _short(value: Any) -> str:
    """Four digits; no powers of ten in numbers of common size."""
    if not isinstance(value, int | float):
        return short(value)
    if value and not 1e-4 < abs(value) < 1e7:
        return f"{value:.4g}"
    return str(np.format_float_positional(value, precision=4, fractional=False, trim="-"))


def _shown(value: Any, name: str) -> str:
    return f"{_short(value)} {unit_of(name)}".rstrip()
