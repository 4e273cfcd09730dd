"""Text tables with aligned columns."""

from __future__ import annotations

from math import isfinite
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

#: Follows a number and hangs into the space between columns.
MARK = "*"
#: Cell of a number that does not exist.
NONE = "-"


def number(value: float, form: str) -> str:
    """A number as a cell.

    Parameters
    ----------
    value : float
    form : str
        Format specification.

    Returns
    -------
    str
    """
    return format(value, form) if isfinite(value) else NONE


def text_table(rows: Iterable[Sequence[str]], *, left: int = 0) -> list[str]:
    """Align the columns of a table.

    Parameters
    ----------
    rows : iterable of sequence of str
        Heads first. A row may end early. A mark hangs into the space behind its column.
    left : int
        Columns that are aligned to the left, from the first on; the others are aligned to the
        right.

    Returns
    -------
    list of str
        Lines, two spaces between columns, none at their ends.
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
