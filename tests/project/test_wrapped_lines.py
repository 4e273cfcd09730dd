"""Width of Markdown lines: prose is wrapped, all else remains."""

from __future__ import annotations

import sys

import pytest

from tests.support.paths import ROOT

sys.path.insert(0, str(ROOT / "docs"))
from wrap_lines import WIDTH, pages, wrapped

sys.path.remove(str(ROOT / "docs"))

LONG = " ".join(["word"] * 40)
LINE = " ".join(["word"] * 24)


def test_prose_and_items_are_filled_with_their_indents() -> None:
    assert wrapped(LONG) == f"{LINE}\n{' '.join(['word'] * 16)}"
    first, second = wrapped(f"* {LONG}").split("\n")
    assert (first[:6], second[:6]) == ("* word", "  word")
    assert len(first) <= WIDTH
    first, second = wrapped(f"12. word\n    {LONG}").split("\n")
    assert (first[:8], second[:8]) == ("12. word", "    word")


@pytest.mark.parametrize(
    "text",
    [
        f"```\n{LONG}\n```",
        f"text\n\n    {LONG}",
        f"| {LONG} |",
        f"# {LONG}",
        f"<!-- begin: table -->\n{LONG}\n<!-- end: table -->",
        f"{LONG}  \nbehind a break of the line",
        f"[target]: {LONG}",
        "short\nlines",
    ],
)
def test_other_lines_remain(text: str) -> None:
    assert wrapped(text) == text


@pytest.mark.parametrize("whole", ["`a b c d`", "[a b c](d#e)", "![a b](c.png)", "$a + b c$"])
def test_code_links_and_mathematics_are_not_broken(whole: str) -> None:
    for words in range(20, 25):
        text = wrapped(f"{' '.join(['word'] * words)} {whole}, {LONG}")
        assert f"{whole}," in text
        assert max(map(len, text.split("\n"))) <= WIDTH


def test_no_line_begins_as_another_block() -> None:
    """A minus at the start of a line would be an item of a list."""
    for words in range(20, 26):
        for mark in ("-", "+", "1.", "#", "|x|"):
            lines = wrapped(f"{' '.join(['word'] * words)} {mark} {LONG}").split("\n")
            assert not any(line.startswith(mark) for line in lines)


def test_wrapping_twice_changes_nothing() -> None:
    for path in pages():
        once = wrapped(path.read_text(encoding="utf-8"))
        assert wrapped(once) == once, path
