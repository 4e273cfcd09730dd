"""The lines of an .inp file: keywords with options, and their data lines."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field

from flankload.meshes.io.parts import BadFile

#: Largest credible number of a node or element; larger ones come from a damaged file.
LARGEST_NUMBER = 10**9


@dataclass
class Row:
    """One data line, or several that belong together.

    Attributes
    ----------
    line : int
        Line number in the file, from 1.
    words : list of str
        The comma-separated values.
    """

    line: int
    words: list[str]

    @property
    def text(self) -> str:
        """The row as quoted in a message."""
        return repr(", ".join(self.words)[:40])

    def refused(self, expected: str, found: str) -> BadFile:
        """Make the error of this row."""
        return BadFile(expected, f"{found} in line {self.line}")


@dataclass
class Keyword:
    """A keyword line with its data lines.

    Attributes
    ----------
    line : int
    name : str
        In upper case, without the asterisk.
    options : dict of str to str
        Names in upper case; an option without a value has "".
    data : list of Row
    """

    line: int
    name: str
    options: dict[str, str]
    data: list[Row] = field(default_factory=list)

    def refused(self, expected: str) -> BadFile:
        """Make the error of this keyword."""
        return BadFile(expected, f"*{self.name} in line {self.line}")

    def needed(self, option: str) -> str:
        """Value of a required option."""
        value = self.options.get(option, "")
        if not value:
            raise self.refused(f"{option}= on the keyword line")
        return value

    def numbers(self, row: Row) -> list[float]:
        """Values of a row as numbers, empty ones as 0; Fortran's exponents (D) are accepted."""
        try:
            return [float(word.upper().replace("D", "E") or 0) for word in row.words]
        except ValueError:
            raise row.refused(f"numbers after *{self.name}", row.text) from None

    def integers(self, row: Row) -> list[int]:
        """Values of a row as whole numbers."""
        values = self.numbers(row)
        if any(not value.is_integer() or abs(value) > LARGEST_NUMBER for value in values):
            raise row.refused(f"whole numbers after *{self.name}", row.text)
        return [int(value) for value in values]

    def whole_rows(self, size: int) -> Iterator[Row]:
        """Rows of `size` values each; a shorter row is continued by the following ones."""
        waiting: Row | None = None
        for row in self.data:
            words = [word for word in row.words if word]
            waiting = Row(row.line, words) if waiting is None else Row(
                waiting.line, waiting.words + words
            )  # fmt: skip
            if len(waiting.words) >= size:
                yield waiting
                waiting = None
        if waiting is not None:
            yield waiting


def keywords(lines: Sequence[str]) -> Iterable[Keyword]:
    """Keywords of a file in order, each with its data.

    Raises
    ------
    BadFile
        If there are data before the first keyword.
    """
    current: Keyword | None = None
    number = 0
    while number < len(lines):
        line = lines[number].strip()
        number += 1
        if not line or line.startswith("**"):
            continue
        if not line.startswith("*"):
            if current is None:
                raise BadFile("a readable mesh file", f"{line[:40]!r} before any *KEYWORD")
            words = [word.strip() for word in line.rstrip(", \t").split(",")]
            current.data.append(Row(number, words))
            continue
        first = number
        while line.endswith(",") and number < len(lines):
            line += lines[number].strip()
            number += 1
        if current is not None:
            yield current
        current = _keyword(line, first)
    if current is not None:
        yield current


def _keyword(line: str, number: int) -> Keyword:
    name, *rest = line[1:].split(",")
    options = {}
    for part in rest:
        option, _, value = part.partition("=")
        if option.strip():
            options[option.strip().upper()] = value.strip().strip('"')
    return Keyword(number, " ".join(name.split()).upper(), options)
