"""Positions of a sweep: adaptive ones, uneven angles, windows, the hunting period."""

from __future__ import annotations

import tomllib
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest

import flankload as fl
from flankload.analysis.adaptive_positions import PositionErrors
from flankload.analysis.estimate import BETWEEN, ON_CORNERS, Estimate
from flankload.mechanisms.flank_pair.assembly import build_bodies
from flankload.pairing.pairing import period_of
from flankload.result.harmonics import over_positions
from tests.support.paths import SCENES
from tests.support.solving import solve
from tests.support.tolerances import ROUND_OFF, SOLVER

#: Requirements on adaptive positions: harmonics against a dense sweep, relative to each of them,
#: or to a tenth of the largest where it is smaller; the mean and the contact ratio as they come.
HARMONICS, MEAN, CONTACT_RATIO = 3e-3, 1e-4, 2e-3
DENSE = 768
#: Six and nine teeth: a hunting period of 18 pitches.
FEW_TEETH = {
    "body_1": {
        **{"kind": "gear", "teeth": 12, "module_mm": 4.0, "profile_shift": 0.3},
        **{"tip_diameter_mm": 57.6, "bore_diameter_mm": 20},
    },
    "body_2": {
        **{"kind": "gear", "teeth": 18, "module_mm": 4.0, "profile_shift": 0.0},
        **{"tip_diameter_mm": 79.2, "bore_diameter_mm": 30},
    },
    "pair": {"center_distance_mm": 61.2, "face_width_mm": 10},
    "load": {"torque_Nm": 120},
    "accuracy": {"estimate": False, "tangents": False, "flank_element_mm": 1.5},
}


def solved(name: str, torques: tuple[float, ...], **positions: Any) -> tuple[fl.Result, ...]:
    """An example of the project at torques and positions."""
    tables = tomllib.loads((SCENES / f"{name}.toml").read_text(encoding="utf-8"))
    tables |= {
        "load": {"torque_Nm": list(torques)},
        "positions": positions,
        "accuracy": {"estimate": bool(positions.get("adaptive")), "tangents": False},
    }
    found = solve(fl.Scene.from_dict(tables))
    assert isinstance(found, tuple)
    return found


def few_teeth(errors_1: Any = (), errors_2: Any = (), **tables: Any) -> fl.Scene:
    """A small pair with pitch errors."""
    scene = {**FEW_TEETH, **tables}
    for body, errors in (("body_1", errors_1), ("body_2", errors_2)):
        scene[body] = {**scene[body], "pitch_errors_um": list(errors)}
    return fl.Scene.from_dict(scene)


def errors_of(teeth: int, seed: int) -> np.ndarray:
    return np.random.default_rng(seed).normal(0, 4, teeth).round(1)


TORQUES = {"external_gear": (302.0, 90.0, 15.0), "internal_gear": (450.0, 135.0, 22.0)}
#: Solves of a single torque: limit, and number found today.
MOST_SOLVES = {"external_gear": 60, "internal_gear": 200}


@cache
def dense(name: str) -> tuple[fl.Result, ...]:
    return solved(name, TORQUES[name], count=DENSE)


# --- adaptive -------------------------------------------------------------------------------------
@pytest.mark.parametrize("name", TORQUES)
@pytest.mark.parametrize("which", [(0,), (1,), (2,), (0, 1, 2)], ids=str)
def test_adaptive_positions_are_as_good_as_a_dense_sweep(name: str, which: tuple[int]) -> None:
    torques = tuple(TORQUES[name][t] for t in which)
    found = solved(name, torques, adaptive=True)
    for result, t in zip(found, which, strict=True):
        reference = dense(name)[t]
        wanted = np.array(reference.summary["transmission_error_harmonics_um"][:3])
        harmonics = np.array(result.summary["transmission_error_harmonics_um"][:3])
        scale = np.maximum(wanted, 0.1 * wanted.max())
        error = np.abs(harmonics - wanted) / scale
        assert error.max() < HARMONICS
        left = result.estimate["by_source"]["positions"]
        assert error.max() < left["transmission_error_harmonics"] < HARMONICS
        span, whole = (r.summary["transmission_error_peak_to_peak_um"] for r in (result, reference))
        # found positions: the estimate covers the curve between them
        assert whole - span < left["transmission_error_peak_to_peak"] * span
        assert left["transmission_error_peak_to_peak"] < HARMONICS
        assert result.summary["transmission_error_mean_um"] == pytest.approx(
            reference.summary["transmission_error_mean_um"], rel=MEAN
        )
        assert result.summary["contact_ratio_under_load"] == pytest.approx(
            reference.summary["contact_ratio_under_load"], rel=CONTACT_RATIO
        )
        assert (np.diff(result.position_rad) > 0).all()
        assert result.closed
        assert result.cost["positions"] == result.position_rad.size
        assert result.cost["position_rounds"] <= 12
        assert not any("too few" in warning for warning in result.warnings)
    assert len({r.position_rad.tobytes() for r in found}) == 1
    if len(found) == 1:
        assert found[0].position_rad.size <= MOST_SOLVES[name]


