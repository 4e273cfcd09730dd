"""Pages of the documentation site: what a Markdown file gets beyond its own text.

An index page lists its pages as Markdown links, `* [Title](page.md): text`; the site makes the
table of contents from these lines. A page that no index lists appears in the index of its folder
under "Further pages".
"""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path, PurePosixPath

ROOT = Path(__file__).parent.parent
#: Sources of the site, relative to the root of the repository.
SOURCES = (
    "docs/**.md",
    "fortran/README.md",
    "examples/**README.md",
    "benchmarks/README.md",
    "CHANGELOG.md",
    "CONTRIBUTING.md",
)
#: Pages that list other pages, the first one being the home page.
INDEXES = (
    "docs/index",
    "docs/tutorials/index",
    "docs/guide/index",
    "docs/reference/index",
    "docs/theory/index",
    "docs/benchmarks/index",
)
LISTED = re.compile(r"^\* \[[^\]]+\]\(([\w./-]+\.md)\)", re.MULTILINE)
#: Beginning of a program in fixed form, which has a lexer of its own.
FIXED_FORM = re.compile(r"^```fortran\nC", re.MULTILINE)


def completed(page: str, text: str) -> str:
    """Text of a page and, on an index, its table of contents.

    Parameters
    ----------
    page : str
        Path without suffix, relative to the root of the repository.
    text : str

    Returns
    -------
    str
    """
    text = FIXED_FORM.sub("```fortranfixed\nC", text)
    if page not in INDEXES:
        return text
    listed = list(pages_of_indexes()[page])
    if rest := unlisted(page):
        lines = [f"* [{title_of(other)}]({PurePosixPath(other).name}.md)" for other in rest]
        text = "\n".join([text.rstrip(), "", "## Further pages", "", *lines, ""])
        listed += rest
    entries = "\n".join(f"/{other}" for other in listed)
    return f"{text.rstrip()}\n\n```{{toctree}}\n:hidden:\n\n{entries}\n```\n"


@cache
def pages_of_indexes() -> dict[str, tuple[str, ...]]:
    """Pages that each index lists; a page belongs to the first index that lists it."""
    taken: set[str] = set(INDEXES[:1])
    found = {}
    for index in INDEXES:
        text = (ROOT / f"{index}.md").read_text(encoding="utf-8")
        folder = PurePosixPath(index).parent
        pages = [normalized(folder / link) for link in LISTED.findall(text)]
        found[index] = tuple(page for page in dict.fromkeys(pages) if page not in taken)
        taken.update(pages)
    return found


def normalized(path: PurePosixPath) -> str:
    """A path without its suffix and without `..`."""
    parts: list[str] = []
    for part in path.with_suffix("").parts:
        if part == "..":
            parts.pop()
        else:
            parts.append(part)
    return "/".join(parts)


def unlisted(index: str) -> list[str]:
    """Pages in the folder of an index that no index lists; none for the home page."""
    if index == INDEXES[0]:
        return []
    listed = {page for pages in pages_of_indexes().values() for page in pages} | set(INDEXES)
    folder = str(PurePosixPath(index).parent)
    pages = sorted(f"{folder}/{path.stem}" for path in (ROOT / folder).glob("*.md"))
    return [page for page in pages if page not in listed and not page.endswith(".in")]


def title_of(page: str) -> str:
    """First heading of a page."""
    text = (ROOT / f"{page}.md").read_text(encoding="utf-8")
    found = re.search(r"^# (.+)$", text, re.MULTILINE)
    return found[1] if found else PurePosixPath(page).name
