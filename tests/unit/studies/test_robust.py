"""Robust design: first order against sensitivities and Monte Carlo, kinks, sampling errors."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy import stats

import flankload as fl
from flankload.studies.robustness import Failures, FirstOrder, Robust, Samples
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
    slope = stats.norm(0.0, 5.0)
    found = fl.robust(scene, {path: slope}, [mean], n=12, seed=1)
    kink, distance = found.notes
    words = f"{mean}: first order does not hold: "
    assert kink == f"{words}its derivatives to both sides differ for {path}"
    assert distance.startswith(f"{words}its 95 % percentile differs by ")
    step = 0.1
    low, middle, high = (
        fl.solve(scene.replace({path: value})).summary[mean] for value in (-step, 0.0, step)
    )
    half_difference = 0.5 * (high - 2.0 * middle + low) / step
    assert float(found.first_order[mean].kinks[path]) == pytest.approx(
        5.0 * abs(half_difference), rel=0.02
    )


def test_failed_designs_are_counted_with_their_share() -> None:
    path = "body_1.profile_crowning_um"
    variables = {path: {"distribution": "normal", "mean": 1, "standard_deviation": 1}}
    found = fl.robust(lumped(), variables, [SWING], n=12, seed=1)
    assert found.failures is not None
    failed = found.failures.count
    assert 0 < failed < 11
    assert len(found.samples(SWING)) == 12
    assert found.samples(SWING).known == 12 - failed
    text = str(found)
    assert f"failed designs: {failed} of 12, {100 * failed / 12:.3g} % (95 % confidence: " in text
    monte_carlo = next(line for line in text.splitlines() if "Monte Carlo  " in line)
    assert monte_carlo.split()[-3::2] == ["failed", "failed"]
    assert "the first failed with: body_1.profile_crowning_um: expected" in found.notes[-1]


@pytest.mark.parametrize("failed", [0, 3, 11])
def test_failed_designs_are_beyond_percentiles_at_both_ends(failed: int) -> None:
    """Regression: failures were left out, so 3 and 11 of 100 changed no percentile."""
    values = np.random.default_rng(3).permutation(np.arange(100.0))
    values[values < failed] = np.nan
    samples = Samples(values)
    if failed > 5:
        assert np.isnan([samples.percentile(5), samples.percentile(95)]).all()
        assert np.isnan(samples.interval(95)[1])
        assert np.isfinite(samples.interval(50)).all()
    else:
        # of 100 designs, as many as fail are below the least value, then above the largest
        assert samples.percentile(5) == pytest.approx(4.95)
        assert samples.percentile(95) == pytest.approx(94.05 + failed)
    assert samples.percentile(50) == pytest.approx(49.5 + failed)
    assert samples.mean == pytest.approx(np.arange(failed, 100).mean())
    assert samples.standard_deviation == pytest.approx(np.arange(failed, 100).std(ddof=1))


@pytest.mark.parametrize(
    ("count", "low", "high"), [(0, 0.0, 0.036217), (3, 0.006230, 0.085176), (100, 0.963783, 1.0)]
)
def test_the_share_of_failures_has_exact_limits(count: int, low: float, high: float) -> None:
    """Limits of Clopper and Pearson: their tails of the binomial distribution have 2.5 %."""
    found = Failures(count, 100).interval
    np.testing.assert_allclose(found, (low, high), atol=5e-7)
    if count:
        assert stats.binom.sf(count - 1, 100, found[0]) == pytest.approx(0.025)
    if count < 100:
        assert stats.binom.cdf(count, 100, found[1]) == pytest.approx(0.025)


def test_first_order_has_no_percentile_below_the_least_possible_value(found: Robust) -> None:
    """Regression: a peak to peak of 1 +- 1 had a 5 % percentile of -0.645."""
    least = {name: linear.least for name, linear in found.first_order.items()}
    assert least == {SWING: 0.0, CURVE: -np.inf}
    linear = FirstOrder(np.array([1.0, 3.0]), np.ones(2), {"a": np.ones(2)}, {}, least[SWING])
    np.testing.assert_allclose(linear.percentile(5), [np.nan, 3 - 1.6448536])
    robust = Robust("pair", (1.0, 2.0), {SWING: linear}, None, 1, {"first_order": 1.0})
    (note,) = robust.notes
    assert note == (
        f"{SWING}: first order does not hold: its 5 % percentile would be -0.64485, and no value "
        "is below 0; sample with n > 0"
    )
    rows = [line.split() for line in str(robust).splitlines()]
    assert rows[2][-4:] == ["1", "1", "1", "2.6449"]  # no cell for 5 %
    assert rows[3][-3:] == ["1.3551", "3", "4.6449"]


@pytest.mark.parametrize("percent", [5, 50])
def test_intervals_contain_the_percentile_with_their_probability(percent: float) -> None:
    drawn = stats.norm.ppf(np.random.default_rng(4).random((200, 2000)))
    low, high = Samples(drawn).interval(percent)
    exact = stats.norm.ppf(percent / 100)
    held = ((low < exact) & (exact < high)).mean()
    assert 0.945 < held < 0.975


def test_too_few_samples_leave_a_limit_unknown() -> None:
    samples = Samples(np.random.default_rng(4).random(20))
    low, high = samples.interval(5)
    assert np.isnan(low)
    assert high > samples.percentile(5)
    exact = np.sqrt(1 / 12)
    many = Samples(np.random.default_rng(4).random(20000))
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
