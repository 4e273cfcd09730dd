"""Lumped contact requested by a scene: results, cost, refused scenes."""

from __future__ import annotations

import json
import tomllib
from typing import Any

import numpy as np
import pytest

import flankload as fl
from flankload.analysis.estimate import POINTWISE
from tests.support.gear_scenes import changed, refusal
from tests.support.paths import SCENES
from tests.support.tolerances import ROUND_OFF

LUMP = {"effects__contact": "lumped", "positions__count": 16}


def solved(**changes: Any) -> fl.Result:
    found = fl.solve(fl.Scene.from_dict(changed(**{**LUMP, **changes})))
    assert isinstance(found, fl.Result)
    return found


@pytest.fixture(scope="module")
def lumped() -> fl.Result:
    return solved(effects__root_stress=True)


@pytest.fixture(scope="module")
def pairs() -> fl.Result:
    return solved(effects__root_stress=True, effects__contact="pairs")


def test_no_cell_is_laid_and_no_column_made(lumped: fl.Result) -> None:
    cost = lumped.cost
    for counter in ("influence_columns", "influence_columns_tangential", "contact_passes"):
        assert cost[counter] == 0
    assert cost["lumped_solutions"] > 0
    assert "tangent" not in cost["stages"]


def test_a_pair_is_a_contact(lumped: fl.Result) -> None:
    carrying = 0
    for p, table in enumerate(lumped.pair_tables):
        assert table.half_width_mm is not None
        np.testing.assert_allclose(table.cell_mm, 0.5 * np.pi * table.half_width_mm, ROUND_OFF)
        for s, site in enumerate(lumped.sites):
            own = (table.site == site) & (table.force_N > 0)
            carrying += int(own.sum())
            assert table.force_N[own].sum() == pytest.approx(lumped.site_force_N[p, s], abs=1e-9)
            if own.any():
                hertz = 2 * table.force_N[own] / (np.pi * table.half_width_mm[own] * 14)
                assert hertz.max() == pytest.approx(lumped.peak_pressure_MPa[p, s], rel=1e-12)
                assert lumped.contact_half_width_mm[p, s] == table.half_width_mm[own].sum()
    assert 16 < carrying < 48


def test_everything_else_is_there(lumped: fl.Result, pairs: fl.Result) -> None:
    np.testing.assert_array_equal(lumped.sites, pairs.sites)
    assert lumped.summary["loaded_pairs_max"] == pairs.summary["loaded_pairs_max"]
    # slope of differences against that of the equations; corners included
    np.testing.assert_allclose(
        lumped.stiffness_tangent_Nm_per_rad, pairs.stiffness_tangent_Nm_per_rad, rtol=0.01
    )
    smooth = ~pairs.corner_contact.any(axis=1)
    carries = pairs.contact_half_width_mm[smooth] > 0
    np.testing.assert_allclose(
        lumped.contact_half_width_mm[smooth][carries],
        pairs.contact_half_width_mm[smooth][carries],
        rtol=0.015,
    )
    for one, two in zip(lumped.root_stress, pairs.root_stress, strict=True):
        assert one is not None
        assert two is not None
        largest = two.tension.stress_MPa.max()
        np.testing.assert_allclose(
            one.tension.stress_MPa[smooth], two.tension.stress_MPa[smooth], 0, 2e-3 * largest
        )
    np.testing.assert_array_equal(lumped.potential_pairs, pairs.potential_pairs)


def test_the_estimate_contains_the_error_of_the_level(lumped: fl.Result, pairs: fl.Result) -> None:
    assert lumped.estimate is not None
    sources = lumped.estimate["by_source"]
    assert set(sources) == {"modes", "elements", "lumped", "positions"}  # no strips
    # the largest pressure lies beside the end of a flank
    estimated = [quantity for quantity in POINTWISE if quantity != "largest_pressure"]
    assert set(sources["lumped"]) >= set(estimated)
    for quantity in estimated:
        parts = [errors[quantity] for errors in sources.values() if quantity in errors]
        assert sources["lumped"][quantity] <= lumped.estimate[quantity] <= sum(parts)
    beside = np.abs(lumped.rotation_rad / pairs.rotation_rad - 1).max()
    assert beside < sources["lumped"]["transmission_error"] < 10 * beside
    share = np.abs(lumped.load_share - pairs.load_share).max()
    assert share < sources["lumped"]["load_share"] < 10 * share


def test_files_and_text(lumped: fl.Result) -> None:
    tree = json.loads(lumped.to_json())
    assert len(tree["pairs"][0]["half_width_mm"]) == len(tree["pairs"][0]["force_N"])
    assert str(lumped)


def test_friction_and_several_torques() -> None:
    torques = [0, 30, 302]
    scene = changed(**LUMP, effects__friction_coefficient=0.1, load__torque_Nm=torques)
    found = fl.solve(fl.Scene.from_dict(scene)).by_torque
    alone = solved(effects__friction_coefficient=0.1)
    np.testing.assert_array_equal(found[2].rotation_rad, alone.rotation_rad)
    assert found[0].estimate is None
    friction = alone.friction
    assert friction is not None
    assert friction.efficiency is not None
    # torque 2 by the forces, against the balance of work
    with_pairs = solved(effects__friction_coefficient=0.1, effects__contact="pairs").friction
    assert with_pairs is not None
    assert with_pairs.efficiency is not None
    assert friction.efficiency == pytest.approx(with_pairs.efficiency, abs=2e-4)
    np.testing.assert_allclose(friction.torque_2_Nm, with_pairs.torque_2_Nm, rtol=5e-3)


def test_adaptive_positions() -> None:
    found = solved(positions__adaptive=True, positions__count=8)
    assert found.position_rad.size > 8


def test_a_rounding_is_named() -> None:
    found = solved(body_1__tip_radius_mm=0.5, body_2__tip_radius_mm=0.5, load__torque_Nm=900)
    assert any("pressures there are Hertz values" in warning for warning in found.warnings)


def test_splines_conform() -> None:
    tables = tomllib.loads((SCENES / "spline.toml").read_text(encoding="utf-8"))
    error = refusal({**tables, "effects": {"contact": "lumped"}})
    assert error.key == "effects.contact"
    assert "'pairs' with body_1.kind 'spline_shaft'" in str(error)


@pytest.mark.parametrize(
    "knob", ["strips_per_half_width", "corner_strips_per_half_width", "zone_half_widths"]
)
def test_strips_go_with_pairs(knob: str) -> None:
    error = refusal(changed(effects__contact="lumped", **{f"accuracy__{knob}": 3.5}))
    assert str(error) == (
        f"a.toml: accuracy.{knob}: expected nothing with effects.contact 'lumped', which has no "
        "strips, found 3.5"
    )


def test_levels_are_named() -> None:
    error = refusal(changed(effects__contact="lump"))
    assert error.key == "effects.contact"
    assert "lumped" in error.expected
