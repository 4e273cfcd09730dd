"""Common parts of the plots of results: the data that they show, figures, docstrings.

`draw_NAME(axes, results)` draws on given Axes, without a title; `plot_NAME(results)` returns a
figure with title and margins. A picture shows all torques, the largest one, or that at a position.
"""

from __future__ import annotations

from contextlib import contextmanager
from inspect import cleandoc, signature
from typing import TYPE_CHECKING, Any, TypeAlias, TypeVar

import numpy as np
from matplotlib import rc_context

from flankload.plot.figures import as_results, empty_figure, fit, heaviest, set_title, subtitle
from flankload.plot.style import GREY, SIZE, STYLE

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping, Sequence

    from matplotlib.figure import Figure

    from flankload.result import Result

    Results: TypeAlias = Result | Sequence[Result]

Function = TypeVar("Function", bound="Callable[..., Any]")

#: All plots by name: the functions `plot_NAME`.
PICTURES: dict[str, Callable[..., Figure]] = {}
#: The functions `draw_NAME`; of several panels they draw one.
DRAWINGS: dict[str, Callable[..., None]] = {}
#: Names of those that show the largest torque alone.
OF_LARGEST: set[str] = set()

#: Parameters of the functions, as in their docstrings.
PARAMETERS = {
    "axes": "matplotlib.axes.Axes",
    "results": "Result, or sequence of Result\n    Of one scene, one per torque. {shown}",
    "position": "int, optional\n    Index of the position; by default the {default}",
    "body": "int\n    1 or 2; a figure shows both, in two panels, unless one is given.",
    "key": "bool\n    Whether to explain colours or dashed lines beside the panel.",
    "largest_MPa": "float, optional\n    End of the scale of colours; by default that of the body.",
    "planet": "int\n    From 1; a figure shows all.",
    "mesh": 'str\n    "sun" or "ring"; a figure shows both.',
    "quantity": "str\n    One of `QUANTITIES`; a figure shows four unless one is given.",
}
SMALL: dict[str, Any] = {"fontsize": 9, "fontweight": "normal", "color": GREY}


def all_torques(results: Results) -> tuple[Result, ...]:
    """Each is drawn."""
    return as_results(results)


def largest(results: Results) -> Result:
    """The one of the largest torque is drawn."""
    return heaviest(results)


def at(default: Callable[[Result], int]) -> Callable[[Results, int | None], tuple[Result, int]]:
    """Result of the largest torque, and a position.

    Parameters
    ----------
    default : callable
        Position if none is given; its docstring describes it in a line.
    """

    def shown(results: Results, position: int | None) -> tuple[Result, int]:
        result = heaviest(results)
        return result, default(result) if position is None else position

    shown.__doc__ = f"{largest.__doc__}\n{default.__doc__}"
    return shown


def of_largest_force(result: Result) -> int:
    """Position of the largest force of a site."""
    return int(np.argmax(result.site_force_N.max(axis=1)))


def of_largest_line_load(result: Result) -> int:
    """Position of the largest line load."""
    return int(np.argmax(result.mean_line_load_N_per_mm.max(axis=(1, 2))))


at_largest_force, at_largest_line_load = at(of_largest_force), at(of_largest_line_load)


def picture(shown: Callable[..., Any]) -> Callable[[Function], Function]:
    """List `draw_NAME` in `DRAWINGS`, `plot_NAME` in `PICTURES`; describe its parameters.

    Parameters
    ----------
    shown : callable
        `all_torques`, `largest` or one from `at`, which the function calls.
    """
    which, _, default = (shown.__doc__ or "").partition("\n")
    default = default[:1].lower() + default[1:]

    def listed(function: Function) -> Function:
        kind, _, name = function.__name__.partition("_")
        (DRAWINGS if kind == "draw" else PICTURES)[name] = function
        if shown is not all_torques:
            OF_LARGEST.add(name)
        texts = {
            name: PARAMETERS[name].format(shown=which, default=default)
            for name in signature(function).parameters
        }
        function.__doc__ = with_parameters(cleandoc(function.__doc__ or ""), texts)
        return function

    return listed


@contextmanager
def panels(shown: Results, title: str = "", size: tuple[float, float] = SIZE) -> Iterator[Figure]:
    """Figure for several panels; title and margins are set at the end of the `with` block.

    Parameters
    ----------
    shown : Result, or sequence of Result
        Their name and torques are beside the title.
    title : str
        Above all panels; without it there are no name and torques either.
    size : (float, float)
        Inches.
    """
    with rc_context(STYLE):
        figure = empty_figure(size)
        yield figure
        if title:
            set_title(figure, subtitle(shown), title)
        fit(figure)


def figure_of(
    draw: Callable[..., None],
    shown: Results,
    title: str,
    *,
    second: str = "",
    pad: float = 6.0,
    size: tuple[float, float] = SIZE,
    projection: str | None = None,
    **options: Any,
) -> Figure:
    """Figure of one panel.

    Parameters
    ----------
    draw : callable
        The function `draw_NAME`.
    shown : Result, or sequence of Result
        The argument of `draw`; name and torques are beside the title.
    second : str
        Title of the panel, below that of the figure.
    pad : float
        Space below the second title, points.
    size : (float, float)
        Inches.
    projection : str, optional
        Projection for `add_subplot`.
    **options
        Options of `draw`.
    """
    with panels(shown, title if second else "", size) as figure:
        axes = figure.add_subplot(projection=projection)
        draw(axes, shown, **options)
        if second:
            axes.set_title(second, loc="left", pad=pad, **SMALL)
        else:
            axes.set_title(title)
            axes.set_title(subtitle(shown), loc="right", **SMALL)
    return figure


def with_parameters(words: str, texts: Mapping[str, str]) -> str:
    """A docstring with its parameters, before what it raises."""
    before, raises, after = words.partition("\n\nRaises\n")
    listed = "\n".join(f"{name} : {text}" for name, text in texts.items())
    return f"{before}\n\nParameters\n----------\n{listed}{raises}{after}"