def test_adaptive_positions_are_those_of_single_sweeps() -> None:
    """Several rounds together equal one sweep of the same positions, bit by bit."""
    (found,) = solved("external_gear", (302.0,), adaptive=True)
    (again,) = solved("external_gear", (302.0,), angles_deg=np.degrees(found.position_rad))
    np.testing.assert_allclose(again.position_rad, found.position_rad, rtol=ROUND_OFF, atol=0)
    np.testing.assert_allclose(again.rotation_rad, found.rotation_rad, rtol=SOLVER, atol=0)
    for p in (0, 20, found.position_rad.size - 1):
        np.testing.assert_array_equal(found.pairs(p).site, again.pairs(p).site)
        np.testing.assert_allclose(
            found.pairs(p).force_N, again.pairs(p).force_N, rtol=0, atol=1e-6 * 9000
        )
    # the same curve, so the same numbers: the list covers the period
    for key in ("mean_um", "harmonics_um"):
        np.testing.assert_allclose(
            again.summary[f"transmission_error_{key}"],
            found.summary[f"transmission_error_{key}"],
            rtol=1e-7,
            atol=0,
        )


def test_too_few_positions_are_never_silent() -> None:
    (found,) = solved("external_gear", (302.0,), adaptive=True, max_count=36)
    assert found.position_rad.size <= 36
    (warning,) = (line for line in found.warnings if "too few" in line)
    left = found.estimate["by_source"]["positions"]
    assert f"{100 * left['transmission_error_harmonics']:.2g} %" in warning
    assert max(left.values()) > HARMONICS


def test_tighter_tolerance_costs_more_positions_and_leaves_less() -> None:
    sizes, errors = [], []
    (reference, *_) = dense("external_gear")
    wanted = np.array(reference.summary["transmission_error_harmonics_um"][:3])
    for tolerance in (1e-2, 1e-3):
        (found,) = solved("external_gear", (302.0,), adaptive=True, tolerance=tolerance)
        sizes.append(found.position_rad.size)
        left = found.estimate["by_source"]["positions"]
        assert max(left.values()) <= tolerance
        harmonics = np.array(found.summary["transmission_error_harmonics_um"][:3])
        errors.append(np.abs(harmonics - wanted).max())
    assert sizes[0] < sizes[1]
    assert errors[1] < errors[0]


def test_unloaded_involutes_need_no_more_positions() -> None:
    """A transmission error of the size of rounding has no features to resolve."""
    (found,) = solved("external_gear", (0.0,), adaptive=True)
    assert found.position_rad.size == 32
    assert found.cost["position_rounds"] == 1


def test_unloaded_motion_has_its_kinks_where_the_next_pair_takes_over() -> None:
    """Regression: the peak between two pairs of relieved flanks was rounded off."""
    tables = tomllib.loads((SCENES / "internal_gear.toml").read_text(encoding="utf-8"))
    tables |= {"load": {"torque_Nm": 0}}
    for body, start in (("body_1", 75.0), ("body_2", 180.0)):
        # so long that no pair is at rest on its involute all the time
        tables[body] |= {"tip_relief_um": 40, "tip_relief_start_diameter_mm": start}
    adaptive, even = (
        solve(fl.Scene.from_dict(tables | {"positions": positions}))
        for positions in ({"adaptive": True}, {"count": DENSE})
    )
    assert isinstance(adaptive, fl.Result)
    assert isinstance(even, fl.Result)
    assert adaptive.position_rad.size < 60
    for key in ("peak_to_peak_um", "mean_um"):
        assert adaptive.summary[f"transmission_error_{key}"] == pytest.approx(
            even.summary[f"transmission_error_{key}"], rel=HARMONICS
        )


