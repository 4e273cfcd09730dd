"""Settings of many runs: error estimates and tangents that no quantity needs are left out."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest

import flankload as fl
from flankload.studies.settings import estimated_error, settings_for
from tests.support.design_scene import design_scene
from tests.support.paths import SCENES

ESTIMATE, TANGENTS = "accuracy.estimate", "accuracy.tangents"
SWING, STIFFNESS = "transmission_error_peak_to_peak_um", "stiffness_tangent_mean_N_per_um"
TORQUE = "load.torque_Nm"
LINE = (
    "left out, since no quantity needs them: error estimates (accuracy.estimate), states for the "
    "tangent stiffness (accuracy.tangents)"
)


def scene(**changes: Any) -> fl.Scene:
    """The small scene, which names neither estimates nor tangents."""
    return design_scene(**({ESTIMATE: None, TANGENTS: None} | changes))


@pytest.fixture(scope="module")
def found() -> fl.DesignStudy:
    with ThreadPoolExecutor(1) as executor:
        return fl.study(scene(), {TORQUE: [300, 200, 250]}, quantities=[SWING], executor=executor)


@pytest.mark.parametrize(
    ("changes", "quantities", "expected"),
    [
        ({}, [SWING], {ESTIMATE, TANGENTS}),
        ({}, [SWING, STIFFNESS], {ESTIMATE}),
        ({}, ["stiffness_secant_mean_N_per_um"], {ESTIMATE, TANGENTS}),
        ({ESTIMATE: True}, [SWING], {TANGENTS}),
        ({ESTIMATE: False, TANGENTS: True}, [SWING], set()),
        ({"accuracy.tolerance": 0.1}, [SWING], set()),
    ],
)
def test_what_no_quantity_needs_and_no_key_names_is_left_out(
    changes: dict[str, Any], quantities: list[str], expected: set[str]
) -> None:
    assert settings_for(scene(**changes), quantities) == dict.fromkeys(expected, False)


def test_keys_that_designs_change_are_kept() -> None:
    assert settings_for(scene(), [SWING], {ESTIMATE}) == {TANGENTS: False}


def test_the_best_design_of_a_study_has_its_error_estimate(found: fl.DesignStudy) -> None:
    assert [bool(row.outcome.results[0]["estimate"]) for row in found.rows] == [False, True, False]
    expected = fl.solve(scene(**{TORQUE: 200, TANGENTS: False}))
    assert isinstance(expected, fl.Result)
    assert found.best[SWING].number == 1
    assert found.best[SWING].outcome.results[0]["estimate"] == pytest.approx(
        {name: x for name, x in expected.estimate.items() if isinstance(x, float)}
    )
    error = estimated_error(expected.estimate, SWING)
    assert error is not None
    lines = str(found).splitlines()
    assert f"least {SWING} (+- {100 * error:.1f} %): design 1, {TORQUE} = 200" in lines
    assert LINE in lines


def test_a_study_solves_what_its_scene_names() -> None:
    with ThreadPoolExecutor(1) as executor:
        asked = scene(**{ESTIMATE: True, TANGENTS: False})
        study = fl.study(asked, {TORQUE: [200, 300]}, quantities=[SWING], executor=executor)
    assert all(row.outcome.results[0]["estimate"] for row in study.rows)
    assert "left out" not in str(study)


def test_a_robust_design_leaves_out_the_same() -> None:
    draws = {TORQUE: {"distribution": "normal", "mean": 302, "standard_deviation": 6}}
    assert LINE in str(fl.robust(scene(), draws, [SWING], n=0)).splitlines()


def test_an_optimum_has_its_error_estimate() -> None:
    crowning = {"paths": "body_1.profile_crowning_um", "lower": 0, "upper": 5, "start": 2}
    optimum = fl.optimise(scene(), [crowning], SWING, most_evaluations=2)
    assert optimum.settings == {ESTIMATE: False, TANGENTS: False}
    error = estimated_error(optimum.results[0].estimate, SWING)
    assert error is not None
    assert optimum.estimated_errors == {SWING: error}
    assert f"estimated errors of the optimum: {SWING} {100 * error:.1f} %" in str(optimum)


def test_drives_without_tangents_keep_the_key() -> None:
    belt = fl.read_scene(SCENES / "belt.toml")
    assert TANGENTS not in settings_for(belt, ["rotation_mean_rad"])


def test_stores_keep_the_estimates_of_the_best(tmp_path: Path) -> None:
    """A study from a store has them, too, and solves nothing."""
    store = tmp_path / "study.sqlite"
    with ThreadPoolExecutor(1) as executor:
        one, two = (
            fl.study(scene(), {TORQUE: [200]}, quantities=[SWING], store=store, executor=executor)
            for _ in range(2)
        )
    assert one.rows[0].outcome.results == two.rows[0].outcome.results
    assert one.rows[0].outcome.results[0]["estimate"]
