"""Files of the installed library for packagers and other build systems, and nothing else."""

from __future__ import annotations

import re
import runpy
import shutil
import subprocess
from pathlib import Path

import pytest

from tests.support.nodal_position import DATA
from tests.support.programs import EXAMPLES, ROOT, built, run, written

EXPORTS = runpy.run_path(str(ROOT / "fortran" / "install" / "exported_symbols.py"))
PROJECT = """cmake_minimum_required(VERSION 3.18)
project(loads C Fortran)
find_package(flankload 0.1 CONFIG REQUIRED)
foreach(kind flankload flankload_static)
    add_executable(c_${kind} @EXAMPLES@/c/loads.c @EXAMPLES@/c/body.c)
    add_executable(f_${kind} @EXAMPLES@/modern_fortran/body_file.f90
                             @EXAMPLES@/modern_fortran/loads.f90)
    set_target_properties(f_${kind} PROPERTIES Fortran_MODULE_DIRECTORY modules_${kind})
    target_link_libraries(c_${kind} PRIVATE flankload::${kind})
    target_link_libraries(f_${kind} PRIVATE flankload::${kind})
endforeach()
find_package(flankload 0.0.1 CONFIG QUIET)
if(flankload_FOUND)
    message(FATAL_ERROR "0.1 is not 0.0")
endif()
"""


def said_by(*command: str | Path, **options: object) -> str:
    done = subprocess.run(command, capture_output=True, text=True, check=False, **options)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def test_module_internals_are_not_exported(prefix) -> None:
    table = said_by("nm", "-D", "--defined-only", prefix / "lib" / "libflankload.so")
    shown = {line.split()[-1] for line in table.splitlines()}
    flat = {name for name in shown if not name.startswith("__")}
    headers = ("flat/flankload.h", "handles/flankload_handles.h")
    texts = ((ROOT / "fortran" / header).read_text(encoding="utf-8") for header in headers)
    prototypes = "".join(texts)
    by_text = {"flankload_status_text_", "flankload_read_record_"}
    assert flat == set(re.findall(r"\b(flankload_\w+)\(", prototypes)) | by_text
    sources = sorted((ROOT / "fortran").rglob("*.f90"))
    public = EXPORTS["public_names"](ROOT / "fortran" / "flankload.f90")
    types = EXPORTS["types_of"](sources)
    procedures = {name.partition("_MOD_")[2] for name in shown - flat if "_MOD___" not in name}
    assert procedures <= public
    assert {"solve_contact_problem", "sweep_positions", "status_text"} <= procedures
    tables = {name for name in shown if "_MOD___vtab_" in name}
    reached = public & set(types)
    for _ in types:
        reached |= {part for name in reached for part in types[name]} & set(types)
    assert {re.search(r"_([A-Z][a-z]\w*)$", name)[1].lower() for name in tables} <= reached


def test_pkg_config_requires_openblas(prefix, environment) -> None:
    ask = ["pkg-config", "--print-requires-private", "flankload"]
    assert said_by(*ask, env=environment).split() == ["openblas"]
    linked = said_by("pkg-config", "--static", "--libs", "flankload", env=environment).split()
    assert "-lopenblas" in linked
    assert "-lgfortran" in linked


def test_two_builds_give_the_same_bytes(prefix) -> None:
    """Builds of the Python package and of the library alone, in separate folders."""
    built = "fortran/libflankload.a.p"
    one, two = (
        {path.name: path.read_bytes() for path in (folder / built).glob("*.o")}
        for folder in (ROOT / "build", prefix.parent)
    )
    if not one:
        pytest.skip("the Python package was built elsewhere")
    assert len(one) > 100
    assert one == two


def test_soname_is_that_of_the_interface(prefix) -> None:
    version = re.search(r"^Version: (.*)$", package_config(prefix), re.MULTILINE)[1].split(".")
    interface = ".".join(version[:2] if version[0] == "0" else version[:1])
    facts = said_by("readelf", "-d", prefix / "lib" / "libflankload.so")
    assert f"[libflankload.so.{interface}]" in facts


def package_config(prefix: Path) -> str:
    return (prefix / "lib" / "pkgconfig" / "flankload.pc").read_text(encoding="ascii")


@pytest.mark.parametrize(
    ("installed", "source"),
    [
        ("share/doc/flankload/LICENSE", "LICENSE"),
        ("share/man/man1/flankload.1", "docs/flankload.1"),
    ],
)
def test_licence_and_manual_page_are_installed(prefix, installed, source) -> None:
    assert (prefix / installed).read_bytes() == (ROOT / source).read_bytes()


@pytest.mark.skipif(shutil.which("cmake") is None, reason="no cmake on this machine")
def test_cmake_finds_both_libraries(prefix, workshop, environment) -> None:
    folder = workshop / "cmake"
    folder.mkdir(exist_ok=True)
    written(folder / "CMakeLists.txt", PROJECT.replace("@EXAMPLES@", str(EXAMPLES)))
    said_by("cmake", "-S", folder, "-B", folder / "made", f"-DCMAKE_PREFIX_PATH={prefix}")
    said_by("cmake", "--build", folder / "made")
    for letter, language in (("c", "c"), ("f", "modern_fortran")):
        by_make = built(EXAMPLES / language, workshop / language, environment, static=False)
        expected = run(by_make / "loads", DATA, environment)
        for kind in ("flankload", "flankload_static"):
            program = folder / "made" / f"{letter}_{kind}"
            assert run(program, DATA, environment) == expected
            needed = said_by("readelf", "-d", program)
            assert ("libflankload.so" in needed) == (kind == "flankload")