# --- angles ---------------------------------------------------------------------------------------
def test_uneven_angles_that_cover_a_period_have_its_harmonics() -> None:
    (reference, *_) = dense("internal_gear")
    rng = np.random.default_rng(4)
    pitch = 360 / 24
    angles = pitch * (np.arange(100) + rng.uniform(-0.4, 0.4, 100)) / 100
    # in any order, over two turns of the pinion
    angles = rng.permutation(angles + 360 * rng.integers(0, 2, 100))
    (found,) = solved("internal_gear", (450.0,), angles_deg=angles.tolist())
    assert not found.closed
    np.testing.assert_allclose(
        found.summary["transmission_error_harmonics_um"][:3],
        reference.summary["transmission_error_harmonics_um"][:3],
        rtol=3e-3,
        atol=0,
    )
    assert found.summary["transmission_error_mean_um"] == pytest.approx(
        reference.summary["transmission_error_mean_um"], rel=1e-3
    )
    assert found.summary["contact_ratio_under_load"] == pytest.approx(
        reference.summary["contact_ratio_under_load"], rel=1e-2
    )


def test_angles_crowded_in_one_place_do_not_pull_the_mean() -> None:
    (reference, *_) = dense("external_gear")
    even, crowd = np.arange(32) * 22.5 / 32, np.linspace(9.01, 9.99, 50)
    (found,) = solved("external_gear", (302.0,), angles_deg=[*even, *crowd])
    wanted = reference.summary["transmission_error_mean_um"]
    assert found.summary["transmission_error_mean_um"] == pytest.approx(wanted, rel=1e-3)
    assert abs(found.transmission_error_um.mean() / wanted - 1) > 0.05


def test_angles_that_leave_a_part_open_have_no_harmonics() -> None:
    (half,) = solved("external_gear", (302.0,), angles_deg=np.linspace(0, 11, 23).tolist())
    (single,) = solved("external_gear", (302.0,), angles_deg=[0.0, 11.0, 2.0])
    for result in (half, single):
        assert result.summary["transmission_error_harmonics_um"] is None
        assert result.summary["contact_ratio_under_load"] is None
    # weighted by turn where there are no holes, otherwise unweighted
    steps = np.diff(half.position_rad)
    error = half.transmission_error_um
    trapezes = (steps * (error[1:] + error[:-1]) / 2).sum() / steps.sum()
    assert half.summary["transmission_error_mean_um"] == pytest.approx(trapezes, rel=5e-3)
    assert single.summary["transmission_error_mean_um"] == single.transmission_error_um.mean()


def test_positions_many_turns_apart_are_two_positions() -> None:
    """Regression: every pair between them was a site."""
    scene = few_teeth(positions={"angles_deg": [0.0, 1e7]})
    pair = build_bodies(scene)
    assert pair.pairing.sites.size < 20
    found = solve(scene)
    assert found.rotation_rad.size == 2


# --- windows and the hunting period ---------------------------------------------------------------
@pytest.mark.parametrize(
    ("errors_1", "errors_2", "pitches"),
    [
        ((), (), 1),
        (errors_of(12, 1), (), 12),
        ((), errors_of(18, 2), 18),
        (errors_of(12, 1), errors_of(18, 2), 36),
        (np.tile([1.0, -2.0, 0.5], 4), np.tile([1.0, -1.0], 9), 6),
    ],
    ids=["none", "pinion", "wheel", "both", "groups"],
)
def test_period_is_where_teeth_alike_meet_again(errors_1: Any, errors_2: Any, pitches: int) -> None:
    pair = build_bodies(few_teeth(errors_1, errors_2, positions={"count": 4, "pitches": "hunting"}))
    assert pair.pairing.period.pitches == pitches
    assert pair.pairing.pitch_rad == pytest.approx(np.pi / 6, rel=ROUND_OFF)
    assert pair.position_rad.size == 4 * pitches
    assert pair.closed
    assert not any("repeat after" in note for note in pair.notes)


