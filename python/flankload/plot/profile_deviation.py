"""The profile diagram: deviation of both flanks from their involutes over the roll length."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib import rc_context

from flankload.plot.figures import empty_figure, fit, heaviest
from flankload.plot.style import BODIES, GREY, STYLE, short

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from flankload.bodies.profile_deviation import ProfileDeviation
    from flankload.result import Result

#: Least range of the plotted deviations, um: smaller values are roundoff.
LEAST_SPAN_UM = 5.0
#: Height of the title of a panel: that of the label of the upper axis, beside it; points.
BESIDE = 21.0
#: Height of a row of names, as part of the plot.
ROW = 0.085


def plot_profile_deviation(results: Result | Sequence[Result], body: int | None = None) -> Figure:
    """Deviation from the involute along its normal, a panel for each body that has one.

    Parameters
    ----------
    results : Result, or sequence of Result
    body : int, optional
        1 or 2; by default both, in two panels.
    """
    result = heaviest(results)
    known = [z + 1 for z, profile in enumerate(result.drawing.profiles) if profile is not None]
    bodies = known if body is None else [body]
    with rc_context(STYLE):
        figure = empty_figure((7.2, 1.0 + 2.9 * max(1, len(bodies))))
        figure.suptitle("Profile deviation", x=0.01, ha="left", fontsize=11, fontweight="bold")
        name = short(result.name)
        figure.text(0.99, 0.985, name, ha="right", va="top", fontsize=9, color=GREY)
        for row, each in enumerate(bodies):
            axes = figure.add_subplot(len(bodies), 1, row + 1)
            draw_profile_deviation(axes, (result,), body=each)
            axes.set_title(f"body {each}", color=BODIES[each - 1], fontsize=10, pad=BESIDE)
        fit(figure)
        return figure


def draw_profile_deviation(axes: Axes, results: Sequence[Result], *, body: int = 1) -> None:
    """Draw the deviation of a body from its involute along its normal, over roll length.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
    results : sequence of Result
        All have the same profiles; the scale is that of both bodies.
    body : int
        1 or 2.

    Raises
    ------
    ValueError
        If the involute of the body is unknown.
    """
    drawing = results[0].drawing
    profile = drawing.profiles[body - 1]
    if profile is None:
        raise ValueError(f"body: expected one with an involute, found {body}")
    axes.set_ylim(*_span([each for each in drawing.profiles if each is not None]))
    _draw_profile(axes, profile, drawing.active_roll_mm[body - 1], body - 1)


def _span(profiles: list[ProfileDeviation]) -> tuple[float, float]:
    """One scale for both bodies, with space above for the labels of the marks."""
    every = np.concatenate([profile.deviation_um for profile in profiles])
    low, high = min(0.0, float(every.min())), max(0.0, float(every.max()))
    if high - low < LEAST_SPAN_UM:
        low -= LEAST_SPAN_UM - (high - low)
    foot = 0.14 * (high - low)
    head = 0.05 + ROW * max(len(profile.marks) for profile in profiles)  # part of the height
    return low - foot, high + (high - low + foot) * head / (1.0 - head)


def _draw_profile(
    axes: Axes, profile: ProfileDeviation, active: tuple[float, float] | None, z: int
) -> None:
    colour = BODIES[z]
    ends = [*profile.roll_length_mm[[0, -1]], *(place for _, place in profile.marks)]
    margin = 0.03 * (max(ends) - min(ends))
    axes.set_xlim(min(ends) - margin, max(ends) + margin)
    if active is not None:
        axes.axvspan(*active, color="#f0f0f0", zorder=0)
        axes.text(
            0.5 * sum(active),
            0.03,
            "active profile",
            transform=axes.get_xaxis_transform(),
            ha="center",
            fontsize=8,
            color=GREY,
        )
    axes.axhline(0.0, color=GREY, linewidth=1)
    _draw_marks(axes, profile)
    axes.plot(profile.roll_length_mm, profile.deviation_um, color=colour)
    axes.set_ylabel("deviation in µm")
    axes.set_xlabel("roll length in mm")
    base = profile.base_radius_mm

    def diameter(roll_length: Any) -> Any:
        return 2 * np.hypot(base, np.maximum(roll_length, 0.0))

    def roll_length(diameter: Any) -> Any:
        return np.sqrt(np.maximum((0.5 * np.asarray(diameter)) ** 2 - base**2, 0.0))

    axes.secondary_xaxis("top", functions=(diameter, roll_length)).set_xlabel("diameter in mm")


def _draw_marks(axes: Axes, profile: ProfileDeviation) -> None:
    """A line for each mark, with its label beside it in a row of its own."""
    marks = sorted(profile.marks, key=lambda mark: mark[1])
    low, high = axes.get_xlim()
    for row, (name, place) in enumerate(marks):
        axes.axvline(place, color=GREY, linewidth=0.9, linestyle=(0, (4, 3)))
        at_left = place < 0.5 * (low + high)
        axes.annotate(
            f"{name} ⌀ {2 * np.hypot(profile.base_radius_mm, place):.2f}",
            xy=(place, 0.97 - ROW * row),
            xycoords=("data", "axes fraction"),
            xytext=(4 if at_left else -4, 0),
            textcoords="offset points",
            ha="left" if at_left else "right",
            va="top",
            fontsize=8,
            color=GREY,
            bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.85, "pad": 0.6},
        )
