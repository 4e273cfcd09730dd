"""Pictures for a report; the only room that knows matplotlib.

Figures are made as objects (no pyplot, no global state) and drawn by the Agg canvas, so that they
come out the same with and without a screen.
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
from flankload.plot.curves import (
    plot_follower_motion,
    plot_load_sharing,
    plot_peak_pressure,
    plot_transmission_error,
)
from flankload.plot.drive import plot_chain_on_sprocket, plot_tensions
from flankload.plot.flank_forces import plot_flank_forces
from flankload.plot.loaded_pair import plot_loaded_pair
from flankload.plot.profile_deviation import plot_profile_deviation
from flankload.plot.root_stress import plot_root_stress
from flankload.plot.stiffness import plot_stiffness
from flankload.plot.style import png_of
from flankload.plot.whole_circle import plot_flank_pressure, plot_load_per_tooth
from flankload.result.belt import BeltDrive

if TYPE_CHECKING:
    from collections.abc import Callable

    from matplotlib.figure import Figure

    from flankload.result import Result

__all__ = [
    "plot_all",
    "plot_belt_on_pulley",
    "plot_chain_on_sprocket",
    "plot_flank_forces",
    "plot_flank_pressure",
    "plot_follower_motion",
    "plot_force_through_wrap",
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
]


def plot_all(result: Result, directory: str | Path) -> tuple[Path, ...]:
    """Write the pictures of a result, all or none.

    Parameters
    ----------
    result : Result
    directory : path
        Made where it does not exist.

    Returns
    -------
    tuple of Path
        transmission_error.png, load_sharing.png, peak_pressure.png, loaded_pair.png;
        stiffness.png where there is a torque; flank_forces.png where coast flanks can carry;
        profile_deviation.png where a body has an
        involute. Of a follower on its cam follower_motion.png in place of load_sharing.png. Of
        bodies that touch all around load_per_tooth.png, flank_pressure.png,
        loaded_pair.png, and with several positions transmission_error.png. Of all
        root_stress.png where stress is asked for. Of a chain transmission_error.png,
        chain_on_sprocket.png, tensions.png and stiffness.png. Of a belt belt_on_pulley.png and
        load_around_wrap.png, with several positions transmission_error.png and
        force_through_wrap.png.

    Raises
    ------
    OSError
        If the directory cannot be made or a file not be written.
    """
    pictures: dict[str, Callable[[Result], Figure]] = {
        "transmission_error.png": plot_transmission_error,
        "load_sharing.png": plot_load_sharing,
        "peak_pressure.png": plot_peak_pressure,
        "loaded_pair.png": plot_loaded_pair,
    }
    if result.coast is not None:
        pictures["flank_forces.png"] = plot_flank_forces
    if result.torque_Nm > 0:
        pictures["stiffness.png"] = plot_stiffness
    if any(profile is not None for profile in result.drawing.profiles):
        pictures["profile_deviation.png"] = plot_profile_deviation
    if result.has_cam:
        del pictures["load_sharing.png"]
        pictures["follower_motion.png"] = plot_follower_motion
    if result.whole_circle:
        pictures = {
            "load_per_tooth.png": plot_load_per_tooth,
            "flank_pressure.png": plot_flank_pressure,
            "loaded_pair.png": plot_loaded_pair,
        }
        if result.position_rad.size > 1:
            pictures["transmission_error.png"] = plot_transmission_error
    if isinstance(result.drive, BeltDrive):
        pictures = {
            "belt_on_pulley.png": plot_belt_on_pulley,
            "load_around_wrap.png": plot_load_around_wrap,
        }
        if result.position_rad.size > 1:
            pictures["transmission_error.png"] = plot_transmission_error
            pictures["force_through_wrap.png"] = plot_force_through_wrap
    elif result.drive is not None:
        pictures = {
            "transmission_error.png": plot_transmission_error,
            "chain_on_sprocket.png": plot_chain_on_sprocket,
            "tensions.png": plot_tensions,
            "stiffness.png": plot_stiffness,
        }
    if any(stress is not None for stress in result.root_stress):
        pictures["root_stress.png"] = plot_root_stress
    # Every picture is drawn before the first is written.
    drawn = {name: png_of(picture(result)) for name, picture in pictures.items()}
    folder = Path(directory)
    folder.mkdir(parents=True, exist_ok=True)
    for name, content in drawn.items():
        write_atomically(folder / name, content)
    return tuple(folder / name for name in drawn)
