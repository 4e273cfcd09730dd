"""Results as a workbook (.xlsx): a sheet with the summary, then one per quantity."""

from __future__ import annotations

import io
from collections.abc import Sequence
from math import degrees, isfinite
from typing import TYPE_CHECKING, Any

import numpy as np

from flankload.base.files import write_atomically
from flankload.base.optional import optional
from flankload.result.quantities import (
    ALONG_POSITIONS,
    OVER_SITES,
    SINGLE_NUMBERS,
    along_positions,
    by_path,
    column,
    over_sites,
    over_slices,
    site_column,
    torques_of,
    units_of,
)

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from flankload.result.result import Result

#: Longest name of a sheet.
LONGEST_NAME = 31
#: Width of a column, in characters.
WIDTH, WIDE = 18, 48

Row = Sequence[Any]


def results_to_xlsx(results: Result | Sequence[Result], path: str | Path) -> None:
    """Write a result, or results of single torques, as a workbook.

    The sheet `summary` has the numbers of `Result.summary` and the estimated errors, a column per
    torque, then violated premises and warnings. Each further sheet is a quantity with its unit in
    the heads: a row per position, a column per torque, or per torque and pair (and slice). A cell
    is empty if there is not a number.

    Raises
    ------
    ImportError
        If openpyxl is not installed.
    ValueError
        If the results have different positions.
    """
    openpyxl = optional("openpyxl", "to_xlsx", extra="xlsx")
    several = torques_of(results)
    first = several[0]
    if any(not np.array_equal(first.position_rad, one.position_rad) for one in several):
        raise ValueError("results at different positions make no workbook")
    book = openpyxl.Workbook(write_only=True)
    _add_sheet(book, "summary", list(_summary(several)), wide=True)
    for name, rows in _quantities(several):
        _add_sheet(book, _sheet_name(name), rows)
    content = io.BytesIO()
    book.save(content)
    write_atomically(path, content.getvalue())


def _sheet_name(name: str) -> str:
    """Name of a sheet; one that is too long loses its unit, which the heads of the columns have."""
    return name if len(name) <= LONGEST_NAME else name.rpartition("_")[0][:LONGEST_NAME]


def _add_sheet(book: Any, name: str, rows: Sequence[Row], *, wide: bool = False) -> None:
    """A sheet whose first row is bold and stays in view."""
    from openpyxl.cell import WriteOnlyCell
    from openpyxl.cell.cell import ILLEGAL_CHARACTERS_RE
    from openpyxl.styles import Alignment, Font
    from openpyxl.utils import get_column_letter

    def cell(value: Any) -> Any:
        if not isinstance(value := _plain(value), str):
            return value
        found = WriteOnlyCell(sheet, value=ILLEGAL_CHARACTERS_RE.sub("", value))
        found.data_type = "s"  # also if it begins with =, as a formula does
        return found

    sheet = book.create_sheet(name)
    sheet.freeze_panes = "B2" if wide else "C2"
    for k in range(len(rows[0])):
        sheet.column_dimensions[get_column_letter(k + 1)].width = WIDE if wide and not k else WIDTH
    heads = [cell(text) for text in rows[0]]
    for head in heads:
        head.font, head.alignment = Font(bold=True), Alignment(wrap_text=True, vertical="top")
    sheet.append(heads)
    for row in rows[1:]:
        sheet.append([cell(value) for value in row])


def _summary(results: Sequence[Result]) -> Iterator[Row]:
    """Rows of the first sheet."""
    first = results[0]
    yield [first.name, *(f"{result.torque_Nm:.12g} N m" for result in results)]
    for key in SINGLE_NUMBERS:
        yield [key, *(getattr(result, key) for result in results)]
    for part, of_results in (
        ("", [result.summary for result in results]),
        ("estimated error: ", [result.estimate or {} for result in results]),
    ):
        rows = [dict(by_path(values, lambda n: f" {n + 1}")) for values in of_results]
        for key in dict.fromkeys(key for row in rows for key in row):
            yield [f"{part}{key}", *(row.get(key) for row in rows)]
    yield []
    broken = [", ".join(result.outside_limits) or "none" for result in results]
    yield ["violated premises of the model", *broken]
    yield ["warnings", *(len(result.warnings) for result in results)]
    for text in dict.fromkeys(text for result in results for text in result.warnings):
        concerned = ["yes" if text in result.warnings else None for result in results]
        yield [text, *concerned]


def _quantities(results: Sequence[Result]) -> Iterator[tuple[str, list[Row]]]:
    """Names and rows of the sheets of quantities."""
    along = [along_positions(result) for result in results]
    for key, unit in units_of(along, ALONG_POSITIONS).items():
        if key != "position_rad":
            columns = [column(*both, key) for both in zip(results, along, strict=True)]
            heads = [_torque(result, unit) for result in results]
            yield key, _rows(results, heads, zip(*columns, strict=True))
    sites = sorted({int(site) for result in results for site in result.sites})
    over, word = [over_sites(result) for result in results], results[0].engagement.site_word
    for key, unit in units_of(over, OVER_SITES).items():
        heads = [f"{word} {j}, {_torque(result, unit)}" for result in results for j in sites]
        both = zip(results, over, strict=True)
        columns = [site_column(*one, key, j) for one in both for j in sites]
        yield key, _rows(results, heads, zip(*columns, strict=True))
    if all(result.slices is not None for result in results):
        in_slices = [over_slices(result) for result in results]
        for key, (_, unit) in in_slices[0].items():
            heads = [
                f"{word} {j}, z {z:.6g} mm, {_torque(result, unit)}"
                for result in results
                for j in result.sites
                for z in result.slice_z_mm
            ]
            columns = [arrays[key][0].reshape(len(arrays[key][0]), -1) for arrays in in_slices]
            yield key, _rows(results, heads, np.hstack(columns))


def _rows(results: Sequence[Result], heads: Sequence[str], values: Any) -> list[Row]:
    """Rows of a quantity, with the positions in front."""
    angles = results[0].position_rad
    rows = [[angle, degrees(angle), *row] for angle, row in zip(angles, values, strict=True)]
    return [["position [rad]", "position [deg]", *heads], *rows]


def _torque(result: Result, unit: str) -> str:
    return f"{result.torque_Nm:.12g} N m [{unit}]"


def _plain(value: Any) -> Any:
    """A value as a cell holds it; None if it is not finite."""
    plain = value.item() if isinstance(value, np.generic) else value
    if isinstance(plain, bool):
        return int(plain)
    if isinstance(plain, float) and not isfinite(plain):
        return None
    return plain if isinstance(plain, (int, float, str)) or plain is None else str(plain)
