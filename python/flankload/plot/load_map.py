"""Load of all pairs over the positions, as a map."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.ticker import MaxNLocator

from flankload.plot.figures import heaviest, one_panel
from flankload.plot.positions import is_closed, label_positions, pair_curve
from flankload.plot.style import SIZE, loaded_sites

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    from flankload.result import Result

LOAD_MAP = "viridis_r"
#: Up to this number of pairs, each one is a tick.
MOST_TICKS = 12


def plot_load_map(results: Result | Sequence[Result]) -> Figure:
    """Force of each pair at each position."""
    result = heaviest(results)
    _, several = _words(result)
    return one_panel(draw_load_map, result, f"Load of the {several}", (SIZE[0], 3.6))


def _words(result: Result) -> tuple[str, str]:
    """The word for a site, and for several."""
    if result.drive is not None:
        return result.drive.words_for_sites
    return ("tooth", "teeth") if result.whole_circle else ("pair", "pairs")


def draw_load_map(axes: Axes, results: Sequence[Result]) -> None:
    """Draw the force of each pair (vertical) at each position (horizontal) as a colour.

    A pair without load is blank.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
    results : sequence of Result
        The one of the largest torque is drawn.
    """
    result = heaviest(results)
    columns = [s for s, _ in loaded_sites(result)] or [0]
    rows = range(columns[0], columns[-1] + 1)
    curves = [pair_curve(result, result.site_force_N, s) for s in rows]
    angle, force = curves[0][0], np.array([force for _, force in curves]) / 1e3
    sites = result.sites[rows.start : rows.stop]
    shown = axes.pcolormesh(
        _edges(result, angle),
        np.append(sites - 0.5, sites[-1] + 0.5),
        np.where(force > 0, force, np.nan),
        cmap=LOAD_MAP,
        vmin=0.0,
    )
    label_positions(axes, result)
    axes.grid(visible=False)
    if len(rows) <= MOST_TICKS:
        axes.set_yticks(sites, [f"{site}".replace("-", "−") for site in sites])
    else:
        axes.yaxis.set_major_locator(MaxNLocator(integer=True))
    axes.set_ylabel(_words(result)[0])
    axes.figure.colorbar(shown, ax=axes, label="force in kN", pad=0.02)


def _edges(result: Result, angle: NDArray[np.float64]) -> NDArray[np.float64]:
    """Boundaries between positions; a gap has no colour of its own."""
    known = np.where(np.isnan(angle), 0.5 * (np.roll(angle, 1) + np.roll(angle, -1)), angle)
    middle = 0.5 * (known[1:] + known[:-1])
    if is_closed(result):
        return np.concatenate([known[:1], middle, known[-1:]])
    half = 0.5 * np.degrees(result.pitch_rad) / max(result.position_rad.size, 1)
    first, last = (middle[0], middle[-1]) if middle.size else (known[0] + half, known[0] - half)
    return np.concatenate([[2 * known[0] - first], middle, [2 * known[-1] - last]])
