"""Common parts of all plots: style, colours, words, and figures without a screen.

A colour has one meaning in all pictures of a result: `COLOURS` are pairs, `BODIES` the two bodies,
`torque_colours` torques, `FORCE` forces; `INK` and its tints are quantities of the whole drive.
"""

from __future__ import annotations

import contextlib
import io
import warnings
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib import colormaps, rc_context
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.font_manager import fontManager

from flankload.base.arguments import require_path
from flankload.base.files import write_atomically

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from numpy.typing import NDArray

    from flankload.result import Result

#: Colours that are distinguishable for colour-blind readers (Okabe and Ito), and in grey by their
#: order. In pictures of a result they are pairs; in those of studies, series.
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
#: Areas of both bodies, and lines of both bodies: darker tones of the same.
STEEL = ("#dfe5ea", "#ece5da")
BODIES = ("#4a6b82", "#8f6f2e")
#: Arrows and curves of forces.
FORCE = "#a3293d"
#: A quantity of the whole drive; a second and a third one beside it.
INK, SLATE, PALE = "#2b2140", "#6f7f90", "#b4bfca"
GREY = "#555555"
#: Torques from the least to the largest: part of a map of colours from light to dark.
TORQUE_MAP, TORQUE_RANGE = "viridis", (0.78, 0.05)

#: Used if installed: for scripts that matplotlib's default font does not have.
OTHER_SCRIPTS = (
    "Noto Sans CJK JP", "Noto Sans CJK SC", "Noto Sans JP", "Noto Sans SC", "IPAexGothic",
    "WenQuanYi Zen Hei", "Droid Sans Fallback", "Hiragino Sans", "PingFang SC", "Yu Gothic",
    "Microsoft YaHei", "Malgun Gothic", "Arial Unicode MS", "Noto Sans Devanagari",
    "Noto Sans Thai", "Noto Sans Bengali", "Noto Sans Tamil",
)  # fmt: skip

INSTALLED = frozenset(fontManager.get_font_names())

STYLE: Any = {
    "font.family": ["DejaVu Sans", *(name for name in OTHER_SCRIPTS if name in INSTALLED)],
    "text.parse_math": False,  # names of scenes are words, whatever is in them
    "font.size": 10,
    "axes.titlesize": 11,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.titley": 1.0,  # not searched for: titles have no axis above the panel to avoid
    "axes.labelsize": 10,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": "#e2e2e2",
    "grid.linewidth": 0.6,
    "axes.axisbelow": True,
    "lines.linewidth": 1.8,
    "legend.frameon": False,
    "legend.fontsize": 9,
    "savefig.dpi": 160,
    "svg.hashsalt": "flankload",  # the same picture, the same file
}

#: Formats of files, and what `savefig` receives for them.
FORMATS: dict[str, dict[str, Any]] = {
    "png": {"pil_kwargs": {"compress_level": 1}},  # an eighth more bytes, a third of the time
    "svg": {"metadata": {"Date": None}},
    "pdf": {"metadata": {"CreationDate": None}},
}

LONGEST_NAME = 48  # characters beside the title

SIZE = (7.2, 4.2)  # inches: a text width of A4 with margins


class Picture(Figure):
    """Figure without pyplot on an Agg canvas; notebooks show it without any setting."""

    def __init__(self, *arguments: Any, **options: Any) -> None:
        super().__init__(*arguments, **options)
        FigureCanvasAgg(self)

    def _repr_png_(self) -> bytes:
        return png_of(self)


def new_figure(size: tuple[float, float]) -> Figure:
    """Figure with margins by a layout engine, in inches."""
    return Picture(figsize=size, layout="constrained")


def png_of(figure: Figure) -> bytes:
    """The plot as PNG; a letter missing in all fonts is a box."""
    return file_of(figure, "png")


def write_pictures(directory: str | Path, drawn: Mapping[str, bytes]) -> tuple[Path, ...]:
    """Write pictures by their names to a folder, which is created if it does not exist."""
    require_path("directory", directory)
    folder = Path(directory)
    folder.mkdir(parents=True, exist_ok=True)
    for name, content in drawn.items():
        write_atomically(folder / name, content)
    return tuple(folder / name for name in drawn)


@contextlib.contextmanager
def missing_letters_are_boxes() -> Iterator[None]:
    """No warning of a letter that no font has."""
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", r"Glyph \d+ .* missing from", UserWarning)
        # matplotlib before 3.10 sets such scripts letter by letter, with a warning
        warnings.filterwarnings("ignore", r"Matplotlib currently does not support", UserWarning)
        yield


def file_of(figure: Figure, kind: str, dpi: float | None = None) -> bytes:
    """The plot as a file of a format of `FORMATS`, without the time of writing."""
    out = io.BytesIO()
    with rc_context(STYLE), missing_letters_are_boxes():
        figure.savefig(out, format=kind, dpi=dpi or STYLE["savefig.dpi"], **FORMATS[kind])
    return out.getvalue()


def short(name: str) -> str:
    """A name on one line, cut before it reaches the title."""
    line = "".join(letter if letter.isprintable() else " " for letter in " ".join(name.split()))
    return line if len(line) <= LONGEST_NAME else line[: LONGEST_NAME - 1].rstrip() + "…"


def torque_colours(count: int) -> list[Any]:
    """Colours (r, g, b, a) of ascending torques; one alone has the colour of the largest."""
    places = np.linspace(*TORQUE_RANGE, count) if count > 1 else TORQUE_RANGE[1:]
    return [colormaps[TORQUE_MAP](place) for place in places]


def loaded_sites(result: Result) -> list[tuple[int, int]]:
    """(Column, pair number) of the pairs that carry load at any position."""
    return [
        (s, int(site))
        for s, site in enumerate(result.sites)
        if (result.site_force_N[:, s] > 0).any()
    ]


def coast_sites(result: Result) -> list[tuple[int, int]]:
    """(Column, pair number) of the coast flanks that carry load at any position."""
    if result.coast is None:
        return []
    carries = (result.coast.force_N > 0).any(axis=0)
    return [(int(s), int(result.sites[s])) for s in np.flatnonzero(carries)]


def colour_of(result: Result, site: int) -> str:
    """Colour of a pair, the same in every plot of a result.

    The loaded pairs get the colours in the order 0, -1, 1, -2, 2, ..., so that a few pairs never
    share one, however far from pair 0 they are.
    """
    order = sorted({j for _, j in loaded_sites(result) + coast_sites(result)}, key=_turn)
    return COLOURS[order.index(site) % len(COLOURS)]


def _turn(site: int) -> int:
    return 2 * abs(site) - (site < 0)


def pair_name(site: int) -> str:
    return f"pair {site}".replace("-", "−")


def at_corner(result: Result) -> NDArray[np.bool_]:
    return np.asarray((result.corner_contact & (result.site_force_N > 0)).any(axis=1))
