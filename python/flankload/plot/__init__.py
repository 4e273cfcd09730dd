"""Plots for a report; the only package that imports matplotlib.

Figures are created as objects (no pyplot, no global state) and drawn on the Agg canvas, so they are
the same with and without a screen. Each plot is a pair: `draw_NAME(axes, results)` draws on any
Axes, `plot_NAME(results)` returns a figure with title and margins; `results` is a result or a
sequence of results, one per torque. The decorator `picture` lists them in `DRAWINGS` and
`PICTURES`, whose functions are attributes of this package and methods of `Result.plot`.
"""

from __future__ import annotations

from inspect import Parameter, signature
from typing import TYPE_CHECKING, Any

import numpy as np

from flankload.base.arguments import is_index, refuse_argument, require
from flankload.plot import (
    curves,
    involutes,
    load_maps,
    loaded_pair,
    root_stress,
    whole_circle,
    wrapped,
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
from flankload.plot.picture import DRAWINGS, PICTURES
from flankload.plot.style import FORMATS, SIZE, file_of, png_of, write_pictures

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence
    from pathlib import Path

    from matplotlib.axes import Axes

    from flankload.result import Result

__all__ = [
    "DRAWINGS",
    "FORMATS",
    "PICTURES",
    "draw_bands",
    "draw_curve",
    "draw_histogram",
    "draw_map",
    "draw_on",
    "draw_over_torque",
    "draw_pareto",
    "file_of",
    "method_of",
    "pictures_of",
    "plot_all",
    "png_of",
    "study_figures",
    "suited",
    "write_study",
]

#: Modules with the functions of `PICTURES` and `DRAWINGS`.
MODULES = (curves, involutes, load_maps, loaded_pair, root_stress, whole_circle, wrapped)
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
        Of one scene, one per torque. Plots over positions have a curve per torque; plots of one
        torque show the largest.
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
        Of the function `draw_…`.

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


def method_of(name: str, results: Sequence[Result]) -> Callable[..., Axes]:
    """`draw_on` for a plot of `PICTURES`, with its docstring, its options and optional Axes."""
    options = [*signature(PICTURES[name]).parameters.values()][1:]
    shown = signature(PICTURES[name]).replace(
        parameters=[
            Parameter("ax", Parameter.POSITIONAL_OR_KEYWORD, default=None),
            *(option.replace(kind=Parameter.KEYWORD_ONLY) for option in options),
        ],
        return_annotation="Axes",
    )

    def method(*given: Any, **named: Any) -> Axes:
        arguments = shown.bind(*given, **named).arguments
        axes = arguments.pop("ax", None)
        wanted = {key: value for key, value in arguments.items() if value is not None}
        return draw_on(name, results, axes, **wanted)

    method.__name__ = method.__qualname__ = name
    method.__doc__ = (DRAWINGS[name].__doc__ or "").partition("\n\nParameters\n")[0]
    method.__signature__ = shown  # type: ignore[attr-defined]
    return method


def __getattr__(name: str) -> Callable[..., Any]:
    kind, _, picture = name.partition("_")
    functions: dict[str, Mapping[str, Callable[..., Any]]] = {"draw": DRAWINGS, "plot": PICTURES}
    listed = functions.get(kind, {})
    if picture not in listed:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return listed[picture]


def pictures_of(results: Result | Sequence[Result]) -> tuple[str, ...]:
    """Names of the plots that suit the results.

    Parameters
    ----------
    results : Result, or sequence of Result
        Of one scene, one per torque.

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
        force_through_wrap. All: load_map for several positions, transmission_error_spectrum if
        these cover the period, root_stress if requested (in three dimensions also
        root_stress_over_width), torque_sweep for several torques.
    """
    shown = as_results(results)
    found = {name: None for one in shown for name in one.engagement.pictures(one)}
    return (*found, *["torque_sweep"] * (len(shown) > 1))


def suited(name: str, results: Sequence[Result]) -> Sequence[Result]:
    """The results that a plot shows: with load for a stiffness, for instance."""
    return [one for one in results if name in one.engagement.pictures(one)] or results
