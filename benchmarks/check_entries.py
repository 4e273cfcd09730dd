"""Checks the entries of programs and writes the pages of the set, without flankload.

check_entries.py [--check]: reads every `entries/*.json` and every `*/case.json` beside this file;
writes ENTRIES.md, a column for each program, and CITATIONS.bib. With --check nothing is written,
and a page that would change is an error. Needs Python 3.11 and nothing else.
"""

from __future__ import annotations

import json
import sys
from math import isfinite
from pathlib import Path
from typing import Any

HERE = Path(__file__).resolve().parent
#: Keys of an entry, and whether it must have them.
KEYS = {
    "program": True,
    "author": True,
    "date": True,
    "method": True,
    "citation": True,
    "license": True,
    "values": True,
    "seconds": False,
}
LICENSE = "CC-BY-4.0"


class EntryError(Exception):
    """An entry that breaks a rule: file, key, expected, found."""


def refuse(path: Path, key: str, expected: str, found: object) -> None:
    """One line on what is wrong."""
    raise EntryError(f"{path.name}: {key}: expected {expected}, found {found}")


def read_json(path: Path) -> Any:
    """Content of a file; not a number and the infinite are no JSON."""
    try:
        return json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        refuse(path, "file", "JSON in UTF-8", error)


def read_cases(folder: Path) -> dict[str, dict[str, Any]]:
    """All cases of the set by name."""
    return {path.parent.name: read_json(path) for path in sorted(folder.glob("*/case.json"))}


def is_number(value: object) -> bool:
    """A finite number, and no truth value."""
    return isinstance(value, int | float) and not isinstance(value, bool) and isfinite(value)


def check_entry(path: Path, entry: Any, cases: dict[str, dict[str, Any]]) -> None:
    """Refuse an entry without its keys, with unknown quantities, or with values that are none."""
    if not isinstance(entry, dict):
        refuse(path, "file", "an object with the keys of the template", type(entry).__name__)
    for key in entry:
        if key not in KEYS:
            refuse(path, key, f"the keys {', '.join(KEYS)}", "an unknown key")
    for key, needed in KEYS.items():
        if needed and not entry.get(key):
            refuse(path, key, "a value", "none")
    if entry["license"] != LICENSE:
        refuse(path, "license", LICENSE, entry["license"])
    for name, values in entry["values"].items():
        if name not in cases:
            refuse(path, f"values.{name}", "a case of the set", "no such case")
        for identifier, value in values.items():
            if identifier not in cases[name]["quantities"]:
                refuse(path, f"values.{name}.{identifier}", "a quantity of the case", "none such")
            if not is_number(value):
                refuse(path, f"values.{name}.{identifier}", "a finite number", repr(value))
    for name, value in entry.get("seconds", {}).items():
        if name not in entry["values"] or not is_number(value) or value < 0:
            refuse(path, f"seconds.{name}", "seconds of a case with values", repr(value))


def cell(case: dict[str, Any], values: dict[str, float] | None) -> str:
    """Values within the uncertainty of the reference, and the largest ratio to it."""
    if not values:
        return ""
    ratios = [
        abs(value - known["value"]) / known["uncertainty"]
        for identifier, value in values.items()
        for known in [case["quantities"][identifier]]
    ]
    within = sum(ratio <= 1.0 for ratio in ratios)
    return f"{within} of {len(ratios)}; {max(ratios):.2g}"


def page(cases: dict[str, dict[str, Any]], entries: list[dict[str, Any]]) -> str:
    """Cases as rows, programs as columns."""
    numbers = range(1, len(entries) + 1)
    lines = [
        "# Entries",
        "",
        "Written by `check_entries.py` from `entries/`. A cell has the number of values within the",
        "uncertainty of the reference, of those that the program gives, and the largest difference",
        "as a multiple of the uncertainty. An empty cell: the program gives no value of the case.",
        "",
        "| case | quantities | " + " | ".join(f"({number})" for number in numbers) + " |",
        "|---|---|" + "---|" * len(entries),
    ]
    for name, case in cases.items():
        cells = [cell(case, entry["values"].get(name)) for entry in entries]
        link = f"[{name}]({name}/case.json)"
        lines.append(f"| {link} | {len(case['quantities'])} | " + " | ".join(cells) + " |")
    lines += ["", "| | program | method | entered by | date |", "|---|---|---|---|---|"]
    about = ("program", "method", "author", "date")
    lines += [
        f"| ({number}) | " + " | ".join(entry[key] for key in about) + " |"
        for number, entry in zip(numbers, entries, strict=True)
    ]
    return "\n".join(lines) + "\n"


def citations(cases: dict[str, dict[str, Any]]) -> str:
    """An entry of BibTeX for each case."""
    form = (
        "@misc{{flankload_benchmark_{key},\n  author = {{{{flankload developers}}}},\n"
        "  title = {{{title}}},\n  howpublished = {{Case {name} of the flankload benchmark set}},\n"
        "  note = {{{license}}}\n}}\n"
    )
    return "\n".join(
        form.format(key=name, title=case["title"], name=name.replace("_", r"\_"), license=LICENSE)
        for name, case in cases.items()
    )


def pages(folder: Path) -> dict[Path, str]:
    """What belongs into the written files. Raises EntryError for the first wrong entry."""
    cases = read_cases(folder)
    entries = []
    for path in sorted(folder.glob("entries/*.json")):
        entry = read_json(path)
        if path.name != "template.json":
            check_entry(path, entry, cases)
            entries.append(entry)
    return {folder / "ENTRIES.md": page(cases, entries), folder / "CITATIONS.bib": citations(cases)}


def main(arguments: list[str]) -> int:
    """Write, or say what would change."""
    try:
        made = pages(HERE)
    except EntryError as error:
        print(error, file=sys.stderr)
        return 2
    for path, text in made.items():
        if path.exists() and path.read_text(encoding="utf-8") == text:
            continue
        if "--check" in arguments:
            print(f"{path.name}: differs from the entries: run check_entries.py", file=sys.stderr)
            return 1
        path.write_text(text, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
