"""Splines: tables, geometry, position zero, impossible assemblies, words and pictures."""

from __future__ import annotations

import re
from math import cos, pi, radians
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import flankload as fl
from flankload.errors import SceneError
from flankload.mechanisms.flank_pair.assembly import build_bodies
from flankload.mechanisms.flank_pair.premises import coast_overlap_um
from flankload.pairing.body_pair import BodyPair
from flankload.pairing.spline_fit import describe_fit
from flankload.plot import plot_all, plot_flank_pressure, plot_load_per_tooth, plot_loaded_pair
from tests.support.paths import SCENES
from tests.support.solving import solve
from tests.support.tolerances import ROUND_OFF, SOLVER

EXAMPLE = SCENES / "spline.toml"
SHAFT = {
    "kind": "spline_shaft",
    "teeth": 24,
    "module_mm": 2.0,
    "tip_diameter_mm": 49.6,
    "root_diameter_mm": 45.2,
    "bore_diameter_mm": 20.0,
}
HUB = {
    "kind": "spline_hub",
    "teeth": 24,
    "module_mm": 2.0,
    "profile_shift": 0.02,
    "tip_diameter_mm": 46.2,
    "root_diameter_mm": 50.8,
    "outer_diameter_mm": 75.0,
}
GEAR = {
    "kind": "gear",
    "teeth": 24,
    "module_mm": 2.0,
    "tip_diameter_mm": 52.0,
    "bore_diameter_mm": 20.0,
}
BASE_RADIUS = 24 * cos(radians(30))

#: Pixels of overlap, and places on a curve, of pictures.
DRAWN = 1e-9


def scene(
    shaft: dict | None = None, hub: dict | None = None, pair: dict | None = None, **keys: object
) -> fl.Scene:
    return fl.Scene.from_dict(
        {
            "body_1": {**SHAFT, **(shaft or {})},
            "body_2": {**HUB, **(hub or {})},
            "pair": {"face_width_mm": 30.0, **(pair or {})},
            "load": {"torque_Nm": 1500.0},
            **keys,
        }
    )


def pair(*args: dict, **keys: object) -> BodyPair:
    return build_bodies(scene(*args, **keys))  # type: ignore[arg-type]


def refused(*args: dict, **keys: object) -> SceneError:
    with pytest.raises(SceneError) as caught:
        pair(*args, **keys)
    assert "\n" not in str(caught.value)
    return caught.value


# --- tables -----------------------------------------------------------------------------------


def test_dedendum_of_the_rack_follows_from_the_root_circle() -> None:
    shaft = pair({"profile_shift": 0.01}).body_1
    assert shaft.root_radius_mm == pytest.approx(22.6, rel=ROUND_OFF)
    assert scene({"profile_shift": 0.01}).body_1.dedendum_factor == pytest.approx(0.71, rel=1e-12)


def test_root_fillet_of_a_hub_is_a_part_of_the_module() -> None:
    given = pair({}, {"root_fillet_radius_mm": 0.32}).body_2.curve
    absent = pair().body_2.curve
    np.testing.assert_allclose(absent.breaks, given.breaks, rtol=ROUND_OFF)


@pytest.mark.parametrize(
    ("one", "two"),
    [(SHAFT, {**HUB, "kind": "ring"}), (GEAR, HUB), (SHAFT, GEAR)],
    ids=["shaft in a ring", "gear in a hub", "shaft beside a gear"],
)
def test_shaft_and_hub_go_together(one: dict, two: dict) -> None:
    with pytest.raises(SceneError) as caught:
        fl.Scene.from_dict(
            {
                "body_1": one,
                "body_2": two,
                "pair": {"center_distance_mm": 50.0, "face_width_mm": 30.0},
                "load": {"torque_Nm": 100.0},
            }
        )
    assert str(caught.value) == (
        "body_2.kind: expected 'spline_hub' with body_1.kind 'spline_shaft': the two go together "
        f"and with no other, found '{two['kind']}' with body_1.kind '{one['kind']}'"
    )


def test_axes_follow_from_one_key_or_the_other() -> None:
    error = refused(pair={"center_distance_mm": 1.0})
    assert error.key == "pair.center_distance_mm"
    assert "pair.center_offset_mm" in error.expected
    with pytest.raises(SceneError) as caught:
        fl.Scene.from_dict(
            {
                "body_1": GEAR,
                "body_2": GEAR,
                "pair": {"center_offset_mm": 0.1, "face_width_mm": 30.0},
                "load": {"torque_Nm": 100.0},
            }
        )
    assert caught.value.key == "pair.center_offset_mm"
    assert "pair.center_distance_mm" in caught.value.expected


def test_common_axes_have_one_position() -> None:
    silent, asked = pair(), pair(positions={"count": 8})
    assert silent.position_rad.size == asked.position_rad.size == 1
    assert silent.notes == ()
    (note,) = asked.notes
    assert note.startswith("on a common axis all positions are equal: one is computed instead of 8")
    assert pair(positions={"angles_deg": [0, 5]}).position_rad.size == 2
    apart = pair(pair={"center_offset_mm": 0.01})
    assert apart.position_rad.size == 32
    assert apart.closed