def test_uneven_flanks_of_a_mesh_are_pitch_errors() -> None:
    pair = build_bodies(few_teeth())
    turned = replace(pair.body_2, flank_turns_rad=tuple(1e-5 * errors_of(18, 6)))
    assert period_of(pair.body_1, turned).pitches == 18
    halves = replace(pair.body_1, flank_turns_rad=tuple(np.tile(1e-5 * errors_of(6, 6), 2)))
    assert period_of(halves, turned).pitches == 18
    assert period_of(halves, pair.body_2).pitches == 6


@pytest.fixture(scope="module")
def hunting() -> fl.Result:
    found = solve(
        few_teeth(errors_of(12, 1), errors_of(18, 2), positions={"count": 8, "pitches": "hunting"})
    )
    assert isinstance(found, fl.Result)
    return found


def test_curve_closes_over_the_hunting_period_and_not_before(hunting: fl.Result) -> None:
    pitch = 30.0
    angles = [0.0, 7.0, 36 * pitch, 36 * pitch + 7.0, 12 * pitch, 18 * pitch]
    found = solve(few_teeth(errors_of(12, 1), errors_of(18, 2), positions={"angles_deg": angles}))
    assert isinstance(found, fl.Result)
    rotation = found.rotation_rad
    np.testing.assert_allclose(rotation[2:4], rotation[:2], rtol=1e-8, atol=0)
    assert np.abs(rotation[4:] / rotation[0] - 1).min() > 0.01
    # a position of the long window is a position like any other
    assert hunting.rotation_rad[0] == pytest.approx(rotation[0], rel=1e-8)
    assert hunting.rotation_rad[8 * 12] == pytest.approx(rotation[4], rel=1e-8)
    assert hunting.closed
    assert hunting.period_pitches == 36
    assert hunting.period_rad == pytest.approx(36 * hunting.pitch_rad, rel=ROUND_OFF)


def test_harmonics_of_the_hunting_period_and_of_the_mesh(hunting: fl.Result) -> None:
    waves = 2 / 288 * np.abs(np.fft.rfft(hunting.transmission_error_um))
    summary = hunting.summary
    np.testing.assert_array_equal(summary["transmission_error_harmonics_um"], waves[1:6])
    mesh = summary["transmission_error_mesh_harmonics_um"]
    np.testing.assert_array_equal(mesh[:3], waves[[36, 72, 108]])
    assert mesh[3:] == [None, None]
    # once per turn of the pinion (12 pitches) and of the wheel (18) above what lies between
    assert min(waves[3], waves[2]) > 3 * waves[1]
    lines = hunting.table().splitlines()
    assert any(line.strip().startswith("harmonics of 36 pitches") for line in lines)
    assert "288 positions over 36 pitches of 30 deg" in lines[0]


def test_window_is_a_part_of_the_hunting_period(hunting: fl.Result) -> None:
    scene = few_teeth(errors_of(12, 1), errors_of(18, 2), positions={"count": 8, "pitches": 3})
    window = solve(scene)
    assert isinstance(window, fl.Result)
    np.testing.assert_allclose(window.rotation_rad, hunting.rotation_rad[:24], rtol=1e-8, atol=0)
    assert not window.closed
    assert window.period_pitches == 36
    assert window.summary["transmission_error_harmonics_um"] is None
    (note,) = (line for line in window.warnings if "repeat after" in line)
    assert "repeat after 36 pitches; these positions cover 3 pitches" in note


def test_pitches_without_errors_are_periods(hunting: fl.Result) -> None:
    one, three = (
        solve(few_teeth(positions={"count": 16, "pitches": pitches})) for pitches in (1, 3)
    )
    assert isinstance(one, fl.Result)
    assert isinstance(three, fl.Result)
    np.testing.assert_allclose(three.rotation_rad, np.tile(one.rotation_rad, 3), rtol=1e-8, atol=0)
    assert three.closed
    np.testing.assert_allclose(
        three.summary["transmission_error_mesh_harmonics_um"],
        one.summary["transmission_error_mesh_harmonics_um"],
        rtol=1e-6,
        atol=0,
    )
    assert max(three.summary["transmission_error_harmonics_um"][:2]) < 1e-6


