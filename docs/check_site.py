"""Checks a built site: every link to a file or an anchor of the site exists, nothing is fetched.

`python docs/check_site.py build-docs/html`
"""

from __future__ import annotations

import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

#: Tags that fetch what they name, and the attribute with the name.
FETCHED = {"img": "src", "script": "src", "link": "href", "iframe": "src", "source": "src"}


class Page(HTMLParser):
    """Anchors, links and fetched files of a page."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.anchors: set[str] = set()
        self.links: list[str] = []
        self.fetched: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Note what a tag has."""
        values = {name: value or "" for name, value in attrs}
        self.anchors.update(filter(None, (values.get("id"), values.get("name"))))
        if tag == "a" and "href" in values:
            self.links.append(values["href"])
        if name := values.get(FETCHED.get(tag, "")):
            self.fetched.append(name)


def faults(site: Path) -> list[str]:
    """A line for each dead link and each file that a page fetches from elsewhere.

    Parameters
    ----------
    site : Path
        Folder of the built pages.

    Returns
    -------
    list of str
    """
    pages = {
        path.resolve(): Page(path.read_text(encoding="utf-8")) for path in site.rglob("*.html")
    }
    found = []
    for path, page in pages.items():
        for link in [*page.links, *page.fetched]:
            parts = urlsplit(link)
            if parts.scheme or parts.netloc:
                if link in page.fetched and parts.scheme != "data":
                    found.append(
                        f"{path.relative_to(site.resolve())}: fetched from elsewhere: {link}"
                    )
                continue
            target = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            anchor = unquote(parts.fragment)
            if not target.exists() or (
                anchor and target in pages and anchor not in pages[target].anchors
            ):
                found.append(f"{path.relative_to(site.resolve())}: leads nowhere: {link}")
    return sorted(set(found))


if __name__ == "__main__":
    lines = faults(Path(sys.argv[1]))
    print("\n".join(lines), end="\n" if lines else "", file=sys.stderr)
    sys.exit(1 if lines else 0)
