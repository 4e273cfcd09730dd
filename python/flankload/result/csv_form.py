"""Form of CSV files: separator, decimal sign, unit of angles."""

from __future__ import annotations

import csv
import io
from dataclasses import dataclass
from math import degrees, isfinite
from typing import TYPE_CHECKING, Any

import numpy as np

from flankload.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Iterable

#: Separators by name; the name is that of the command line.
SEPARATORS = {"comma": ",", "semicolon": ";", "tab": "\t"}


@dataclass(frozen=True)
class CsvForm:
    """How numbers are written; the defaults are those of files without options.

    Attributes
    ----------
    separator : str or None
        "," or ";" or a tab; None: ",", with a decimal comma ";".
    decimal_comma : bool
        Numbers have a comma in place of the decimal point.
    degrees : bool
        Angles in rad are written in degrees, and their names end with _deg; quantities per rad
        stay.
    """

    separator: str | None = None
    decimal_comma: bool = False
    degrees: bool = False

    def __post_init__(self) -> None:
        """Refuse unknown separators, and a comma for two purposes.

        Raises
        ------
        InputError
        """
        if self.separator not in (None, *SEPARATORS.values()):
            raise InputError(f"separator: expected ',' or ';' or a tab, found {self.separator!r}")
        if self.decimal_comma and self.separator == ",":
            raise InputError("separator: expected ';' or a tab with a decimal comma, found ','")

    def head(self, key: str, unit: str) -> str:
        """Name of a column."""
        return f"{key.removesuffix('_rad')}_deg" if self._turns(unit) else key

    def cell(self, value: Any, unit: str = "") -> str:
        """A number as text, empty if it is not finite; a bool as 0 or 1."""
        plain = value.item() if isinstance(value, np.generic) else value
        if isinstance(plain, bool):
            return str(int(plain))
        if self._turns(unit):
            plain = degrees(plain)
        if isinstance(plain, float) and not isfinite(plain):
            return ""
        text = repr(plain)
        return text.replace(".", ",") if self.decimal_comma else text

    def lines(self, rows: Iterable[Iterable[str]]) -> str:
        """Rows of texts as CSV."""
        out = io.StringIO()
        separator = self.separator or (";" if self.decimal_comma else ",")
        csv.writer(out, lineterminator="\n", delimiter=separator).writerows(rows)
        return out.getvalue()

    def _turns(self, unit: str) -> bool:
        return self.degrees and unit == "rad"
