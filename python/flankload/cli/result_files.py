"""The files of the command run."""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

from flankload.cli.outputs import STDOUT, check_file, check_folder
from flankload.errors import SceneError

if TYPE_CHECKING:
    from argparse import Namespace
    from collections.abc import Iterator, Sequence

    from flankload.result import Result, StiffnessTable
    from flankload.result.export import CsvForm
    from flankload.scene import Scene

#: Options that name a file, by their names in the arguments; those that can be printed first.
PRINTABLE = ("json", "csv", "stiffness_csv", "modelica", "report")
FILES = (*PRINTABLE, "xlsx", "fmu")
FORM_WORDS = ("semicolon", "tab", "decimal-comma", "degrees")


def files_of(arguments: Namespace) -> dict[str, str]:
    """Requested files by their options."""
    named = {f"--{key.replace('_', '-')}": getattr(arguments, key) for key in FILES}
    return {key: path for key, path in named.items() if path is not None}


def places_of(arguments: Namespace) -> Iterator[tuple[str, Path]]:
    """Paths that will be written, by option."""
    for key, path in files_of(arguments).items():
        if path != STDOUT:
            yield key, Path(path)
    for key in ("plot", "vtu"):
        if getattr(arguments, key) is not None:
            yield f"--{key}", getattr(arguments, key)


def check_outputs(arguments: Namespace, formats: Sequence[str]) -> None:
    """Refuse outputs that could not be written, before the computation.

    Parameters
    ----------
    arguments : Namespace
    formats : sequence of str
        Of the plots.

    Raises
    ------
    SceneError
    """
    files = files_of(arguments)
    printed = [key for key, path in files.items() if path == STDOUT]
    for key in printed:
        if key not in {f"--{name.replace('_', '-')}" for name in PRINTABLE}:
            raise SceneError(key=key, expected="a file, since it is no text", found="-")
    if len(printed) > 1:
        raise SceneError(
            key=printed[1], expected=f"a file, since {printed[0]} uses stdout", found="-"
        )
    for key, path in files.items():
        if path != STDOUT:
            check_file(key, Path(path))
    if arguments.xlsx is not None and find_spec("openpyxl") is None:
        expected = "the package openpyxl: pip install 'flankload[xlsx]'"
        raise SceneError(key="--xlsx", expected=expected, found="none")
    if arguments.plot is not None:
        kinds = " and ".join(kind.upper() for kind in formats)
        check_folder("--plot", arguments.plot, content=f"{kinds} files")
    if arguments.vtu is not None:
        check_folder("--vtu", arguments.vtu, content="VTU files")
    csv_form(arguments.csv_format)
    if arguments.csv_format and arguments.csv is None and arguments.stiffness_csv is None:
        expected = "--csv FILE or --stiffness-csv FILE beside it"
        raise SceneError(key="--csv-format", expected=expected, found="neither")
    positions = indices(arguments.vtu_positions)
    if positions is not None and arguments.vtu is None:
        raise SceneError(
            key="--vtu-positions", expected="--vtu DIR beside it", found=arguments.vtu_positions
        )


def csv_form(words: str) -> CsvForm:
    """The form of CSV files from words with commas between them.

    Raises
    ------
    SceneError
        If a word is unknown, or two name a separator.
    """
    from flankload.result.export import SEPARATORS, CsvForm

    found = [word.strip() for word in words.split(",")] if words else []
    separators = [word for word in found if word in SEPARATORS]
    if not set(found) <= set(FORM_WORDS) or len(separators) > 1:
        raise SceneError(
            key="--csv-format",
            expected=f"words among {', '.join(FORM_WORDS)}, with one separator",
            found=words,
        )
    return CsvForm(
        separator=SEPARATORS[separators[0]] if separators else None,
        decimal_comma="decimal-comma" in found,
        degrees="degrees" in found,
    )


def indices(text: str) -> list[int] | None:
    """Indices with commas between them; None if there are none.

    Raises
    ------
    SceneError
        If a part is no index.
    """
    parts = [part.strip() for part in text.split(",")] if text else []
    if not all(part.isascii() and part.isdigit() for part in parts):
        raise SceneError(
            key="--vtu-positions", expected="indices such as 0,8,16", found=f"'{text}'"
        )
    return [int(part) for part in parts] or None


def write_files(
    arguments: Namespace, scene: Scene, results: Sequence[Result], *, listed: bool
) -> list[str]:
    """Write or print the requested files.

    Parameters
    ----------
    arguments : Namespace
    scene : Scene
    results : sequence of Result
        One per torque.
    listed : bool
        Whether the scene has a list of torques.

    Returns
    -------
    list of str
        Lines about files that need words.

    Raises
    ------
    SceneError
        If the positions do not suit a file.
    """
    from flankload.result import (
        results_to_csv,
        results_to_json,
        results_to_xlsx,
        stiffness_table,
    )

    form, said = csv_form(arguments.csv_format), []
    if arguments.json is not None:
        _write(arguments.json, results_to_json(results if listed else results[0]))
    if arguments.csv is not None:
        _write(arguments.csv, results_to_csv(results, form=form))
    if arguments.xlsx is not None:
        results_to_xlsx(results, arguments.xlsx)
    tables = (arguments.stiffness_csv, arguments.modelica, arguments.fmu)
    if any(path is not None for path in tables):
        try:
            said += _write_tables(arguments, stiffness_table(results), form)
        except SceneError as error:
            raise error.with_file(scene.file or "scene") from None
    if arguments.vtu is not None:
        from flankload.export import write_vtu

        positions = indices(arguments.vtu_positions)
        said += write_vtu(scene, results, arguments.vtu, positions=positions)
    return said


def _write_tables(arguments: Namespace, table: StiffnessTable, form: CsvForm) -> list[str]:
    """Write tables over angle and torque."""
    if arguments.stiffness_csv is not None:
        _write(arguments.stiffness_csv, table.to_csv(form=form))
    if arguments.modelica is not None:
        _write(arguments.modelica, table.to_modelica())
    if arguments.fmu is None:
        return []
    compiled = table.to_fmu(arguments.fmu)
    content = "a library for linux64" if compiled else "no library, since there is no C compiler"
    return [f"{arguments.fmu}: C sources and {content}"]


def _write(path: str, text: str) -> None:
    """Write a text, or print it."""
    if path == STDOUT:
        print(text, end="")
        return
    from flankload.base.files import write_atomically

    write_atomically(path, text)
