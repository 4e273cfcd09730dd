"""The flat interface: its prototypes, its words, and that it keeps to itself."""

from __future__ import annotations

import ctypes
import importlib.util
import re
import subprocess
import textwrap
from types import ModuleType

import numpy as np
import pytest

from flankload import _core
from flankload.contact.body_record import PARTS
from flankload.contact.status import SiteCorner, Status
from tests.support.paths import FORTRAN

FLAT = sorted((FORTRAN / "flat").glob("*.f90"))
SOURCES = sorted(FORTRAN.rglob("*.f90"))

PROCEDURE = re.compile(
    r"^subroutine (\w+)\(([^)]*)\) ?(?:bind\(c, name='\w+'\))?$(.*?)^end subroutine \1$",
    re.MULTILINE | re.DOTALL,
)
DECLARED = re.compile(
    r"^    (integer(?:\(c_int\))?|real\(c_double\)|double precision|character\([\w=*]+\)), "
    r"intent\((in|out|inout)\)(, value)? :: (\w+)",
    re.MULTILINE,
)
C_TYPES = {"integer": "int", "double precision": "double"}


def joined(text: str) -> str:
    """Source with its continued lines in one."""
    return re.sub(r"&\s*\n\s*&\s*", "", text)


def procedures() -> dict[str, list[tuple[str, str, str]]]:
    """Name, intent and type of every argument of every procedure of the interface."""
    found = {}
    for path in FLAT:
        for name, arguments, body in PROCEDURE.findall(joined(path.read_text(encoding="utf-8"))):
            declared = {d[3]: (d[0], d[1]) for d in DECLARED.findall(body)}
            names = [argument.strip() for argument in arguments.split(",")]
            found[name] = [
                (argument, *declared[argument]) for argument in names if argument in declared
            ]
            assert len(found[name]) == len(names), f"{name}: an argument without its declaration"
    return found


INTERFACE = procedures()
FOR_FORTRAN = sorted(name for name in INTERFACE if not name.endswith("_c"))
FOR_C = sorted({*INTERFACE} - {"flankload_status_text", "flankload_read_record"})
FOR_BOTH = sorted({*FOR_FORTRAN} & {*FOR_C})


def test_every_procedure_was_found() -> None:
    text = "".join(path.read_text(encoding="utf-8") for path in FLAT)
    assert len(INTERFACE) == len(re.findall(r"^subroutine", text, re.MULTILINE)) >= 9


@pytest.mark.parametrize("name", FOR_FORTRAN)
def test_manners(name: str) -> None:
    """Names of at most 31 letters; info last."""
    assert len(name) <= 31
    assert name.startswith("flankload_")
    if name != "flankload_status_text":
        assert INTERFACE[name][-1] == ("info", "integer", "out")


def prototype(name: str) -> str:
    """Declaration of a procedure in flankload.h."""
    arguments = [
        f"{'const ' if intent == 'in' else ''}{C_TYPES[kind]} *{argument}"
        for argument, kind, intent in INTERFACE[name]
    ]
    head = f"void\0{name}_("
    # an argument stays in one line
    joined_up = ", ".join(argument.replace(" ", "\0") for argument in arguments)
    lines = textwrap.wrap(head + joined_up + ");", 100, subsequent_indent=" " * len(head))
    return "\n".join(lines).replace("\0", " ")


@pytest.mark.parametrize(
    "name", sorted({*FOR_C} - {"flankload_status_text_c", "flankload_read_record_c"})
)
def test_prototypes_for_c(name: str) -> None:
    header = " ".join((FORTRAN / "flat" / "flankload.h").read_text(encoding="utf-8").split())
    wanted = prototype(name)
    assert " ".join(wanted.split()) in header, f"flankload.h lacks\n{wanted}"


def test_the_header_names_nothing_else() -> None:
    header = (FORTRAN / "flat" / "flankload.h").read_text(encoding="utf-8")
    assert sorted(re.findall(r"void (flankload_\w+?)_?\(", header)) == FOR_C
    assert "void flankload_status_text_c(int code, int size, char *text);" in header
    assert "void flankload_read_record_c(const char *name, int n_record, double *record" in header


