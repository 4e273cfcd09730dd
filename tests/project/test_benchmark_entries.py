"""Entries of other programs to the benchmark set: checked without flankload."""

from __future__ import annotations

import json
import runpy
from pathlib import Path
from typing import Any

import pytest

from tests.support.paths import ROOT

CHECKER = runpy.run_path(str(ROOT / "benchmarks/check_entries.py"))
TEMPLATE = json.loads((ROOT / "benchmarks/entries/template.json").read_text("utf-8"))


def test_the_pages_are_those_of_the_entries() -> None:
    made = CHECKER["pages"](ROOT / "benchmarks")
    old = [path.name for path, text in made.items() if path.read_text("utf-8") != text]
    assert old == [], "`python benchmarks/check_entries.py` writes them anew"


def checked(**changed: Any) -> str:
    """Output of the checker for the template with other values."""
    try:
        CHECKER["check_entry"](Path("mine.json"), TEMPLATE | changed, CASES)
    except CHECKER["EntryError"] as error:
        return str(error)
    return ""


CASES = CHECKER["read_cases"](ROOT / "benchmarks")


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        ({}, ""),
        ({"license": "GPL"}, "mine.json: license: expected CC-BY-4.0, found GPL"),
        ({"citation": ""}, "mine.json: citation: expected a value, found none"),
        ({"mood": "good"}, "mine.json: mood: expected the keys"),
        ({"values": {"spurs": {}}}, "mine.json: values.spurs: expected a case of the set"),
        ({"values": {"springs": {"heat[0]": 1.0}}}, "expected a quantity of the case"),
        ({"values": {"springs": {"rotation[0]": float("nan")}}}, "expected a finite number"),
        ({"values": {"springs": {"rotation[0]": "1"}}}, "expected a finite number, found '1'"),
        ({"seconds": {"springs": 1.0}}, "expected seconds of a case with values"),
    ],
)
def test_a_wrong_entry_is_one_line(changed: dict[str, Any], said: str) -> None:
    found = checked(**changed)
    assert (found == "") == (said == "")
    assert said in found
    assert "\n" not in found


def test_a_cell_counts_what_is_within_the_uncertainty() -> None:
    case = {"quantities": {name: {"value": 2.0, "uncertainty": 0.5} for name in "ab"}}
    assert CHECKER["cell"](case, {"a": 2.4, "b": 3.0}) == "1 of 2; 2"
    assert CHECKER["cell"](case, None) == ""
