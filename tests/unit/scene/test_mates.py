"""Data of two gears that do not belong together: the key to change is named."""

from __future__ import annotations

from typing import Any

import pytest

import flankload as fl
from flankload.mechanisms.flank_pair.assembly import build_bodies
from tests.support.drawing import drawing


def refused(tables: dict[str, Any]) -> fl.SceneError:
    with pytest.raises(fl.SceneError) as caught:
        build_bodies(fl.Scene.from_dict(tables))
    assert "\n" not in str(caught.value)
    return caught.value


def test_another_pressure_angle_is_named_before_the_fillet() -> None:
    """Regression: 25 deg on one gear blamed its fillet_radius_factor."""
    error = refused(drawing({"pressure_angle_deg": 25}))
    assert (error.key, error.found) == ("body_2.pressure_angle_deg", "20, the default")
    assert error.expected.startswith("25, as in body_1.pressure_angle_deg, since base pitches ")
    both = refused(drawing({"pressure_angle_deg": 25}, {"pressure_angle_deg": 25}))
    assert (both.key, both.found) == ("body_1.fillet_radius_factor", "0.38, the default")
    assert both.expected.endswith("dedendum and pressure angle (25 deg)")


def test_another_module_is_named() -> None:
    error = refused(drawing(body_2={"module_mm": 3}))
    assert error.key == "body_2.module_mm"
    assert error.expected.startswith("2.5, as in body_1.module_mm: the base pitch of body_1, 7.71")


@pytest.mark.parametrize("number", [1, 2])
def test_the_transverse_module_of_one_gear_is_named(number: int) -> None:
    error = refused(drawing(**{f"body_{number}": {"module_mm": 2.6287}}))
    assert error.key == f"body_{number}.module_mm"
    assert error.expected == "2.5, the normal module, as of the other body"
    assert error.found == "2.6287, the transverse module"


def test_the_transverse_module_of_both_gears_is_named() -> None:
    """Regression: the tip radius of body 2 was blamed."""
    error = refused(drawing({"module_mm": 2.6287}, {"module_mm": 2.6287}))
    assert error.key == "body_1.module_mm"
    assert error.expected == "2.5, the normal module, with which the gears mesh"
    assert error.found.startswith("2.6287, the transverse module, which is impossible (body_2.tip_")


def test_errors_of_impossible_pairs_name_unusual_values() -> None:
    for tables, key, meant in (
        (drawing(center_distance_mm=0.12404), "pair.center_distance_mm", "124.04"),
        (drawing({"tip_diameter_mm": 0.0667}), "body_1.tip_diameter_mm", "66.7"),
    ):
        assert f"; unusual: {key} = " in refused(tables).found
        assert f", did you mean {meant}? (usual: " in refused(tables).found
