"""Writes the generated parts of the pages in docs/reference: `python docs/make_reference.py`.

A part is what stands between `<!-- begin: NAME -->` and `<!-- end: NAME -->`; the function NAME of
`TEXTS` returns it as Markdown. A test compares the pages with the code.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parent))

import make_manual
from reference_markdown import table
from reference_python import python_api
from reference_result import result_quantities
from reference_scene import scene_keys

import flankload as fl
from flankload.cli import parser
from flankload.contact.status import EXCEPTIONS, status_text

PAGES = Path(__file__).parent / "reference"
PART = re.compile(
    r"(?P<begin>^<!-- begin: (?P<name>\w+) -->\n).*?(?P<end>^<!-- end: (?P=name) -->$)",
    re.MULTILINE | re.DOTALL,
)
#: Statuses of the core are at most this far below 0; `info` has other meanings below.
LAST_STATUS = -100


def statuses() -> str:
    """Every status of the core with its words and its exception."""
    unknown = status_text(LAST_STATUS).replace(str(LAST_STATUS), "{}")
    rows = []
    for code in range(9, LAST_STATUS, -1):
        said = status_text(code)
        if said == unknown.format(code):
            continue
        error = EXCEPTIONS.get(code)
        if code == fl.NegativeForce.code:
            error = fl.NegativeForce
        rows.append((str(code), said, f"`{error.__name__}`" if error else ""))
    return table(("status", "meaning", "exception"), rows)


def command_line() -> str:
    """Every command with its arguments, from the parser."""
    top = parser()
    names, described = make_manual.commands(top)
    parts = []
    for name, command in names.items():
        usage = " ".join(command.format_usage().split()).removeprefix("usage: ")
        actions = [a for a in command._actions if type(a).__name__ != "_HelpAction"]
        rows = [argument(action) for action in actions]
        text = f"{described[name][0].upper()}{described[name][1:]}.".replace("%%", "%")
        listed = table(("argument", "meaning"), rows) if rows else ""
        parts.append(f"## {name}\n\n{text}\n\n```\n{usage}\n```\n\n{listed}")
    codes = str(top.epilog).removeprefix("exit codes: ")
    return "\n".join([*parts, f"## Exit codes\n\n{codes}.\n"])


def argument(action: Any) -> tuple[str, str]:
    """Names, value and help of an argument."""
    value = action.metavar if action.nargs != 0 else None
    if value is None and action.choices:
        value = "{" + ",".join(map(str, action.choices)) + "}"
    names = ", ".join(action.option_strings)
    text = " ".join(part for part in (names, str(value or "")) if part)
    return f"`{text}`", str(action.help or "").replace("%%", "%")


TEXTS = {
    "scene_keys": scene_keys,
    "result_quantities": result_quantities,
    "statuses": statuses,
    "command_line": command_line,
    "python_api": python_api,
}


def completed(page: str) -> str:
    """A page with its generated parts.

    Raises
    ------
    ValueError
        If the page has a part that `TEXTS` lacks.
    """

    def part(found: re.Match[str]) -> str:
        if found["name"] not in TEXTS:
            known = ", ".join(sorted(TEXTS))
            raise ValueError(f"begin: expected one of {known}, found {found['name']}")
        return f"{found['begin']}\n{TEXTS[found['name']]()}\n{found['end']}"

    return PART.sub(part, page)


if __name__ == "__main__":
    for path in sorted(PAGES.glob("*.md")):
        text = path.read_text(encoding="utf-8")
        path.write_text(completed(text), encoding="utf-8")
