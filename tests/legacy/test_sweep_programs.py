"""Sweeps of points by programs that know nothing but the installed library."""

from __future__ import annotations

import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.support.nodal_position import DATA
from tests.support.nodal_sweep import NAMES, SWEEP_DATA, NodalSweep, read_sweep
from tests.support.programs import EXAMPLES, LINKING, PROGRAMS, built, expect_printed, run, written

FOLDERS = ["legacy_fortran", "modern_fortran", "c"]


@pytest.fixture(scope="module")
def sweep() -> NodalSweep:
    return read_sweep(SWEEP_DATA)


@pytest.fixture(scope="module")
def solved(sweep: NodalSweep) -> dict[str, Any]:
    found = sweep.solve()
    assert found["info"] == 0
    return found


def example(
    folder: str,
    workshop: Path,
    environment: dict[str, str],
    *,
    static: bool,
    program: str = "sweep",
) -> Path:
    name = folder + ("_static" if static else "")
    return built(EXAMPLES / folder, workshop / name, environment, static=static, program=program)


def blocks(text: str, sweep: NodalSweep) -> list[list[list[str]]]:
    """Words of the lines under each torque; the torque itself is as it must be."""
    lines = [line.split() for line in text.splitlines() if line.split()]
    starts = [k for k, words in enumerate(lines) if words[0].lower() == "torque"]
    for k, torque in zip(starts, sweep.torques_Nmm, strict=True):
        expect_printed(lines[k][-1], torque)
    return [lines[a + 1 : b] for a, b in zip(starts, [*starts[1:], len(lines)], strict=True)]


def test_fixed_form_fortran(sweep, solved, workshop, environment) -> None:
    folder = example("legacy_fortran", workshop, environment, static=False)
    found = blocks(run(folder / "sweep", SWEEP_DATA, environment), sweep)
    for t, (_, *rows) in enumerate(found):
        assert len(rows) == sweep.angles_rad.shape[1]
        for k, (angle, status, rotation, torque_2, *flanks) in enumerate(rows):
            expect_printed(angle, sweep.angles_rad[0, k])
            assert int(status) == solved["status"][k, t]
            expect_printed(rotation, solved["rotation"][k, t])
            expect_printed(torque_2, solved["torque_2"][k, t])
            for printed, force in zip(flanks, solved["flank_force"][:, k, t], strict=True):
                expect_printed(printed, force)


@pytest.mark.parametrize("static", LINKING)
def test_modern_fortran(static, sweep, solved, workshop, environment) -> None:
    folder = example("modern_fortran", workshop, environment, static=static)
    found = blocks(run(folder / "sweep", SWEEP_DATA, environment), sweep)
    for t, rows in enumerate(found):
        assert len(rows) == sweep.angles_rad.shape[1]
        for k, (angle, rotation, touching, *flanks) in enumerate(rows):
            expect_printed(angle, sweep.angles_rad[0, k])
            expect_printed(rotation, solved["rotation"][k, t])
            assert int(touching) == (solved["force"][: solved["n_pairs"][k], k, t] > 0).sum()
            for printed, force in zip(flanks, solved["flank_force"][:, k, t], strict=True):
                expect_printed(printed, force)


@pytest.mark.parametrize("static", LINKING)
def test_c(static, sweep, solved, workshop, environment) -> None:
    folder = example("c", workshop, environment, static=static)
    found = blocks(run(folder / "sweep", SWEEP_DATA, environment), sweep)
    for t, rows in enumerate(found):
        assert len(rows) == sweep.angles_rad.shape[1]
        for k, (angle, rotation, torque_2, *words) in enumerate(rows):
            forces = solved["force"][: solved["n_pairs"][k], k, t]
            expect_printed(angle, sweep.angles_rad[0, k])
            expect_printed(rotation, solved["rotation"][k, t])
            expect_printed(torque_2, solved["torque_2"][k, t])
            for printed, force in zip(
                words[: words.index("largest")], solved["flank_force"][:, k, t], strict=True
            ):
                expect_printed(printed, force)
            expect_printed(words[words.index("largest") + 1], forces.max())
            expect_printed(words[-1], solved["radius"][forces.argmax(), k])


