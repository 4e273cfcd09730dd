"""Write flankload_interfaces.inc from the sources of the flat interface and from flankload.inc.

To be run after each change of an argument: `python fortran/flat/make_interfaces.py`.
"""

import re
from pathlib import Path

FLAT = Path(__file__).resolve().parent
TARGET = FLAT / "flankload_interfaces.inc"

PROCEDURE = re.compile(
    r"^subroutine (\w+)\(([^)]*)\)$(.*?)^end subroutine \1$", re.MULTILINE | re.DOTALL
)
ARGUMENT = re.compile(r"^    ([\w(=*) ]+(?:, \w+)*, intent\(\w+\) :: (\w+).*)$", re.MULTILINE)

HEAD = """\
! Flat interface of flankload with explicit interfaces: for INCLUDE in
! fixed or free source form, instead of flankload.inc. The compiler
! rejects calls with a wrong number or wrong types of arguments.
! All reals are DOUBLE PRECISION, all integers default integers.
! Written by make_interfaces.py from the sources.
"""


def in_both_forms(statement: str, indent: int) -> str:
    """Return a statement in lines for both source forms: & in column 73 and in column 6."""
    pieces = re.findall(r"\S+\s*", statement)
    lines = [" " * indent]
    for piece in pieces:
        if len(lines[-1]) + len(piece.rstrip()) > 72:
            lines.append("     &" + " " * (indent + 4 - 6))
        lines[-1] += piece
    return "".join(f"{line.rstrip():72}&\n" for line in lines[:-1]) + lines[-1].rstrip() + "\n"


def interface(name: str, arguments: str, body: str) -> str:
    """Return the interface of a procedure: its head and the declarations of its arguments."""
    declared = {found[1]: found[0] for found in ARGUMENT.findall(body)}
    names = [argument.strip() for argument in arguments.split(",")]
    # In the order of the source, where sizes are declared before the arrays.
    in_order = [declared[argument] for argument in declared if argument in names]
    statements = [
        (f"subroutine {name}({', '.join(names)})", 6),
        ("implicit none", 8),
        *((statement, 8) for statement in in_order),
        (f"end subroutine {name}", 6),
    ]
    return "".join(in_both_forms(*statement) for statement in statements)


def use_of(constants: str) -> str:
    """Return an interface that names all constants, so that no compiler calls one unused."""
    names = re.findall(r"(\w+)=", constants)
    statements = [
        ("subroutine fl_numbers(unused)", 8),
        ("import", 10),
        ("implicit none", 10),
        (f"integer, intent(in) :: unused(max({', '.join(names)}))", 10),
        ("end subroutine fl_numbers", 8),
    ]
    return "".join(in_both_forms(*statement) for statement in statements)


def interfaces() -> str:
    """Return the text of the include file."""
    constants = (FLAT / "flankload.inc").read_text(encoding="ascii")
    constants = constants[constants.index("! Known structure of K") :]
    text = HEAD + constants + "      interface\n" + use_of(constants)
    for path in sorted(FLAT.glob("*.f90")):
        source = re.sub(r"&\s*\n\s*&\s*", "", path.read_text(encoding="utf-8"))
        text += "".join(interface(*found) for found in PROCEDURE.findall(source))
    return text + "      end interface\n"


if __name__ == "__main__":
    TARGET.write_text(interfaces(), encoding="ascii")
