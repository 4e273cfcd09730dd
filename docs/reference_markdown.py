"""Parts of the generated reference pages that all of them have: tables and units."""

from __future__ import annotations

import re


def table(heads: tuple[str, ...], rows: list[tuple[str, ...]]) -> str:
    """A Markdown table; `|` and line breaks in cells are escaped."""
    lines = [heads, ("---",) * len(heads), *rows]
    cells = (
        " | ".join(" ".join(cell.replace("|", "\\|").split()) for cell in row) for row in lines
    )
    return "\n".join(f"| {line} |" for line in cells) + "\n"


def unit_shown(unit: str) -> str:
    """A unit; nothing for a pure number."""
    return "" if unit in ("1", "-") else re.sub(r"\bum\b", "µm", unit)
