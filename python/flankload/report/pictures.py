"""Plots of a report, by section, and their curves for the script."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from inspect import signature
from typing import TYPE_CHECKING, Any

import numpy as np

from flankload import plot as pictures
from flankload.plot.loaded_pair import view_of
from flankload.plot.picture import OF_LARGEST
from flankload.plot.svg import Panel, panel_of
from flankload.report.turning import thinned
from flankload.result.stage import MESHES

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from flankload.result import Result

#: Sections of plots in their order, with the plots that belong to each.
SECTIONS = {
    "Motion": ("transmission_error", "transmission_error_spectrum", "follower_motion"),
    "Load sharing": (
        "load_sharing",
        "planet_load_share",
        "mesh_load_factor",
        "sun_orbit",
        "load_per_tooth",
        "flank_forces",
        "load_around_wrap",
        "force_through_wrap",
        "tensions",
        "load_map",
    ),
    "Pressure": ("peak_pressure", "flank_pressure", "pressure_over_diameter"),
    "Load over the face width": ("line_load", "line_load_map", "contact_pattern", "stage_patterns"),
    "Stiffness and torque": ("stiffness", "torque_sweep"),
    "Root stress": ("root_stress", "root_stress_over_width"),
    "Loaded bodies": (
        *("loaded_pair", "planetary_stage", "gear_train"),
        *("belt_on_pulley", "chain_on_sprocket"),
    ),
    "Profiles": ("profile_deviation",),
}
#: Section of plots that are in no other one.
OTHERS = "Further plots"
#: Titles that are not the name of the picture in words.
TITLES = {
    "transmission_error_spectrum": "Spectrum of the transmission error",
    "load_map": "Force of each pair over the positions",
    "peak_pressure": "Peak pressure",
    "line_load": "Line load over the face width",
    "root_stress_over_width": "Stress in the tooth roots over the face width",
    "line_load_map": "Line load of a tooth on its way through the mesh",
    "load_around_wrap": "Forces around the wrap",
    "tension_around_wrap": "Tension and lands around the wrap",
    "force_through_wrap": "Force of a tooth on its way through the wrap",
    "planet_load_share": "Load shares of the planets",
    "mesh_load_factor": "K_gamma over the torque",
    "sun_orbit": "Orbit of the sun",
    "stage_patterns": "Contact pattern",
    "tensions": "Tension around the sprocket",
    "load_per_tooth": "Force per tooth",
}
#: Sizes in inches: of a plot of half a page, and of drawings.
SIZE, DRAWING = (5.8, 3.9), (5.8, 5.4)
#: Pictures of whole bodies.
OF_BODIES = (
    *("loaded_pair", "planetary_stage", "gear_train"),
    *("belt_on_pulley", "chain_on_sprocket"),
)
#: Points of an outline may lie off by this part of the tip radius.
OFF = 2e-4


@dataclass(frozen=True)
class Plot:
    """A plot of a section: its name, unique in a page, and that of its picture."""

    name: str
    picture: str
    title: str
    panel: Panel


def plots_of(results: Sequence[Result]) -> dict[str, tuple[Plot, ...]]:
    """Plots that suit the results (one per torque), by section, without empty sections."""
    light = tuple(_light(result) for result in results)
    known = pictures.pictures_of(light)
    placed = {name for names in SECTIONS.values() for name in names}
    others = [name for name in known if name not in placed]
    drawn = {
        title: [plot for name in names if name in known for plot in _plots(name, light)]
        for title, names in (*SECTIONS.items(), (OTHERS, others))
    }
    return {title: tuple(plots) for title, plots in drawn.items() if plots}


def _light(result: Result) -> Result:
    """The result with fewer points in the outlines, which no reader of a page could see."""
    drawing = result.drawing
    one, two = (
        thinned(outline, OFF * float(np.hypot(*outline.T).max()))
        for outline in (drawing.outline_1, drawing.outline_2)
    )
    return replace(result, drawing=replace(drawing, outline_1=one, outline_2=two))


def _plots(name: str, light: Sequence[Result]) -> list[Plot]:
    """The panels of a picture, each a plot of its own."""
    results, draw = pictures.suited(name, light), pictures.DRAWINGS[name]
    title = TITLES.get(name, name.replace("_", " ").capitalize())
    if name in OF_LARGEST and len(results) > 1:
        title += f", {results[-1].torque_Nm:g} N m"
    drawn = {name: (title, draw)}
    if name == "load_around_wrap":
        of_tension = TITLES["tension_around_wrap"], pictures.draw_tension_around_wrap
        drawn["tension_around_wrap"] = of_tension
    elif name == "stage_patterns":
        drawn = dict(_patterns(title, results[-1]))
    elif "body" in signature(draw).parameters and (bodies := _bodies(name, results)):
        drawn = {f"{name}_{z}": (f"{title}, body {z}", partial(draw, body=z)) for z in bodies}
    elif name == "torque_sweep":
        drawn = {
            f"{name}_{quantity}": (words, partial(draw, quantity=quantity))
            for quantity, words in _swept(results).items()
        }
    size = DRAWING if name in OF_BODIES else SIZE
    return [
        Plot(key, name, words, panel_of(partial(draw, results=results), key, size))
        for key, (words, draw) in drawn.items()
    ]


def _patterns(title: str, result: Result) -> Iterator[tuple[str, tuple[str, Any]]]:
    """Contact patterns of the meshes of a stage."""
    assert result.stage is not None
    for kind in MESHES:
        for j in range(1, result.stage.count + 1):
            draw = partial(pictures.draw_stage_patterns, planet=j, mesh=kind)
            yield f"stage_patterns_{kind}_{j}", (f"{title}, planet {j} with the {kind}", draw)


def _bodies(name: str, results: Sequence[Result]) -> tuple[int, ...]:
    """Bodies that a picture shows one by one; none if it shows both at once."""
    if name == "loaded_pair":
        return view_of(results[-1]).one_by_one
    if name != "profile_deviation":
        return (1, 2)
    profiles = results[-1].drawing.profiles
    return tuple(z for z, profile in zip((1, 2), profiles, strict=True) if profile is not None)


def _swept(results: Sequence[Result]) -> dict[str, str]:
    """Quantities over the torque that are known, with their titles."""
    last = results[-1]
    found = {"transmission_error_mean": "Mean transmission error over the torque"}
    if last.position_rad.size > 1:
        found["transmission_error_peak_to_peak"] = "Peak to peak over the torque"
    if last.engagement.has_pressures:
        found["peak_pressure"] = "Peak pressure over the torque"
    else:
        found["tooth_force"] = "Largest force over the torque"
    if all(one.summary["stiffness_tangent_mean_N_per_um"] is not None for one in results):
        found["stiffness"] = "Stiffness over the torque"
    return found


# --- data for the script --------------------------------------------------------------------------
def curve_data(
    plots: dict[str, tuple[Plot, ...]], torques: Sequence[str] = ()
) -> dict[str, list[dict[str, Any]]]:
    """Curves for the script of the page: by name of the plot, the axes of its panel.

    If there is a curve without a label for each of several torques, these are their names.
    """
    return {
        plot.name: [_named(axes, torques) for axes in plot.panel.axes]
        for section in plots.values()
        for plot in section
        if plot.panel.axes
    }


def _named(axes: dict[str, Any], torques: Sequence[str]) -> dict[str, Any]:
    curves = axes["curves"]
    if not 1 < len(curves) == len(torques) or any(name for name, *_ in curves):
        return axes
    named = [[name, x, y] for name, (_, x, y) in zip(torques, curves, strict=True)]
    return axes | {"curves": named}
