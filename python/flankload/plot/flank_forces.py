"""Forces on working and coast flanks over the positions."""

from __future__ import annotations

from typing import TYPE_CHECKING

from matplotlib import rc_context
from matplotlib.lines import Line2D

from flankload.plot.curves import figure_over_positions, legend_of_pairs, lifted, marks, pair_curve
from flankload.plot.style import GREY, STYLE, coast_sites, colour_of, loaded_sites, pair_name

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from flankload.result import Result


def plot_flank_forces(result: Result) -> Figure:
    """Force of each pair over the positions, on coast flanks dashed.

    Parameters
    ----------
    result : Result
        Result with coast flanks that can carry load.

    Returns
    -------
    matplotlib.figure.Figure

    Raises
    ------
    ValueError
        If they cannot carry load.
    """
    if result.coast is None:
        raise ValueError("result: expected contact on coast flanks, found none")
    with rc_context(STYLE):
        figure, axes = figure_over_positions(result, "Forces on both flanks")
        named: set[int] = set()
        for sites, force, line in (
            (loaded_sites(result), result.site_force_N, "-"),
            (coast_sites(result), result.coast.force_N, "--"),
        ):
            for s, site in sites:
                angle, along = pair_curve(result, force / 1e3, s)
                axes.plot(
                    angle,
                    lifted(along),
                    line,
                    color=colour_of(result, site),
                    label=None if site in named else pair_name(site),
                    **marks(result),
                )
                named.add(site)
        legend_of_pairs(axes, {"dashed: coast flank": Line2D([], [], color=GREY, linestyle="--")})
        axes.set_ylim(0, None)
        axes.set_ylabel("force in kN")
        return figure
