"""Check that no procedure below fortran/ has more than 60 lines of code or 8 arguments.

Comments and blank lines do not count; a procedure counts with the ones inside it. Those of flat/,
whose arguments are arrays without descriptors, are as long as their lists of arguments.
"""

import re
import sys
from collections.abc import Iterator
from pathlib import Path

FORTRAN = Path(__file__).resolve().parents[2] / "fortran"
MOST_LINES, MOST_ARGUMENTS = 60, 8
HEAD = re.compile(
    r"\s*(?!end\b)(?:[a-z][\w() =]*\s)?(?:subroutine|function)\s+(\w+)\s*"
    r"(?:\(([^)]*)\))?",
    re.IGNORECASE,
)
END = re.compile(r"\s*end\s+(?:subroutine|function)\b", re.IGNORECASE)

#: Procedures above a bound, with their lines and arguments: none may grow, none may join.
LARGER: dict[str, tuple[int, int]] = {}


def procedures(path: Path) -> Iterator[tuple[str, int, int]]:
    """Name, lines and arguments of each procedure of a file, inner ones first."""
    lines = (line.rstrip() for line in path.read_text(encoding="utf-8").splitlines())
    code = [line for line in lines if line and not line.lstrip().startswith("!")]
    begun = []
    for number, line in enumerate(code):
        joined, following = line.rstrip("&"), number
        while code[following].endswith("&"):
            following += 1
            joined += code[following].strip().strip("&")
        if head := HEAD.match(joined):
            begun.append((head[1], number, len((head[2] or "").split(",")) if head[2] else 0))
        elif END.match(line):
            name, first, arguments = begun.pop()
            yield name, number - first + 1, arguments


def larger() -> dict[str, tuple[int, int]]:
    """Procedures above a bound as `folder/file.f90: name`."""
    found = {}
    for path in sorted(FORTRAN.rglob("*.f90")):
        place = path.relative_to(FORTRAN)
        if place.parts[0] == "flat":
            continue
        for name, lines, arguments in procedures(path):
            if lines > MOST_LINES or arguments > MOST_ARGUMENTS:
                found[f"{place.as_posix()}: {name}"] = lines, arguments
    return found


def complaints() -> list[str]:
    """One sentence for each procedure that has grown, and for each entry that is not needed."""
    found, now = [], larger()
    for name, (lines, arguments) in now.items():
        bound = LARGER.get(name, (MOST_LINES, MOST_ARGUMENTS))
        if lines > max(bound[0], MOST_LINES) or arguments > max(bound[1], MOST_ARGUMENTS):
            found.append(f"{name}: {lines} lines and {arguments} arguments, at most {bound}")
    for name, bound in LARGER.items():
        if now.get(name) != bound:
            found.append(f"{name}: has {now.get(name, 'no more than a bound')}, noted are {bound}")
    return found


if __name__ == "__main__":
    if "--list" in sys.argv:
        for name, sizes in larger().items():
            print(f'    "{name}": {sizes},')
        sys.exit()
    lines = complaints()
    for line in lines:
        print(line, file=sys.stderr)
    sys.exit(bool(lines))
