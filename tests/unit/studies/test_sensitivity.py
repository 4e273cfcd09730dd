"""Derivatives with respect to keys: the same as differences of complete solutions, off kinks."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import flankload as fl
from flankload.errors import InputError, SceneError
from flankload.scene import Scene, read_scene
from flankload.scene.tree import number_at
from flankload.studies.sensitivity import sensitivity
from tests.support.paths import SCENES

#: Second differences that do not grow with the square of the step are kinks: a pair of flanks comes
#: into contact or leaves it within the step.
KINK = 1e-5
#: Relative error of extrapolated differences of complete solutions, and rounding of their values.
EXACT, ROUNDING = 1e-6, 1e-12
QUICK = {
    "accuracy.estimate": False,
    "accuracy.tangents": False,
    "positions": {"count": 6},
}
RELIEF = {
    "body_1.tip_relief_um": 20,
    "body_1.tip_relief_start_diameter_mm": 76.5,
    "body_1.tip_relief_shape": "parabolic",
    "accuracy.flank_element_mm": 2.0,
}
COARSE_3D = {
    "accuracy.flank_element_mm": 4.0,
    "accuracy.axial_degree": 4,
    "accuracy.load_degree_z": 0,
    "accuracy.slices": 3,
    "body_1.lead_crowning_um": 5,
    # metal is only removed, at the one end or at the other: slopes of 0 are a kink
    "body_2.helix_slope_um": 2,
}
CASES: dict[str, tuple[str, dict[str, Any], list[str]]] = {
    "cells": (
        "external_gear",
        RELIEF,
        ["body_1.tip_relief_um", "pair.center_distance_mm", "load.torque_Nm"],
    ),
    "lumped": ("external_gear", {**RELIEF, "effects.contact": "lumped"}, ["body_1.tip_relief_um"]),
    "friction": (
        "external_gear",
        {"effects.friction_coefficient": 0.08, "accuracy.flank_element_mm": 2.0},
        ["effects.friction_coefficient", "pair.center_distance_mm"],
    ),
    "pitch_errors": (
        "external_gear",
        {"body_1.pitch_errors_um": [0.0] * 24, "accuracy.flank_element_mm": 2.0},
        ["body_1.pitch_errors_um[0]"],
    ),
    "coast_flanks": (
        "external_gear",
        {"effects.coast_flank": True, "accuracy.flank_element_mm": 2.0},
        ["pair.center_distance_mm"],
    ),
    "ring": ("internal_gear", {"accuracy.flank_element_mm": 2.0}, ["pair.center_distance_mm"]),
    "bore": (
        "external_gear",
        {"accuracy.flank_element_mm": 4.0},
        ["body_1.bore_diameter_mm", "body_2.young_modulus_MPa"],
    ),
    "spline": ("spline", {"accuracy.flank_element_mm": 1.2}, ["load.torque_Nm"]),
    "slices": (
        "helical_gear",
        COARSE_3D,
        ["body_1.lead_crowning_um", "body_2.helix_slope_um", "pair.deviation_um_per_mm"],
    ),
}


def scene_of(name: str) -> tuple[Scene, list[str]]:
    """A scene with coarse elements and few positions."""
    file, changes, paths = CASES[name]
    scene = read_scene(SCENES / f"{file}.toml")
    changes = {**QUICK, **changes}
    if "pitch_errors" in name:
        changes["body_1.pitch_errors_um"] = [0.0] * scene.body_1.teeth
    if name == "spline":  # its positions are equivalent
        del changes["positions"]
    return scene.replace(changes), paths


@pytest.mark.parametrize("name", CASES)
def test_derivatives_are_those_of_complete_solutions(name: str) -> None:
    scene, paths = scene_of(name)
    prepared = fl.prepare(scene)
    found = fl.sensitivity(prepared, paths)
    middle = prepared.solve()
    for k, path in enumerate(paths):
        value, step = number_at(scene, path), 2.0 * found.step_of(path)
        beside = {n: prepared.solve({path: value + n * step}) for n in (-2, -1, 1, 2)}
        for quantity in ("rotation_rad", "site_force_N"):
            at = {n: getattr(one, quantity) for n, one in beside.items()} | {
                0: getattr(middle, quantity)
            }
            single, double = ((at[n] - at[-n]) / (2 * n * step) for n in (1, 2))
            expected = (4.0 * single - double) / 3.0
            scale = np.abs(expected).max()
            bend, twice = (at[n] - 2 * at[0] + at[-n] for n in (1, 2))
            smooth = np.abs(twice - 4 * bend) / step < KINK * scale
            error = np.abs(found.derivative(quantity)[k, 0] - expected)[smooth]
            assert smooth.mean() > 0.6, (path, quantity)
            allowed = EXACT * scale + ROUNDING * np.abs(at[0]).max() / step
            assert error.max() < allowed, (path, quantity)


def test_no_contact_problem_is_solved_for_derivatives_on_cells() -> None:
    scene, paths = scene_of("cells")
    found = fl.sensitivity(scene, paths)
    assert found.cost["solved_states"] == 0
    assert found.cost["continued_states"] == (2 * len(paths) + 1) * 6


@pytest.mark.parametrize("value", [20.0, 0.0])
def test_states_that_must_be_solved_need_one_side_for_first_order(value: float) -> None:
    """The value is within its range, or 0, which is an end of it."""
    scene, paths = scene_of("lumped")
    scene = scene.replace({"body_1.tip_relief_um": value})
    central, first = (
        sensitivity(scene, paths, first_order=first_order) for first_order in (False, True)
    )
    assert (central.cost["solved_states"], first.cost["solved_states"]) == (12, 6)
    expected = central.derivative("rotation_rad")
    np.testing.assert_allclose(
        first.derivative("rotation_rad"), expected, rtol=0, atol=1e-3 * np.abs(expected).max()
    )
    below, above = first.to_each_side("rotation_rad")
    assert np.isnan(below).all()
    np.testing.assert_array_equal(above, first.derivative("rotation_rad"))


def test_first_order_is_not_used_for_states_that_are_continued() -> None:
    scene, paths = scene_of("cells")
    found = sensitivity(scene, paths, first_order=True)
    assert found.cost["continued_states"] == (2 * len(paths) + 1) * 6


def test_key_figures_and_functions_have_derivatives() -> None:
    scene, _ = scene_of("cells")
    scene = scene.replace({"load.torque_Nm": [100.0, 200.0], "positions": {"count": 12}})
    found = fl.sensitivity(scene, ["body_1.tip_relief_um", "body_1.tip_relief_start_diameter_mm"])
    figure = "transmission_error_peak_to_peak_um"
    swing = found.derivative(figure)
    assert swing.shape == (2, 2)
    again = found.derivative(lambda result: np.ptp(result.transmission_error_um))
    np.testing.assert_allclose(swing, again, rtol=1e-6)
    curves = found.derivative("transmission_error_um")
    for t, result in enumerate(found.results):
        curve = result.transmission_error_um
        ends = curves[:, t, np.argmax(curve)] - curves[:, t, np.argmin(curve)]
        np.testing.assert_allclose(swing[:, t], ends, rtol=1e-5)
    lines = found.to_text([figure]).splitlines()
    assert len(lines) == 5
    assert lines[1].split()[:2] == ["body_1.tip_relief_um", "100"]


def test_a_contact_that_reaches_a_corner_within_the_step_keeps_its_derivative() -> None:
    """The kink of a relief moves up to the only loaded pair, whose pressure then has no value."""
    path, name = "body_1.tip_relief_start_diameter_mm", "peak_pressure_MPa"
    changes = {"body_1.tip_relief_shape": "linear", "positions": {"angles_deg": [6.0]}}
    scene = scene_of("lumped")[0].replace({**changes, "load.torque_Nm": 127.0})
    prepared = fl.prepare(scene)
    low, high = 75.5, 76.0
    while high - low > 2e-5:
        middle = 0.5 * (low + high)
        reaches = prepared.solve({path: middle}).summary[name] is None
        low, high = (low, middle) if reaches else (middle, high)
    assert high < 76.0
    found = fl.sensitivity(scene.replace({path: low}), [path])
    assert found.step_of(path) > high - low
    below, above = found.to_each_side(name)
    assert above.item() == pytest.approx(below.item(), rel=1e-3)


def test_a_value_at_the_end_of_its_range_has_a_derivative_to_one_side() -> None:
    scene, _ = scene_of("cells")
    scene = scene.replace({"body_1.profile_crowning_um": 0.0})
    found = fl.sensitivity(scene, ["body_1.profile_crowning_um"])
    result = fl.solve(scene.replace({"body_1.profile_crowning_um": 0.02}))
    expected = (result.rotation_rad - found.results[0].rotation_rad) / 0.02
    np.testing.assert_allclose(
        found.derivative("rotation_rad")[0, 0], expected, atol=2e-2 * abs(expected).max()
    )
    below, above = found.to_each_side("rotation_rad")
    assert np.isnan(below).all()
    np.testing.assert_allclose(
        above, found.derivative("rotation_rad"), atol=1e-4 * abs(expected).max()
    )


def test_a_kink_shows_as_two_derivatives() -> None:
    scene, _ = scene_of("cells")
    found = fl.sensitivity(scene, ["load.torque_Nm"])
    largest = scene.load.torque_Nm
    below, above = found.to_each_side(lambda result: abs(result.torque_Nm - largest))
    assert below[0, 0] == pytest.approx(-1.0, rel=1e-6)
    assert above[0, 0] == pytest.approx(1.0, rel=1e-6)


@pytest.mark.parametrize(
    ("changes", "paths", "line"),
    [
        ({}, ["body_1.tip_releif_um"], "body_1.tip_releif_um: expected a key with a number"),
        ({}, ["body_1.name"], "body_1.name: expected a key with a number, found"),
        ({}, ["positions.count"], "positions.count: expected a key of the bodies"),
        ({}, ["body_1.tip_relief_um"], "body_1.tip_relief_start_diameter_mm: expected a number"),
        ({"accuracy.tolerance": 0.01}, ["load.torque_Nm"], "accuracy.tolerance: expected no tol"),
        ({"effects.choose": "auto"}, ["load.torque_Nm"], "effects.choose: expected named effects"),
    ],
)
def test_impossible_derivatives_are_refused(
    changes: dict[str, Any], paths: list[str], line: str
) -> None:
    scene = read_scene(SCENES / "external_gear.toml").replace(changes)
    with pytest.raises(SceneError) as caught:
        fl.sensitivity(scene, paths)
    assert line in str(caught.value)
    assert "external_gear.toml" in str(caught.value)


def test_drives_without_flanks_and_wrong_arguments_are_refused() -> None:
    with pytest.raises(SceneError, match="bodies with flanks"):
        fl.sensitivity(read_scene(SCENES / "chain.toml"), ["load.torque_Nm"])
    with pytest.raises(InputError, match="expected a sequence of paths"):
        fl.sensitivity(read_scene(SCENES / "external_gear.toml"), "load.torque_Nm")
    scene, paths = scene_of("cells")
    with pytest.raises(InputError, match="expected a number of Result"):
        fl.sensitivity(scene, paths[:1]).derivative("transmission_eror")
