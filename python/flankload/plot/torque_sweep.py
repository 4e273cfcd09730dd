"""Key figures over the torque."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flankload.plot.picture import all_torques, panels, picture
from flankload.plot.style import SIZE, torque_colours

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from flankload.result import Result


def _largest_force(result: Result) -> float:
    return float(result.site_force_N.max())


#: Quantities by name: label with unit, and key of the summary or function of a result.
QUANTITIES: dict[str, tuple[str, str | Callable[[Result], float]]] = {
    "transmission_error_peak_to_peak": (
        "transmission error,\npeak to peak in µm",
        "transmission_error_peak_to_peak_um",
    ),
    "transmission_error_mean": ("transmission error,\nmean in µm", "transmission_error_mean_um"),
    "peak_pressure": ("peak pressure off\ncorners in MPa", "peak_pressure_off_corners_MPa"),
    "stiffness": ("tangent stiffness,\nmean in N/µm", "stiffness_tangent_mean_N_per_um"),
    "tooth_force": ("largest force on\na tooth in N", _largest_force),
}


@panels(all_torques, "Over the torque")
def plot_torque_sweep(
    figure: Figure, results: Sequence[Result], *, quantity: str | None = None
) -> None:
    """Draw transmission error, pressure or force, and stiffness over the torque."""
    if quantity is not None:
        draw_torque_sweep(figure.add_subplot(), results, quantity=quantity)
        return
    third = "peak_pressure" if results[0].drive is None else "tooth_force"
    names = ("transmission_error_peak_to_peak", "transmission_error_mean", third, "stiffness")
    figure.set_size_inches(SIZE[0], 1.25 * SIZE[1])
    for axes, name in zip(figure.subplots(2, 2).flat, names, strict=True):
        draw_torque_sweep(axes, results, quantity=name)


@picture(all_torques)
def draw_torque_sweep(
    axes: Axes, results: Sequence[Result], *, quantity: str = "transmission_error_peak_to_peak"
) -> None:
    """Draw a key figure over the torque.

    Raises
    ------
    ValueError
        If the quantity is none of `QUANTITIES`.
    """
    if quantity not in QUANTITIES:
        expected = ", ".join(QUANTITIES)
        raise ValueError(f"quantity: expected one of {expected}, found {quantity!r}")
    label, key = QUANTITIES[quantity]
    values = [result.summary[key] if isinstance(key, str) else key(result) for result in results]
    torques = np.array([result.torque_Nm for result in results])
    numbers = np.array([np.nan if value is None else value for value in values], dtype=float)
    colours = torque_colours(len(results))
    axes.plot(torques, numbers, color="#9a9a9a", linewidth=1.2, zorder=1)
    axes.scatter(torques, numbers, c=colours, s=34, zorder=2)
    axes.set_xlabel("torque on body 1 in N m")
    axes.set_ylabel(label)
    known = numbers[np.isfinite(numbers)]
    if known.size and known.min() >= 0:
        axes.set_ylim(0, 1.12 * known.max() or 1.0)
    axes.set_xlim(min(0.0, torques.min()), 1.06 * torques.max() or 1.0)
