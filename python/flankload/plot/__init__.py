"""Plots for a report; the only package that imports matplotlib.

Figures are created as objects (no pyplot, no global state) and drawn on the Agg canvas, so they are
the same with and without a screen. Each plot is a pair: `draw_…(axes, results)` draws on any Axes,
`plot_…(results)` returns a figure with title and margins; `results` is a result or a sequence of
results, one per torque. Both are made by the decorators of `picture.py`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from flankload.base.arguments import is_index, refuse_argument, require
from flankload.plot.curves import (
    draw_flank_forces,
    draw_follower_motion,
    draw_load_sharing,
    draw_peak_pressure,
    draw_stiffness,
    draw_torque_sweep,
    draw_transmission_error,
    draw_transmission_error_spectrum,
    plot_flank_forces,
    plot_follower_motion,
    plot_load_sharing,
    plot_peak_pressure,
    plot_stiffness,
    plot_torque_sweep,
    plot_transmission_error,
    plot_transmission_error_spectrum,
)
from flankload.plot.design_study import (
    draw_bands,
    draw_curve,
    draw_histogram,
    draw_map,
    draw_over_torque,
    draw_pareto,
    study_figures,
    write_study,
)
from flankload.plot.figures import as_results, fit
from flankload.plot.involutes import (
    draw_pressure_over_diameter,
    draw_profile_deviation,
    plot_pressure_over_diameter,
    plot_profile_deviation,
)
from flankload.plot.load_maps import (
    draw_contact_pattern,
    draw_line_load,
    draw_line_load_map,
    draw_load_map,
    plot_contact_pattern,
    plot_line_load,
    plot_line_load_map,
    plot_load_map,
)
from flankload.plot.loaded_pair import draw_loaded_pair, plot_loaded_pair
from flankload.plot.picture import DRAWINGS, PICTURES
from flankload.plot.root_stress import (
    draw_root_stress,
    draw_root_stress_over_width,
    plot_root_stress,
    plot_root_stress_over_width,
)
from flankload.plot.stage import (
    draw_mesh_load_factor,
    draw_planet_load_share,
    draw_planetary_stage,
    draw_sun_orbit,
    plot_mesh_load_factor,
    plot_planet_load_share,
    plot_planetary_stage,
    plot_sun_orbit,
)
from flankload.plot.stage_patterns import draw_stage_patterns, plot_stage_patterns
from flankload.plot.style import FORMATS, SIZE, file_of, png_of, write_pictures
from flankload.plot.train import draw_gear_train, plot_gear_train
from flankload.plot.whole_circle import (
    draw_flank_pressure,
    draw_load_per_tooth,
    plot_flank_pressure,
    plot_load_per_tooth,
)
from flankload.plot.wrapped import (
    draw_belt_on_pulley,
    draw_chain_on_sprocket,
    draw_force_through_wrap,
    draw_load_around_wrap,
    draw_tension_around_wrap,
    draw_tensions,
    plot_belt_on_pulley,
    plot_chain_on_sprocket,
    plot_force_through_wrap,
    plot_load_around_wrap,
    plot_tensions,
)

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from matplotlib.axes import Axes

    from flankload.result import Result

__all__ = [
    "DRAWINGS",
    "FORMATS",
    "PICTURES",
    "draw_bands",
    "draw_belt_on_pulley",
    "draw_chain_on_sprocket",
    "draw_contact_pattern",
    "draw_curve",
    "draw_flank_forces",
    "draw_flank_pressure",
    "draw_follower_motion",
    "draw_force_through_wrap",
    "draw_gear_train",
    "draw_histogram",
    "draw_line_load",
    "draw_line_load_map",
    "draw_load_around_wrap",
    "draw_load_map",
    "draw_load_per_tooth",
    "draw_load_sharing",
    "draw_loaded_pair",
    "draw_map",
    "draw_mesh_load_factor",
    "draw_on",
    "draw_over_torque",
    "draw_pareto",
    "draw_peak_pressure",
    "draw_planet_load_share",
    "draw_planetary_stage",
    "draw_pressure_over_diameter",
    "draw_profile_deviation",
    "draw_root_stress",
    "draw_root_stress_over_width",
    "draw_stage_patterns",
    "draw_stiffness",
    "draw_sun_orbit",
    "draw_tension_around_wrap",
    "draw_tensions",
    "draw_torque_sweep",
    "draw_transmission_error",
    "draw_transmission_error_spectrum",
    "file_of",
    "pictures_of",
    "plot_all",
    "plot_belt_on_pulley",
    "plot_chain_on_sprocket",
    "plot_contact_pattern",
    "plot_flank_forces",
    "plot_flank_pressure",
    "plot_follower_motion",
    "plot_force_through_wrap",
    "plot_gear_train",
    "plot_line_load",
    "plot_line_load_map",
    "plot_load_around_wrap",
    "plot_load_map",
    "plot_load_per_tooth",
    "plot_load_sharing",
    "plot_loaded_pair",
    "plot_mesh_load_factor",
    "plot_peak_pressure",
    "plot_planet_load_share",
    "plot_planetary_stage",
    "plot_pressure_over_diameter",
    "plot_profile_deviation",
    "plot_root_stress",
    "plot_root_stress_over_width",
    "plot_stage_patterns",
    "plot_stiffness",
    "plot_sun_orbit",
    "plot_tensions",
    "plot_torque_sweep",
    "plot_transmission_error",
    "plot_transmission_error_spectrum",
    "png_of",
    "study_figures",
    "suited",
    "write_study",
]

MM_PER_INCH = 25.4


def plot_all(
    results: Result | Sequence[Result],
    directory: str | Path,
    *,
    formats: Sequence[str] = ("png",),
    dpi: float | None = None,
    size_mm: tuple[float, float] | None = None,
) -> tuple[Path, ...]:
    """Write the plots that suit the results, all or none.

    Parameters
    ----------
    results : Result, or sequence of Result
        Results of one scene, one per torque. Plots over positions have a curve per torque; plots of
        one torque show the largest.
    directory : path
        Created if it does not exist.
    formats : sequence of {"png", "svg", "pdf"}
    dpi : float, optional
        Pixels per inch of PNG files; by default 160.
    size_mm : (float, float), optional
        Width and height of a plot with one panel; others keep their ratio to it. By default 183 by
        107 mm.

    Returns
    -------
    tuple of Path
        Names of `pictures_of` with the suffixes of the formats.

    Raises
    ------
    ValueError
        If a format is unknown.
    OSError
        If the directory cannot be created or a file cannot be written.
    """
    if unknown := [kind for kind in formats if kind not in FORMATS]:
        refuse_argument("formats", unknown[0], ", ".join(FORMATS))
    drawn = {}
    # Every plot is drawn before the first is written.
    several = as_results(results)
    for name in pictures_of(several):
        figure = PICTURES[name](suited(name, several))
        if size_mm is not None:
            scale = np.array(size_mm) / MM_PER_INCH / SIZE
            figure.set_size_inches(*(figure.get_size_inches() * scale))
            fit(figure)
        for kind in dict.fromkeys(formats):
            drawn[f"{name}.{kind}"] = file_of(figure, kind, dpi)
    return write_pictures(directory, drawn)


def draw_on(
    name: str, results: Result | Sequence[Result], axes: Axes | None, **options: Any
) -> Axes:
    """Draw a plot on given Axes, or on those of a new figure.

    Parameters
    ----------
    name : str
        One of `PICTURES`.
    results : Result, or sequence of Result
    axes : matplotlib.axes.Axes or None
        With None, a new figure with title and margins; of several panels, the first one, unless
        options choose another.
    **options
        Options of the function `draw_…`.

    Returns
    -------
    matplotlib.axes.Axes

    Raises
    ------
    InputError
        If the plot does not suit the results, or if there is no such position or body.
    """
    shown = as_results(results)
    names = tuple(dict.fromkeys((*pictures_of(shown), "torque_sweep")))
    require("plot", name, f"one that suits the results ({', '.join(names)})", fits=name in names)
    count = shown[-1].position_rad.size
    position, body = options.get("position", 0), options.get("body", 1)
    fits = is_index(position) and -count <= position < count
    require("position", position, f"an index from 0 to {count - 1}", fits=fits)
    require("body", body, "1 or 2", fits=is_index(body) and body in (1, 2))
    if axes is not None:
        DRAWINGS[name](axes, shown, **options)
        return axes
    return PICTURES[name](shown, **options).axes[0]


def pictures_of(results: Result | Sequence[Result]) -> tuple[str, ...]:
    """Names of the plots that suit the results.

    Parameters
    ----------
    results : Result, or sequence of Result
        Results of one scene, one per torque.

    Returns
    -------
    tuple of str
        Flank pairs: transmission_error, load_sharing (for a follower on its cam follower_motion),
        peak_pressure, loaded_pair; stiffness if there is a torque; flank_forces if coast flanks can
        carry load; profile_deviation if a body has an involute, pressure_over_diameter if both
        have; loaded three-dimensional bodies: line_load, line_load_map and contact_pattern. Contact
        all around: load_per_tooth, flank_pressure, loaded_pair, and for several positions
        transmission_error. Chains: transmission_error, chain_on_sprocket, tensions and stiffness.
        Belts: belt_on_pulley, load_around_wrap, and for several positions transmission_error and
        force_through_wrap. Gear trains: gear_train, and transmission_error for several positions.
        Planetary stages: planetary_stage, and for several positions
        transmission_error, planet_load_share, and sun_orbit if the sun moves; mesh_load_factor for
        several torques; with a width stage_patterns. All: load_map for several positions,
        transmission_error_spectrum if these cover the period, root_stress if requested (in three
        dimensions also root_stress_over_width), torque_sweep for several torques.
    """
    shown = as_results(results)
    found = {name: None for one in shown for name in one.engagement.pictures(one)}
    return (*found, *shown[0].engagement.over_torque * (len(shown) > 1))


def suited(name: str, results: Sequence[Result]) -> Sequence[Result]:
    """The results that a plot shows: with load for a stiffness, for instance."""
    return [one for one in results if name in one.engagement.pictures(one)] or results
