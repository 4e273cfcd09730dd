"""Programs of the documentation, built with the command in their first line."""

from __future__ import annotations

import re
import subprocess
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import flankload as fl
from flankload import _core
from flankload.contact.flank_contact import FlankContact
from flankload.contact.sweep import Sweep, sweep
from flankload.elasticity.compliance import BodyCompliance, Expansion, FlankModes, NearField
from flankload.pairing.gear_mesh import GearMesh
from flankload.pairing.slices import plane_slice
from flankload.scene.discretization import Grid
from tests.support import packed_points
from tests.support.nodal_position import NodalPosition
from tests.support.nodal_sweep import NodalSweep
from tests.support.pressed_cylinders import arc, cylinders, one_site
from tests.support.programs import ROOT, expect_printed, run

PAGE = (ROOT / "docs" / "reference" / "fortran.md").read_text(encoding="utf-8")
TUTORIAL = (ROOT / "docs" / "tutorials" / "fortran77.md").read_text(encoding="utf-8")
COMMAND = re.compile(r"(gfortran|gcc) ([\w.]+) `pkg-config --cflags --libs flankload`")
SOURCES = {
    COMMAND.search(source)[2]: source
    for source in re.findall(r"```(?:fortran|c)\n(.*?)```", PAGE + TUTORIAL, re.DOTALL)
}
THREE = (np.array([[10, 9.4, 8], [9.4, 10, 9.4], [8, 9.4, 10]]), np.ones(3), np.array([1.0, 0, 1]))


def numbers_in(text: str) -> list[str]:
    return re.findall(r"(?<![\w.])-?\d[\d.]*(?:E[+-]\d+)?(?![\w.])", text)


def expect_numbers(printed: list[str], expected: NDArray[np.float64]) -> None:
    for token, number in zip(printed, expected, strict=True):
        expect_printed(token, number)


def three_flanks(text: str) -> None:
    expect_numbers(numbers_in(text), np.array([0, 5, 0, 5, 0, 3, 0, 91]))


def torques(text: str) -> None:
    *rows, version = text.splitlines()
    states = fl.solve_contact_torques(*THREE, [0, 0.1, 1, 10])
    for row, state in zip(rows, states, strict=True):
        expect_numbers(
            numbers_in(row.split(":")[1]), np.array([0, state.rotation, *state.normal_forces])
        )
    assert version == f"flankload {fl.__version__}"


def pitch(text: str) -> None:
    alpha, base, steps = np.pi / 9, np.array([30.0, 45.0]), 0.3 * np.arange(51)
    distance = base.sum() / np.cos(alpha)
    axes = np.array([[0.0, 0.0], [distance, 0.0]])
    points: list[list[NDArray[np.float64]]] = [[], []]
    for k in range(2):
        rho = 3.2 + k * np.pi * base[0] / 10
        rho_2 = distance * np.sin(alpha) - rho
        begins = rho / base[0] - alpha, np.pi - alpha + rho_2 / base[1]
        for z, begin in enumerate(begins):
            roll = (3.0, 9.0)[z] + steps
            u = begin - roll / base[z]
            radial, around = np.array([np.cos(u), np.sin(u)]), np.array([-np.sin(u), np.cos(u)])
            points[z].append(axes[z] + (base[z] * radial + roll * around).T)
    tables = []
    for z, first in enumerate((3.0, 9.0)):
        tooth = 1.5e-6 + np.diag(1e-6 * base[z] / (first + steps))
        tables.append(np.kron(np.eye(2), tooth))
    sizes = np.array([51, 51], dtype=np.int32)
    turn = np.arange(5) * np.pi / 50
    sweep = NodalSweep(
        still=NodalPosition(
            torque_Nmm=3e5,
            axes=(axes[0], axes[1]),
            sizes=(sizes, sizes),
            points=(np.concatenate(points[0]), np.concatenate(points[1])),
            compliances=(tables[0], tables[1]),
        ),
        angles_rad=np.array([turn, -turn * base[0] / base[1]]),
        torques_Nmm=np.array([3e4, 3e5]),
    )
    found = sweep.solve()
    flank, _, gap_angle, lever, row, _, matrix = sweep.still.pairs()
    alone = fl.solve_contact_general(matrix, lever * gap_angle, lever, 3e5, load_rows=row)
    assert flank.size > 80
    expected = [alone.status, 3e4 * alone.rotation, found["info"]]
    for t in range(2):
        for k in range(5):
            expected += [3e4 * found["rotation"][k, t], *found["flank_force"][:, k, t]]
    expect_numbers(numbers_in(text), np.array(expected))


