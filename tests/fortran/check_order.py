"""Check that Fortran files `use` only modules of files that stand before them in the build.

The order of the sources in fortran/meson.build is the order of the pipeline; data flow one way.
"""

import re
import sys
from pathlib import Path

FORTRAN = Path(__file__).resolve().parents[2] / "fortran"
USE = re.compile(r"^\s*use\s+(?:,\s*\w+\s*::\s*)?(flankload\w*)", re.IGNORECASE | re.MULTILINE)
EXTERNAL = re.compile(r"^subroutine\s+(\w+)", re.IGNORECASE | re.MULTILINE)
MODULE = re.compile(r"^\s*module\s+(?!procedure\b)(\w+)\s*$", re.IGNORECASE | re.MULTILINE)


def listed_sources() -> list[Path]:
    """Sources in the order of the build; what the build writes itself comes first."""
    text = (FORTRAN / "meson.build").read_text(encoding="utf-8")
    made = sorted(FORTRAN.glob("*.f90.in"))
    return made + [
        FORTRAN / name
        for name in re.findall(r"^\s*(?:input: )?'([\w/]+\.f90)',", text, re.MULTILINE)
    ]


def complaints() -> list[str]:
    """One sentence for each rule that a file breaks."""
    found = []
    known: set[str] = set()
    sources = listed_sources()
    for path in sources:
        text = path.read_text(encoding="utf-8")
        name = path.relative_to(FORTRAN).as_posix()
        modules = MODULE.findall(text)
        expected = "flankload_" + path.name.split(".")[0]
        if path.parent == FORTRAN and path.stem != "flankload" and modules != [expected]:
            found.append(f"{name}: expected one module {expected}, found {modules}")
        for module in USE.findall(text):
            if module not in known and module not in modules:
                found.append(f"{name}: uses {module}, which does not stand before it")
        known.update(modules)
    # Modules and external procedures are global names (Fortran 2008, 16.2).
    for path in sources:
        for name in EXTERNAL.findall(path.read_text(encoding="utf-8")):
            if name.lower() in known:
                found.append(f"{path.name}: the module {name} has the name of this procedure")
    for path in sorted(FORTRAN.rglob("*.f90")):
        if path not in sources:
            found.append(f"{path.relative_to(FORTRAN).as_posix()}: not in fortran/meson.build")
    return found


if __name__ == "__main__":
    lines = complaints()
    for line in lines:
        print(line, file=sys.stderr)
    sys.exit(bool(lines))
