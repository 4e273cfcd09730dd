"""The plots of a result as methods: `result.plot.transmission_error(axes)`.

The package with the plots is imported at first use: it depends on this one.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from flankload.result.quantities import torques_of

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Sequence
    from pathlib import Path

    from flankload.result.forms import ResultForms
    from flankload.result.result import Result


class Plots:
    """Methods that draw the plots of results of one scene, one per torque.

    Each plot of `flankload.plot.PICTURES` is a method with the name of the file that
    `flankload run --plot` writes, for example `transmission_error(ax=None)` or
    `loaded_pair(ax=None, *, position=None)`; `help` describes it. It draws on the given
    `matplotlib.axes.Axes`, without a title, or on those of a new figure with title and margins, and
    returns the Axes. The state of `matplotlib.pyplot` is neither used nor changed. A new figure can
    be written by `axes.figure.savefig`. Plots of one torque show the largest one.

    Parameters
    ----------
    results : Result, or sequence of Result of single torques
    """

    def __init__(self, results: ResultForms | Sequence[Result]) -> None:
        self._results = torques_of(results)

    def __getattr__(self, name: str) -> Callable[..., Any]:
        # names with an underscore are those that Python and notebooks look for in any object
        if name.startswith("_") or name not in _plot().PICTURES:
            raise AttributeError(f"plot: expected one of dir(result.plot), found {name!r}")
        method: Callable[..., Any] = _plot().method_of(name, self._results)
        return method

    def __dir__(self) -> Iterable[str]:
        return [*super().__dir__(), *_plot().PICTURES]

    def names(self) -> tuple[str, ...]:
        """Names of the plots that suit the results."""
        return tuple(_plot().pictures_of(self._results))

    def all(self, folder: str | Path, **options: Any) -> tuple[Path, ...]:
        """Write all plots that suit the results, as `flankload run --plot`.

        Parameters
        ----------
        folder : path
            Created if it does not exist.
        **options
            `formats` (sequence of "png", "svg", "pdf"), `dpi`, `size_mm` (width, height).

        Returns
        -------
        tuple of Path
        """
        return tuple(_plot().plot_all(self._results, folder, **options))


def _plot() -> Any:
    return import_module("flankload.plot")
