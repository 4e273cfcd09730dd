"""Plots of a report, by section, and their curves for the script."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from flankload.plot import PICTURES, names_of
from flankload.plot.svg import panel

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flankload.plot.svg import Panel, PlottedAxes
    from flankload.result import Result

#: Sections of plots in their order, with the plots that belong to each.
SECTIONS = {
    "Transmission error": (
        "transmission_error",
        "transmission_error_spectrum",
        "follower_motion",
    ),
    "Load sharing": (
        "load_sharing",
        "load_map",
        "load_per_tooth",
        "flank_forces",
        "load_around_wrap",
        "force_through_wrap",
        "tensions",
    ),
    "Pressure": ("peak_pressure", "pressure_over_diameter", "flank_pressure"),
    "Load over the face width": ("line_load", "line_load_map", "contact_pattern"),
    "Stiffness": ("stiffness",),
    "Root stress": ("root_stress",),
    "Torque": ("torque_sweep",),
    "Profiles": ("profile_deviation",),
    "Loaded bodies": ("loaded_pair", "belt_on_pulley", "chain_on_sprocket"),
}
#: Section of plots that are in no other one.
OTHERS = "Further plots"
#: Plots that need the width of a page.
WIDE = ("profile_deviation", "loaded_pair", "contact_pattern", "load_map")
#: Significant digits of the curves for the script.
DIGITS = 4
#: Words in the label of an axis that shows the positions.
OF_POSITIONS = ("angle of body 1 in degrees", "cam angle in degrees")


@dataclass(frozen=True)
class Plot:
    """A plot of a section.

    Attributes
    ----------
    name : str
        Name of the picture, unique in a page.
    title : str
    panel : Panel
    """

    name: str
    title: str
    panel: Panel

    @property
    def wide(self) -> bool:
        """Whether it needs the width of the page."""
        return self.name in WIDE


def plots_of(results: Sequence[Result]) -> dict[str, tuple[Plot, ...]]:
    """Plots that suit the results, by section.

    Parameters
    ----------
    results : sequence of Result
        One per torque.

    Returns
    -------
    dict of str to tuple of Plot
        Without empty sections.
    """
    drawn: dict[str, list[Plot]] = {title: [] for title in (*SECTIONS, OTHERS)}
    section = {name: title for title, names in SECTIONS.items() for name in names}
    for name in names_of(results[-1]):
        drawn[section.get(name, OTHERS)].append(_plot(name, results))
    return {title: tuple(plots) for title, plots in drawn.items() if plots}


def _plot(name: str, results: Sequence[Result]) -> Plot:
    title = name.replace("_", " ").capitalize()
    return Plot(name, title, panel(PICTURES[name](results[-1]), name))


# --- data for the script --------------------------------------------------------------------------
def curve_data(plots: dict[str, tuple[Plot, ...]]) -> dict[str, list[dict[str, Any]]]:
    """Curves of all plots, for the script of the page.

    Parameters
    ----------
    plots : dict
        From `plots_of`.

    Returns
    -------
    dict
        By name of the plot, a list of its axes: `box`, `x` and `y` (ranges), `label` (of the
        ordinate), `position` (whether the abscissa is the position) and `curves` (name, x, y).
    """
    return {
        plot.name: [_axes_data(axes) for axes in plot.panel.axes]
        for section in plots.values()
        for plot in section
        if plot.panel.axes
    }


def _axes_data(axes: PlottedAxes) -> dict[str, Any]:
    return {
        "box": [round(float(value), 2) for value in axes.box],
        "x": _numbers(np.array(axes.x_range)),
        "y": _numbers(np.array(axes.y_range)),
        "label": axes.y_label,
        "position": axes.x_label.startswith(OF_POSITIONS),
        "curves": [
            [curve.name, _numbers(curve.x, DIGITS + 1), _numbers(curve.y)] for curve in axes.curves
        ],
    }


def _numbers(values: Any, digits: int = DIGITS) -> list[float | None]:
    """Values with few significant digits; None where they are not finite."""
    return [float(f"{value:.{digits}g}") if np.isfinite(value) else None for value in values]
