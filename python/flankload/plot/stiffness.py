"""Stiffness of the pair over the positions."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from flankload.plot.figures import label_curves, legend_below, one_panel
from flankload.plot.positions import curve, label_positions, marks
from flankload.plot.style import torque_colours

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from flankload.result import Result

#: Place of the second axis beside the labels of the curves, as part of the width of the panel.
BESIDE_LABELS = 1.17


def plot_stiffness(results: Result | Sequence[Result]) -> Figure:
    """Stiffness over the positions, along the line of action and torsional.

    One torque: tangent and secant stiffness; several torques: a curve of the tangent stiffness
    for each.
    """
    return one_panel(draw_stiffness, results, "Stiffness")


def draw_stiffness(axes: Axes, results: Sequence[Result]) -> None:
    """Draw the tangent stiffness over the positions; of one torque also the secant stiffness.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
    results : sequence of Result
        One per torque, by ascending torque.
    """
    label_positions(axes, results[0])
    colours = torque_colours(len(results))
    if len(results) == 1:
        _draw_both(axes, results[0], colours[0])
        _add_torsional_axis(axes, results[0], 1.0)
        return
    axes.set_ylabel("tangent stiffness along the line of action in N/µm")
    ends = []
    for result, colour in zip(results, colours, strict=True):
        angle, shown = curve(result, result.stiffness_tangent_N_per_um)
        axes.plot(angle, shown, color=colour, **marks(result))
        ends.append(float(shown[-1]))
    axes.margins(y=0.1)
    label_curves(axes, ends, [f"{result.torque_Nm:g} N m" for result in results], colours)
    _add_torsional_axis(axes, results[0], BESIDE_LABELS)


def _draw_both(axes: Axes, result: Result, colour: Any) -> None:
    """Tangent and secant stiffness of one torque, with their means."""
    curves = {
        "tangent": result.stiffness_tangent_N_per_um,
        "secant": result.stiffness_secant_N_per_um,
    }
    for kind, values in curves.items():
        mean = result.summary[f"stiffness_{kind}_mean_N_per_um"]
        label = kind if mean is None else f"{kind}, mean {mean:.1f} N/µm"
        angle, shown = curve(result, values)
        style = "solid" if kind == "tangent" else (0, (5, 2))
        axes.plot(angle, shown, color=colour, label=label, linestyle=style, **marks(result))
    known = np.concatenate([values[np.isfinite(values)] for values in curves.values()])
    top = float(known.max(initial=0.0)) or 1.0
    axes.set_ylim(0, 1.1 * top)
    axes.set_ylabel("along the line of action in N/µm")
    legend_below(axes, ncols=2)


def _add_torsional_axis(axes: Axes, result: Result, place: float) -> None:
    # N/um times mm² is N m/rad
    factor = result.reference_radius_mm**2 / 1e3

    def torsional(value: Any) -> Any:
        return value * factor

    def along(value: Any) -> Any:
        return value / factor

    second = axes.secondary_yaxis(place, functions=(torsional, along))
    second.set_ylabel("torsional in kN m/rad")
    second.spines["right"].set_visible(True)
