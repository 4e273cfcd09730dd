"""Options of the plots."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from flankload.errors import SceneError

if TYPE_CHECKING:
    from argparse import Namespace

FORMATS = ("png", "svg", "pdf")
#: Range of pixels per inch, and of width and height in mm.
DPI, MM = (30.0, 1200.0), (40.0, 1000.0)


def plot_options(arguments: Namespace) -> dict[str, Any]:
    """Formats, resolution and size of the plots.

    Parameters
    ----------
    arguments : Namespace
        With `plot`, `formats`, `dpi` and `size` as on the command line.

    Returns
    -------
    dict
        Keywords of `flankload.plot.plot_all`.

    Raises
    ------
    SceneError
        If an option has no meaning, or there is no --plot.
    """
    given = {"--format": arguments.formats, "--dpi": arguments.dpi, "--size": arguments.size}
    for key, value in given.items():
        if value and arguments.plot is None:
            raise SceneError(key=key, expected="--plot DIR beside it", found="no --plot")
    return {
        "formats": _formats(arguments.formats),
        "dpi": None if arguments.dpi is None else _number("--dpi", arguments.dpi, DPI, "a number"),
        "size_mm": None if arguments.size is None else _size(arguments.size),
    }


def _formats(given: list[str]) -> tuple[str, ...]:
    """Formats in their order, each once."""
    names = [name.strip().lower() for each in given for name in each.split(",")]
    for name in names:
        if name not in FORMATS:
            expected = "png, svg or pdf, or several with commas"
            raise SceneError(key="--format", expected=expected, found=repr(name))
    return tuple(dict.fromkeys(names)) or FORMATS[:1]


def _size(given: str) -> tuple[float, float]:
    parts = given.lower().replace("×", "x").split("x")
    what = "WxH, such as 160x100, each"
    if len(parts) != 2:
        raise _wrong("--size", given, MM, what, " mm")
    width, height = (_number("--size", part, MM, what, " mm", given) for part in parts)
    return width, height


def _number(
    key: str, text: str, bounds: tuple[float, float], what: str, unit: str = "", given: str = ""
) -> float:
    try:
        number = float(text)
    except ValueError:
        number = float("nan")
    if not bounds[0] <= number <= bounds[1]:
        raise _wrong(key, given or text, bounds, what, unit)
    return number


def _wrong(key: str, given: str, bounds: tuple[float, float], what: str, unit: str) -> SceneError:
    expected = f"{what} from {bounds[0]:g} to {bounds[1]:g}{unit}"
    return SceneError(key=key, expected=expected, found=repr(given))