def test_adaptive_positions_over_a_window_reach_its_end() -> None:
    scene = few_teeth(
        errors_of(12, 1), errors_of(18, 2), positions={"adaptive": True, "pitches": 2}
    )
    found = solve(scene)
    assert isinstance(found, fl.Result)
    assert found.position_rad[-1] == pytest.approx(2 * found.pitch_rad, rel=ROUND_OFF)
    assert over_positions(found).contiguous
    dense = solve(
        few_teeth(errors_of(12, 1), errors_of(18, 2), positions={"count": 512, "pitches": 2})
    )
    assert isinstance(dense, fl.Result)
    assert found.summary["transmission_error_mean_um"] == pytest.approx(
        dense.transmission_error_um.mean(), rel=1e-3
    )
    assert found.summary["transmission_error_peak_to_peak_um"] == pytest.approx(
        dense.summary["transmission_error_peak_to_peak_um"], rel=HARMONICS
    )


def test_hunting_period_inside_a_ring() -> None:
    """24 teeth in 60: 120 pitches; each position equals that of a separate run."""
    tables = tomllib.loads((SCENES / "internal_gear.toml").read_text(encoding="utf-8"))
    tables["body_1"]["pitch_errors_um"] = errors_of(24, 3).tolist()
    tables["body_2"] |= {"pitch_errors_um": errors_of(60, 4).tolist(), "rigid": True}
    tables["accuracy"] = {"estimate": False, "tangents": False, "flank_element_mm": 1.5}

    def rotation(**positions: Any) -> np.ndarray:
        found = solve(fl.Scene.from_dict(tables | {"positions": positions}))
        assert isinstance(found, fl.Result)
        return found.rotation_rad

    whole = rotation(count=1, pitches="hunting")
    assert whole.size == 120
    for k in (0, 23, 24, 61, 119):
        alone = rotation(angles_deg=[15.0 * k])
        assert whole[k] == pytest.approx(alone[0], rel=1e-8)
    after = rotation(angles_deg=[15.0 * 120, 15.0 * 121])
    np.testing.assert_allclose(after, whole[:2], rtol=1e-8, atol=0)
    assert np.abs(whole[[24, 60]] / whole[0] - 1).min() > 1e-3


def test_spline_with_errors_on_axes_apart_repeats_after_a_turn() -> None:
    tables = tomllib.loads((SCENES / "spline.toml").read_text(encoding="utf-8"))
    tables["pair"]["center_offset_mm"] = 0.01
    tables["accuracy"] = {"estimate": False, "tangents": False, "flank_element_mm": 1.0}
    tables["body_2"]["rigid"] = True
    around = build_bodies(
        fl.Scene.from_dict(tables | {"positions": {"count": 1, "pitches": "hunting"}})
    )
    assert around.closed
    assert around.period_rad == pytest.approx(2 * np.pi, rel=ROUND_OFF)
    turned = solve(fl.Scene.from_dict(tables | {"positions": {"angles_deg": [0.0, 15.0, 360.0]}}))
    assert isinstance(turned, fl.Result)
    rotation = turned.rotation_rad
    assert turned.period_pitches == 24
    assert rotation[2] == pytest.approx(rotation[0], rel=1e-8)
    assert abs(rotation[1] / rotation[0] - 1) > 1e-4


def test_window_beyond_all_memory_is_refused() -> None:
    with pytest.raises(fl.SceneError) as caught:
        build_bodies(few_teeth(positions={"count": 8, "pitches": 10000}))
    assert caught.value.key == "positions.pitches"
    assert caught.value.found == "10000 pitches of 8 positions"


def test_adaptive_positions_say_what_they_do_not_bound() -> None:
    """Regression: largest line loads had no error between them, silently."""
    errors = {"transmission_error_peak_to_peak": 0.03, "peak_line_load": 0.01}
    estimate = Estimate(errors, {"slices": errors}, {"peak_pressure": ON_CORNERS})
    found = estimate.as_dict(positions=PositionErrors(harmonics=0.1, peak_to_peak=0.04))
    assert found["transmission_error_peak_to_peak"] == pytest.approx(0.05, rel=ROUND_OFF)
    assert found["uncertain"] == {"peak_pressure": ON_CORNERS, "peak_line_load": BETWEEN}
