"""Programs that know nothing but the installed library: every number is that of Python."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

import numpy as np
import pytest

import flankload as fl
from flankload import _core
from tests.support.gear_like import gear_like
from tests.support.nodal_position import DATA, read_data
from tests.support.programs import (
    EXAMPLES,
    LINKING,
    PROGRAMS,
    ROOT,
    built,
    expect_printed,
    run,
    written,
)


@pytest.fixture(scope="module")
def python_side() -> dict[str, np.ndarray]:
    """The position of the data file, solved by Python."""
    data = read_data(DATA)
    flank, radius, gap_angle, lever, row, row_2, matrix = data.pairs()
    state = fl.solve_contact_general(
        matrix, lever * gap_angle, lever, data.torque_Nmm, load_rows=row
    )
    several = [
        fl.solve_contact_general(
            matrix, lever * gap_angle, lever, part * data.torque_Nmm, load_rows=row
        )
        for part in (0.25, 0.5, 1.0)
    ]
    return {
        "flank": flank,
        "radius": radius,
        "gap_angle": gap_angle,
        "row_2": row_2,
        "torque": data.torque_Nmm,
        "state": state,
        "several": several,
    }


@pytest.mark.parametrize("static", LINKING)
def test_fixed_form_fortran(static, python_side, workshop, environment) -> None:
    name = "legacy_fortran" + ("_static" if static else "")
    folder = built(
        EXAMPLES / "legacy_fortran", workshop / name, environment, static=static, program="loads"
    )
    lines = run(folder / "loads", DATA, environment).splitlines()
    state, flank = python_side["state"], python_side["flank"]
    assert lines[1].split()[:3] == ["STATUS", str(state.status), "solved"]
    table = [line.split() for line in lines if re.match(r" +\d+ +\d+\.\d", line)]
    assert len(table) == flank.size
    for i, row in enumerate(table):
        assert int(row[0]) == flank[i]
        expect_printed(row[1], python_side["radius"][i])
        expect_printed(row[2], python_side["gap_angle"][i])
        expect_printed(row[3], state.normal_forces[i])
        expect_printed(row[4], state.final_gap_angles[i])
    text = "\n".join(lines)
    for label, number in (
        ("ROTATION RAD", state.rotation),
        ("MM\\)", state.tangent[0, 0]),
        ("TORQUE 2 N MM", float(python_side["row_2"] @ state.normal_forces)),
        ("FLANK  1 CARRIES N", state.normal_forces[flank == 1].sum()),
        ("FLANK  2 CARRIES N", state.normal_forces[flank == 2].sum()),
    ):
        found = re.search(label + r" +(\S+)", text)
        assert found is not None, text
        expect_printed(found[1], number)


def test_modern_fortran(python_side, workshop, environment) -> None:
    name = "modern_fortran"
    folder = built(EXAMPLES / name, workshop / name, environment, static=False)
    words = [line.split() for line in run(folder / "loads", DATA, environment).splitlines()]
    flank = python_side["flank"]
    for k, state in enumerate(python_side["several"]):
        torque, *flanks = words[3 * k : 3 * k + 3]
        expect_printed(torque[1], (0.25, 0.5, 1.0)[k] * python_side["torque"])
        expect_printed(torque[3], state.rotation)
        assert int(torque[5]) == state.active_pairs.size
        for f, row in enumerate(flanks, start=1):
            assert int(row[1]) == f
            expect_printed(row[3], state.normal_forces[flank == f].sum())
    largest = int(state.normal_forces.argmax())
    expect_printed(words[9][4], python_side["radius"][largest])
    expect_printed(words[9][6], state.normal_forces[largest])


def test_c(python_side, workshop, environment) -> None:
    folder = built(EXAMPLES / "c", workshop / "c", environment, static=False)
    first, *table, motion, quality = run(folder / "loads", DATA, environment).splitlines()
    state = python_side["state"]
    assert first == f"status {state.status}: solved"
    assert len(table) == python_side["flank"].size
    for i, line in enumerate(table):
        row = line.split()
        assert int(row[0]) == python_side["flank"][i]
        expect_printed(row[1], python_side["radius"][i])
        expect_printed(row[2], python_side["gap_angle"][i])
        expect_printed(row[3], state.normal_forces[i])
        expect_printed(row[4], state.final_gap_angles[i])
        assert int(row[5]) == (i in state.active_pairs)
    expect_printed(motion.split()[1], state.rotation)
    expect_printed(motion.split()[3], state.tangent[0, 0])
    expect_printed(quality.split()[1], state.info.condition)
    expect_printed(quality.split()[4], state.info.backward_error)


def contact_problems() -> list[tuple[int, int, tuple[np.ndarray, ...]]]:
    """Structure, method and arrays: gear-like, cold and by every loop, and one without a state."""
    rng = np.random.default_rng(20261121)
    found = []
    for method in (0, 1, 3, 4, 5, 6, 7):
        problem = gear_like(rng)
        while problem.gap_angles.size < 30 or problem.friction > 0:
            problem = gear_like(rng)
        levers = problem.levers[:, None]
        matrix = problem.levers[:, None] * problem.flexibility
        found.append(
            (
                1,
                method,
                (
                    0.5 * (matrix + matrix.T),
                    problem.levers * problem.gap_angles,
                    levers,
                    problem.torque_row[:, None],
                    np.array([problem.torque]),
                ),
            )
        )
    backwards = -np.ones((2, 1))
    none = (np.array([[2.0, 1.0], [1.0, 2.0]]), np.zeros(2), backwards, backwards, np.ones(1))
    return [*found, (1, 0, none)]


@pytest.fixture(scope="module")
def problem_file(workshop: Path) -> Path:
    lines = [str(len(contact_problems()))]
    for structure, method, arrays in contact_problems():
        n, q = arrays[2].shape
        lines.append(f"{n} {q} {structure} {method}")
        lines += [" ".join(f"{x:.17g}" for x in part.ravel(order="F")) for part in arrays]
    return written(workshop / "problems.txt", "\n".join(lines) + "\n")


@pytest.mark.parametrize("program", ["bits", "bits_fortran", "bits_modern"])
def test_the_same_bits_through_every_interface(
    program, problem_file, workshop, environment
) -> None:
    folder = built(PROGRAMS, workshop / "programs", environment, static=False, program=program)
    read = float.fromhex if program == "bits" else float
    lines = run(folder / program, problem_file, environment).splitlines()
    for line, (structure, method, arrays) in zip(lines, contact_problems(), strict=True):
        info, pivots, *numbers = line.split()
        answer = _core.flankload_solve_contact(
            *(np.asfortranarray(part) for part in arrays),
            structure,
            method,
            np.empty(0, dtype=np.int32),
        )
        expected = np.concatenate([part.ravel(order="F") for part in (*answer[:4], answer[6])])
        assert int(info) == answer[-1]
        assert int(pivots) == answer[5][0]
        np.testing.assert_array_equal([read(number) for number in numbers], expected)
    assert int(info) == -1


def test_threads_of_the_caller(problem_file, workshop, environment) -> None:
    folder = built(PROGRAMS, workshop / "programs", environment, static=False, program="threads")
    printed = run(folder / "threads", problem_file, environment)
    assert printed.split() == ["0", "of", "800", "differ"]


def test_every_interface_has_the_version(prefix, workshop, environment) -> None:
    text = (ROOT / "meson.build").read_text(encoding="utf-8")
    version = re.search(r"^    version: '([\d.]+)'", text, re.MULTILINE)[1]
    folder = built(PROGRAMS, workshop / "programs", environment, static=False)
    assert run(folder / "bits", None, environment, "version").strip() == version
    told = subprocess.run(
        ["pkg-config", "--modversion", "flankload"],
        env=environment,
        capture_output=True,
        text=True,
        check=True,
    )
    assert told.stdout.strip() == version
    assert fl.__version__ == version
    assert (prefix / "lib" / f"libflankload.so.{version}").is_file()
    tree = subprocess.run(
        ["git", "grep", "-lF", f"{version}", "--", "*.toml", "*.py", "*.build", "*.f90", "*.in"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    if tree.returncode == 0:
        assert [path for path in tree.stdout.split() if "meson.build" in path] == ["meson.build"]


def test_installing_again_changes_nothing(prefix: Path) -> None:
    files = sorted(path for path in prefix.rglob("*") if path.is_file())
    before = [path.stat().st_mtime_ns for path in files]
    told = subprocess.run(
        [ROOT / "dev", "install", prefix], check=True, capture_output=True, text=True
    )
    for name in ("libflankload.a", "libflankload.so", "flankload.pc", "flankload.h"):
        assert name in told.stdout
    assert [path.stat().st_mtime_ns for path in files] == before
