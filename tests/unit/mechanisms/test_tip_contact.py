"""Tip and fillet contact left out: unchanged results, errors, refused scenes."""

from __future__ import annotations

import numpy as np
import pytest

import flankload as fl
from flankload.errors import NoContactState, SceneError
from flankload.mechanisms.flank_pair.assembly import build_bodies
from flankload.result import Result
from tests.support.cam_scenes import cam_scene
from tests.support.pair_scenes import EXTERNAL, RING_PAIR, SPLINE, solved
from tests.support.tolerances import ROUND_OFF, SOLVER

WITHOUT = {"effects": {"tip_contact": False}}
#: Loss of stiffness of the external pair where a sharp tip carries: up to 40 %, measured
#: before; reproduced within a third of it.
LARGEST, THIRD = 0.40, 1.0 / 3.0
#: Rotation of a pair whose tip roundings are left out against one whose teeth end where these
#: begin: the metal of the tips themselves.
TIPS = 1e-3


@pytest.fixture(scope="module")
def both() -> tuple[Result, Result]:
    return solved(EXTERNAL, 302.0, count=32), solved(EXTERNAL, 302.0, count=32, **WITHOUT)


def test_positions_without_tip_contact_keep_their_values(both: tuple[Result, Result]) -> None:
    """Cells are as wide as the estimate, an iteration that has more zones with tips."""
    with_tips, without = both
    alike = ~with_tips.corner_contact.any(axis=1)
    assert 16 < alike.sum() < 32
    for name in ("rotation_rad", "site_force_N", "peak_pressure_MPa"):
        one, two = getattr(with_tips, name)[alike], getattr(without, name)[alike]
        np.testing.assert_allclose(one, two, rtol=SOLVER, atol=0.0)


def test_contact_that_grows_up_to_a_tip_stays(both: tuple[Result, Result]) -> None:
    with_tips, without = both
    grown = without.corner_contact.any(axis=1)
    assert grown.any()
    for name in ("rotation_rad", "site_force_N"):
        one, two = getattr(with_tips, name)[grown], getattr(without, name)[grown]
        np.testing.assert_allclose(one, two, rtol=SOLVER, atol=0.0)


def test_tips_left_out_cost_up_to_forty_per_cent(both: tuple[Result, Result]) -> None:
    with_tips, without = both
    missed = without.rotation_rad / with_tips.rotation_rad - 1.0
    assert missed.min() >= -ROUND_OFF  # a support less never makes a pair stiffer
    assert missed.max() == pytest.approx(LARGEST, rel=THIRD)
    assert without.cost["influence_columns"] < with_tips.cost["influence_columns"]


def test_where_it_matters_is_said(both: tuple[Result, Result]) -> None:
    with_tips, without = both
    matters = int((without.rotation_rad > with_tips.rotation_rad * (1.0 + SOLVER)).sum())
    assert matters > 0
    said = [warning for warning in without.warnings if "tip_contact" in warning]
    expected = (
        f"a tip or fillet that effects.tip_contact = false excludes would touch at {matters} of "
        "32 positions; the rotation there is too large"
    )
    assert said == [expected]
    assert not any("tip_contact" in warning for warning in with_tips.warnings)


def test_a_rounding_left_out_is_a_tooth_that_ends_where_it_begins() -> None:
    rounded = {
        **EXTERNAL,
        **{key: {**EXTERNAL[key], "tip_radius_mm": 0.5} for key in ("body_1", "body_2")},
    }
    pair = build_bodies(_scene(rounded))
    shorter = {**EXTERNAL}
    for key, body in (("body_1", pair.body_1), ("body_2", pair.body_2)):
        assert body.active_range_mm is not None
        end = body.curve.point([body.active_range_mm[1]])[0]
        shorter[key] = {**EXTERNAL[key], "tip_diameter_mm": 2 * float(np.hypot(*end))}
    one, two = (solved(scene, 302.0, count=16, **WITHOUT) for scene in (rounded, shorter))
    np.testing.assert_array_equal(one.site_force_N > 0, two.site_force_N > 0)
    off_ends = ~(one.corner_contact | two.corner_contact).any(axis=1)
    assert off_ends.sum() >= 12
    np.testing.assert_allclose(
        one.rotation_rad[off_ends], two.rotation_rad[off_ends], rtol=TIPS, atol=0.0
    )


@pytest.mark.parametrize("pair", [RING_PAIR, SPLINE], ids=["internal", "spline"])
def test_other_pairs_without_tips(pair: dict) -> None:
    with_tips = solved(pair, 200.0, count=4)
    without = solved(pair, 200.0, count=4, **WITHOUT)
    assert (without.rotation_rad >= with_tips.rotation_rad * (1.0 - SOLVER)).all()
    if pair is SPLINE:  # flanks that lie upon each other up to their tips are no tip contact
        assert not any("tip_contact" in warning for warning in without.warnings)
        np.testing.assert_allclose(
            without.rotation_rad, with_tips.rotation_rad, rtol=SOLVER, atol=0.0
        )


def test_between_two_paths_nothing_is_left_to_touch() -> None:
    short = {
        **EXTERNAL,
        "body_1": {**EXTERNAL["body_1"], "tip_diameter_mm": 77.5},
        "body_2": {**EXTERNAL["body_2"], "tip_diameter_mm": 113.5},
    }
    beyond = {"beyond_limits": True}
    with_tips = solved(short, 302.0, count=16, effects=beyond)
    assert with_tips.summary["contact_ratio_geometric"] < 1.0
    with pytest.raises(NoContactState, match=r"which effects\.tip_contact = false excludes"):
        solved(short, 302.0, count=16, effects={**WITHOUT["effects"], **beyond})


def test_cams_have_no_tips() -> None:
    with pytest.raises(SceneError) as caught:
        fl.Scene.from_dict(cam_scene(**WITHOUT))
    assert str(caught.value) == (
        "effects.tip_contact: expected true with body_2.kind 'cam', which has neither tips nor "
        "fillets, found false"
    )


def _scene(pair: dict) -> fl.Scene:
    return fl.Scene.from_dict({**pair, "load": {"torque_Nm": 302.0}, **WITHOUT})
