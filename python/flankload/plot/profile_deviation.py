"""The profile diagram: deviation of both flanks from their involutes over the roll length."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib import rc_context
from matplotlib.figure import Figure

from flankload.plot.style import COLOURS, GREY, STYLE, new_figure, short

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from flankload.bodies.profile_deviation import ProfileDeviation
    from flankload.result import Result

#: Least range of the plotted deviations, um: smaller values are roundoff.
LEAST_SPAN_UM = 5.0
#: Height of a row of names, as part of the plot.
ROW = 0.085


def plot_profile_deviation(result: Result) -> Figure:
    """Deviation from the involute along its normal, for each body that has one.

    Parameters
    ----------
    result : Result

    Returns
    -------
    matplotlib.figure.Figure
    """
    drawing = result.drawing
    shown = [
        (z, profile, drawing.active_roll_mm[z])
        for z, profile in enumerate(drawing.profiles)
        if profile is not None
    ]
    with rc_context(STYLE):
        figure = new_figure((7.2, 1.0 + 2.9 * max(1, len(shown))))
        figure.suptitle("Profile deviation", x=0.01, ha="left", fontsize=11, fontweight="bold")
        name = short(result.name)
        figure.text(0.99, 0.985, name, ha="right", va="top", fontsize=9, color=GREY)
        low, high = _span([profile for _, profile, _ in shown])
        for row, (z, profile, active) in enumerate(shown):
            axes = figure.add_subplot(len(shown), 1, row + 1)
            axes.set_ylim(low, high)
            _draw_profile(axes, profile, active, z)
        return figure


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
    colour = COLOURS[z]
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
    axes.set_title(f"body {z + 1}", color=colour, fontsize=10)
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