ARRAY = re.compile(r"^    \S.*, intent\(\w+\) :: (\w+)\(", re.MULTILINE)


def arrays() -> list[tuple[str, int]]:
    """Procedure, and number (from 1) of an array among its arguments except for the last, info."""
    found = []
    for path in FLAT:
        for name, _, body in PROCEDURE.findall(joined(path.read_text(encoding="utf-8"))):
            if name not in FOR_BOTH:
                continue
            of_procedure = {*ARRAY.findall(body)} - {"text"}
            found += [
                (name, k + 1)
                for k, (argument, *_) in enumerate(INTERFACE[name][:-1])
                if argument in of_procedure
            ]
    return found


@pytest.mark.parametrize("entries", [0, 2])
def test_null_pointers_are_refused_if_the_array_has_entries(entries: int) -> None:
    """Regression: they ended the program. Arrays without entries may be null pointers."""
    core = ctypes.CDLL(_core.__file__)
    refused, words = {}, {}
    for name, missing in arrays():
        sizes = np.full(1, entries, dtype=np.intc)
        held: list[np.ndarray | None] = [sizes, *(np.zeros(512) for _ in INTERFACE[name][1:-1])]
        for k, (argument, *_) in enumerate(INTERFACE[name][:-1]):
            if argument.startswith(("n_", "max_", "room")):
                held[k] = sizes
        held[missing - 1] = None
        info = np.full(64, 7, dtype=np.intc)
        getattr(core, f"{name}_")(
            *(ctypes.c_void_p(None if each is None else each.ctypes.data) for each in held),
            ctypes.c_void_p(info.ctypes.data),
        )
        refused[name, missing] = int(info[0])
        words[name, missing] = _core.flankload_status_text(int(info[0])).decode().strip()
    if entries:
        assert len(refused) > 80
        for (name, missing), info_of in refused.items():
            assert info_of == -100 - missing, name
            argument = INTERFACE[name][missing - 1][0]
            expected = f"{name}: {argument}: expected an array, found a null pointer"
            assert words[name, missing] == expected
    else:
        assert refused["flankload_double_vector", 2] == 0
        assert refused["flankload_solve_contact", 4] == -101


def test_the_include_file_names_every_procedure() -> None:
    text = (FORTRAN / "flat" / "flankload.inc").read_text(encoding="ascii")
    assert sorted(re.findall(r"external (\w+)", text)) == FOR_FORTRAN
    # fixed and free source form both read it
    for line in text.splitlines():
        assert len(line) <= 72
        assert line.startswith(("!", "      "))
        assert "&" not in line


def make_interfaces() -> ModuleType:
    """The script that writes the interfaces."""
    path = FORTRAN / "flat" / "make_interfaces.py"
    specification = importlib.util.spec_from_file_location(path.stem, path)
    assert specification is not None
    assert specification.loader is not None
    module = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(module)
    return module


def test_the_interfaces_are_those_of_the_sources() -> None:
    text = (FORTRAN / "flat" / "flankload_interfaces.inc").read_text(encoding="ascii")
    wanted = make_interfaces().interfaces()
    assert text == wanted, "run python fortran/flat/make_interfaces.py"
    assert sorted(re.findall(r"^      subroutine (\w+)", text, re.MULTILINE)) == FOR_FORTRAN
    statements = re.sub(r" *&\n     & *", " ", text)
    for name in FOR_FORTRAN:
        block = re.search(
            rf"subroutine {name}\((.*?)\)$(.*?)end subroutine", statements, re.M | re.S
        )
        assert block is not None
        assert block[1].split(", ") == [argument for argument, *_ in INTERFACE[name]]
        assert {
            found[3] for found in DECLARED.findall(block[2].replace("\n        ", "\n    "))
        } == {argument for argument, *_ in INTERFACE[name]}


def test_both_source_forms_read_the_interfaces() -> None:
    """Continued lines have & in column 73, where fixed form ends, and in column 6."""
    lines = (FORTRAN / "flat" / "flankload_interfaces.inc").read_text(encoding="ascii").splitlines()
    for line, following in zip(lines, [*lines[1:], ""], strict=True):
        assert line.startswith(("!", "      ", "     &"))
        assert len(line) <= 72 or (len(line) == 73 and line.endswith("&"))
        assert line.endswith("&") == following.startswith("     &")


