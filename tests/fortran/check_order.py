"""Check the order and the contracts of the folders below fortran/; `--list` prints the sources.

The order of subdir() in fortran/meson.build, and of the files in each folder's meson.build, is the
order of the pipeline: a file uses only modules of files before it, and of the folders that its own
folder may use.
"""

import re
import sys
from pathlib import Path

FORTRAN = Path(__file__).resolve().parents[2] / "fortran"
USE = re.compile(r"^\s*use\s+(?:,\s*\w+\s*::\s*)?(flankload\w*)", re.IGNORECASE | re.MULTILINE)
EXTERNAL = re.compile(r"^subroutine\s+(\w+)", re.IGNORECASE | re.MULTILINE)
MODULE = re.compile(r"^\s*module\s+(?!procedure\b)(\w+)\s*$", re.IGNORECASE | re.MULTILINE)
LISTED = re.compile(r"^\s*(?:input: )?'(\w+\.f90(?:\.in)?)',|^subdir\('(\w+)'\)", re.MULTILINE)

#: Folders whose modules a folder may use beside its own.
MAY_USE = {
    "base": set(),
    "flank": {"base"},
    "cells": {"base", "flank"},
    "compliance": {"base", "flank", "cells"},
    "solver": {"base"},
    "position": {"base", "flank", "cells", "compliance", "solver"},
    "points": {"base", "flank", "compliance", "solver"},
    "handles": {"base", "position"},
}


def listed_sources(folder: Path = FORTRAN) -> list[Path]:
    """Sources in the order of the build."""
    found = []
    for name, below in LISTED.findall((folder / "meson.build").read_text(encoding="utf-8")):
        found += [folder / name] if name else listed_sources(folder / below)
    return found


def module_complaints(path: Path, known: dict[str, str]) -> list[str]:
    """Faults of the modules of a file; `known` are those before it and their folders."""
    found = []
    text = path.read_text(encoding="utf-8")
    name, folder = path.relative_to(FORTRAN).as_posix(), path.parent.name
    modules = MODULE.findall(text)
    expected = "flankload_" + path.name.split(".")[0]
    if folder in MAY_USE and modules != [expected]:
        found.append(f"{name}: expected one module {expected}, found {modules}")
    for module in USE.findall(text):
        if module not in known and module not in modules:
            found.append(f"{name}: uses {module}, which does not precede it")
        elif folder in MAY_USE and known.get(module, folder) not in MAY_USE[folder] | {folder}:
            found.append(f"{name}: {folder}/ does not use {known[module]}/, but {module} is used")
    known.update(dict.fromkeys(modules, folder))
    return found


def complaints() -> list[str]:
    """One sentence for each rule that a file breaks."""
    found = []
    known: dict[str, str] = {}
    sources = listed_sources()
    for path in sources:
        found += module_complaints(path, known)
    # Modules and external procedures are global names (Fortran 2008, 16.2).
    for path in sources:
        for name in EXTERNAL.findall(path.read_text(encoding="utf-8")):
            if name.lower() in known:
                found.append(f"{path.name}: the module {name} has the name of this procedure")
    for path in sorted(FORTRAN.rglob("*.f90")):
        if path not in sources:
            found.append(f"{path.relative_to(FORTRAN).as_posix()}: in no meson.build")
    return found


if __name__ == "__main__":
    if "--list" in sys.argv:
        print(*(path.relative_to(FORTRAN.parent).as_posix() for path in listed_sources()), sep="\n")
        sys.exit()
    lines = complaints()
    for line in lines:
        print(line, file=sys.stderr)
    sys.exit(bool(lines))
