"""Ends of a narrower body on the flanks of a wider one: sharp corners along the axis."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import flankload as fl
from flankload.result.slices import mean_line_loads
from tests.support.solving import solve as solve_scene
from tests.support.three_dimensional import SMALL, tree_of
from tests.support.tolerances import ROUND_OFF

WIDE = {
    "body_1__face_width_mm": 18.0,
    "positions__count": 2,
    "accuracy__line_load_length_mm": 1.0,
}
#: Largest difference of K_Hbeta and of the largest line load between numbers of slices and cells.
SAME = 0.01


def spur(**changes: Any) -> fl.Result:
    """The spur pair in three dimensions."""
    tree = tree_of("external_gear", {**SMALL, "effects__dimension": 3, **changes})
    found = solve_scene(fl.Scene.from_dict(tree))
    assert isinstance(found, fl.Result)
    return found


@pytest.fixture(scope="module")
def coarse() -> fl.Result:
    return spur(**WIDE, accuracy__slices=28)


@pytest.mark.parametrize(
    "changes",
    [
        {"accuracy__slices": 90},
        {"accuracy__slices": 18, "effects__contact": "pairs", "accuracy__strips_per_half_width": 3},
    ],
    ids=["slices", "cells"],
)
def test_load_factors_do_not_depend_on_the_slices(
    coarse: fl.Result, changes: dict[str, Any]
) -> None:
    """Regression: they had no limit; K_Hbeta of 14 and 200 slices was 1.15 and 1.92."""
    fine = spur(**WIDE, **changes)
    assert fine.face_load_factor == pytest.approx(coarse.face_load_factor, rel=SAME)
    assert fine.line_load_factor == pytest.approx(coarse.line_load_factor, rel=SAME)
    loads = [one.summary["peak_line_load_N_per_mm"] for one in (fine, coarse)]
    assert loads[0] == pytest.approx(loads[1], rel=SAME)
    # the line load of the slices themselves has no limit
    assert fine.slice_line_load_N_per_mm.max() > 1.05 * coarse.slice_line_load_N_per_mm.max()
    assert coarse.summary["line_load_length_mm"] == pytest.approx(1.0, rel=ROUND_OFF)


def test_sharp_ends_are_marked_with_the_key_that_relieves_them(coarse: fl.Result) -> None:
    """Regression: pressures there were reported as finite values."""
    ends = (coarse.slice_line_load_N_per_mm[..., [0, -1]] > 0).any(axis=2)
    assert ends.any()
    assert coarse.corner_contact[ends].all()
    assert coarse.summary["peak_pressure_MPa"] is None
    (note,) = (line for line in coarse.warnings if "sharp end" in line)
    assert "body_2.end_relief_um" in note
    relieved = spur(
        **WIDE, body_2__end_relief_um=[60.0, 60.0], body_2__end_relief_length_mm=[3.0, 3.0]
    )
    assert not any("sharp end" in line for line in relieved.warnings)
    assert relieved.summary["corner_pressure_MPa"] is None
    same = spur(positions__count=2)
    assert not any("sharp end" in line for line in same.warnings)
    assert same.summary["line_load_length_mm"] == pytest.approx(14.0 / 28, rel=ROUND_OFF)


def test_mean_line_loads_by_hand() -> None:
    width = np.array([1.0, 1.0, 2.0, 4.0])
    force = np.array([4.0, 2.0, 2.0, 4.0])
    # line loads 4, 2, 1, 1: over 2 mm [0, 2] twice, the third slice, the whole fourth one
    found = mean_line_loads(force, width, 2.0)
    np.testing.assert_allclose(found, [3.0, 3.0, 1.0, 1.0], rtol=ROUND_OFF)
    # a rising load: [2, 4] in place of [1, 3] about the second slice
    found = mean_line_loads(np.array([1.0, 2.0, 4.0, 8.0]), np.ones(4), 2.0)
    np.testing.assert_allclose(found, [1.5, 3.0, 6.0, 6.0], rtol=ROUND_OFF)
    np.testing.assert_allclose(mean_line_loads(force, width, 99.0), np.full(4, 1.5))
    np.testing.assert_allclose(mean_line_loads(force, width, 0.1), force / width)
