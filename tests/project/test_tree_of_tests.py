"""The tests by room: each imports what it shares from `tests/support`, never from another test."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.support.paths import ROOT

TESTS = ROOT / "tests"
#: A program within a string that imports a test, as one for another process does.
PROGRAM = re.compile(r"^\s*(?:from|import)\s+(?:[\w.]*\.)?(?:test_\w+|conftest)\b", re.MULTILINE)
#: Folders whose modules the tests of the project test.
TESTED = {"benchmarks", "mutations"}


def imported(module: Path, nodes: list[ast.AST]) -> Iterator[str]:
    """Dotted names of all that a module imports, anywhere in it."""
    folder = module.relative_to(ROOT).parent.parts
    for node in nodes:
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            above = folder[: len(folder) + 1 - node.level] if node.level else ()
            start = ".".join([*above, *([node.module] if node.module else [])])
            yield from (f"{start}.{alias.name}" for alias in node.names)


def faults_of(module: Path, text: str) -> list[str]:
    """Forbidden imports of a module."""
    own = module.relative_to(TESTS).parts[0]
    allowed = {"support", own} | (TESTED if own == "project" else set())
    nodes = list(ast.walk(ast.parse(text)))
    found = []
    for name in imported(module, nodes):
        parts = name.split(".")
        if any(re.fullmatch(r"test_\w+|conftest", part) for part in parts[:3] + parts[-2:]):
            found.append(f"imports a test: {name}")
        elif parts[0] == "tests" and len(parts) > 1 and parts[1] not in allowed:
            found.append(f"imports from {parts[1]}: {name}")
    strings = (node.value for node in nodes if isinstance(node, ast.Constant))
    programs = [text for text in strings if isinstance(text, str) and PROGRAM.search(text)]
    return found + [f"a program imports a test: {program!r}" for program in programs]


MODULES = sorted(path for path in TESTS.rglob("*.py") if path != Path(__file__))


def test_no_module_imports_a_test() -> None:
    assert len(MODULES) > 100
    faults = [
        f"{path.relative_to(ROOT)}: {fault}"
        for path in MODULES
        for fault in faults_of(path, path.read_text(encoding="utf-8"))
    ]
    assert faults == []


@pytest.mark.parametrize(
    ("folder", "text"),
    [
        ("unit/contact", "from test_contact import THREE"),
        ("unit/contact", "from tests.unit.contact.test_sweep import solved"),
        ("unit/contact", "from tests.unit.contact import test_sweep"),
        ("unit/contact", "from .test_sweep import solved"),
        ("physics", "def f():\n    import tests.physics.test_belt"),
        ("legacy", "from .conftest import ROOT"),
        ("unit/contact", "SCRIPT = 'import sys\\nfrom test_sweep import solved\\n'"),
        ("unit/contact", "from tests.benchmarks._core import core_times"),
        ("support", "from tests.benchmarks.estimate import table"),
        ("benchmarks", "from tests.physics.fields import field"),
    ],
)
def test_an_import_of_a_test_is_seen(folder: str, text: str) -> None:
    assert len(faults_of(TESTS / folder / "module.py", text)) == 1


def test_shared_modules_may_be_imported() -> None:
    shared = "import numpy as np\nfrom tests.support.paths import ROOT\nfrom .compare import table"
    assert faults_of(TESTS / "regression" / "module.py", shared) == []
    bench = "from tests.benchmarks import fuzz\nfrom tests.mutations.faults import FAULTS"
    assert faults_of(TESTS / "project" / "module.py", bench) == []


def test_tests_of_a_room_are_in_a_folder_of_its_name() -> None:
    rooms = {path.parent.name for path in (ROOT / "python" / "flankload").glob("*/*.py")}
    modules = list((TESTS / "unit").rglob("*.py"))
    assert all(path.name.startswith("test_") for path in modules)
    assert {path.relative_to(TESTS).parts[1] for path in modules} <= rooms
