"""Pictures of a design study that suit its designs."""

from __future__ import annotations

from functools import partial
from math import ceil
from pathlib import Path
from typing import TYPE_CHECKING, Any

from matplotlib import rc_context

from flankload.base.files import write_atomically
from flankload.plot.study_axes import (
    chosen_torques,
    draw_bands,
    draw_curve,
    draw_histogram,
    draw_map,
    draw_over_torque,
    draw_pareto,
)
from flankload.plot.study_table import StudyTable
from flankload.plot.style import GREY, SIZE, STYLE, new_figure, png_of, short

if TYPE_CHECKING:
    from collections.abc import Callable

    from matplotlib.figure import Figure

    from flankload.studies.design import DesignStudy

#: Inches of a panel if there are several.
PANEL = (4.6, 3.9)


def study_figures(study: DesignStudy) -> dict[str, Callable[[], Figure]]:
    """Pictures that suit a study, by name; each is drawn when it is called.

    Parameters
    ----------
    study : DesignStudy

    Returns
    -------
    dict of callable
        For each quantity: `map_…` (factorial, two or more variables, over the first two) or
        `curve_…` (one variable, or each alone), and `torques_…` for several torques. For random
        and Sobol designs `bands_…` of curves over the positions and `histogram_…`. `pareto` of the
        first two quantities with one number per design.
    """
    table, kind = StudyTable(study), study.designs.kind
    names, drawn = table.variables, kind in ("random", "sobol")
    torques, figure = chosen_torques(table.torques_Nm.shape[1]), partial(_figure, study)
    found: dict[str, Callable[[], Figure]] = {}

    def add(name: str, title: str, draw: Callable[..., None], *arguments: Any) -> None:
        found[name] = partial(figure, title, [(draw, *arguments, t) for t in torques])

    for quantity in table.numbers:
        if drawn:
            add(f"histogram_{quantity}", "Distribution", draw_histogram, quantity)
        elif kind == "factorial" and len(names) > 1:
            add(f"map_{quantity}", "Map over two variables", draw_map, quantity, names[:2])
        elif names and (kind == "one-at-a-time" or len(names) == 1):
            title = "Curve over one variable" if len(names) == 1 else "Each variable alone"
            panels = [(draw_curve, quantity, name) for name in names]
            found[f"curve_{quantity}"] = partial(figure, title, panels)
        if len(torques) > 1:
            lines = [(draw_over_torque, quantity)]
            found[f"torques_{quantity}"] = partial(figure, "Designs over the torque", lines)
    for quantity in table.curves if drawn else ():
        add(f"bands_{quantity}", "Percentiles over the positions", draw_bands, quantity)
    if len(table.numbers) > 1 and len(table.designs) > 1:
        add("pareto", "Pareto front", draw_pareto, table.numbers[:2])
    return found


def write_study(study: DesignStudy, directory: str | Path) -> tuple[Path, ...]:
    """Write the pictures that suit a study as PNG, all or none.

    Parameters
    ----------
    study : DesignStudy
    directory : path
        Created if it does not exist.

    Returns
    -------
    tuple of Path
        Names of `study_figures` with the suffix .png.

    Raises
    ------
    OSError
        If the directory cannot be created or a file cannot be written.
    """
    drawn = {f"{name}.png": png_of(figure()) for name, figure in study_figures(study).items()}
    folder = Path(directory)
    folder.mkdir(parents=True, exist_ok=True)
    for name, content in drawn.items():
        write_atomically(folder / name, content)
    return tuple(folder / name for name in drawn)


def _figure(study: DesignStudy, title: str, panels: list[tuple[Any, ...]]) -> Figure:
    """A figure with a panel for each function and its arguments; two in a row."""
    columns = min(2, len(panels))
    lines = ceil(len(panels) / columns)
    with rc_context(STYLE | {"axes.formatter.useoffset": False}):
        size = SIZE if columns == 1 else (PANEL[0] * columns, PANEL[1] * lines)
        figure = new_figure(size)
        figure.suptitle(title, x=0.01, ha="left", fontsize=11, fontweight="bold")
        text = f"{short(study.name)}, {len(study.rows)} design{'s' * (len(study.rows) != 1)}"
        figure.text(0.99, 0.985, text, ha="right", va="top", fontsize=9, color=GREY)
        for k, (draw, *arguments) in enumerate(panels):
            draw(figure.add_subplot(lines, columns, k + 1), study, *arguments)
        return figure
