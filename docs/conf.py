"""Sphinx configuration of the documentation site; `./dev docs` builds it into build-docs/html.

The sources are the Markdown files of the repository as they are: `site_pages.py` adds the tables of
contents when a file is read. Formulas are plain text, so the pages need no
script for mathematics. The theme furo is plain, has the sections of one tree at the side, suits
narrow screens, and brings neither fonts nor icons from elsewhere: the site works without a network.
"""

from __future__ import annotations

import sys
from importlib.metadata import version as installed_version
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parent.parent
sys.path.insert(0, str(ROOT / "docs"))

import site_pages  # noqa: E402

project = "flankload"
author = "flankload developers"
copyright = author  # noqa: A001 - a name of Sphinx
version = release = installed_version("flankload")

extensions = ["myst_parser"]
root_doc = "docs/index"
include_patterns = list(site_pages.SOURCES)
exclude_patterns = ["docs/**/*.in.md"]
nitpicky = False

myst_heading_anchors = 4
# Excerpts of scene files may contain "…", which no lexer knows.
suppress_warnings = ["misc.highlighting_failure"]

smartquotes = False

html_theme = "furo"
html_title = f"flankload {version}"
html_show_copyright = False
html_show_sphinx = False
html_copy_source = False
html_theme_options = {"navigation_with_keys": True}
html_static_path = ["site_static"]
html_css_files = ["site.css"]


def expand(_app: Any, page: str, source: list[str]) -> None:
    """Complete the text of a page before it is parsed."""
    source[0] = site_pages.completed(page, source[0])


def setup(app: Any) -> None:
    """Connect the expansion of pages."""
    app.connect("source-read", expand)
