"""Measures of the benches: the error of an answer, and packages that agree."""

from __future__ import annotations

import tomllib

import numpy as np
import pytest

import flankload as fl
from tests.benchmarks import effects
from tests.benchmarks._instructions import read_profile
from tests.benchmarks._packages import PACKAGES, Package, scale
from tests.benchmarks._rivals import EXACT_ENOUGH, Measured, least_ratio, measure_package
from tests.benchmarks._sweep_core import _numbers
from tests.support.cylinder_problem import Problem, cylinder, residual
from tests.support.pair_job import Job
from tests.support.paths import ROOT
from tests.support.tolerances import ROUND_OFF, SOLVER

FRICTIONS = (0.0, 0.1)
SOLVED = [(package, mu) for package in PACKAGES for mu in FRICTIONS if package.friction or mu == 0]


def solve(problem: Problem) -> fl.ContactState:
    """The state of a problem of the benches."""
    return fl.solve_contact_general(
        problem.compliance,
        problem.gaps,
        problem.levers,
        problem.torque,
        load_rows=problem.row,
        positive_definite=True,
    )


def two_springs(gap: float = 0.0) -> Problem:
    """Two pairs of compliance one and lever one that hold a torque of two."""
    one = np.ones(2)
    return Problem(np.eye(2), np.array([0.0, gap]), one, one, 2.0)


@pytest.mark.parametrize(
    ("gap", "forces", "rotation", "expected"),
    [
        (0.0, (1.0, 1.0), 1.0, 0.0),
        (4.0, (2.0, 0.0), 2.0, 0.0),  # the second pair is open
        (0.0, (1.5, 0.5), 1.0, 1 / 3),  # overlap 1/2 of a row of 1/2 + 1
        (0.0, (2.0, 0.0), 2.0, 1.0),  # overlap 2 of a row of 2
        (1.0, (1.5, 0.5), 1.0, 1 / 5),  # gaps 1/2 of rows of 3/2 + 1 and 1/2 + 1 + 1, with forces
        (4.0, (2.0 + 2e-10, -2e-10), 2.0, 1e-10),  # tension
        (0.0, (3.0, 3.0), 3.0, 1 / 2),  # torque 6 instead of 2, of 6 + 2
        (0.0, (np.nan, 1.0), 1.0, np.inf),
    ],
)
def test_residual_by_hand(
    gap: float, forces: tuple[float, float], rotation: float, expected: float
) -> None:
    found = residual(two_springs(gap), np.array(forces), rotation)
    assert found == pytest.approx(expected, rel=0, abs=ROUND_OFF)


def test_residual_takes_the_rotation_from_the_carrying_rows() -> None:
    assert residual(two_springs(4.0), np.array([2.0, 0.0])) <= ROUND_OFF
    # The mean of 3/2 and 1/2, weighted with the forces, is 5/4: 1/4 and 3/4 are left.
    found = residual(two_springs(), np.array([1.5, 0.5]))
    assert found == pytest.approx(0.75 / 1.75, rel=ROUND_OFF)


@pytest.mark.parametrize("friction", FRICTIONS)
def test_residual_reveals_a_wrong_answer(friction: float) -> None:
    problem = cylinder(30, friction)
    state = solve(problem)
    right = state.normal_forces
    assert residual(problem, right, state.rotation) <= ROUND_OFF
    assert residual(problem, right) <= ROUND_OFF
    strongest, opened = int(right.argmax()), int(np.flatnonzero(right == 0.0)[0])
    torque_moved = right.copy()
    torque_moved[strongest] *= 1.0 + 1e-6
    pulling = right.copy()
    pulling[opened] = -1e-6 * right.max()
    outside = right.copy()
    outside[opened] = 1e-6 * right.max()
    for wrong in (torque_moved, pulling, outside):
        assert residual(problem, wrong) > 100 * EXACT_ENOUGH
    assert residual(problem, right, state.rotation * (1.0 + 1e-6)) > 100 * EXACT_ENOUGH


@pytest.mark.filterwarnings("default")  # warnings of packages at import are not ours
@pytest.mark.parametrize(
    ("package", "friction"), SOLVED, ids=[f"{package.name}-{mu:g}" for package, mu in SOLVED]
)
def test_packages_find_our_forces(package: Package, friction: float) -> None:
    pytest.importorskip(package.module)
    problem = cylinder(30, friction)
    scaled = scale(problem)
    forces = scaled.unit * package.solve(scaled)[0]
    expected = solve(problem).normal_forces
    np.testing.assert_allclose(forces, expected, rtol=0, atol=SOLVER * expected.max())
    assert residual(problem, forces) <= EXACT_ENOUGH


def test_a_missing_package_is_said_and_does_not_count() -> None:
    absent = Package("absent", "a_package_that_nobody_has", PACKAGES[0].solve, "nothing")
    answers = measure_package(absent, [cylinder(10), cylinder(20)])
    assert [answer.remark for answer in answers] == ["not installed"] * 2
    ours = [Measured(2.0, 0.0)]
    exact, coarse = Measured(8.0, 1e-10), Measured(4.0, 1e-8)
    assert least_ratio({"a": [exact], "b": [coarse], "c": answers[:1]}, ours, 0) == 4.0


def test_the_extra_names_every_package() -> None:
    text = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    extra = tomllib.loads(text)["project"]["optional-dependencies"]["bench"]
    names = {line.split(">=")[0] for line in extra}
    assert names == {package.name for package in PACKAGES} - {"scipy"}


# --- instructions ---------------------------------------------------------------------------------
PROFILE = """events: Ir
fn=(1) flankload_sweep_mesh_
12 100
cfn=(2) __flankload_position_load_MOD_solve_position
calls=1 20
12 540

fn=(2)
20 30
+1 70
cfn=(3) __flankload_influence_coefficients_MOD_influence_matrix.isra.0
calls=2 40
* 400
cfn=(4) malloc
calls=3 60
-2 40

fn=(3)
40 400

fn=(4)
60 40
"""


def test_instructions_are_summed_by_procedure_without_those_that_find_memory() -> None:
    counted = read_profile(PROFILE)
    assert counted.own == {
        "flankload_sweep_mesh_": 100,
        "solve_position": 100,
        "influence_matrix": 400,
    }
    assert counted.whole == 600
    assert counted.within["flankload_sweep_mesh_", "solve_position"] == 540
    assert counted.within["solve_position", "influence_matrix"] == 400


def test_bench_of_effects_knows_all_that_a_scene_can_call_for() -> None:
    known = {**effects.ON, **effects.OFF}
    assert {row.name for row in effects.readable()} - set(known) == set()


def test_the_compiled_bench_of_a_sweep_is_handed_a_scene() -> None:
    """Regression: parts that it does not read (nodes, shifts) were refused."""
    job = Job(fl.read_scene(ROOT / "examples" / "scenes" / "external_gear.toml"))
    numbers = _numbers(job, 3, 1000.0, job.bodies.discretization.grid)
    np.testing.assert_array_equal(numbers[:2], [3.0, 1000.0])
    assert np.isfinite(numbers).all()
