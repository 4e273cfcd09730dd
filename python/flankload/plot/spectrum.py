"""Spectrum of the transmission error: amplitudes over the mesh orders."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flankload.plot.figures import legend_below, one_panel
from flankload.plot.style import torque_colours
from flankload.result.harmonics import over_positions

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    from flankload.result import Result

#: Largest mesh order.
MOST_ORDERS = 10
#: Part of an order that the bars of all torques cover.
COVERED = 0.8


def plot_transmission_error_spectrum(results: Result | Sequence[Result]) -> Figure:
    """Amplitudes of the transmission error over the mesh orders, a bar per torque."""
    return one_panel(
        draw_transmission_error_spectrum, results, "Spectrum of the transmission error"
    )


def draw_transmission_error_spectrum(axes: Axes, results: Sequence[Result]) -> None:
    """Draw the amplitudes of the transmission error over the mesh orders, a bar per torque.

    If the period has several pitches, the orders between the mesh orders are those of a period.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
    results : sequence of Result
        One per torque, by ascending torque; their positions cover the period.
    """
    pitches = results[0].period_pitches
    width = COVERED / (len(results) * pitches)
    for k, (result, colour) in enumerate(zip(results, torque_colours(len(results)), strict=True)):
        order, amplitude = spectrum(result)
        beside = (k - 0.5 * (len(results) - 1)) * width
        label = f"{result.torque_Nm:g} N m"
        axes.bar(order + beside, amplitude, width=width, color=colour, label=label)
    axes.set_xticks(range(1, int(order.max()) + 1))
    axes.set_xlim(min(0.5, order[0] - 0.5 / pitches), order[-1] + 0.5)
    axes.grid(visible=False, axis="x")
    axes.set_xlabel("mesh order (multiple of the tooth mesh frequency)")
    axes.set_ylabel("amplitude in µm")
    if len(results) > 1:
        legend_below(axes, ncols=min(len(results), 5))


def spectrum(result: Result) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Mesh orders and amplitudes of the transmission error, as far as the positions resolve them.

    Parameters
    ----------
    result : Result

    Returns
    -------
    order, amplitude_um : (n,) arrays
        Empty if the positions do not cover the period.
    """
    pitches = result.period_pitches
    count = min(MOST_ORDERS * pitches, (result.position_rad.size - 1) // 2)
    error = result.transmission_error_um
    found = over_positions(result).harmonics(error, count=count) if count > 0 else None
    known = [amplitude for amplitude in found or () if amplitude is not None]
    return np.arange(1, len(known) + 1) / pitches, np.array(known)