# --- pairing ----------------------------------------------------------------------------------


def test_flanks_without_errors_lie_on_each_other() -> None:
    """At every radius between the tips both flanks are at the same angle, on every tooth."""
    found = pair()
    turns = found.pairing.turns(np.array([0.3]))
    radius = np.linspace(23.15, 24.75, 9)
    one, two = (
        [body.involute.polar_angle_at(r) + turn[0] for r in radius]
        for body, turn in zip((found.body_1, found.body_2), turns, strict=True)
    )
    np.testing.assert_allclose(one, two, rtol=0, atol=ROUND_OFF)
    angles = found.pairing.site_angles_rad
    np.testing.assert_array_equal(*angles)
    np.testing.assert_allclose(np.diff(angles[0]), 2 * pi / 24, rtol=ROUND_OFF * 24)
    assert found.pairing.whole_circle
    # tooth 0 is on the line of centres
    assert found.pairing.turns_at_zero_rad[0] == 0.0


def test_unloaded_spline_touches_without_turning_or_at_the_highest_tooth() -> None:
    without = solve(scene(load={"torque_Nm": 0.0}))
    np.testing.assert_allclose(without.transmission_error_um, 0.0, atol=5e-6)
    errors = 24 * [0.0]
    errors[5] = 3.0
    for where in ({"pitch_errors_um": errors}, None), (None, {"pitch_errors_um": errors}):
        found = solve(scene(*where, load={"torque_Nm": 0.0}))
        # along the base tangent; the result counts on the pitch circle
        expected = -3.0 * 24 / BASE_RADIUS
        np.testing.assert_allclose(found.transmission_error_um, expected, rtol=0, atol=5e-6)


def test_entry_j_of_the_errors_is_tooth_j() -> None:
    errors = [0.0, 0.0, 20.0] + 21 * [0.0]
    for where in ({"pitch_errors_um": errors}, None), (None, {"pitch_errors_um": errors}):
        found = solve(
            scene(*where, load={"torque_Nm": 20.0}, accuracy={"estimate": False, "tangents": False})
        )
        assert found.loaded_pairs.tolist() == [1]
        assert found.sites[np.argmax(found.site_force_N[0])] == 2


def test_check_says_how_they_fit() -> None:
    rows = dict(describe_fit(pair().pairing.fit))
    assert rows["active flank between"] == "46.2000 and 49.6000 mm"
    # 4 x m tan(alpha) on the pitch circle
    backlash = 2 * 0.02 * 2.0 * np.tan(radians(30))
    assert rows["backlash on the pitch circle"] == f"{backlash:.4f} mm"


def test_offset_beyond_the_backlash_is_said() -> None:
    assert pair(pair={"center_offset_mm": 0.01}).notes == ()
    (note,) = pair(pair={"center_offset_mm": 0.03}).notes
    assert re.search(r"normal backlash of 40\.0 um .* offset of 30\.0 um", note)


def test_twice_the_offset_is_taken_off_the_backlash() -> None:
    """With a backlash of 40 um, coast flanks stay apart at an offset of 10 um, but not of 30 um."""
    coast = SimpleNamespace(gap_rad=np.array([0.0, -1e-3]), base_radius_mm=BASE_RADIUS)
    still = SimpleNamespace(torque_Nmm=0.0, tangent_rad_per_Nmm=np.zeros(2), rotation_rad=0.0)
    for offset, overlap in ((0.01, 0.0), (0.03, BASE_RADIUS)):
        found = coast_overlap_um(
            pair(pair={"center_offset_mm": offset}),
            SimpleNamespace(coast=coast),  # type: ignore[arg-type]
            still,  # type: ignore[arg-type]
        )
        assert found == pytest.approx(overlap, rel=ROUND_OFF)


# --- impossible assemblies --------------------------------------------------------------------


