"""Variables of a study: values, distributions, and the line for each that is wrong."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy import stats

import flankload as fl
from flankload.studies.variables import variables_of
from tests.support.tolerances import ROUND_OFF

PATH = "body_1.tip_relief_um"
NORMAL = {"distribution": "normal", "mean": 2, "standard_deviation": 3}
PROBABILITIES = np.array([0.01, 0.3, 0.5, 0.9])


def only(value: Any) -> Any:
    (variable,) = variables_of({PATH: value})
    return variable


@pytest.mark.parametrize(
    ("table", "same"),
    [
        (NORMAL, stats.norm(2, 3)),
        ({"distribution": "uniform", "lower": -1, "upper": 5}, stats.uniform(-1, 6)),
        (NORMAL | {"lower": -1, "upper": 5}, stats.truncnorm(-1, 1, 2, 3)),
        (NORMAL | {"upper": 5}, stats.truncnorm(-np.inf, 1, 2, 3)),
        (stats.weibull_min(2, scale=4), stats.weibull_min(2, scale=4)),
    ],
)
def test_distributions_have_the_quantiles_of_scipy(table: Any, same: Any) -> None:
    found = only(table).quantiles(PROBABILITIES)
    np.testing.assert_allclose(found, same.ppf(PROBABILITIES), rtol=ROUND_OFF, atol=ROUND_OFF)


def test_quantiles_are_finite_and_inside_their_limits() -> None:
    ends = only(NORMAL).quantiles([0.0, 1.0])
    assert np.isfinite(ends).all()
    low, high = only(NORMAL | {"lower": -1, "upper": 5}).quantiles([0.0, 1.0])
    assert -1 <= low < high <= 5


def test_discrete_distributions_give_integers() -> None:
    found = only(stats.randint(16, 20)).quantiles(PROBABILITIES)
    assert found == [16, 17, 17, 19]
    assert all(type(value) is int for value in found)


def test_paths_may_be_nested_tables_and_share_a_value() -> None:
    found = variables_of(
        {
            "load": {"torque_Nm": np.array([1.0, 2.0])},
            "body_1": {"tip_relief_um": NORMAL},
            "body_2.tip_relief_um, body_2.profile_crowning_um": [[1], {"a": 2}],
        }
    )
    names = ["load.torque_Nm", PATH, "body_2.tip_relief_um, body_2.profile_crowning_um"]
    assert [variable.name for variable in found] == names
    assert found[0].values == (1.0, 2.0)
    paths = ("body_2.tip_relief_um", "body_2.profile_crowning_um")
    assert found[2].changes(3) == dict.fromkeys(paths, 3)


@pytest.mark.parametrize(
    ("tree", "line"),
    [
        ({}, "variables: expected a table of paths with values or distributions, found nothing"),
        ({PATH: []}, f"variables.{PATH}: expected a non-empty list of values or a table with a"),
        ({PATH: 3}, f"variables.{PATH}: expected a non-empty list of values or a table with a"),
        ({PATH: "a"}, "distribution, found 'a'"),
        ({PATH: {"lower": 0}}, f"variables.{PATH}.lower: expected a non-empty list"),
        (
            {PATH: {"distribution": "gauss"}},
            "distribution: expected 'normal' or 'uniform' or 'iso_1328', found 'gauss'",
        ),
        (
            {PATH: {"distribution": "uniform", "lower": 0}},
            f"variables.{PATH}.upper: expected a number, found nothing",
        ),
        (
            {PATH: {"distribution": "uniform", "lower": 0, "upper": 0}},
            f"variables.{PATH}.upper: expected a number above lower, 0, found 0",
        ),
        (
            {PATH: NORMAL | {"standard_deviation": 0}},
            f"variables.{PATH}.standard_deviation: expected a number > 0, found 0",
        ),
        ({PATH: NORMAL | {"sigma": 0}}, f"variables.{PATH}.sigma: expected a known key"),
        (
            {PATH: [1], f"load.torque_Nm,{PATH}": [1]},
            f"variables.load.torque_Nm,{PATH}: expected paths that no other variable has, found",
        ),
    ],
)
def test_wrong_variables_get_one_line(tree: dict[str, Any], line: str) -> None:
    with pytest.raises(fl.SceneError) as refused:
        variables_of(tree)
    assert line in str(refused.value)
