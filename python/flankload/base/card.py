"""Short representations of objects with large arrays, for a terminal and for a notebook."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import fields
from typing import Any

import numpy as np

#: Largest number of lines of a card, and of characters of a value.
MOST_LINES, MOST_LETTERS = 20, 100
#: Largest number of entries of an array that is shown in full.
MOST_ENTRIES = 6


class Card:
    """Base of dataclasses that are shown in at most 20 lines: a line for each field.

    A subclass that is a dataclass has `repr=False`; it may list other lines in `_card_lines`.
    """

    def _card_lines(self) -> Iterator[tuple[str, str]]:
        """Names and values of the lines."""
        for field in fields(self):  # type: ignore[arg-type]
            if field.repr and not field.name.startswith("_"):
                yield field.name, shortened(getattr(self, field.name))

    def _card_title(self) -> str:
        """First line."""
        return type(self).__name__

    def _cut_lines(self) -> list[tuple[str, str]]:
        lines = [(name, cut(value)) for name, value in self._card_lines()]
        most = MOST_LINES - 1  # below the title
        if len(lines) > most:
            lines = [*lines[: most - 1], ("...", f"{len(lines) - most + 1} more")]
        return lines

    def __repr__(self) -> str:
        lines = self._cut_lines()
        width = max((len(name) for name, _ in lines), default=0)
        rows = (f"  {name:{width}}  {value}".rstrip() for name, value in lines)
        return "\n".join([self._card_title(), *rows])

    def _repr_html_(self) -> str:
        """The card as an HTML table, for notebooks."""
        from html import escape

        rows = (
            f"<tr><th style='text-align:left'>{escape(name)}</th>"
            f"<td style='text-align:left'>{escape(value)}</td></tr>"
            for name, value in self._cut_lines()
        )
        return f"<table><caption>{escape(self._card_title())}</caption>{''.join(rows)}</table>"


def cut(text: str) -> str:
    """A text in one line of limited length."""
    text = " ".join(text.split())
    return text if len(text) <= MOST_LETTERS else text[: MOST_LETTERS - 3] + "..."


def shortened(value: Any) -> str:
    """A value in a few words: numbers and text in full, mappings by their keys, others by kind."""
    if value is None or isinstance(value, bool | int | str):
        return str(value)
    if isinstance(value, float | np.floating):
        return f"{value:.6g}"
    if isinstance(value, np.ndarray):
        return _range_of(value)
    if isinstance(value, Mapping):
        return ", ".join(map(str, value)) or "none"
    if isinstance(value, Sequence):
        plain = all(isinstance(item, bool | int | float | str) for item in value)
        entries = f"{len(value)} entr{'y' if len(value) == 1 else 'ies'}"
        return (", ".join(map(shortened, value)) or "none") if plain else entries
    return value._card_title() if isinstance(value, Card) else str(value).split("(")[0]


def _range_of(array: np.ndarray[Any, Any]) -> str:
    """Shape of an array with its range."""
    if array.ndim == 1 and array.size <= MOST_ENTRIES:
        return ", ".join(map(shortened, array.tolist())) or "none"
    text = f"{array.dtype} array {array.shape}"
    known = array[np.isfinite(array)] if array.dtype.kind in "fiu" else array[:0]
    return f"{text} from {known.min():.4g} to {known.max():.4g}" if known.size else text