@pytest.fixture(scope="module")
def sweep_file(sweep: NodalSweep, workshop: Path) -> Path:
    still = sweep.still
    parts = [sweep.angles_rad, sweep.torques_Nmm, *still.axes]
    for points, matrix in zip(still.points, still.compliances, strict=True):
        parts += [points, matrix.T]
    counts = [sweep.angles_rad.shape[1], sweep.torques_Nmm.size, still.sizes[0].size]
    lines = [
        " ".join(str(n) for n in [*counts, *(sizes.sum() for sizes in still.sizes)]),
        *(" ".join(str(n) for n in sizes) for sizes in still.sizes),
        *("\n".join(f"{x:.17g}" for x in part.ravel()) for part in parts),
    ]
    return written(workshop / "sweep.txt", "\n".join(lines) + "\n")


@pytest.mark.parametrize("program", ["sweep_bits", "sweep_bits_fortran", "sweep_bits_modern"])
def test_the_same_bits_through_every_interface(
    program, solved, sweep_file, workshop, environment
) -> None:
    folder = built(PROGRAMS, workshop / "programs", environment, static=False)
    read = float.fromhex if program == "sweep_bits" else float
    info, *numbers = run(folder / program, sweep_file, environment).split()
    assert int(info) == 0
    expected = [
        solved[name].ravel(order="F")
        for name in NAMES
        if name not in ("status", "n_pairs", "flank", "info")
    ]
    np.testing.assert_array_equal([read(x) for x in numbers], np.concatenate(expected))


@pytest.mark.parametrize("static", LINKING)
def test_threads_of_the_caller(static, sweep_file, workshop, environment) -> None:
    folder = built(
        PROGRAMS,
        workshop / ("programs" + static * "_static"),
        environment,
        static=static,
        program="sweep_threads",
    )
    printed = run(folder / "sweep_threads", sweep_file, environment)
    assert printed.split() == ["0", "of", "100", "differ"]


@pytest.mark.parametrize("folder", FOLDERS)
@pytest.mark.parametrize("program", ["loads", "sweep"])
def test_data_that_end_too_early_get_one_line(folder, program, workshop, environment) -> None:
    """Data may end anywhere."""
    path = example(folder, workshop, environment, static=False, program=program) / program
    lines = (DATA if program == "loads" else SWEEP_DATA).read_text(encoding="ascii").splitlines()
    wholes = [lines[:k] for k in (0, 1, 2, 3, 4, len(lines) // 3, len(lines) - 1)]
    wrong = [[lines[0], "0 8 3", *lines[2:]], [*lines[:3], "a b", *lines[4:]], ["", "1.5 x"]]
    for data in (*wholes, *wrong):
        done = subprocess.run(
            [path],
            input="".join(line + "\n" for line in data),
            env=environment,
            capture_output=True,
            text=True,
            check=False,
            timeout=60,
        )
        assert done.returncode > 0, data[:3]
        said = [line for line in done.stderr.splitlines() if line != "STOP 2"]
        assert len(said) == 1, done.stderr
        assert said[0].strip().lower().startswith("bad data, expected "), said[0]
        assert done.stdout == ""


@pytest.mark.parametrize(
    ("folder", "program"),
    [("legacy_fortran", "loads"), ("modern_fortran", "sweep"), ("c", "sweep")],
)
def test_static_programs_want_the_c_library_alone(folder, program, workshop, environment) -> None:
    path = example(folder, workshop, environment, static=True, program=program) / program
    listed = subprocess.run(
        ["ldd", path], capture_output=True, text=True, check=True
    ).stdout.splitlines()
    names = {Path(line.split()[0]).name.split(".")[0] for line in listed}
    assert names <= {"linux-vdso", "libm", "libc", "libpthread", "ld-linux-x86-64"}, names