def test_the_module_shows_the_whole_interface() -> None:
    text = (FORTRAN / "flankload.f90").read_text(encoding="utf-8")
    shown = [name for line in re.findall(r"public :: (.*)", text) for name in line.split(", ")]
    include = (FORTRAN / "flat" / "flankload.inc").read_text(encoding="ascii")
    numbers = re.findall(r"(fl_\w+)=", include)
    assert len(numbers) == 12 + len(PARTS) + len(SiteCorner)
    interface = [name for name in shown if name.startswith(("flankload_", "fl_"))]
    assert sorted(interface) == sorted([*FOR_FORTRAN, *numbers])


def named_numbers() -> tuple[dict[str, int], dict[str, int]]:
    """Constants for Fortran, and those for C, without their prefixes."""
    include = (FORTRAN / "flat" / "flankload.inc").read_text(encoding="ascii")
    header = (FORTRAN / "flat" / "flankload.h").read_text(encoding="utf-8")
    of_c = {k.lower(): int(v) for k, v in re.findall(r"FLANKLOAD_(\w+) = (-?\d+)", header)}
    return {k: int(v) for k, v in re.findall(r"fl_(\w+)=(-?\d+)", include)}, of_c


def test_numbers_of_methods_structures_and_parts_agree() -> None:
    from flankload.contact.problem import DEFINITE, DEFINITE_PART, GENERAL, METHOD_NAMES, SYMMETRIC

    of_fortran, of_c = named_numbers()
    names = {name.replace("single_pivoted", "pivoted"): n for n, name in METHOD_NAMES.items()}
    names |= {
        "general": GENERAL,
        "symmetric": SYMMETRIC,
        "definite": DEFINITE,
        "definite_part": DEFINITE_PART,
    }
    names |= {f"part_{name}": number for number, name in enumerate(PARTS, start=1)}
    names |= {f"site_{corner.name.lower()}": corner.value for corner in SiteCorner}
    assert of_fortran == of_c == names


def test_every_status_has_its_words() -> None:
    registry = (FORTRAN / "base" / "status.f90").read_text(encoding="utf-8")
    numbers = registry.partition("contains")[0]
    named = dict(re.findall(r"\b(\w+) = (-?\d+)\b", numbers))
    del named["before_arguments"]
    corners = {name for name in named if name.startswith("site_")}
    marks = {name.removeprefix("site_").upper(): int(named.pop(name)) for name in corners}
    of_body = {SiteCorner.CORNER_1, SiteCorner.CORNER_2}
    assert marks == {corner.name: corner.value for corner in set(SiteCorner) - of_body}
    names = {re.sub("^(status|code)_", "", name).upper(): int(n) for name, n in named.items()}
    assert names == {status.name: status.value for status in Status}
    words = {code: _core.flankload_status_text(code).decode("ascii").strip() for code in Status}
    assert len(set(words.values())) == len(words)
    assert not any(text.startswith("no status") for text in words.values())
    assert max(len(text) for text in words.values()) <= 80
    assert _core.flankload_status_text(-199) == b"argument 99 is not valid"
    assert _core.flankload_status_text(99) == b"no status has the number 99"


def test_only_the_registry_numbers_statuses() -> None:
    numbered = re.compile(r"\b(code|status)\w* = -?[1-9]|fatal_error\(error, -?\d")
    for path in SOURCES:
        if path.name != "status.f90":
            assert not numbered.search(path.read_text(encoding="utf-8")), path.name


def contact_arguments(**changes: object) -> list[object]:
    arguments: dict[str, object] = {
        "compliance": np.eye(2, order="F"),
        "normal_gaps": np.zeros(2),
        "motions": np.ones((2, 1), order="F"),
        "load_rows": np.ones((2, 1), order="F"),
        "loads": np.ones(1),
        "structure": 1,
        "method": 0,
        "warm_pairs": np.empty(0, dtype=np.int32),
    }
    return list((arguments | changes).values())


