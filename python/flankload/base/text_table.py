"""Text tables with aligned columns."""

from __future__ import annotations

from math import isfinite
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

#: A mark behind a number; it is printed in the space between two columns.
MARK = "*"
#: Cell of a number that does not exist.
NONE = "-"


def number(value: float, form: str) -> str:
    """Format a number as a cell by a format specification; `NONE` if it is not finite."""
    return format(value, form) if isfinite(value) else NONE


def text_table(rows: Iterable[Sequence[str]], *, left: int = 0) -> list[str]:
    """Align the columns of a table.

    Parameters
    ----------
    rows : iterable of sequence of str
        Header first. Rows may be shorter than others. A mark is printed in the space behind its
        column.
    left : int
        Number of leading columns that are aligned to the left; the others are aligned to the
        right.

    Returns
    -------
    list of str
        Lines, with two spaces between columns and no trailing spaces.
    """
    table = [
        [
            cell if column < left or cell.endswith(MARK) else f"{cell} "
            for column, cell in enumerate(row)
        ]
        for row in rows
    ]
    widths = [
        max(len(row[column]) for row in table if column < len(row))
        for column in range(max(map(len, table), default=0))
    ]
    return [
        " ".join(
            f"{cell:<{width + 1}}" if column < left else f"{cell:>{width}}"
            for column, (cell, width) in enumerate(zip(row, widths, strict=False))
        ).rstrip()
        for row in table
    ]
