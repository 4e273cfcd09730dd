"""Files and plots of the command run: options, checks, writing."""

from __future__ import annotations

from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

from flankload.cli.outputs import STDOUT, Output, check_outputs, refuse, write_text

if TYPE_CHECKING:
    from argparse import Namespace
    from collections.abc import Sequence

    from flankload.result import Result, StiffnessTable
    from flankload.result.export import CsvForm
    from flankload.scene import Scene

#: Options that name a file, by their names in the arguments.
FILES = ("json", "csv", "stiffness_csv", "modelica", "report", "xlsx", "fmu")
FORM_WORDS = ("semicolon", "tab", "decimal-comma", "degrees")
FORMATS = ("png", "svg", "pdf")
#: Range of pixels per inch, and of width and height in mm.
DPI, MM = (30.0, 1200.0), (40.0, 1000.0)


def files_of(arguments: Namespace) -> dict[str, str]:
    """Requested files by their options."""
    named = {f"--{key.replace('_', '-')}": getattr(arguments, key) for key in FILES}
    return {key: path for key, path in named.items() if path is not None}


def check_files(arguments: Namespace, formats: Sequence[str]) -> list[Output]:
    """Refuse outputs that could not be written; the others without stdout. Plots have formats."""
    files = files_of(arguments)
    for key in ("--xlsx", "--fmu"):
        if files.get(key) == STDOUT:
            refuse(key, "a file, since it is no text", STDOUT)
    kinds = " and ".join(kind.upper() for kind in formats)
    vtu_names: tuple[str, ...] = ()
    if arguments.vtu is not None:
        from flankload.export import fields

        vtu_names = fields.NAMES
    folders = [
        ("--plot", arguments.plot, f"{kinds} files", tuple(f"*.{kind}" for kind in formats)),
        ("--vtu", arguments.vtu, "VTU files", vtu_names),
    ]
    places = check_outputs(files.items(), folders)
    if arguments.xlsx is not None and find_spec("openpyxl") is None:
        refuse("--xlsx", "the package openpyxl: pip install 'flankload[xlsx]'", "none")
    csv_form(arguments.csv_format)
    if arguments.csv_format and arguments.csv is None and arguments.stiffness_csv is None:
        refuse("--csv-format", "--csv FILE or --stiffness-csv FILE beside it", "neither")
    if indices(arguments.vtu_positions) is not None and arguments.vtu is None:
        refuse("--vtu-positions", "--vtu DIR beside it", arguments.vtu_positions)
    return places


def check_tables(arguments: Namespace, scene: Scene) -> None:
    """Refuse tables over angle and torque for which the scene has no stiffness."""
    option = next((f"--{x}" for x in ("modelica", "fmu") if getattr(arguments, x) is not None), "")
    if option and not all(scene.torques_Nm):
        refuse("load.torque_Nm", f"torques > 0, since {option} needs stiffness", "0", scene.file)
    if option and not scene.accuracy.tangents:
        expected = f"true, since {option} needs tangent stiffness"
        refuse("accuracy.tangents", expected, "false", scene.file)


def csv_form(words: str) -> CsvForm:
    """The form of CSV files from words with commas between them, one separator at most."""
    from flankload.result.export import SEPARATORS, CsvForm

    found = [word.strip() for word in words.split(",")] if words else []
    separators = [word for word in found if word in SEPARATORS]
    if not set(found) <= set(FORM_WORDS) or len(separators) > 1:
        expected = f"words among {', '.join(FORM_WORDS)}, with one separator"
        refuse("--csv-format", expected, words)
    return CsvForm(
        separator=SEPARATORS[separators[0]] if separators else None,
        decimal_comma="decimal-comma" in found,
        degrees="degrees" in found,
    )


def indices(text: str) -> list[int] | None:
    """Indices with commas between them; None if there are none."""
    parts = [part.strip() for part in text.split(",")] if text else []
    if not all(part.isascii() and part.isdigit() for part in parts):
        refuse("--vtu-positions", "indices such as 0,8,16", f"'{text}'")
    return [int(part) for part in parts] or None


def write_files(
    arguments: Namespace, scene: Scene, results: Sequence[Result], *, listed: bool
) -> list[str]:
    """Write or print the requested files; lines about those that need words.

    There is a result per torque; `listed`: the scene has a list of torques.
    """
    from flankload import result as forms
    from flankload.scene.refusal import in_file

    form, said = csv_form(arguments.csv_format), []
    if arguments.json is not None:
        write_text(arguments.json, forms.results_to_json(results if listed else results[0]))
    if arguments.csv is not None:
        write_text(arguments.csv, forms.results_to_csv(results, form=form))
    if arguments.xlsx is not None:
        forms.results_to_xlsx(results, arguments.xlsx)
    tables = (arguments.stiffness_csv, arguments.modelica, arguments.fmu)
    if any(path is not None for path in tables):
        with in_file(scene.file or "scene"):
            said += _write_tables(arguments, forms.stiffness_table(results), form)
    if arguments.vtu is not None:
        from flankload.export import write_vtu

        chosen = indices(arguments.vtu_positions)
        said += write_vtu(scene, results, arguments.vtu, positions=chosen)
    return said


def _write_tables(arguments: Namespace, table: StiffnessTable, form: CsvForm) -> list[str]:
    """Write tables over angle and torque."""
    if arguments.stiffness_csv is not None:
        write_text(arguments.stiffness_csv, table.to_csv(form=form))
    if arguments.modelica is not None:
        write_text(arguments.modelica, table.to_modelica())
    if arguments.fmu is None:
        return []
    compiled = table.to_fmu(arguments.fmu)
    content = "a library for linux64" if compiled else "no library, since there is no C compiler"
    return [f"{arguments.fmu}: C sources and {content}"]


def plot_options(arguments: Namespace) -> dict[str, Any]:
    """Formats, resolution and size of the plots: keywords of `flankload.plot.plot_all`."""
    given = {"--format": arguments.formats, "--dpi": arguments.dpi, "--size": arguments.size}
    for key, value in given.items():
        if value and arguments.plot is None:
            refuse(key, "--plot DIR beside it", "no --plot")
    dpi, size, sizes = arguments.dpi, arguments.size, "WxH, such as 160x100, each {} mm"
    return {
        "formats": _formats(arguments.formats),
        "dpi": None if dpi is None else _numbers("--dpi", dpi, 1, DPI, "a number {}")[0],
        "size_mm": None if size is None else _numbers("--size", size, 2, MM, sizes),
    }


def _formats(given: list[str]) -> tuple[str, ...]:
    """Formats in their order, each once."""
    names = [name.strip().lower() for each in given for name in each.split(",")]
    for name in names:
        if name not in FORMATS:
            refuse("--format", "png, svg or pdf, or several with commas", repr(name))
    return tuple(dict.fromkeys(names)) or FORMATS[:1]


def _numbers(
    key: str, text: str, count: int, bounds: tuple[float, float], what: str
) -> tuple[float, ...]:
    """Numbers with x between them, all within bounds."""
    try:
        numbers = tuple(float(part) for part in text.lower().replace("×", "x").split("x"))
    except ValueError:
        numbers = ()
    low, high = bounds
    if len(numbers) != count or not all(low <= number <= high for number in numbers):
        refuse(key, what.format(f"from {low:g} to {high:g}"), repr(text))
    return numbers
