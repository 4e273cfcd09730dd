"""Forces on working and coast flanks over the positions."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from matplotlib.lines import Line2D

from flankload.plot.figures import heaviest, one_panel
from flankload.plot.positions import label_positions, legend_of_pairs, lifted, marks, pair_curve
from flankload.plot.style import GREY, coast_sites, colour_of, loaded_sites, pair_name

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from flankload.result import Result


def plot_flank_forces(results: Result | Sequence[Result]) -> Figure:
    """Force of each pair over the positions, on coast flanks dashed.

    Raises
    ------
    ValueError
        If coast flanks cannot carry load.
    """
    return one_panel(draw_flank_forces, heaviest(results), "Forces on both flanks")


def draw_flank_forces(axes: Axes, results: Sequence[Result]) -> None:
    """Draw the force of each pair over the positions, on coast flanks dashed.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
    results : sequence of Result
        The one of the largest torque is drawn; its coast flanks can carry load.

    Raises
    ------
    ValueError
        If they cannot carry load.
    """
    result = heaviest(results)
    if result.coast is None:
        raise ValueError("result: expected contact on coast flanks, found none")
    label_positions(axes, result)
    named: set[int] = set()
    for sites, force, line in (
        (loaded_sites(result), result.site_force_N, "-"),
        (coast_sites(result), result.coast.force_N, "--"),
    ):
        for s, site in sites:
            angle, along = pair_curve(result, force / 1e3, s)
            look: dict[str, Any] = {"color": colour_of(result, site), **marks(result)}
            label = None if site in named else pair_name(site)
            axes.plot(angle, lifted(along), line, label=label, **look)
            named.add(site)
    legend_of_pairs(axes, {"dashed: coast flank": Line2D([], [], color=GREY, linestyle="--")})
    axes.set_ylim(0, None)
    axes.set_ylabel("force in kN")
