"""Plots for a report; the only package that imports matplotlib.

Figures are created as objects (no pyplot, no global state) and drawn on the Agg canvas, so they are
the same with and without a screen.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from flankload.base.files import write_atomically
from flankload.plot.belt import (
    plot_belt_on_pulley,
    plot_force_through_wrap,
    plot_load_around_wrap,
)
from flankload.plot.chain import plot_chain_on_sprocket, plot_tensions
from flankload.plot.curves import (
    plot_follower_motion,
    plot_load_sharing,
    plot_peak_pressure,
    plot_transmission_error,
)
from flankload.plot.design_study import study_figures, write_study
from flankload.plot.flank_forces import plot_flank_forces
from flankload.plot.loaded_pair import plot_loaded_pair
from flankload.plot.profile_deviation import plot_profile_deviation
from flankload.plot.root_stress import plot_root_stress
from flankload.plot.slices import plot_contact_pattern, plot_line_load, plot_line_load_map
from flankload.plot.stiffness import plot_stiffness
from flankload.plot.study_axes import (
    draw_bands,
    draw_curve,
    draw_histogram,
    draw_map,
    draw_over_torque,
    draw_pareto,
)
from flankload.plot.style import png_of
from flankload.plot.whole_circle import plot_flank_pressure, plot_load_per_tooth

if TYPE_CHECKING:
    from collections.abc import Callable

    from matplotlib.figure import Figure

    from flankload.result import Result

__all__ = [
    "draw_bands",
    "draw_curve",
    "draw_histogram",
    "draw_map",
    "draw_over_torque",
    "draw_pareto",
    "plot_all",
    "plot_belt_on_pulley",
    "plot_chain_on_sprocket",
    "plot_contact_pattern",
    "plot_flank_forces",
    "plot_flank_pressure",
    "plot_follower_motion",
    "plot_force_through_wrap",
    "plot_line_load",
    "plot_line_load_map",
    "plot_load_around_wrap",
    "plot_load_per_tooth",
    "plot_load_sharing",
    "plot_loaded_pair",
    "plot_peak_pressure",
    "plot_profile_deviation",
    "plot_root_stress",
    "plot_stiffness",
    "plot_tensions",
    "plot_transmission_error",
    "study_figures",
    "write_study",
]


#: All plots by name.
PICTURES: dict[str, Callable[[Result], Figure]] = {
    "transmission_error": plot_transmission_error,
    "load_sharing": plot_load_sharing,
    "peak_pressure": plot_peak_pressure,
    "loaded_pair": plot_loaded_pair,
    "flank_forces": plot_flank_forces,
    "stiffness": plot_stiffness,
    "profile_deviation": plot_profile_deviation,
    "follower_motion": plot_follower_motion,
    "load_per_tooth": plot_load_per_tooth,
    "flank_pressure": plot_flank_pressure,
    "root_stress": plot_root_stress,
    "line_load": plot_line_load,
    "line_load_map": plot_line_load_map,
    "contact_pattern": plot_contact_pattern,
    "belt_on_pulley": plot_belt_on_pulley,
    "load_around_wrap": plot_load_around_wrap,
    "force_through_wrap": plot_force_through_wrap,
    "chain_on_sprocket": plot_chain_on_sprocket,
    "tensions": plot_tensions,
}


def plot_all(result: Result, directory: str | Path) -> tuple[Path, ...]:
    """Write the plots of a result, all or none.

    Parameters
    ----------
    result : Result
        With a list of torques, each has its own folder in the directory: torque_302_Nm.
    directory : path
        Created if it does not exist.

    Returns
    -------
    tuple of Path
        transmission_error.png, load_sharing.png, peak_pressure.png, loaded_pair.png (of
        three-dimensional bodies over their face width); stiffness.png if there is a torque;
        flank_forces.png if coast flanks can carry load; profile_deviation.png if a body has an
        involute; for loaded three-dimensional bodies line_load.png, line_load_map.png and
        contact_pattern.png. For a follower on its cam follower_motion.png replaces
        load_sharing.png. For bodies with contact all around: load_per_tooth.png,
        flank_pressure.png, loaded_pair.png, and for several positions transmission_error.png. For
        all of these root_stress.png if stress is requested. For a chain: transmission_error.png,
        chain_on_sprocket.png, tensions.png and stiffness.png. For a belt: belt_on_pulley.png and
        load_around_wrap.png, for several positions also transmission_error.png and
        force_through_wrap.png.

    Raises
    ------
    OSError
        If the directory cannot be created or a file cannot be written.
    """
    if result.has_torque_list:
        folders = {Path(directory) / f"torque_{r.torque_Nm:g}_Nm": r for r in result.by_torque}
        return tuple(path for place, one in folders.items() for path in plot_all(one, place))
    names = result.drive.pictures(result) if result.drive is not None else _of_flanks(result)
    if any(stress is not None for stress in result.root_stress):
        names = (*names, "root_stress")
    pictures = {f"{name}.png": PICTURES[name] for name in names}
    # Every plot is drawn before the first is written.
    drawn = {name: png_of(picture(result)) for name, picture in pictures.items()}
    folder = Path(directory)
    folder.mkdir(parents=True, exist_ok=True)
    for name, content in drawn.items():
        write_atomically(folder / name, content)
    return tuple(folder / name for name in drawn)


def _of_flanks(result: Result) -> tuple[str, ...]:
    """Plots of a flank pair."""
    several = result.position_rad.size > 1
    if result.whole_circle:
        names = ("load_per_tooth", "flank_pressure", "loaded_pair")
        return (*names, *["transmission_error"] * several)
    profiles = any(profile is not None for profile in result.drawing.profiles)
    carries_in_slices = result.slices is not None and result.torque_Nm > 0
    return (
        "transmission_error",
        "follower_motion" if result.has_cam else "load_sharing",
        "peak_pressure",
        "loaded_pair",
        *["flank_forces"] * (result.coast is not None),
        *["stiffness"] * (result.torque_Nm > 0),
        *["profile_deviation"] * profiles,
        *["line_load", "line_load_map", "contact_pattern"] * carries_in_slices,
    )