@pytest.mark.parametrize(
    ("shaft", "hub", "key", "says"),
    [
        ({}, {"teeth": 25}, "body_2.teeth", "expected 24, as in body_1.teeth, found 25"),
        (
            {},
            {"module_mm": 2.1, "root_diameter_mm": 53.0, "tip_diameter_mm": 49.0},
            "body_2.module_mm",
            "expected 2, as in body_1.module_mm, found 2.1",
        ),
        (
            {},
            {"pressure_angle_deg": 20},
            "body_2.pressure_angle_deg",
            "expected 30, as in body_1.pressure_angle_deg, found 20",
        ),
        ({"profile_shift": 0.05}, {}, "body_1.profile_shift", "at most that of body_2"),
        (
            {"tip_diameter_mm": 50.9},
            {},
            "body_1.tip_diameter_mm",
            "less than 50.8000, where the tip clears the root circle of body_2, found 50.9",
        ),
        ({}, {"tip_diameter_mm": 45.1}, "body_2.tip_diameter_mm", "more than 45.2000"),
        (
            {},
            {"tip_diameter_mm": 45.4},
            "body_2.tip_diameter_mm",
            "clears the root fillet of body_1",
        ),
        (
            {"tip_diameter_mm": 50.7},
            {},
            "body_1.tip_diameter_mm",
            "clears the root fillet of body_2",
        ),
        ({"tip_diameter_mm": 46.1}, {}, "body_1.tip_diameter_mm", "flanks lie on each other"),
        ({"tip_diameter_mm": 54.0}, {}, "body_1.tip_diameter_mm", "where the teeth are pointed"),
        ({}, {"root_diameter_mm": 60.0}, "body_2.root_diameter_mm", "where the spaces are pointed"),
        ({}, {"tip_diameter_mm": 41.0}, "body_2.tip_diameter_mm", "base diameter 41.5692"),
        ({"bore_diameter_mm": 45.5}, {}, "body_1.bore_diameter_mm", "root diameter 45.2000"),
        ({"root_diameter_mm": 49.8}, {}, "body_1.root_diameter_mm", "less than 48.0000"),
        ({"root_diameter_mm": 42.0}, {}, "body_1.root_diameter_mm", "more than 42.5586"),
        ({}, {"root_fillet_radius_mm": 3.0}, "body_2.root_fillet_radius_mm", "at most"),
        ({}, {"outer_diameter_mm": 50.0}, "body_2.outer_diameter_mm", "the teeth of a hub"),
    ],
    ids=lambda value: "" if isinstance(value, dict) else None,
)
def test_splines_that_cannot_be_assembled_get_one_line(
    shaft: dict, hub: dict, key: str, says: str
) -> None:
    error = refused(shaft, hub)
    assert error.key == key
    assert says in str(error)


def test_offset_eats_the_clearance_of_tips() -> None:
    error = refused(pair={"center_offset_mm": 0.55})
    assert error.key == "body_2.tip_diameter_mm"
    assert "on an offset of 0.55 mm" in str(error)


# --- words and pictures -----------------------------------------------------------------------


@pytest.fixture(scope="module")
def example() -> fl.Result:
    return solve(fl.read_scene(EXAMPLE))


def test_every_tooth_is_in_the_result(example: fl.Result) -> None:
    np.testing.assert_array_equal(example.sites, np.arange(24))
    np.testing.assert_array_equal(example.loaded_pairs, (example.site_force_N > 0).sum(axis=1))
    assert 1 < example.loaded_pairs[0] < 24
    text = example.table()
    assert f"{example.loaded_pairs[0]} of 24 teeth carry" in text
    assert "load per tooth at 0.000 deg" in text
    table = [line for line in text.splitlines() if not line.startswith("warning  ")]
    rows = "\n".join(table).split("transmission error  ")[0].splitlines()
    assert max(map(len, rows)) <= 110


def test_common_axes_leave_no_pitch_out(example: fl.Result) -> None:
    """Regression: a period of 24 pitches was reported, although the same teeth always meet."""
    assert example.warnings == ()


def test_force_and_moment_of_the_example(example: fl.Result) -> None:
    """On an involute every force has the base radius as its lever, at the rounded edges, too."""
    moment = example.site_force_N[0].sum() * BASE_RADIUS
    np.testing.assert_allclose(moment, 1500e3, rtol=1e-5)
    assert example.reference_radius_mm == pytest.approx(24.0, rel=ROUND_OFF)
    np.testing.assert_allclose(
        example.transmission_error_um, 24e3 * example.rotation_rad, rtol=SOLVER
    )


def test_pictures_of_a_spline(example: fl.Result, tmp_path: Path) -> None:
    names = [path.name for path in plot_all(example, tmp_path)]
    assert names == ["load_per_tooth.png", "flank_pressure.png", "loaded_pair.png"]
    bars = plot_load_per_tooth(example).axes[0].patches
    heights = [bar.get_height() for bar in bars]
    np.testing.assert_allclose(heights, example.site_force_N[0] / 1e3, rtol=DRAWN)
    line = plot_flank_pressure(example).axes[0].lines[0]
    assert line.get_ydata().max() == pytest.approx(
        example.peak_pressure_MPa[0, np.argmax(example.site_force_N[0])], rel=0.02
    )
    # shaft, hub and a bar for each tooth that carries
    assert len(plot_loaded_pair(example).axes[0].patches) == 2 + example.loaded_pairs[0]


def test_pictures_of_a_spline_on_an_offset(tmp_path: Path) -> None:
    result = solve(
        scene(
            pair={"center_offset_mm": 0.01},
            positions={"count": 2},
            load={"torque_Nm": 0.0},
            accuracy={"estimate": False, "tangents": False},
        )
    )
    names = {path.stem for path in plot_all(result, tmp_path)}
    assert len(names) == 5
    assert {"load_per_tooth", "transmission_error", "load_map"} < names
    assert "of 24 teeth carry" in result.table()
