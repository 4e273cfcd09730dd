"""Check that procedures below fortran/ are short, and that another file uses each public name.

A procedure has at most 60 lines of code and 8 arguments. Comments and blank lines do not count; a
procedure counts with the ones inside it. Those of flat/, whose arguments are arrays without
descriptors, are as long as their lists of arguments, and those of LAPACK have its arguments.
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

#: What a program calls, or hands on as it was called: K, g0, B, R, Q, structure, method and what
#: comes of them; a sweep. Their lists of arguments are public.
PUBLIC = {
    "solver/contact_loop.f90: solve_contact_problem",
    "solver/contact_loop.f90: solve_and_keep",
    "solver/contact_loads.f90: solve_contact_loads",
    "solver/contact_sequence.f90: solve_contact_sequence",
    "position/position_load.f90: solve_position",
    "position/position_sweep.f90: sweep_positions",
    "position/recorded_sweep.f90: sweep_records",
    "position/recorded_meshes.f90: sweep_meshes",
    "position/recorded_sweep.f90: unpack_sweep",
    "points/nodal_sweep.f90: sweep_nodal_positions",
}


def procedures(path: Path) -> Iterator[tuple[str, int, int]]:
    """Name, lines and arguments of each procedure of a file, inner ones first."""
    lines = (line.rstrip() for line in path.read_text(encoding="utf-8").splitlines())
    code = [line for line in lines if line and not line.lstrip().startswith("!")]
    begun = []
    of_others = False
    for number, line in enumerate(code):
        if re.match(r"\s*(abstract )?interface\s*$|\s*end interface", line):
            of_others = "end" not in line
        if of_others:
            continue
        joined, following = line.rstrip("&"), number
        while code[following].endswith("&"):
            following += 1
            joined += code[following].strip().strip("&")
        if head := HEAD.match(joined):
            begun.append((head[1], number, len(head[2].split(",")) if head[2] else 0))
        elif END.match(line):
            name, first, arguments = begun.pop()
            yield name, number - first + 1, arguments


def complaints() -> list[str]:
    """One sentence for each procedure above a bound."""
    found = []
    for path in sorted(FORTRAN.rglob("*.f90")):
        place = path.relative_to(FORTRAN)
        if place.parts[0] in ("flat", "handles"):
            continue
        for name, lines, arguments in procedures(path):
            called = f"{place.as_posix()}: {name}"
            if lines > MOST_LINES or (arguments > MOST_ARGUMENTS and called not in PUBLIC):
                found.append(
                    f"{called}: {lines} lines and {arguments} arguments, "
                    f"at most {MOST_LINES} and {MOST_ARGUMENTS}"
                )
    return found


def unused() -> list[str]:
    """One sentence for each public name of a module that neither another file nor a test uses."""
    codes = {
        path: re.sub(r"&\s*\n\s*&", " ", re.sub(r"!.*", "", path.read_text(encoding="utf-8")))
        for folder in (FORTRAN, Path(__file__).resolve().parent)
        for path in sorted(folder.rglob("*.f90"))
    }
    words = {path: set(re.findall(r"\w+", code.lower())) for path, code in codes.items()}
    return [
        f"{path.relative_to(FORTRAN.parent).as_posix()}: no other file uses {name}"
        for path, code in codes.items()
        if FORTRAN in path.parents and path.parent != FORTRAN
        for names in re.findall(r"^ *public *:: *(.*)$", code, re.MULTILINE)
        for name in re.findall(r"\w+", names)
        if not any(name.lower() in words[other] for other in words if other != path)
    ]


if __name__ == "__main__":
    lines = complaints() + unused()
    for line in lines:
        print(line, file=sys.stderr)
    sys.exit(bool(lines))
