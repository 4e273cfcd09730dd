"""Cams and followers: tables, profile, motion, meshes, impossible cams, results, pictures."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

import flankload as fl
from flankload.bodies.cam.cam import _closed_spline
from flankload.bodies.cam.lever import Lever, lever_of
from flankload.cli import main
from flankload.elasticity.near_field import (
    mode_norms,
    mode_values,
    projected_logarithm,
)
from flankload.errors import SceneError
from flankload.mechanisms.flank_pair.assembly import build_bodies
from flankload.mechanisms.flank_pair.states import window_of
from flankload.meshes.plane_mesh import boundary_edges, jacobians
from flankload.pairing.body_pair import BodyPair
from flankload.pairing.cam_motion import CamContacts
from flankload.plot import plot_all, plot_follower_motion, plot_loaded_pair
from tests.support.cam_scenes import (
    ARM,
    CENTER_DISTANCE,
    DISC,
    ECCENTRICITY,
    FLAT_FOLLOWER,
    FLAT_OFFSET,
    ROLLER,
    ROLLER_FOLLOWER,
    cam_scene,
    disc,
    lift_and_dwell,
    waves,
)
from tests.support.paths import SCENES
from tests.support.solving import solve
from tests.support.tolerances import ROUND_OFF, SOLVER

EXAMPLE = SCENES / "cam.toml"

#: Curves of the core against the spline of the table, mm.
CURVE = 1e-9
#: Angle on a disc as a spline through a row every degree, rad; its normal is off by a thousand
#: times as much.
SPLINE = 1e-9
#: Results with the curve beginning elsewhere, which is then fitted to 1e-10 mm with other breaks.
BEGUN = 1e-8

STIFF = {"rigid": True}


def pair_of(*args: object, **keys: object) -> BodyPair:
    return build_bodies(fl.Scene.from_dict(cam_scene(*args, **keys)))


def contacts_of(pair: BodyPair, angles_deg: np.ndarray | None = None) -> CamContacts:
    motion = pair.pairing.motion
    assert motion is not None
    return motion.contacts(pair.position_rad if angles_deg is None else np.radians(angles_deg))


def refused(*args: object, **keys: object) -> str:
    with pytest.raises(SceneError) as caught:
        pair_of(*args, **keys)
    assert "\n" not in str(caught.value)
    return str(caught.value)


def without_load(profile: list, follower: dict | None = None, **keys: object) -> CamContacts:
    """Position of a rigid follower: no elements."""
    return contacts_of(pair_of(profile, {**(follower or {}), **STIFF}, STIFF, **keys, **NO_LOAD))


NO_LOAD = {"load": {"torque_Nm": 0.0}}

# --- profile ----------------------------------------------------------------------------------


def test_curve_is_the_periodic_spline_of_the_table() -> None:
    table = np.array(lift_and_dwell(5.0))
    curve = pair_of(table.tolist(), STIFF, STIFF, **NO_LOAD).body_2.curve
    spline = CubicSpline(
        np.radians(np.append(table[:, 0], 360.0)),
        np.append(table[:, 1], table[0, 1]),
        bc_type="periodic",
    )
    x, y = curve.point(np.linspace(0.0, curve.length_mm, 5001)).T
    radius = spline(np.arctan2(y, x) % (2 * np.pi))
    np.testing.assert_allclose(np.hypot(x, y), radius, rtol=0, atol=CURVE)
    speed = np.linalg.norm(curve.derivatives(np.linspace(0, curve.length_mm, 5001))[1], axis=1)
    np.testing.assert_allclose(speed, 1.0, rtol=0, atol=1e-7)
    assert curve.closed
    # clockwise, so that the material lies on the right
    area = 0.5 * np.sum(x[:-1] * y[1:] - x[1:] * y[:-1])
    assert area < 0
    normal = curve.normal(np.linspace(0, curve.length_mm, 50))
    place = curve.point(np.linspace(0, curve.length_mm, 50))
    assert ((normal * place).sum(axis=1) > 0).all()


def test_derivatives_of_a_profile_are_those_of_its_places() -> None:
    """They are compared between the rows, where the spline has third derivatives."""
    table, h = np.array(lift_and_dwell(5.0)), 1e-5
    place = _closed_spline(
        np.radians(np.append(table[:, 0], 360.0)), np.append(table[:, 1], table[0, 1])
    )
    angle = np.radians(table[:, 0] + 2.5)
    beside = [place(angle + side * h) for side in (-1, 1)]
    for k, found in enumerate(place(angle)[1:]):
        np.testing.assert_allclose(
            found, (beside[1][k] - beside[0][k]) / (2 * h), rtol=0, atol=1e-7 * table[:, 1].max()
        )


def test_a_row_that_closes_the_turn_changes_nothing() -> None:
    table = lift_and_dwell()
    one = pair_of(table, STIFF, STIFF, **NO_LOAD).body_2.curve
    two = pair_of([*table, [360.0, table[0][1]]], STIFF, STIFF, **NO_LOAD).body_2.curve
    np.testing.assert_array_equal(one.coefficients, two.coefficients)


@pytest.mark.parametrize("head", ["", "angle_deg, radius_mm\n", "# a cam\nangle_deg,radius_mm\n"])
def test_table_in_a_file_is_the_same(tmp_path: Path, head: str) -> None:
    rows = "".join(f"{a!r}, {r!r}\n" for a, r in disc())
    (tmp_path / "cam.csv").write_text(head + rows, encoding="utf-8")
    scene = cam_scene(None, STIFF, {"profile_file": "cam.csv", **STIFF}, **NO_LOAD)
    found = build_bodies(fl.Scene.from_dict(scene, file=tmp_path / "scene.toml")).body_2.curve
    inline = pair_of(disc(), STIFF, STIFF, **NO_LOAD).body_2.curve
    np.testing.assert_array_equal(found.coefficients, inline.coefficients)


@pytest.mark.parametrize(
    ("text", "line"),
    [
        (None, ("cam.toml: body_2.profile_file: expected a .csv file with the columns angle_deg, "
         "radius_mm, found no file cam.csv")),
        ("0,30\n5;30\n", ("cam.csv: line 2: expected 2 numbers: angle_deg, radius_mm, "
         "found '5;30'")),
        ("0,30\n5,nan\n", ("cam.csv: line 2: expected 2 numbers: angle_deg, radius_mm, "
         "found '5,nan'")),
        ("", "body_2.profile_file: expected 8 to 10000 rows of angle and radius, found 0"),
    ],
)  # fmt: skip
def test_file_that_is_no_table(tmp_path: Path, text: str | None, line: str) -> None:
    if text is not None:
        (tmp_path / "cam.csv").write_text(text, encoding="utf-8")
    scene = cam_scene(None, STIFF, {"profile_file": "cam.csv", **STIFF}, **NO_LOAD)
    with pytest.raises(SceneError) as caught:
        build_bodies(fl.Scene.from_dict(scene, file=tmp_path / "cam.toml"))
    assert str(caught.value).endswith(line)


def kinked(lift: float) -> list:
    table = np.array(disc())
    table[20, 1] += lift
    return table.tolist()


@pytest.mark.parametrize(
    ("profile", "line"),
    [
        (disc()[:7], "body_2.profile: expected 8 to 10000 rows of angle and radius, found 7"),
        ([*disc(), [360.0, 38.1]], ("body_2.profile: expected a periodic table, whose last row "
         "repeats the radius of the first, one turn later, found 38 mm at 0 deg and 38.1 mm at "
         "360 deg")),
        (disc()[:40], ("body_2.profile: expected rows at most 30 deg apart all around, found none "
         "between 195 and 360 deg")),
        ([*disc()[:9], *disc()[8:]], ("body_2.profile: expected ascending angles, found 40 deg "
         "behind 40 deg in row 10")),
        ([*disc(), [370.0, 30.0]], ("body_2.profile: expected angles within one turn, found 0 to "
         "370 deg")),
        (kinked(0.3), ("body_2.profile: expected a smooth profile, without kinks or cusps, whose "
         "rows follow its curvature, found a turn of 47.4 deg at the row of 100 deg")),
    ],
)  # fmt: skip
def test_table_that_is_no_profile(profile: list, line: str) -> None:
    assert refused(profile, STIFF, STIFF, **NO_LOAD) == line


# --- keys that do not go together ---------------------------------------------------------------


@pytest.mark.parametrize(
    ("follower", "cam", "line"),
    [
        ({}, {"bore_diameter_mm": 44.0}, ("body_2.bore_diameter_mm: expected at most 0.98 of twice "
         "the least radius of the profile: 43.1200, found 44")),
        ({}, {"profile_file": "x.csv", "profile": disc()}, ("body_2.profile: expected a table of "
         "angles and radii, here or in body_2.profile_file, found both")),
        ({}, {"profile": [[0.0, 30.0], [1.0]]}, ("body_2.profile[1]: expected a list of 2 numbers "
         "from -360 to 720, found [1.0]")),
        ({}, {"profile": 3.0}, "body_2.profile: expected a list of lists of 2 numbers, found 3.0"),
        ({"flat_to_mm": 3.0}, {}, ("body_1.flat_to_mm: expected nothing beside body_1.arm_mm: a "
         "follower has a roller or a flat, found 3")),
        ({"kind": "follower", "bore_diameter_mm": 16.0, "arm_mm": 70.0}, {},
         ("body_1.roller_radius_mm: expected a number: a follower has a roller (arm_mm, "
         "roller_radius_mm) or a flat (flat_offset_mm, flat_from_mm, flat_to_mm), found nothing")),
        ({"roller_radius_mm": 75.0}, {}, ("body_1.arm_mm: expected more than "
         "body_1.roller_radius_mm (75), found 70")),
        ({"hub_diameter_mm": 15.0}, {}, ("body_1.hub_diameter_mm: expected more than "
         "body_1.bore_diameter_mm (16), found 15")),
        ({"arm_width_mm": 19.0}, {}, ("body_1.arm_width_mm: expected 0.2 to 1.6 of "
         "body_1.roller_radius_mm (2 to 16), found 19")),
        ({"arm_width_mm": 15.0, "hub_diameter_mm": 17.0}, {}, ("body_1.hub_diameter_mm: expected "
         "at least 18.75, so that the hub holds the arm (y from -7.5 to 7.5 mm), found 17")),
        ({"arm_mm": 22.0}, {}, ("body_1.arm_mm: expected more than the radii of hub and roller "
         "together, 22.8, found 22")),
        ({**FLAT_FOLLOWER, "flat_from_mm": 15.0}, {}, ("body_1.flat_from_mm: expected at least "
         "22.1416, where the arm leaves the hub of radius 22.5, found 15")),
    ],
)  # fmt: skip
def test_keys_that_do_not_go_together(follower: dict, cam: dict, line: str) -> None:
    assert refused(None, follower, cam) == line


def test_a_cam_goes_with_a_follower_only() -> None:
    gear = {"kind": "gear", "teeth": 20, "module_mm": 3.0, "tip_diameter_mm": 66.0}
    scene = cam_scene()
    scene["body_2"] = {**gear, "bore_diameter_mm": 20.0}
    with pytest.raises(
        SceneError, match=r"expected 'cam' with body_1\.kind 'follower': the two go"
    ):
        fl.Scene.from_dict(scene)


def test_friction_on_a_cam_is_not_known() -> None:
    scene = cam_scene(effects={"friction_coefficient": 0.1})
    with pytest.raises(SceneError) as caught:
        fl.Scene.from_dict(scene)
    assert str(caught.value) == (
        "effects.friction_coefficient: expected nothing: this version has no friction between a "
        "cam and its follower, found a coefficient"
    )
    assert not fl.Scene.from_dict(cam_scene(effects={"friction_coefficient": 0})).has_friction


def test_a_cam_has_no_tooth_roots() -> None:
    with pytest.raises(SceneError) as caught:
        fl.Scene.from_dict(cam_scene(effects={"root_stress": True}))
    assert str(caught.value) == (
        "effects.root_stress: expected nothing: a cam and its follower have no tooth roots, "
        "found true"
    )


# --- impossible motions -------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("profile", "follower", "keys", "line"),
    [
        (disc(), {"arm_mm": 130.0}, {}, ("body_1.arm_mm: expected arm and roller that reach the "
         "cam, found none at a cam angle of 0.000 deg")),
        (disc(), {"arm_mm": 45.0}, {}, ("body_1.arm_mm: expected arm and roller that reach the "
         "cam, found none at a cam angle of 135.000 deg")),
        (disc(), {"arm_mm": 48.15}, {}, ("pair.center_distance_mm: expected a force line that "
         "stays off the follower's axis by 0.1 of the distance of the contact, found 5.6300 mm off "
         "at a contact 58.0932 mm from that axis at a cam angle of 180.000 deg")),
        (disc(), {"arm_mm": 110.0}, {}, ("body_1.arm_width_mm: expected an arm that leaves the "
         "roller free where it touches, found contact 14.60 deg from the arm's middle at a cam "
         "angle of 0.000 deg")),
        (disc(), {}, {"pair": {"center_distance_mm": 50.0, "face_width_mm": 12.0}},
         ("pair.center_distance_mm: expected more than the cam's largest radius 38.0000 and the "
         "follower's hub 12.8 together, found 50")),
        (waves(), {"roller_radius_mm": 44.0, "arm_mm": 75.0}, {}, ("body_1.roller_radius_mm: "
         "expected less than the least concave radius of the cam, 44.2178, found 44")),
        (disc(), {**FLAT_FOLLOWER, "flat_to_mm": 80.0}, {}, ("body_1.flat_to_mm: expected a flat "
         "that reaches over every place of contact, found a contact beyond its ends at a cam "
         "angle of 135.000 deg")),
        (disc(), {**FLAT_FOLLOWER, "flat_from_mm": 70.0}, {}, ("body_1.flat_to_mm: expected a flat "
         "that reaches over every place of contact, found a contact beyond its ends at a cam "
         "angle of 0.000 deg")),
    ],
)  # fmt: skip
def test_motion_that_cannot_be(profile: list, follower: dict, keys: dict, line: str) -> None:
    positions = {"count": 8}
    assert refused(profile, follower, positions=positions, **keys) == line


# --- motion -------------------------------------------------------------------------------------


def centre_of_disc(contacts: CamContacts) -> np.ndarray:
    turned = np.stack([np.cos(contacts.turn_2), np.sin(contacts.turn_2)], axis=1)
    return np.array([CENTER_DISTANCE, 0.0]) + ECCENTRICITY * turned


@pytest.mark.parametrize("sense", ["clockwise", "counter_clockwise"])
def test_angle_of_a_roller_on_an_eccentric_disc(sense: str) -> None:
    """Triangle of both axes and both centres; the disc turns as a crank."""
    angles = np.arange(0.0, 360.0, 11.0)
    pair = pair_of(disc(1.0), STIFF, {"sense": sense, **STIFF}, **NO_LOAD)
    contacts = contacts_of(pair, angles)
    turn = np.pi + np.radians(angles) * (-1 if sense == "clockwise" else 1)
    np.testing.assert_allclose(contacts.turn_2, turn, rtol=ROUND_OFF)
    centre = centre_of_disc(contacts)
    distance = np.hypot(*centre.T)
    sides = (distance**2 + ARM**2 - (DISC + ROLLER) ** 2) / (2 * distance * ARM)
    expected = np.arctan2(centre[:, 1], centre[:, 0]) - np.arccos(sides)
    np.testing.assert_allclose(contacts.turn_1, expected, rtol=0, atol=SPLINE)
    point, normal = contacts.contact()
    np.testing.assert_allclose(point, centre + DISC * normal, rtol=0, atol=1000 * SPLINE)


def test_angle_of_a_flat_on_an_eccentric_disc() -> None:
    contacts = without_load(disc(1.0), FLAT_FOLLOWER, positions={"count": 25})
    centre = centre_of_disc(contacts)
    # the centre of the disc is one radius above the line of the flat
    lifted = np.arcsin((FLAT_OFFSET + DISC) / np.hypot(*centre.T))
    expected = np.arctan2(centre[:, 1], centre[:, 0]) - lifted
    np.testing.assert_allclose(contacts.turn_1, expected, rtol=0, atol=SPLINE)


@pytest.mark.parametrize("follower", [{}, FLAT_FOLLOWER], ids=["roller", "flat"])
@pytest.mark.parametrize("sense", ["clockwise", "counter_clockwise"])
def test_rate_is_the_change_of_the_angle(follower: dict, sense: str) -> None:
    pair = pair_of(lift_and_dwell(), {**follower, **STIFF}, {"sense": sense, **STIFF}, **NO_LOAD)
    motion = pair.pairing.motion
    assert motion is not None
    position, step = np.radians(np.arange(3.0, 360.0, 7.0)), 1e-5
    before, after = (motion.contacts(position + d).turn_1 for d in (-step, step))
    rate, cam_rate = pair.pairing.speeds(position)
    assert (cam_rate == (1.0 if sense == "counter_clockwise" else -1.0)).all()
    np.testing.assert_allclose((after - before) / (2 * step), rate, rtol=0, atol=1e-7)
    assert np.ptp(rate) > 0.1


@pytest.mark.parametrize("follower", [{}, FLAT_FOLLOWER], ids=["roller", "flat"])
def test_follower_rests_where_it_first_touches(follower: dict) -> None:
    """With any hollows, no point of the cam lies inside the follower, and one lies on it."""
    pair = pair_of(waves(), {**follower, **STIFF}, STIFF, positions={"count": 37}, **NO_LOAD)
    contacts = contacts_of(pair)
    places = pair.body_2.curve.point(np.linspace(0, pair.body_2.curve.length_mm, 20001))
    for turn_1, turn_2 in zip(contacts.turn_1, contacts.turn_2, strict=True):
        c, s = np.cos(turn_2 - turn_1), np.sin(turn_2 - turn_1)
        axis = CENTER_DISTANCE * np.array([np.cos(turn_1), -np.sin(turn_1)])
        x, y = (places @ np.array([[c, s], [-s, c]]) + axis).T
        if follower:
            on = (x >= 35.0) & (x <= 115.0)
            clearance = (y - FLAT_OFFSET)[on]
        else:
            clearance = np.hypot(x - ARM, y) - ROLLER
        assert clearance.min() > -1e-9
        assert clearance.min() < 1e-5


def test_many_positions_are_looked_at_in_parts() -> None:
    pair = pair_of(disc(), STIFF, STIFF, positions={"count": 600}, **NO_LOAD)
    whole = contacts_of(pair)
    alone = contacts_of(pair, np.degrees(pair.position_rad[[0, 255, 256, 599]]))
    np.testing.assert_allclose(
        whole.turn_1[[0, 255, 256, 599]], alone.turn_1, rtol=0, atol=ROUND_OFF
    )


# --- results ------------------------------------------------------------------------------------


def solved(*args: object, by: Callable[..., Any] = solve, **keys: object) -> fl.Result:
    """Result of the pair; its cost by fl.solve."""
    result = by(fl.Scene.from_dict(cam_scene(*args, **keys)))
    assert isinstance(result, fl.Result)
    return result


def test_results_do_not_know_where_the_table_begins() -> None:
    """A rotated table rotates the results only, also at the start of the curve."""
    table = np.array(lift_and_dwell(5.0))
    angles = np.arange(0.0, 360.0, 22.5)
    keys: dict = {"positions": {"angles_deg": angles.tolist()}}
    expected = solved(table.tolist(), STIFF, **keys)
    begins = contacts_of(pair_of(table.tolist(), STIFF, STIFF, **keys, **NO_LOAD))
    for first in (1, 17, 44):
        turned = np.roll(table, -first, axis=0)
        off = turned[0, 0]
        turned[:, 0] = (turned[:, 0] - off) % 360.0
        positions = {"angles_deg": (angles - off).tolist()}
        found = solved(turned.tolist(), STIFF, positions=positions)
        np.testing.assert_allclose(
            found.rotation_rad, expected.rotation_rad, rtol=0, atol=CURVE / ARM
        )
        np.testing.assert_allclose(found.site_force_N, expected.site_force_N, rtol=BEGUN)
        np.testing.assert_allclose(
            found.peak_pressure_MPa, expected.peak_pressure_MPa, rtol=10 * BEGUN
        )
    assert np.ptp(begins.arc_length_mm) > 100.0


def test_contact_on_the_seam_is_like_any_other() -> None:
    """Cells lie on both sides of the place where the curve begins."""
    pair = pair_of(disc(), STIFF, STIFF, **NO_LOAD)
    motion = pair.pairing.motion
    assert motion is not None
    length = pair.body_2.curve.length_mm
    angles = np.linspace(0.0, 360.0, 721)
    s = motion.contacts(np.radians(angles)).arc_length_mm
    across = int(np.argmax(np.abs(np.diff(s)) > 0.5 * length))
    low, high = angles[across], angles[across + 1]
    for _ in range(50):
        middle = 0.5 * (low + high)
        same = (
            abs(motion.contacts(np.radians([middle])).arc_length_mm[0] - s[across]) < 0.5 * length
        )
        low, high = (middle, high) if same else (low, middle)
    found = solved(None, STIFF, positions={"angles_deg": [low - 0.1, low, high + 0.1]})
    places = found.pairs(1).arc_length_2_mm[found.pairs(1).force_N > 0]
    assert places.min() < 1.0
    assert places.max() > length - 1.0
    beside = found.peak_pressure_MPa[[0, 2], 0]
    assert found.peak_pressure_MPa[1, 0] == pytest.approx(beside.mean(), rel=1e-4)
    assert found.rotation_rad[1] == pytest.approx(found.rotation_rad[[0, 2]].mean(), rel=1e-5)


def test_a_cam_that_turns_back_passes_the_same_places() -> None:
    angles = [20.0, 75.0, 200.0]
    one = solved(lift_and_dwell(), STIFF, positions={"angles_deg": angles})
    two = solved(
        lift_and_dwell(),
        STIFF,
        cam={"sense": "counter_clockwise"},
        positions={"angles_deg": [-angle for angle in angles]},
    )
    np.testing.assert_allclose(one.rotation_rad, two.rotation_rad, rtol=SOLVER)
    np.testing.assert_allclose(one.site_force_N, two.site_force_N, rtol=SOLVER)


def test_curve_of_a_cam_goes_on_over_the_turn() -> None:
    """Regression: its one pair seemed to change from the last position to the first."""
    pair = build_bodies(fl.Scene.from_dict(cam_scene()))
    window = window_of(pair)
    assert window.closed
    assert not window.changes(np.ones((3, window.sites.size), dtype=bool)).any()


def test_a_dwell_is_a_position_like_any_other() -> None:
    """The follower rests, the force does not change."""
    result = solved(lift_and_dwell(), STIFF, positions={"angles_deg": [200.0, 230.0, 260.0]})
    assert result.follower_angle_rad is not None
    assert np.ptp(result.follower_angle_rad) < 1e-6
    np.testing.assert_allclose(result.site_force_N, result.site_force_N[0, 0], rtol=1e-4)


def test_unloaded_follower_lies_on_its_cam() -> None:
    result = solved(waves(), STIFF, STIFF, positions={"count": 24}, **NO_LOAD)
    np.testing.assert_allclose(result.rotation_rad, 0.0, rtol=0, atol=SOLVER)
    assert not result.site_force_N.any()


def test_rigid_bodies_cost_no_elements() -> None:
    result = solved(None, STIFF, positions={"count": 2}, by=fl.solve)
    assert result.cost["fe_factorisations"] == 1
    assert result.cost["fe_degrees_of_freedom"][0] == 0
    assert result.cost["unit_loads_normal"] == 41


def test_transmission_error_is_rotation_times_arm() -> None:
    result = solved(positions={"count": 2})
    np.testing.assert_allclose(
        result.transmission_error_um, 1000 * ARM * result.rotation_rad, rtol=ROUND_OFF
    )
    flat = pair_of(None, FLAT_FOLLOWER).body_1
    assert flat.reference_radius_mm == pytest.approx(np.hypot(FLAT_OFFSET, 75.0))


def test_result_has_the_angle_of_the_follower(tmp_path: Path) -> None:
    result = solved(positions={"count": 4})
    pair = pair_of(positions={"count": 4})
    turn = contacts_of(pair).turn_1
    assert result.has_cam
    np.testing.assert_array_equal(result.follower_angle_rad, turn)
    assert json.loads(result.to_json())["follower_angle_rad"] == turn.tolist()
    head, *rows = result.to_csv().splitlines()
    column = head.split(",").index("follower_angle_rad")
    assert [float(row.split(",")[column]) for row in rows] == turn.tolist()
    lines = result.table().splitlines()
    assert lines[0] == "scene: 60 N m, 4 positions over one turn of the cam"
    assert lines[2].split()[-3:] == ["follower", "force", "pressure"]
    assert float(lines[4].split()[4]) == pytest.approx(np.degrees(turn[0]), abs=1e-3)
    said = " ".join(lines)
    assert "mm per rad of the cam, for a roller that does not rotate" in said
    assert "coast flanks" not in said
    names = {path.name for path in plot_all(result, tmp_path)}
    assert names == {
        "transmission_error.png",
        "peak_pressure.png",
        "loaded_pair.png",
        "stiffness.png",
        "follower_motion.png",
    }


def test_gears_have_no_follower() -> None:
    result = fl.solve(fl.read_scene(EXAMPLE.parent / "external_gear.toml"))
    assert not result.has_cam
    assert "follower_angle_rad" not in json.loads(result.to_json())
    assert "follower_angle_rad" not in result.to_csv()
    with pytest.raises(ValueError, match="expected a follower on its cam, found none"):
        plot_follower_motion(result)


def test_picture_shows_both_bodies_and_the_motion() -> None:
    result = solved(positions={"count": 8}, name="cam")
    figure = plot_loaded_pair(result)
    (low_x, high_x), (low_y, high_y) = figure.axes[0].get_xlim(), figure.axes[0].get_ylim()
    assert low_x < -12.8
    assert high_x > CENTER_DISTANCE + DISC - ECCENTRICITY
    assert low_y < -DISC < DISC - ECCENTRICITY < high_y
    angle, turned = plot_follower_motion(result).axes[0].lines[0].get_data()
    assert angle[-1] == 360.0
    assert turned[-1] == turned[0]
    np.testing.assert_allclose(turned[:-1], np.degrees(result.follower_angle_rad))


def test_compliance_of_a_cam_is_not_written(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["compliance", str(EXAMPLE), "-o", str(tmp_path)]) == 2
    assert "body_2.kind: expected bodies with teeth" in capsys.readouterr().err


def test_check_says_what_was_understood(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["check", str(EXAMPLE)]) == 0
    out = capsys.readouterr().out
    assert "radii of the profile      28.0000 to 36.0000 mm" in out
    assert "teeth" not in out


# --- meshes and modes -----------------------------------------------------------------------------


@pytest.mark.parametrize(
    "follower",
    [
        {},
        {"arm_width_mm": 2.0},
        {"arm_width_mm": 16.0},
        {"roller_radius_mm": 30.0, "arm_mm": 95.0},
        {"hub_diameter_mm": 60.0},
        FLAT_FOLLOWER,
        {**FLAT_FOLLOWER, "flat_offset_mm": 12.0},
        {**FLAT_FOLLOWER, "arm_width_mm": 4.0},
        {**FLAT_FOLLOWER, "hub_diameter_mm": 69.9},
    ],
)
def test_follower_is_meshed_whole(follower: dict) -> None:
    scene = fl.Scene.from_dict(cam_scene(None, follower))
    spec = scene.body_1
    body = pair_of(None, follower).body_1 if "roller_radius_mm" not in follower else None
    if body is None:
        from flankload.bodies.cam.follower import build_follower

        body = build_follower(spec, "body_1", flank_element_mm=None, fineness=1.0)
    mesh = body.mesh
    assert mesh is not None
    ((kind, cells),) = mesh.cells
    assert (jacobians(mesh.nodes, kind, cells) > 0).all()
    lever: Lever = lever_of(spec, "body_1")
    assert enclosed(mesh.nodes, mesh.cells) == pytest.approx(area_of(lever), rel=1e-4)
    np.testing.assert_allclose(
        np.hypot(*mesh.nodes[mesh.fixed_nodes].T), 8.0, rtol=0, atol=ROUND_OFF * 8
    )
    (flank,) = mesh.flanks
    on = np.unique(flank.flank_edges)
    s = flank.flank_arc_length[on]
    assert s.min() == 0.0
    assert s.max() == pytest.approx(body.mode_range_mm[1], rel=ROUND_OFF)
    inside = s <= body.curve.length_mm
    np.testing.assert_allclose(
        body.curve.point(s[inside]), mesh.nodes[on][inside], rtol=0, atol=CURVE
    )


def enclosed(nodes: np.ndarray, cells: tuple) -> float:
    """Area between all boundaries of a mesh, with edges as parabolas."""
    first, last, middle = (nodes[column] for column in boundary_edges(cells).T)
    total = 0.0
    for t, weight in zip(*np.polynomial.legendre.leggauss(4), strict=True):
        place = first * t * (t - 1) / 2 + last * t * (t + 1) / 2 + middle * (1 - t * t)
        slope = first * (t - 0.5) + last * (t + 0.5) - 2 * t * middle
        total += weight * 0.5 * np.sum(place[:, 0] * slope[:, 1] - place[:, 1] * slope[:, 0])
    return float(total)


def area_of(lever: Lever) -> float:
    """Area of the contour of the lever without its bore."""
    from flankload.bodies.cam.follower import outline_of

    x, y = outline_of(lever, points=20001).T
    contour = 0.5 * np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y)
    return float(contour - np.pi * lever.bore_radius_mm**2)


@pytest.mark.parametrize("bore", [6.0, 20.0, 42.0])
def test_cam_is_meshed_whole(bore: float) -> None:
    body = pair_of(None, STIFF, {"bore_diameter_mm": bore}).body_2
    mesh = body.mesh
    assert mesh is not None
    ((kind, cells),) = mesh.cells
    assert (jacobians(mesh.nodes, kind, cells) > 0).all()
    expected = np.pi * (DISC**2 - bore**2 / 4)
    assert enclosed(mesh.nodes, mesh.cells) == pytest.approx(expected, rel=1e-6)
    (flank,) = mesh.flanks
    assert len(np.unique(flank.flank_edges)) == 2 * len(flank.flank_edges)


def test_logarithm_of_the_chord_is_projected_in_closed_form() -> None:
    """Compared with a double sum over a turn, with the mean over the cell at the singular point."""
    n, length, modes = 4000, 50.0, 9
    s = (np.arange(n) + 0.5) * length / n
    chord = length / np.pi * np.sin(np.pi * np.arange(1, n) / n)
    row = np.concatenate([[np.log(0.5 * length / n) - 1.0], np.log(chord)])
    values = mode_values(s, (0.0, length), modes, closed=True)
    spread = np.fft.ifft(np.fft.fft(row)[:, None] * np.fft.fft(values, axis=0), axis=0).real
    found = values.T @ spread * (length / n) ** 2
    expected = projected_logarithm(modes, length, closed=True)
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-4 * np.abs(expected).max())
    norms = values.T @ values * length / n
    expected_norms = np.diag(mode_norms((0.0, length), modes, closed=True))
    np.testing.assert_allclose(norms, expected_norms, rtol=0, atol=SOLVER)


def test_roller_follower_of_the_tests_is_the_example() -> None:
    """The example stays near the cases that are checked here."""
    scene = fl.read_scene(EXAMPLE)
    assert scene.body_1.arm_mm == ROLLER_FOLLOWER["arm_mm"]
    assert scene.positions.count == 72
