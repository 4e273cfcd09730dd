"""Tangent stiffness against differences of the rotation that the program itself computes."""

import tomllib

import numpy as np
import pytest

import flankload as fl
from flankload.contact.core_call import CoreCall, CoreOutput
from flankload.contact.status import Status
from flankload.contact.sweep import sweep
from tests.support.pair_job import Job
from tests.support.paths import SCENES
from tests.support.solving import solve

#: The differences' own error: second order in the step, rounding of the rotation over the step.
DIFFERENCES = 1e-6
STEP = 1e-4


@pytest.mark.parametrize("friction", [0.0, 0.1])
@pytest.mark.parametrize("name", ["external_gear", "internal_gear"])
def test_tangent_is_the_derivative_of_the_rotation(name: str, friction: float) -> None:
    tables = tomllib.loads((SCENES / f"{name}.toml").read_text(encoding="utf-8"))
    torque = tables["load"]["torque_Nm"]
    tables |= {
        "load": {"torque_Nm": [torque * (1 - STEP), torque, torque * (1 + STEP)]},
        "effects": {"friction_coefficient": friction},
        "accuracy": {"estimate": False},
    }
    less, here, more = solve(fl.Scene.from_dict(tables))
    found = (more.torque_Nm - less.torque_Nm) / (more.rotation_rad - less.rotation_rad)
    beside = np.abs(found / here.stiffness_tangent_Nm_per_rad - 1.0)
    # on a corner, or where the next pair is just about to touch, cells change their number
    assert np.quantile(beside, 0.85) < DIFFERENCES
    assert beside.max() < 1e-3


def test_tangent_on_cells_in_slices_is_the_derivative_of_the_rotation() -> None:
    """It was 7 % off while K of the cells in contact was that of these cells alone."""
    scene = fl.read_scene(SCENES / "helical_gear.toml").replace(
        {"effects.contact": "pairs", "positions.count": 1, "accuracy.estimate": False}
    )
    torque = float(np.max(scene.torques_Nm))
    steps = [torque * (1 - STEP), torque, torque * (1 + STEP)]
    less, here, more = solve(scene.replace({"load.torque_Nm": steps}))
    found = (more.torque_Nm - less.torque_Nm) / (more.rotation_rad - less.rotation_rad)
    np.testing.assert_allclose(here.stiffness_tangent_Nm_per_rad, found, rtol=DIFFERENCES, atol=0)


PITCH_ERRORS = [6.0, -4.0, 0.0, 5.0] * 4
#: Scenes in which body 1 has turned before there is any torque, by up to this many um.
BEFORE = {
    "external_gear, pitch errors": ({"body_1": {"pitch_errors_um": PITCH_ERRORS}}, 5.0),
    "external_gear, crowned": ({"body_2": {"profile_crowning_um": 20}}, 1.0),
    "external_gear_warm": ({}, 20.0),
    "spline": ({}, 5.0),
    "spline_press_fit": ({}, 1.0),
}


@pytest.mark.parametrize("name", BEFORE)
def test_secant_stiffness_counts_from_the_state_without_torque(name: str) -> None:
    """Regression: torque over all rotation, 625 kN m/rad beside a tangent of 323 on a warm gear."""
    scene, (changes, turned_um) = name.split(",")[0], BEFORE[name]
    tables = tomllib.loads((SCENES / f"{scene}.toml").read_text(encoding="utf-8"))
    for table, keys in changes.items():
        tables[table] |= keys
    torque = np.max(tables["load"]["torque_Nm"])
    positions = {"positions": {"count": 8}} if "external" in scene else {}
    tables |= {"accuracy": {"estimate": False, "modes": 3}, **positions}
    alone, (none, loaded) = (
        solve(fl.Scene.from_dict(tables | {"load": {"torque_Nm": load}}))
        for load in (torque, [0.0, torque])
    )
    np.testing.assert_array_equal(alone.unloaded_rotation_rad, none.rotation_rad)
    np.testing.assert_array_equal(loaded.unloaded_rotation_rad, none.rotation_rad)
    assert np.abs(none.transmission_error_um).max() > turned_um
    for found in (alone, loaded):
        np.testing.assert_allclose(
            found.stiffness_secant_Nm_per_rad * (found.rotation_rad - none.rotation_rad),
            torque,
            rtol=1e-12,
            atol=0,
        )
    # neither a look without torque nor one beside it for the tangent is a state more
    count = alone.position_rad.size
    assert [run.cost["states"] for run in (alone, loaded)] == [count, 2 * count]


