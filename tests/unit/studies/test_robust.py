"""Robust design: first order against sensitivities and Monte Carlo, kinks, sampling errors."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy import stats

import flankload as fl
from flankload.studies.robustness import Robust, Samples
from tests.support.design_scene import design_scene
from tests.support.paths import SCENES

ERRORS = "body_1.pitch_errors_um"
TORQUE = "load.torque_Nm"
CLASS_5 = {"distribution": "iso_1328", "class": 5}
VARIABLES = {TORQUE: {"distribution": "normal", "mean": 302, "standard_deviation": 6}}
SWING, CURVE = "transmission_error_peak_to_peak_um", "transmission_error_um"


def lumped(**changes: Any) -> fl.Scene:
    """A scene with some positions, of which a run takes a few milliseconds."""
    quick = {"effects.contact": "lumped", "pair.center_distance_mm": 91.6, "positions.count": 6}
    return design_scene(**quick, **changes)


@pytest.fixture(scope="module")
def found() -> Robust:
    """The torque varies little: first order holds."""
    with ThreadPoolExecutor(1) as executor:
        return fl.robust(lumped(), VARIABLES, [SWING, CURVE], n=40, seed=2, executor=executor)


def test_first_order_is_the_derivative_times_the_deviation(found: Robust) -> None:
    exact = fl.sensitivity(lumped(), [TORQUE])
    for name in (SWING, CURVE):
        linear = found.first_order[name]
        expected = 6.0 * np.abs(exact.derivative(name)[0, 0])
        np.testing.assert_allclose(linear.standard_deviation, expected, rtol=1e-6)
        np.testing.assert_array_equal(linear.shares[TORQUE], np.ones_like(expected))
        assert linear.percentile(50) == pytest.approx(linear.mean)


def test_monte_carlo_agrees_where_first_order_holds(found: Robust) -> None:
    assert found.notes == ()
    for name in (SWING, CURVE):
        linear, samples = found.first_order[name], found.samples(name)
        assert len(samples) == 40
        beside = np.abs(samples.mean - linear.mean)
        assert np.all(beside < 4.0 * samples.mean_error)
        low, high = samples.interval(50)
        assert np.all((low < samples.percentile(50)) & (samples.percentile(50) < high))
    assert found.samples(CURVE).percentile(95).shape == (6,)


def test_the_report_has_both_beside_each_other(found: Robust) -> None:
    lines = str(found).splitlines()
    assert lines[0].startswith("small job: first order by 1 derivatives in ")
    assert "Monte Carlo with 40 designs in" in lines[0]
    assert lines[1].split() == ["mean", "standard", "deviation", "5", "%", "50", "%", "95", "%"]
    assert [line.split()[0] for line in lines[2:5]] == [SWING, "Monte", "+-"]
    assert lines[-2] == f"  {SWING}: {TORQUE} 100.0 %"


def test_shares_of_all_variables_are_one_and_only_loaded_teeth_have_one() -> None:
    names = [SWING, CURVE, "transmission_error_mean_um"]
    found = fl.robust(fl.prepare(lumped()), {**VARIABLES, ERRORS: CLASS_5}, names)
    assert found.notes == ()  # mean and samples have the same period, that of unequal teeth
    linear = found.first_order[SWING]
    assert next(iter(linear.shares)) == ERRORS
    np.testing.assert_allclose(sum(linear.shares.values()), 1.0)
    assert 3 <= found.solutions <= 5  # the torque, and the teeth that meet in a pitch
    # all teeth together turn the body: the mean over all teeth has no share
    teeth = found.first_order[CURVE].shares[ERRORS]
    assert teeth.shape == (6,)
    assert np.all(teeth > 0.5)


def test_the_same_samples_by_any_workers_and_after_a_resumption(tmp_path: Path) -> None:
    variables, scene = {**VARIABLES, ERRORS: CLASS_5}, lumped()
    options: dict[str, Any] = {"seed": 5, "design": "sobol"}
    store = tmp_path / "runs.sqlite"
    with ThreadPoolExecutor(1) as one:
        fl.robust(scene, variables, [SWING], n=2, store=store, executor=one, **options)
        resumed = fl.robust(scene, variables, [SWING], n=4, store=store, executor=one, **options)
    with ThreadPoolExecutor(2) as two:
        found = fl.robust(scene, variables, [SWING], n=4, executor=two, **options)
    assert resumed.study is not None
    assert found.study is not None
    np.testing.assert_array_equal(resumed.study.values(SWING), found.study.values(SWING))
    seconds = {row.outcome.seconds for row in resumed.study.rows}
    again = fl.robust(scene, variables, [SWING], n=4, store=store, **options)
    assert again.study is not None
    assert {row.outcome.seconds for row in again.study.rows} == seconds  # nothing is solved again


def test_a_list_of_torques_has_a_line_for_each() -> None:
    variables = {"pair.center_distance_mm": stats.uniform(91.6, 0.01)}
    found = fl.robust(lumped(**{TORQUE: [100.0, 300.0]}), variables, [SWING, CURVE], n=4)
    assert found.first_order[CURVE].mean.shape == found.samples(CURVE).mean.shape == (2, 6)
    assert f"{SWING}, 300 N m" in str(found)


def test_a_kink_at_the_mean_and_a_difference_to_monte_carlo_are_noted() -> None:
    """A helix slope only removes metal, at the one end or at the other: 0 is a kink."""
    scene = fl.read_scene(SCENES / "helical_gear.toml").replace(
        {
            "accuracy.estimate": False,
            "accuracy.flank_element_mm": 4.0,
            "accuracy.axial_degree": 4,
            "accuracy.load_degree_z": 0,
            "accuracy.slices": 3,
            "positions": {"count": 2},
        }
    )
    path, mean = "body_1.helix_slope_um", "transmission_error_mean_um"
    found = fl.robust(scene, {path: CLASS_5}, [mean], n=12, seed=1)
    kink, distance = found.notes
    words = f"{mean}: first order does not hold: "
    assert kink == f"{words}its derivatives to both sides differ for {path}"
    assert distance.startswith(f"{words}its 95 % percentile differs by ")


def test_failed_designs_are_left_out_and_counted() -> None:
    path = "body_1.profile_crowning_um"
    variables = {path: {"distribution": "normal", "mean": 1, "standard_deviation": 1}}
    found = fl.robust(lumped(), variables, [SWING], n=12, seed=1)
    assert found.study is not None
    failed = len(found.study.failed)
    assert 0 < failed < 11
    assert len(found.samples(SWING)) == 12 - failed
    assert found.notes[-1].startswith(f"{failed} designs failed and are left out, the first with:")


@pytest.mark.parametrize("percent", [5, 50])
def test_intervals_contain_the_percentile_with_their_probability(percent: float) -> None:
    drawn = stats.norm.ppf(np.random.default_rng(4).random((200, 2000)))
    low, high = Samples(np.sort(drawn, axis=0)).interval(percent)
    exact = stats.norm.ppf(percent / 100)
    held = ((low < exact) & (exact < high)).mean()
    assert 0.945 < held < 0.975


def test_too_few_samples_leave_a_limit_unknown() -> None:
    samples = Samples(np.sort(np.random.default_rng(4).random(20)))
    low, high = samples.interval(5)
    assert np.isnan(low)
    assert high > samples.percentile(5)
    exact = np.sqrt(1 / 12)
    many = Samples(np.sort(np.random.default_rng(4).random(20000)))
    assert abs(many.standard_deviation - exact) < 4 * many.deviation_error
    assert many.deviation_error == pytest.approx(exact * np.sqrt(0.8 / 20000) / 2, rel=0.05)


@pytest.mark.parametrize(
    ("changes", "line"),
    [
        ({"design": "factorial"}, "design: expected 'sobol' or 'random', found 'factorial'"),
        ({"quantities": ["peak_presure_MPa"]}, "expected names in Result.summary or curves (did"),
        ({"quantities": "abc"}, "quantities: expected a non-empty list of names, found 'abc'"),
        (
            {"variables": {TORQUE: [1, 2]}},
            f"variables.{TORQUE}: expected a distribution, since the design is 'random', found [1",
        ),
    ],
)
def test_wrong_calls_get_one_line(changes: dict[str, Any], line: str) -> None:
    options = {"variables": VARIABLES, "quantities": [SWING], **changes}
    with pytest.raises(fl.SceneError) as refused:
        fl.robust(lumped(), **options)
    assert line in str(refused.value)