def rollers(text: str) -> None:
    """Bodies of the same shape, whose curves are fitted to arcs, through `sweep`."""
    width, bends = 10.0, 1e-6
    kernel = 2.0 * 0.91 / (np.pi * 2.06e5)
    one = arc((36.0, -20.0), 20.0, 0.5 * np.pi + 0.3, 0.5 * np.pi - 0.3)
    two = arc((-54.0, 30.0), 30.0, 0.3 - 0.5 * np.pi, -0.3 - 0.5 * np.pi)
    compliance = BodyCompliance(
        np.full((1, 1, 1), bends * width), NearField(kernel), FlankModes((0.0, 12.0))
    )
    warm = replace(
        compliance,
        modes=FlankModes((0.0, 18.0)),
        expansion=Expansion(0.0, {"heat": np.full((1, 1), 5e-3)}),
    )

    def solve(part: float) -> tuple[Sweep, ...]:
        return sweep(
            FlankContact(
                GearMesh(cylinders(one, two), one_site(90.0), plane_slice(width)),
                (compliance, warm),
                Grid(),
            ),
            2e-3 * np.arange(3),
            [part * 3.6e4, part * 3.6e5],
        )

    expected = [0.0]
    for state in solve(1.0):
        for k in range(3):
            expected += [1e3 * state.rotation_rad[k], state.site_force_N[k, 0]]
            expected += [state.site_peak_N_per_mm[k, 0] / width, state.n_pairs[k]]
    for more, less in zip(solve(1.001), solve(0.999), strict=True):
        step = more.torque_Nmm - less.torque_Nmm
        expected += list(1e6 * (more.rotation_rad - less.rotation_rad) / step)
    for state in solve(1.0):
        for rotation in state.rotation_rad:
            expected += [1e3 * rotation, -1e-3 * state.torque_Nmm]
    expect_numbers(numbers_in(text), np.array(expected))


def points(text: str) -> None:
    turned = packed_points.rotation(packed_points.by_points(41), friction=0.1)
    expect_numbers(numbers_in(text), np.array([0.0, turned]))


def coupling(text: str) -> None:
    """The program of the tutorial, whose page shows what it prints."""
    assert f"```\n{text}```\n" in TUTORIAL
    matrix = 4e-6 * np.eye(6) + 1e-6
    gaps, levers = 1e-3 * np.array([0, 4, 9, 2, 6, 1]), np.full(6, 25.0)
    for row, torque in zip(text.splitlines(), (5e4, 25e4, 125e4), strict=True):
        state = fl.solve_contact_general(matrix, gaps, levers, torque)
        expected = [torque / 1e3, 1e3 * state.rotation, *state.normal_forces]
        expect_numbers(numbers_in(row), np.array(expected))


PROGRAMS: dict[str, Callable[[str], None]] = {
    "three.f": three_flanks,
    "three.f90": three_flanks,
    "three.c": three_flanks,
    "torques.c": torques,
    "coupl.f": coupling,
    "pitch.f": pitch,
    "rollers.f": rollers,
    "points.f": points,
}


@pytest.fixture
def build(prefix: Path, workshop: Path, environment: dict[str, str]) -> Callable[[str, str], Path]:
    """Builds a program of the documentation with the command in its first line."""

    def built(name: str, source: str) -> Path:
        folder = workshop / name.replace(".", "_")
        folder.mkdir(exist_ok=True)
        (folder / name).write_text(source, encoding="utf-8")
        made = subprocess.run(
            ["sh", "-c", COMMAND.search(source.splitlines()[0])[0]],
            cwd=folder,
            env={**environment, "LD_LIBRARY_PATH": str(prefix / "lib")},
            capture_output=True,
            check=True,
        )
        assert made.stderr == b""
        return folder / "a.out"

    return built


@pytest.mark.parametrize("name", [*PROGRAMS])
def test_programs_of_the_documentation(
    name: str, build: Callable[[str, str], Path], prefix: Path, environment: dict[str, str]
) -> None:
    environment = {**environment, "LD_LIBRARY_PATH": str(prefix / "lib")}
    PROGRAMS[name](run(build(name, SOURCES[name]), None, environment))


@pytest.mark.parametrize(
    ("right", "wrong", "printed"),
    [
        ("[10.0_wp, 9.4_wp", "[-10.0_wp, 9.4_wp", "  -5 compliance: expected a positive diagonal"),
        ("[10.0_wp], &", "[-10.0_wp], &", "  -1 no forces >= 0 balance the loads"),
        ("method_auto, [", "99, [", "  -4 method: expected one of the constants method_…"),
    ],
    ids=["diagonal", "torque", "method"],
)
def test_a_fortran_program_prints_why_there_is_no_state(
    right: str,
    wrong: str,
    printed: str,
    build: Callable[[str, str], Path],
    prefix: Path,
    environment: dict[str, str],
) -> None:
    source = SOURCES["three.f90"]
    assert source.count(right) == 1
    ended = subprocess.run(
        [build("three.f90", source.replace(right, wrong))],
        env={**environment, "LD_LIBRARY_PATH": str(prefix / "lib")},
        capture_output=True,
        check=False,
        text=True,
    )
    assert (ended.returncode, ended.stdout.rstrip("\n")) == (1, printed)


def test_every_program_of_the_documentation_is_run() -> None:
    assert set(SOURCES) == set(PROGRAMS)


def test_every_procedure_has_a_program() -> None:
    """But for those of the examples (tests of numbers, records in files) and fronts of elements."""
    said = "".join(SOURCES.values()).lower()
    said += "flankload_double_vector flankload_integer_vector flankload_read_record"
    interface = [name for name in dir(_core) if re.match("flankload_(?!front_)", name)]
    assert [name for name in interface if not re.search(rf"{name}(?![a-z])", said)] == []
