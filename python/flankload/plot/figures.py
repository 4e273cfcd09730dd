"""Figures of a result: titles, margins that fit, labels of curves, one panel or several."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.transforms import offset_copy

from flankload.plot.style import (
    GREY,
    SIZE,
    STYLE,
    Picture,
    missing_letters_are_boxes,
    short,
    torque_colours,
)
from flankload.result.quantities import torques_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from flankload.result import Result

#: Space around a figure, and above it for a title of the whole figure, inches.
PAD, TITLE = 0.08, 0.34
#: Distance of a legend from the horizontal axis above it, points: below tick labels and label.
LEGEND_BELOW = 36.0
#: Names up to this number of torques are listed in a title.
MOST_TORQUES = 4
#: White behind a text.
BOX = {"facecolor": "white", "edgecolor": "none"}
#: Mark of a label of a curve, for `spread_labels`.
CURVE_LABEL = "label of a curve"


def as_results(results: Result | Sequence[Result]) -> tuple[Result, ...]:
    """Results by ascending torque, each of one torque."""
    return tuple(sorted(torques_of(results), key=lambda result: result.torque_Nm))


def heaviest(results: Result | Sequence[Result]) -> Result:
    """The result of the largest torque."""
    return as_results(results)[-1]


def empty_figure(size: tuple[float, float] = SIZE) -> Figure:
    """Figure on an Agg canvas without a layout engine: `fit` sets its margins."""
    # the resolution of the file: texts are measured once
    return Picture(figsize=size, dpi=STYLE["savefig.dpi"])


def set_title(figure: Figure, words: str, title: str) -> None:
    """Title on the left, words (name and torques) on the right."""
    figure.suptitle(title, x=0.01, ha="left", fontsize=11, fontweight="bold")
    figure.text(0.99, 0.985, words, ha="right", va="top", fontsize=9, color=GREY)


def subtitle(results: Result | Sequence[Result]) -> str:
    """Name and torques."""
    shown = as_results(results)
    return f"{short(shown[0].name)}, {torque_words(shown)}"


def torque_words(results: Sequence[Result]) -> str:
    """The torques, or their range if there are many."""
    torques = [f"{result.torque_Nm:g}" for result in results]
    if len(torques) > MOST_TORQUES:
        return f"{len(torques)} torques, {torques[0]} to {torques[-1]} N m"
    return f"{', '.join(torques)} N m"


def fit(figure: Figure) -> None:
    """Set the margins and distances of all panels so that their texts fit.

    One pass: text sizes do not depend on the size of a panel. (A layout engine of matplotlib
    needs the time of two more drawings.)
    """
    width, height = figure.get_size_inches()
    with missing_letters_are_boxes():
        shape, reach = _reach(figure)
    above = TITLE if figure.get_suptitle() else 0.0
    left, right = reach.get(("left", 0), PAD), reach.get(("right", shape[1]), PAD)
    top, bottom = above + reach.get(("top", 0), PAD), reach.get(("bottom", shape[0]), PAD)
    across = _gap(reach, "right", "left", shape[1])
    down = _gap(reach, "bottom", "top", shape[0])
    figure.subplots_adjust(
        left=left / width,
        right=1.0 - right / width,
        top=1.0 - top / height,
        bottom=bottom / height,
        wspace=_part(across, width - left - right, shape[1]),
        hspace=_part(down, height - top - bottom, shape[0]),
    )
    for axes in figure.axes:
        spread_labels(axes)


def _reach(figure: Figure) -> tuple[tuple[int, int], dict[tuple[str, int], float]]:
    """Rows and columns of the panels; inches that texts need on each side of each row or column."""
    renderer = figure.canvas.get_renderer()  # type: ignore[attr-defined]
    width, height = figure.get_size_inches()
    shape = (1, 1)
    reach: dict[tuple[str, int], float] = {}
    for axes in figure.axes:
        if (spec := axes.get_subplotspec()) is None:
            continue
        cell = spec.get_topmost_subplotspec()
        shape = cell.get_gridspec().nrows, cell.get_gridspec().ncols
        inside = cell.get_position(figure)
        box = axes.get_tightbbox(renderer, bbox_extra_artists=_outside(axes))
        if box is None:
            continue
        x0, y0, x1, y1 = np.array(box.extents) / figure.dpi
        for side, place, beyond in (
            ("left", cell.colspan.start, inside.x0 * width - x0),
            ("right", cell.colspan.stop, x1 - inside.x1 * width),
            ("top", cell.rowspan.start, y1 - inside.y1 * height),
            ("bottom", cell.rowspan.stop, inside.y0 * height - y0),
        ):
            reach[side, place] = max(beyond + PAD, reach.get((side, place), PAD))
    return shape, reach


def _outside(axes: Axes) -> list[Artist]:
    """Objects that may lie outside the panel beside its axes and titles."""
    legend = axes.get_legend()
    labels = [text for text in axes.texts if text.get_gid() == CURVE_LABEL]
    return [*axes.child_axes, *labels, *([legend] if legend is not None else [])]


def _gap(reach: dict[tuple[str, int], float], before: str, after: str, count: int) -> float:
    """Largest distance that two neighbouring panels need, inches."""
    between = range(1, count)
    return max((reach.get((before, k), 0) + reach.get((after, k), 0) for k in between), default=0.0)


def _part(gap: float, whole: float, count: int) -> float:
    """A distance as part of the mean size of a panel, as `subplots_adjust` expects it."""
    return gap * count / max(whole - gap * (count - 1), 0.1 * whole)


def legend_below(axes: Axes, *handles_and_labels: Any, **options: Any) -> None:
    """A legend below the label of the horizontal axis, where it covers nothing."""
    figure: Any = axes.figure
    below = offset_copy(axes.transAxes, figure, y=-LEGEND_BELOW, units="points")
    axes.legend(
        *handles_and_labels,
        loc="upper center",
        bbox_to_anchor=(0.5, 0.0),
        bbox_transform=below,
        borderaxespad=0.0,
        **options,
    )


def note(
    axes: Axes,
    text: str,
    place: tuple[float, float],
    coords: Any = "data",
    offset: tuple[float, float] = (0.0, 0.0),
    **look: Any,
) -> None:
    """A small grey text at a place, moved by an offset in points.

    The coordinates of the place are "data", "axes fraction", or one of them for each direction.
    """
    usual: dict[str, Any] = {"textcoords": "offset points", "fontsize": 9, "color": GREY}
    axes.annotate(text, place, xytext=offset, xycoords=coords, **(usual | look))


def label_curves(
    axes: Axes, heights: Sequence[float], texts: Sequence[str], colours: Sequence[Any]
) -> None:
    """A label for each curve at the right of the panel, in its colour and near its height.

    The axes have their final limits; heights are values on the vertical axis.
    """
    coords = ("axes fraction", "data")
    look: dict[str, Any] = {"va": "center", "linespacing": 1.15, "annotation_clip": False}
    for height, text, colour in zip(heights, texts, colours, strict=True):
        place, offset = (1.0, height), (5.0, 0.0)
        note(axes, text, place, coords, offset, color=colour, gid=CURVE_LABEL, **look)
    spread_labels(axes)


def label_torques(
    axes: Axes, results: Sequence[Result], heights: Sequence[float], notes: Sequence[str] = ()
) -> None:
    """A label for the curve of each torque, in its colour, and a note below it."""
    names = [f"{result.torque_Nm:g} N m" for result in results]
    texts = ["\n".join(lines) for lines in zip(names, *[notes] * bool(notes), strict=True)]
    label_curves(axes, heights, texts, torque_colours(len(results)))


def spread_labels(axes: Axes) -> None:
    """Move the labels of curves apart, by no more than necessary, within the panel's height."""
    labels: list[Any] = [text for text in axes.texts if text.get_gid() == CURVE_LABEL]
    if not labels:
        return
    per_point = axes.figure.dpi / 72.0
    wanted = np.array([axes.transData.transform((0.0, label.xy[1]))[1] for label in labels])
    high = [1.2 * label.get_fontsize() * (1 + label.get_text().count("\n")) for label in labels]
    order = np.argsort(wanted, kind="stable")
    places = _apart(wanted[order] / per_point, np.array(high)[order])
    for k, place in zip(order, places, strict=True):
        labels[k].set_position((5.0, place - wanted[k] / per_point))


def _apart(wanted: np.ndarray, heights: np.ndarray) -> np.ndarray:
    """Ascending places of minimal squared distance from the wanted ones, without overlaps.

    Places minus the summed heights below them have to ascend: isotonic regression.
    """
    from scipy.optimize import isotonic_regression

    stacked = np.concatenate([[0.0], np.cumsum(0.5 * (heights[1:] + heights[:-1]))])
    return np.asarray(isotonic_regression(wanted - stacked).x + stacked)
