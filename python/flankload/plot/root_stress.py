"""Stress in the tooth roots: on a tooth's way through the mesh, and over the face width."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from flankload.plot.figures import legend_below
from flankload.plot.picture import figure_of, largest, picture
from flankload.plot.positions import label_way, marks, way_curve
from flankload.plot.style import BODIES, GREY, pair_name

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from flankload.plot.picture import Results


#: Pitches drawn before and after the mesh: further away the stress is constant, or the tooth has
#: completed a turn.
BESIDE = 0.5


@picture(largest)
def draw_root_stress(axes: Axes, results: Results) -> None:
    """Draw tension and compression in the roots over the way of a tooth through the mesh.

    Pair j is j pitches further along than pair 0, so the curves of all pairs, one after the other,
    show the history of one tooth. If all teeth carry at once, they are drawn side by side, at the
    position of the largest stress.
    """
    result = largest(results)
    for z, stress in enumerate(result.root_stress):
        if stress is None:
            continue
        most = stress.tension.stress_MPa.max()
        least = stress.compression.stress_MPa.min()
        name = f"body {z + 1}"
        for values, style, label in (
            (stress.tension.stress_MPa, "solid", f"{name}, tension up to {most:.0f} MPa"),
            (stress.compression.stress_MPa, (0, (4, 2)), f"compression up to {-least:.0f} MPa"),
        ):
            look: dict[str, Any] = {"color": BODIES[z], "linestyle": style, "label": label}
            if result.engagement.cyclic_sites:
                p = int(np.abs(values).max(axis=1).argmax())
                axes.plot(result.sites, values[p], marker="o", markersize=4.5, **look)
            else:
                axes.plot(*way_curve(result, values, closing=np.nan), **marks(result), **look)
    if result.engagement.cyclic_sites:
        axes.set_xlabel(result.words_for_sites[0])
    else:
        label_way(axes, result, BESIDE)
    axes.axhline(0.0, color=GREY, linewidth=0.8)
    axes.set_ylabel("stress in MPa")
    legend_below(axes, ncols=2)


@picture(largest)
def plot_root_stress(results: Results) -> Figure:
    """Figure of tension and compression in the roots over the way of a tooth through the mesh."""
    return figure_of(draw_root_stress, largest(results), "Stress in the tooth roots")


@picture(largest)
def draw_root_stress_over_width(axes: Axes, results: Results) -> None:
    """Draw tension and compression over the face width, of each body where they are largest."""
    result = largest(results)
    for z, stress in enumerate(result.root_stress):
        if stress is None:
            continue
        for values, style in (
            (stress.slice_tension_MPa, "solid"),
            (stress.slice_compression_MPa, (0, (4, 2))),
        ):
            p, s, j = np.unravel_index(np.abs(values).argmax(), values.shape)
            label = f"body {z + 1}, {pair_name(result.sites[s])}, "
            label += f"{np.degrees(result.position_rad[p]):.2f}°: {values[p, s, j]:.0f} MPa "
            label += f"at {result.slice_z_mm[j]:.1f} mm"
            look: dict[str, Any] = {"color": BODIES[z], "linestyle": style}
            label = label.replace("-", "−")
            axes.plot(result.slice_z_mm, values[p, s], label=label, **look)
    axes.axhline(0.0, color=GREY, linewidth=0.8)
    axes.set_xlabel("axial position z in mm")
    axes.set_ylabel("stress in MPa")
    legend_below(axes, ncols=1)


@picture(largest)
def plot_root_stress_over_width(results: Results) -> Figure:
    """Figure of tension and compression over the face width where they are largest."""
    return figure_of(
        draw_root_stress_over_width,
        largest(results),
        "Stress in the tooth roots over the face width",
    )
