"""Reading of files of named arrays: .npz without pickled objects, and .csv with one table."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from operator import ge, gt, le
from os.path import isdir, isfile
from pathlib import Path
from typing import Any, NamedTuple, NoReturn

import numpy as np
from numpy.typing import NDArray

from flankload.base.array_archive import BadArchive, Member, read_members
from flankload.base.arrays import Flags, Floats, Numbers
from flankload.base.files import LARGEST_TABLE, read_file
from flankload.base.number_text import number_of
from flankload.errors import ComplianceFileError, SceneError, reason_of

#: Columns of a table before those of the matrix: offset of the displaced tooth, and the point.
LEADING_COLUMNS = ("offset", "x_mm", "y_mm")
EXPECTED_FILE = "a .npz file of plain arrays"
#: Largest length of an axis; flanks have fewer nodes.
MOST_ROWS = 100000
MOST_CHARACTERS = 10000
#: Largest number of lines of a measured table. Each is an interval of the flank; a measured profile
#: has some thousands at most.
MOST_LINES = 10000
#: Largest number; lengths, stiffnesses and compliances in mm and N are smaller, and powers finite.
LARGEST = 1e30


@dataclass(frozen=True)
class NamedArrays:
    """Arrays of one file by name, each read on request.

    Attributes
    ----------
    file : Path
    members : mapping of str to Member
    """

    file: Path
    members: Mapping[str, Member]

    def __contains__(self, name: str) -> bool:
        return name in self.members

    def refuse(self, name: str, expected: str, found: object) -> NoReturn:
        """Raise an error for an array."""
        raise ComplianceFileError(file=self.file, key=name, expected=expected, found=found)

    def check_names(self, *known: str) -> None:
        """Refuse arrays with unknown (misspelled) names."""
        for name in self.members:
            if name not in known:
                self.refuse(
                    name, "an array of this format (" + ", ".join(known) + ")", "an unknown name"
                )

    def numbers(self, name: str, *shape: int | None) -> Floats:
        """An array of finite numbers; None in the shape: any length up to `MOST_ROWS`."""
        member = self._member(name, "numbers")
        wanted = f"({', '.join('any' if n is None else str(n) for n in shape)})"
        if member.dtype.kind not in "fiu":
            self.refuse(name, "real numbers", f"values of type {member.dtype}")
        fits = len(member.shape) == len(shape) and all(
            n in (None, m) for n, m in zip(shape, member.shape, strict=True)
        )
        if not fits:
            self.refuse(name, f"an array of shape {wanted}", f"shape {member.shape}")
        if max(member.shape, default=0) > MOST_ROWS:
            self.refuse(name, f"at most {MOST_ROWS} entries along an axis", f"{member.shape}")
        result = self._read(name).astype(np.float64)
        good = np.abs(result) <= LARGEST
        if not good.all():
            invalid = np.argwhere(~good)
            place = f"[{', '.join(map(str, invalid[0]))}]" if result.ndim else ""
            value = result[tuple(invalid[0])]
            wanted = f"numbers of at most {LARGEST:g}" if np.isfinite(value) else "finite numbers"
            self.refuse(f"{name}{place}", wanted, f"{value:g}")
        return result

    def number(
        self,
        name: str,
        *,
        above: float | None = None,
        least: float | None = None,
        most: float | None = None,
    ) -> float:
        """A single number in a range."""
        value = float(self.numbers(name))
        bounds = ((">", above, gt), (">=", least, ge), ("<=", most, le))
        for sign, bound, holds in bounds:
            if bound is not None and not holds(value, bound):
                self.refuse(name, f"a number {sign} {bound:g}", f"{value:g}")
        return value

    def integers(self, name: str, *shape: int | None) -> Numbers:
        """An array of whole numbers."""
        values = self.numbers(name, *shape)
        if (values != np.round(values)).any():
            self.refuse(name, "whole numbers", f"{values[values != np.round(values)][0]:g}")
        return values.astype(np.int64)

    def integer(self, name: str, *, least: int, most: int) -> int:
        """A single whole number in a range."""
        value = int(self.integers(name))
        if not least <= value <= most:
            self.refuse(name, f"an integer from {least} to {most}", value)
        return value

    def texts(self, name: str) -> tuple[str, ...]:
        """A list of texts."""
        member = self._member(name, "text")
        count = member.shape[0] if len(member.shape) == 1 else MOST_ROWS + 1
        if count > MOST_ROWS or (count and not _is_text(member)):
            self.refuse(name, "a list of texts", f"shape {member.shape} of type {member.dtype}")
        return tuple(str(value) for value in self._read(name))

    def text(self, name: str, *choices: str) -> str:
        """A single text, one of the choices if any are given."""
        member = self._member(name, "text")
        is_text = member.shape == () and _is_text(member)
        value = str(self._read(name)) if is_text else ""
        if not is_text or (choices and value not in choices):
            expected = " or ".join(f"'{choice}'" for choice in choices) or "a text"
            found = f"'{value[:60]}'" if is_text else f"an array of type {member.dtype}"
            self.refuse(name, expected, found)
        return value

    def flags(self, name: str, count: int) -> Flags:
        """An array of `count` Booleans."""
        member = self._member(name, "true or false")
        if member.shape != (count,) or member.dtype != np.bool_:
            self.refuse(
                name, f"{count} times true or false", f"shape {member.shape} of type {member.dtype}"
            )
        return self._read(name)

    def dimensions(self, name: str) -> int:
        """Number of axes of an array; 0 if it is absent."""
        return len(self.members[name].shape) if name in self else 0

    def _member(self, name: str, what: str) -> Member:
        if name not in self.members:
            self.refuse(name, what, "nothing: the file has " + ", ".join(self.members))
        return self.members[name]

    def _read(self, name: str) -> NDArray[Any]:
        try:
            return self.members[name].read()
        except BadArchive as error:
            self.refuse(name, EXPECTED_FILE, error.found)


def read_arrays(path: str | Path, key: str) -> NamedArrays:
    """Read a file of named arrays: .npz, or .csv with a table of points and a matrix.

    Scalars of a .csv file are in its comments. `key` is the scene's key of the file, for messages.

    Raises
    ------
    ComplianceFileError
        If the file is missing, unreadable or pickled, or its rows have different lengths.
    """
    path = Path(path)
    expected, suffix = "a .npz or .csv file", path.suffix.lower()
    found = "" if suffix in (".npz", ".csv") else suffix or "no suffix"
    if not isfile(path):  # unlike Path.is_file, without an exception for long names
        found = "a folder" if isdir(path) else "no such file"
    if found:
        raise ComplianceFileError(file=path, key=key, expected=expected, found=found)
    if suffix == ".csv":
        arrays = _read_csv(path, key)
        return NamedArrays(path, {name: _member_of(value) for name, value in arrays.items()})
    try:
        return NamedArrays(path, read_members(path))
    except BadArchive as error:
        key, found = error.name or key, error.found
    raise ComplianceFileError(file=path, key=key, expected=EXPECTED_FILE, found=found)


def _is_text(member: Member) -> bool:
    """Whether an array is text of a plausible length."""
    return member.dtype.kind == "U" and member.dtype.itemsize <= 4 * MOST_CHARACTERS


def _member_of(array: NDArray[Any]) -> Member:
    return Member(array.shape, array.dtype, lambda: array)


def read_columns(path: str | Path, key: str, names: tuple[str, ...]) -> Floats:
    """Read a table (rows, columns) of numbers from a .csv file, with or without column names.

    `key` is the scene's key of the file; lines that begin with # are skipped.

    Raises
    ------
    SceneError
        If the file is missing or unreadable, or a cell is not a finite number; names the line.
    """
    rows: list[list[float]] = []
    for row in csv_rows(Path(path), key, f"a .csv file with the columns {', '.join(names)}"):
        if not rows and tuple(row.cells) == names:
            continue
        try:
            values = [number_of(cell) for cell in row.cells]
        except ValueError:
            values = []
        if len(values) != len(names) or not np.isfinite(values).all():
            row.refuse(f"{len(names)} numbers: {', '.join(names)}")
        rows.append(values)
    return np.array(rows).reshape(-1, len(names))


class CsvRow(NamedTuple):
    """A row of a .csv file: file, line number, text and cells."""

    file: Path
    number: int
    text: str
    cells: list[str]

    def refuse(self, expected: str) -> NoReturn:
        """Raise the error of this row."""
        key, found = f"line {self.number}", f"'{self.text[:40]}'"
        raise SceneError(file=self.file, key=key, expected=expected, found=found)


def csv_rows(path: Path, key: str, wanted: str) -> list[CsvRow]:
    """Rows of a .csv file, without empty lines and lines that begin with #.

    `key` (the scene's key of the file) and `wanted` (its description) are for messages.

    Raises
    ------
    SceneError
        If the file is missing or unreadable, or has too many lines.
    """
    if not isfile(path) or path.suffix.lower() != ".csv":
        found = f"no file {path.name}" if not isfile(path) else path.name
        raise SceneError(key=key, expected=wanted, found=found)
    try:
        lines = read_file(path).decode("utf-8-sig").splitlines()
    except OSError as error:
        found = f"{path.name}: {reason_of(error)}"
        raise SceneError(key=key, expected=wanted, found=found) from None
    except UnicodeDecodeError:
        raise SceneError(key=key, expected=wanted, found="other bytes than UTF-8") from None
    if len(lines) > MOST_LINES:
        found = f"{len(lines)} in {path.name}"
        raise SceneError(key=key, expected=f"at most {MOST_LINES} lines", found=found)
    return [
        CsvRow(path, number, line.strip(), [cell.strip() for cell in line.split(",")])
        for number, line in enumerate(lines, start=1)
        if line.strip() and not line.strip().startswith("#")
    ]


def _read_csv(path: Path, key: str) -> dict[str, NDArray[Any]]:
    """Comments `# name = value`, then rows: offset, x, y and a row of the matrix."""
    expected = "a table as text in UTF-8"
    try:
        lines = read_file(path, LARGEST_TABLE).decode("utf-8-sig").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        found = reason_of(error) if isinstance(error, OSError) else "other bytes"
        raise ComplianceFileError(file=path, key=key, expected=expected, found=found) from None
    arrays: dict[str, NDArray[Any]] = {}
    rows: list[tuple[int, list[str]]] = []
    for number, line in enumerate(lines, start=1):
        text = line.strip()
        if text.startswith("#"):
            name, equals, value = (part.strip() for part in text[1:].partition("="))
            if equals:
                arrays[name] = _value_of(value)
        elif text:
            rows.append((number, [cell.strip() for cell in text.split(",")]))
    if rows and rows[0][1][0] == LEADING_COLUMNS[0]:
        del rows[0]
    return arrays | _tables_of(path, rows)


def _value_of(text: str) -> NDArray[Any]:
    try:
        return np.array(number_of(text))
    except ValueError:
        return np.array(text)


def _tables_of(path: Path, rows: list[tuple[int, list[str]]]) -> dict[str, NDArray[Any]]:
    """Offsets (k,), points (n, 2) and compliance (k, n, n) from the rows of a table."""

    def refuse(number: int, expected: str, found: str) -> NoReturn:
        raise ComplianceFileError(
            file=path, key=f"line {number}", expected=expected, found=found
        ) from None

    if not rows:
        refuse(1, "rows of " + ", ".join(LEADING_COLUMNS) + ", c_1, c_2, …", "no rows")
    width = len(rows[0][1])
    values = np.empty((len(rows), width))
    for k, (number, cells) in enumerate(rows):
        if len(cells) != width:
            refuse(number, f"{width} columns as in line {rows[0][0]}", f"{len(cells)}")
        for j, cell in enumerate(cells):
            try:
                values[k, j] = number_of(cell)
            except ValueError:
                refuse(number, f"a number in column {j + 1}", f"'{cell[:40]}'")
    lead = len(LEADING_COLUMNS)
    points = width - lead
    if points < 1 or len(rows) % points:
        refuse(
            rows[-1][0],
            f"{points} rows for each offset, as many as the matrix has columns (behind "
            + ", ".join(LEADING_COLUMNS)
            + ")",
            f"{len(rows)} rows",
        )
    blocks = values.reshape(-1, points, width)
    for k, block in enumerate(blocks):
        for i, row in enumerate(block):
            number = rows[k * points + i][0]
            if row[0] != block[0, 0]:
                refuse(number, f"offset {block[0, 0]:g}, {points} rows each", f"{row[0]:g}")
            if (row[1:lead] != blocks[0, i, 1:lead]).any():
                refuse(number, f"the place of line {rows[i][0]}", f"{row[1]:g}, {row[2]:g}")
    return {
        "offsets": blocks[:, 0, 0],
        "points": blocks[0, :, 1:lead],
        "compliance": blocks[:, :, lead:],
    }
