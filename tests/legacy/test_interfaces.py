"""A call with wrong arguments does not compile, whichever interface a program names."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest

from tests.support.programs import EXAMPLES

RIGHT = "3, matrix, 0, levers, scaled, symmetric, elastic, info"
WRONG = {
    "an argument fewer": "3, matrix, 0, levers, scaled, symmetric, elastic",
    "an argument more": "3, matrix, 0, levers, scaled, symmetric, elastic, info, info",
    "a real for an integer": "3d0, matrix, 0, levers, scaled, symmetric, elastic, info",
    "an integer for a real": "3, matrix, 0, info, scaled, symmetric, elastic, info",
    "a scalar for an array": "3, matrix, 0, 1d0, scaled, symmetric, elastic, info",
}
#: Its continued line is one in both source forms.
BODY = f"""\
      double precision matrix(3,3), levers(3), scaled(3,3)
      integer symmetric, elastic, info
      matrix = 1d0
      levers = 1d0
{"      call flankload_normal_compliance(":72}&
     &    {{arguments}})
      end
"""
INCLUDE = "      include 'flankload_interfaces.inc'\n"
#: Regression: 54 warnings of unused parameters.
WARN = ["-Wall", "-Wextra"]
WAYS = {
    "fixed.f": ("      program call\n      implicit none\n" + INCLUDE, ["-std=legacy", *WARN]),
    "free.f90": ("program call\nimplicit none\n" + INCLUDE, ["-std=f2008", "-pedantic", *WARN]),
    "module.f90": ("program call\nuse flankload\nimplicit none\n", ["-std=f2008", "-pedantic"]),
}


def compiled(
    source: Path, text: str, options: list[str], prefix: Path
) -> subprocess.CompletedProcess[str]:
    """Whether a program compiles with the installed files, and the messages."""
    source.write_text(text, encoding="ascii")
    return subprocess.run(
        ["gfortran", "-fsyntax-only", *options, f"-I{prefix / 'include' / 'flankload'}", source],
        cwd=source.parent,
        capture_output=True,
        text=True,
        check=False,
    )


@pytest.mark.parametrize("way", [*WAYS])
def test_a_call_that_lacks_an_argument_does_not_compile(
    way: str, prefix: Path, tmp_path: Path
) -> None:
    head, options = WAYS[way]
    fits = compiled(tmp_path / way, head + BODY.format(arguments=RIGHT), options, prefix)
    assert (fits.returncode, fits.stderr) == (0, "")
    for fault, arguments in WRONG.items():
        made = compiled(tmp_path / way, head + BODY.format(arguments=arguments), options, prefix)
        assert made.returncode != 0, fault
        assert "argument" in made.stderr.lower(), made.stderr


def test_the_module_brings_no_internals(prefix: Path, tmp_path: Path) -> None:
    """Names that a program with USE and without ONLY may give to its own variables."""
    names = [
        "blank, scale_rows, form_of, matrix_form, unpack_result",
        "refused_argument, most_nodal_pairs, fatal_error, rung, position_type",
    ]
    text = "program own\nuse flankload\nimplicit none\n"
    text += "".join(f"integer :: {line}\n" for line in names) + "end program own\n"
    made = compiled(tmp_path / "own.f90", text, ["-std=f2008"], prefix)
    assert made.returncode == 0, made.stderr


def test_programs_with_external_procedures_still_compile(prefix: Path, tmp_path: Path) -> None:
    """Programs that pass a scalar as an array of one number."""
    text = """\
      program old
      include 'flankload.inc'
      double precision x, y
      integer info
      x = 1d0
      call flankload_double_vector (1, x, y, info)
      end
"""
    made = compiled(tmp_path / "old.f", text, ["-std=legacy"], prefix)
    assert (made.returncode, made.stderr) == (0, "")


def with_option(option: str, example: str, program: str, folder: Path, prefix: Path) -> Path | str:
    """An example program compiled with an option, or the message of the compiler."""
    first, ending = ("rdbody.f", "f") if example == "legacy_fortran" else ("body_file.f90", "f90")
    library = prefix / "lib"
    made = subprocess.run(
        [
            *("gfortran", option, f"-I{prefix / 'include' / 'flankload'}", "-o", folder / program),
            *(EXAMPLES / example / name for name in (first, f"{program}.{ending}")),
            *(f"-L{library}", "-lflankload", f"-Wl,-rpath,{library}"),
        ],
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
    )
    return folder / program if made.returncode == 0 else made.stderr


@pytest.mark.parametrize("program", ["loads", "sweep"])
@pytest.mark.parametrize(
    ("option", "words"),
    [
        ("-fdefault-integer-8", "INTEGERS OF 4 BYTES ARE WANTED"),
        ("-fdefault-real-8", "DOUBLE PRECISION OF 8 BYTES IS WANTED"),
    ],
)
def test_numbers_of_another_size_are_refused(
    program: str, option: str, words: str, prefix: Path, tmp_path: Path
) -> None:
    """Otherwise status 0 with wrong pairs in contact would result."""
    made = with_option(option, "legacy_fortran", program, tmp_path, prefix)
    assert isinstance(made, Path), made
    data = EXAMPLES / "legacy_fortran" / ("pair.dat" if program == "loads" else "sweep.dat")
    with data.open() as text:
        done = subprocess.run([made], stdin=text, capture_output=True, text=True, check=False)
    assert done.returncode == 3
    assert words in done.stderr
    assert option in done.stderr
    assert done.stdout == ""


def test_the_module_keeps_the_sizes_of_numbers(
    prefix: Path, tmp_path: Path, environment: dict[str, str]
) -> None:
    refused = with_option("-fdefault-integer-8", "modern_fortran", "loads", tmp_path, prefix)
    assert isinstance(refused, str)
    assert "passed INTEGER(8) to INTEGER(4)" in refused
    printed = []
    for option in ("-O0", "-fdefault-real-8"):
        made = with_option(option, "modern_fortran", "loads", tmp_path, prefix)
        assert isinstance(made, Path), made
        with (EXAMPLES / "legacy_fortran" / "pair.dat").open() as text:
            done = subprocess.run(
                [made], stdin=text, env=environment, capture_output=True, text=True, check=True
            )
        printed.append(done.stdout)
    assert printed[0] == printed[1] != ""