@pytest.mark.parametrize(
    ("argument", "change"),
    [
        (9, {"structure": 4}),
        (9, {"structure": -1}),
        (10, {"method": 8}),
        (11, {"warm_pairs": np.array([3], dtype=np.int32)}),
        (11, {"warm_pairs": np.array([0], dtype=np.int32)}),
    ],
)
def test_refused_arguments_of_a_contact_problem(argument: int, change: dict[str, object]) -> None:
    *numbers, info = _core.flankload_solve_contact(*contact_arguments(**change))
    assert info == -100 - argument
    assert np.isnan(numbers[0]).all()
    assert _core.flankload_solve_contact(*contact_arguments())[-1] == 0


def test_refused_arguments_of_a_sequence() -> None:
    def info_of(**changes: object) -> np.ndarray:
        arguments: dict[str, object] = {
            "n_threads": 1,
            "sizes": np.array([2], dtype=np.int32),
            "compliances": np.eye(2).ravel(),
            "normal_gaps": np.zeros(2),
            "motions": np.ones(2),
            "load_rows": np.ones(2),
            "loads": np.ones((1, 2, 1), order="F"),
            "keys": np.arange(2, dtype=np.int32),
            "structures": np.array([1], dtype=np.int32),
            "method": 0,
        }
        *numbers, info = _core.flankload_solve_sequence(*(arguments | changes).values())
        assert (info == 0).all() or np.isnan(numbers[0]).all()
        return info.ravel().tolist()

    assert info_of() == [0, 0]
    assert info_of(n_threads=-1) == [-106, -106]
    assert info_of(sizes=np.array([1], dtype=np.int32)) == [-107, -107]
    assert info_of(structures=np.array([9], dtype=np.int32)) == [-114, -114]
    assert info_of(method=11) == [-115, -115]


def test_global_names_are_used_once() -> None:
    """Modules and external procedures share one space of names (Fortran 2008, 16.2)."""
    text = "\n".join(path.read_text(encoding="utf-8").lower() for path in SOURCES)
    modules = re.findall(r"^module (\w+)$", text, re.MULTILINE)
    names = [*modules, *INTERFACE]
    assert len(modules) >= 70
    assert {name for name in names if names.count(name) > 1} == set()
    assert "volatile" not in text


def test_the_core_prints_opens_and_stops_nothing() -> None:
    """Between calls it keeps only the message about an invalid argument."""
    kept = re.compile(r"^    (?:integer|real|character|logical|type)[^:]*:: \w+.* = ", re.MULTILINE)
    for path in SOURCES:
        text = path.read_text(encoding="utf-8").partition("\ncontains\n")[0]
        text = re.sub(r"^    type( ::|, ).*?^    end type", "", text, flags=re.M | re.S)
        found = [line for line in kept.findall(text) if "parameter" not in line]
        assert len(found) == (2 if path.name == "refusal.f90" else 0), f"{path.name}: {found}"
    forbidden = re.compile(
        r"^\s*(print\b|open\s*\(|close\s*\(|read\s*\(|(error )?stop\b|save\b"
        r"|write\s*\((?!number,)|common\b|.*\bsave\s*::|call (exit|abort)\b)",
        re.IGNORECASE,
    )
    for path in SOURCES:
        if path.name == "record_file.f90":
            continue  # it opens and reads files of records
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), start=1):
            assert not forbidden.match(line), f"{path.name}:{number}: {line}"


def test_the_library_shows_its_own_names_alone() -> None:
    library = FORTRAN.parent / "build" / "fortran" / "libflankload.so"
    if not library.exists():
        pytest.skip("the library is elsewhere")
    listed = subprocess.run(
        ["nm", "-D", library], capture_output=True, text=True, check=True
    ).stdout.splitlines()
    defined = [line.split()[-1] for line in listed if " U " not in line and " w " not in line]
    assert not [name for name in defined if not re.match(r"(__)?flankload_", name)]
    assert {f"{name}_" for name in FOR_FORTRAN} <= set(defined)
    wanted = {line.split()[-1].split("@")[0] for line in listed if " U " in line}
    for call in ("stop", "flush"):  # files are opened by `record_file.f90` alone, see above
        assert not [name for name in wanted if re.match(rf"_gfortran_(st_|error_)?{call}", name)]
    assert not wanted & {"exit", "abort", "printf", "puts", "fopen", "system"}