def test_secant_and_tangent_of_a_press_fit_are_one_stiffness() -> None:
    """Neither flanks nor teeth come or go, and conforming flanks deflect in proportion."""
    few = {"accuracy.estimate": False, "accuracy.strips_per_half_width": 5.0}
    found = solve(fl.read_scene(SCENES / "spline_press_fit.toml").replace(few))
    assert isinstance(found, fl.Result)
    np.testing.assert_allclose(
        found.stiffness_secant_N_per_um, found.stiffness_tangent_N_per_um, rtol=1e-4, atol=0
    )
    before_um = float(found.unloaded_rotation_rad[0]) * 1000.0 * found.reference_radius_mm
    (whole_um,) = found.transmission_error_um
    text = f"{whole_um:.3f} um at one position ({whole_um - before_um:.3f} um beyond the state"
    assert text in found.table()


def test_no_torque_needs_no_tangent() -> None:
    tables = tomllib.loads((SCENES / "external_gear.toml").read_text(encoding="utf-8"))
    tables["load"]["torque_Nm"] = 0
    result = solve(fl.Scene.from_dict(tables))
    assert isinstance(result, fl.Result)
    assert np.isnan(result.stiffness_tangent_Nm_per_rad).all()


@pytest.mark.parametrize("friction", [0.0, 0.1])
def test_forces_have_derivatives_and_those_of_a_list_are_its_own(friction: float) -> None:
    """Central differences of complete solutions; at a corner, K is that of refined cells."""
    scene = fl.read_scene(SCENES / "external_gear.toml").replace(
        {"effects.friction_coefficient": friction, "positions.count": 8}
    )
    job = Job(scene)
    contact, positions = job.contact(job.bodies.discretization.grid), job.positions(8)
    torque = float(scene.torques_Nmm[0])
    less, more = sweep(contact, positions, [torque * (1 - STEP), torque * (1 + STEP)])
    both = sweep(contact, positions, [0.0, 0.5 * torque, torque], tangents=True)
    found = (more.site_force_N - less.site_force_N) / (2 * STEP * torque)
    largest = np.abs(found).max()
    np.testing.assert_allclose(
        both[2].site_force_per_torque, found, rtol=0, atol=10 * STEP * largest
    )
    (alone,) = sweep(contact, positions, [torque], tangents=True)
    np.testing.assert_array_equal(alone.tangent_rad_per_Nmm, both[2].tangent_rad_per_Nmm)
    np.testing.assert_array_equal(both[0].site_force_per_torque, 0.0)
    np.testing.assert_array_equal(alone.n_pairs, sweep(contact, positions, [torque])[0].n_pairs)


def test_a_torque_that_just_holds_keeps_the_tangent_of_its_state(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A little more torque has no state; the derivative with the pairs in contact held stays."""
    job = Job(fl.read_scene(SCENES / "external_gear.toml"))
    contact, positions = job.contact(job.bodies.discretization.grid), job.positions(2)
    (held,) = sweep(contact, positions, [1e5])
    solve_all = CoreCall.all_positions

    def without_more(self: CoreCall, capacity: int) -> CoreOutput:
        found = solve_all(self, capacity)
        found.status[1, 1::2] = Status.NO_CONTACT_STATE
        return found

    monkeypatch.setattr(CoreCall, "all_positions", without_more)
    (found,) = sweep(contact, positions, [1e5], tangents=True)
    same = found.tangent_rad_per_Nmm == held.tangent_rad_per_Nmm
    np.testing.assert_array_equal(same, [False, True])
    np.testing.assert_array_equal(found.site_force_per_torque[1], held.site_force_N[1] / 1e5)
