"""Pictures as pairs of functions, made from the function that draws what one of them shows.

`draw_NAME(axes, results)` draws on given Axes, without a title; `plot_NAME(results)` returns a
figure with title and margins. A picture shows all torques, the largest one, or that at a position.
"""

from __future__ import annotations

from inspect import Parameter, Signature, cleandoc, signature
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib import rc_context

from flankload.plot.figures import as_results, empty_figure, fit, heaviest, set_title, subtitle
from flankload.plot.style import GREY, SIZE, STYLE

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from flankload.result import Result

    Results = Result | Sequence[Result]
    #: What a picture shows of the results: the arguments of the function that draws it.
    Shown = Callable[..., tuple[Any, ...]]
    #: A text, or a function of what is shown.
    Words = str | Callable[..., str]
    Paint = Callable[..., None]

#: All plots by name.
PICTURES: dict[str, Callable[..., Figure]] = {}
#: The functions that draw them on given Axes; of several panels they draw one.
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
    "quantity": "str\n    One of `QUANTITIES`; a figure shows four unless one is given.",
}
TYPES = {"axes": "Axes", "results": "Result | Sequence[Result]"}
SMALL: dict[str, Any] = {"fontsize": 9, "fontweight": "normal", "color": GREY}


def all_torques(results: Results) -> tuple[tuple[Result, ...]]:
    """Each is drawn."""
    return (as_results(results),)


def largest(results: Results) -> tuple[Result]:
    """The one of the largest torque is drawn."""
    return (heaviest(results),)


def at(default: Callable[[Result], int]) -> Callable[..., tuple[Result, int]]:
    """Result of the largest torque, and a position.

    Parameters
    ----------
    default : callable
        Position if none is given; its docstring describes it in a line.
    """

    def shown(results: Results, position: int | None = None) -> tuple[Result, int]:
        result = heaviest(results)
        return result, default(result) if position is None else position

    shown.__doc__ = f"{largest.__doc__}\n{default.__doc__}"
    return shown


def of_largest_force(result: Result) -> int:
    """Position of the largest force of a site."""
    return int(np.argmax(result.site_force_N.max(axis=1)))


def of_largest_line_load(result: Result) -> int:
    """Position of the largest line load."""
    return int(np.argmax(result.slice_line_load_N_per_mm.max(axis=(1, 2))))


def picture(
    shown: Shown,
    title: Words = "",
    *,
    second: Words = "",
    pad: float = 6.0,
    size: tuple[float, float] = SIZE,
    **axes_options: Any,
) -> Callable[[Paint], Paint]:
    """Make `draw_NAME` from a function that draws on Axes; with a title also `plot_NAME`.

    Parameters
    ----------
    shown : callable
        `all_torques`, `largest` or `at(…)`.
    title : str or callable
        Title of a figure with this panel alone, beside name and torque. Without it, `plot_NAME` is
        made by `panels`.
    second : str or callable
        Title of the panel, below that of the figure.
    pad : float
        Space below the second title, points.
    size : (float, float)
        Inches.
    **axes_options
        Of `add_subplot`.
    """

    def make(paint: Paint) -> Paint:
        def draw(axes: Axes, results: Results, **options: Any) -> None:
            paint(axes, *_taken(shown, results, options), **options)

        def fill(drawn: Figure, *what: Any) -> None:
            axes = drawn.add_subplot(**axes_options)
            paint(axes, *what)
            if second:
                axes.set_title(_words(second, what), loc="left", pad=pad, **SMALL)
            else:
                axes.set_title(_words(title, what))
                axes.set_title(subtitle(what[0]), loc="right", **SMALL)

        name = paint.__name__.removeprefix("draw_")
        if title:
            fill.__module__, fill.__name__ = paint.__module__, f"plot_{name}"
            fill.__doc__ = paint.__doc__
            panels(shown, title if second else "", size)(fill)
        if shown is not all_torques:
            OF_LARGEST.add(name)
        DRAWINGS[name] = _public(draw, paint, ("axes", "results"), shown)
        return DRAWINGS[name]

    return make


def panels(
    shown: Shown, title: Words = "", size: tuple[float, float] = SIZE
) -> Callable[[Paint], Callable[..., Figure]]:
    """Make `plot_NAME`, kept in `PICTURES`, from a function that fills a figure with panels.

    Parameters
    ----------
    shown : callable
        `all_torques`, `largest` or `at(…)`.
    title : str or callable
        Above all panels, beside name and torques.
    size : (float, float)
        Inches.
    """

    def make(fill: Paint) -> Callable[..., Figure]:
        def plot(results: Results, **options: Any) -> Figure:
            what = _taken(shown, results, options)
            with rc_context(STYLE):
                drawn = empty_figure(size)
                fill(drawn, *what, **options)
                if title:
                    set_title(drawn, subtitle(what[0]), _words(title, what))
                fit(drawn)
                return drawn

        made = _public(plot, fill, ("results",), shown)
        PICTURES[fill.__name__.removeprefix("plot_")] = made
        return made

    return make


def _taken(shown: Shown, results: Results, options: dict[str, Any]) -> tuple[Any, ...]:
    """What is shown; its own options are taken from the others."""
    own = [name for name in signature(shown).parameters if name in options]
    return shown(results, **{name: options.pop(name) for name in own})


def _words(text: Words, what: Sequence[Any]) -> str:
    return text(*what) if callable(text) else text


def _public(
    call: Callable[..., Any], source: Paint, first: Sequence[str], shown: Shown
) -> Callable[..., Any]:
    """A function with the name and words of its source; options are those of both its parts."""
    form = _form(source, first, shown)

    def public(*given: Any, **named: Any) -> Any:
        return call(**form.bind(*given, **named).arguments)

    which, _, default = (shown.__doc__ or "").partition("\n")
    default = default[:1].lower() + default[1:]
    texts = {
        name: PARAMETERS[name].format(shown=which, default=default) for name in form.parameters
    }
    words = cleandoc(source.__doc__ or "")
    if "axes" not in first:
        words = f"Figure of {words.removeprefix('Draw ')}"
    public.__module__ = source.__module__
    public.__name__ = public.__qualname__ = source.__name__
    public.__doc__ = with_parameters(words, texts)
    vars(public)["__signature__"] = form
    return public


def with_parameters(words: str, texts: Mapping[str, str]) -> str:
    """A docstring with its parameters, before what it raises."""
    before, raises, after = words.partition("\n\nRaises\n")
    listed = "\n".join(f"{name} : {text}" for name, text in texts.items())
    return f"{before}\n\nParameters\n----------\n{listed}{raises}{after}"


def _form(source: Paint, first: Sequence[str], shown: Shown) -> Signature:
    """Options of `draw_NAME` are named; those of `plot_NAME` may also follow the results."""
    place = Parameter.POSITIONAL_OR_KEYWORD
    options = list(signature(shown).parameters.values())[1:]
    for option in signature(source).parameters.values():
        options += [option] * (option.kind is Parameter.KEYWORD_ONLY)
    on_axes = "axes" in first
    kind = Parameter.KEYWORD_ONLY if on_axes else place
    named = [Parameter(name, place, annotation=TYPES[name]) for name in first]
    parameters = [*named, *(option.replace(kind=kind) for option in options)]
    return Signature(parameters, return_annotation="None" if on_axes else "Figure")
