"""Wraps the prose of all Markdown files at 120 columns: `.venv/bin/python docs/wrap_lines.py`.

`--check` only lists the paragraphs with longer lines; `./dev lint` runs it. Only paragraphs and
items of lists with a line that is too long are filled anew. Tables, code, headings, HTML and
generated parts remain; code spans, links and mathematics are not broken.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator
from pathlib import Path

from flankload.base.files import write_atomically

ROOT = Path(__file__).resolve().parents[1]
WIDTH = 120
#: Folders, files and single files of the documentation.
FILES = ("*.md", "docs/**/*.md", "examples/**/*.md", "fortran/*.md", "benchmarks/*.md")
#: Pages that a program writes as a whole.
GENERATED = ("docs/reference/accuracy.md", "docs/reference/plane_limits.md")
#: Beginning of an item of a list, and its marker.
ITEM = re.compile(r"(\s*)([*+-]|\d+[.)])(\s+)")
#: Lines of other blocks: tables, headings, HTML, quotations, rules, targets of links, directives.
OTHER = re.compile(r"\s*(\||#|<|>|={3,}$|-{3,}$|\[[^\]]+\]: |:::|\$\$)")
#: Text that is not broken: code, links with their text, mathematics.
WHOLE = re.compile(r"(?:[^\s`\[$]|`+[^`]+`+|!?\[[^\]]*\](?:\([^)]*\))?|\$[^$\s][^$]*\$|[\[$`])+")
#: Words that would begin another block at the start of a line.
MARKER = re.compile(r"([*+-]|\d+[.)]|[#=>|<-].*)$")


def wrapped(text: str) -> str:
    """A page with its prose at most `WIDTH` columns wide."""
    blocks = _blocks(text.split("\n"))
    return "\n".join(
        x for is_prose, block in blocks for x in (_filled(block) if is_prose else block)
    )


def _blocks(lines: list[str]) -> Iterator[tuple[bool, list[str]]]:
    """Paragraphs and items of lists as prose; each other line by itself."""
    prose: list[str] = []
    fence = generated = in_list = False
    for line in lines:
        begins_fence = line.lstrip().startswith(("```", "~~~"))
        generated = (generated or "<!-- begin: " in line) and "<!-- end: " not in line
        # code by indentation, unless the line continues prose or a list
        is_code = line.startswith("    ") and not prose and not in_list
        is_prose = not (fence or begins_fence or generated or is_code or OTHER.match(line))
        # of numbers, only 1 interrupts a paragraph
        item = ITEM.match(line)
        begins = item and (item[2] in ("*", "+", "-", "1.", "1)") or in_list or not prose)
        if not is_prose or not line.strip() or begins:
            if prose:
                yield True, prose
            prose = []
        if is_prose and line.strip():
            prose.append(line)
        else:
            yield False, [line]
        fence ^= begins_fence
        if line.strip():
            in_list = bool(begins) or (in_list and line.startswith("  "))
    if prose:
        yield True, prose


def _filled(block: list[str]) -> list[str]:
    """A block whose lines have at most `WIDTH` columns, as far as its words permit."""
    kept = any(line.endswith(("  ", "\\")) for line in block)  # breaks of lines
    if kept or max(map(len, block)) <= WIDTH:
        return block
    item = ITEM.match(block[0])
    indent = " " * (len(block[0]) - len(block[0].lstrip()))
    first, rest = (item[0], " " * len(item[0])) if item else (indent, indent)
    if len(block) > 1 and item:
        rest = " " * (len(block[1]) - len(block[1].lstrip()))
    words: list[str] = []
    for word in WHOLE.findall(" ".join([block[0][len(first) :], *map(str.strip, block[1:])])):
        words[-1:] = (
            [f"{words[-1]} {word}"] if words and MARKER.match(word) else [*words[-1:], word]
        )
    lines = [first + words[0]]
    for word in words[1:]:
        if len(lines[-1]) + 1 + len(word) <= WIDTH:
            lines[-1] += f" {word}"
        else:
            lines.append(rest + word)
    return lines


def pages() -> list[Path]:
    """All pages that are written by hand."""
    found = {path for pattern in FILES for path in ROOT.glob(pattern)}
    return sorted(found - {ROOT / name for name in GENERATED})


def main(arguments: list[str]) -> int:
    """Wrap all pages, or list those that are not."""
    wide = 0
    for path in pages():
        text = path.read_text(encoding="utf-8")
        new = wrapped(text)
        if new == text:
            continue
        wide += 1
        if "--check" in arguments:
            print(
                f"{path.relative_to(ROOT)}: lines of more than {WIDTH} columns: docs/wrap_lines.py"
            )
        else:
            write_atomically(path, new)
    return int(wide > 0 and "--check" in arguments)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
