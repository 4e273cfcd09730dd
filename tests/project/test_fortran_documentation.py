"""Documentation of the core: each name in its table exists, each argument is documented."""

from __future__ import annotations

import re
import runpy
from pathlib import Path

from tests.support.paths import FORTRAN

SOURCES = sorted(FORTRAN.rglob("*.f90"))
PATHS = {path.name: path for path in SOURCES}
HEAD = re.compile(
    r"^\s*(?:(?:pure|elemental|recursive|impure)\s+)*(subroutine|function)\s+(\w+)\s*\(",
    re.IGNORECASE,
)


def procedures_of(path: Path) -> set[str]:
    return {
        match[2].lower()
        for line in path.read_text(encoding="utf-8").splitlines()
        if (match := HEAD.match(line))
    }


def table_rows(column: int = -1) -> list[list[str]]:
    """Names in code type of a column, row by row."""
    text = (FORTRAN / "README.md").read_text(encoding="utf-8")
    table = text.split("## Equation → file: procedure")[1].split("\n\n")[1]
    rows = [line.strip("|").split("|") for line in table.splitlines()[2:]]
    return [re.findall(r"`([^`]+)`", row[column]) for row in rows]


def test_names_of_the_table_exist() -> None:
    rows = table_rows()
    assert len(rows) > 20
    missing = []
    for row in rows:
        file = None
        for name in row:
            if ".f90" in name:
                file, _, name = name.partition(": ")
                if file not in PATHS:
                    missing.append(file)
                    continue
            if name and (file is None or name not in procedures_of(PATHS[file])):
                missing.append(f"{file}: {name}")
    assert not missing


def test_the_table_names_the_folders() -> None:
    for folders, names in zip(table_rows(2), table_rows(), strict=True):
        files = [name.partition(": ")[0] for name in names if ".f90" in name]
        assert {f"{PATHS[file].parent.name}/" for file in files} == {*folders}


def test_the_table_leaves_no_file_out() -> None:
    """Except modules beside the method: kinds, rounding, errors, types, LAPACK, the façade."""
    named = {name.partition(": ")[0] for row in table_rows() for name in row if ".f90" in name}
    beside = {"kinds.f90", "rounding.f90", "status.f90", "error.f90", "lapack.f90"}
    beside |= {"contact_result.f90", "mesh.f90"}
    files = {path.name for path in FORTRAN.glob("*/*.f90") if path.parent.name != "flat"}
    assert files - named - beside == set()


def test_every_procedure_and_its_arguments_are_documented() -> None:
    silent = []
    for path in SOURCES:
        lines = path.read_text(encoding="utf-8").splitlines()
        in_interface = False
        for k, line in enumerate(lines):
            if re.match(r"\s*(abstract )?interface\s*$", line):
                in_interface = path.name == "lapack.f90"
            if re.match(r"\s*end interface", line):
                in_interface = False
            head = HEAD.match(line)
            if not head or in_interface:
                continue
            if not lines[k - 1].strip().startswith("!>"):
                silent.append(f"{path.name}: {head[2]}")
            silent += [f"{path.name}: {head[2]}: {name}" for name in silent_arguments(lines, k)]
    assert not silent


def silent_arguments(lines: list[str], start: int) -> list[str]:
    """Dummy arguments without a line above them; one line may be above several."""
    found = []
    for k in range(start + 1, len(lines)):
        if re.match(r"\s*(end (subroutine|function)|contains\b)", lines[k]):
            break
        if ", intent(" in lines[k]:
            before = lines[k - 1].strip()
            if not (before.startswith("!>") or ", intent(" in before):
                found.append(lines[k].split("::")[-1].strip())
    return found


def test_arguments_are_in_the_order_of_the_call() -> None:
    text = (FORTRAN.parent / "docs" / "reference" / "fortran.md").read_text(encoding="utf-8")
    calls = {}
    for path in (FORTRAN / "flat").glob("*.f90"):
        source = re.sub(r"&\s*\n\s*&\s*", "", path.read_text(encoding="utf-8"))
        for name, arguments in re.findall(r"^subroutine (\w+)\(([^)]*)\)", source, re.MULTILINE):
            calls[name] = [argument.strip() for argument in arguments.split(",")]
    described = r"^`(flankload_\w+)`(?:(?!\n\n)[^|])*:\n\n(\| arguments .*?)\n\n"
    tables = re.findall(described, text, re.M | re.S)
    assert len(tables) == 7
    for name, table in tables:
        rows = [line.split("|")[1] for line in table.splitlines()[2:]]
        assert [word for row in rows for word in re.findall(r"`(\w+)`", row)] == calls[name]


def test_the_flat_interface_is_described_procedure_by_procedure() -> None:
    text = (FORTRAN / "README.md").read_text(encoding="utf-8")
    table = text.split("## The flat interface")[1].split("## ")[0]
    names = {name for path in (FORTRAN / "flat").glob("*.f90") for name in procedures_of(path)}
    assert {name for name in names if f"`{name}" not in table} == set()


def test_public_names_of_the_module_are_described() -> None:
    text = (FORTRAN / "README.md").read_text(encoding="utf-8")
    table = text.split("**Public names of module `flankload`:**")[1].split("\n\n")[1]
    rows = [row.split("|")[1] for row in table.splitlines()[2:]]
    described = [name for row in rows for name in re.findall(r"`(\w+)`", row)]
    public = runpy.run_path(str(FORTRAN / "install" / "exported_symbols.py"))["public_names"]
    assert sorted(described) == sorted(public(FORTRAN / "flankload.f90"))
