"""Stiffness of the pair over the positions."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib import rc_context

from flankload.plot.curves import curve, figure_over_positions, marks
from flankload.plot.style import COLOURS, STYLE

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from flankload.result import Result


def plot_stiffness(result: Result) -> Figure:
    """Tangent and secant stiffness over the positions, along the line of action and torsional.

    Parameters
    ----------
    result : Result

    Returns
    -------
    matplotlib.figure.Figure
    """
    with rc_context(STYLE):
        figure, axes = figure_over_positions(result, "Stiffness")
        curves = {
            "tangent": result.stiffness_tangent_N_per_um,
            "secant": result.stiffness_secant_N_per_um,
        }
        for n, (kind, values) in enumerate(curves.items()):
            mean = result.summary[f"stiffness_{kind}_mean_N_per_um"]
            label = kind if mean is None else f"{kind}, mean {mean:.1f} N/µm"
            angle, shown = curve(result, values)
            style = "solid" if kind == "tangent" else (0, (5, 2))
            axes.plot(angle, shown, color=COLOURS[n], label=label, linestyle=style, **marks(result))
        known = np.concatenate([values[np.isfinite(values)] for values in curves.values()])
        top = float(known.max(initial=0.0)) or 1.0
        axes.set_ylim(0, 1.1 * top)
        axes.set_ylabel("along the line of action in N/µm")
        # N/um times mm² is N m/rad
        factor = result.reference_radius_mm**2 / 1e3

        def torsional(value: Any) -> Any:
            return value * factor

        def along(value: Any) -> Any:
            return value / factor

        second = axes.secondary_yaxis("right", functions=(torsional, along))
        second.set_ylabel("torsional in kN m/rad")
        second.spines["right"].set_visible(True)
        axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.16), ncols=2)
        return figure
