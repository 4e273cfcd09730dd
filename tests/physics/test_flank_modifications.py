"""Modified flanks without load and with little load, against geometry alone."""

from __future__ import annotations

import tomllib
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import brentq, minimize_scalar

import flankload as fl
from flankload.bodies.profile.gear_profile import gear_profile
from flankload.bodies.profile.gear_tip import modifications_of
from flankload.bodies.profile_deviation import profile_deviation
from flankload.mechanisms.flank_pair.assembly import build_bodies
from flankload.scene import Gear
from tests.support.solving import solve

#: Flank curves are within 1e-10 mm of the exact profile; tolerance of results that follow.
GEOMETRY_MM = 1e-9

ONE = {
    "kind": "gear",
    "teeth": 16,
    "module_mm": 4.5,
    "profile_shift": 0.182,
    "tip_diameter_mm": 82.46,
    "bore_diameter_mm": 30,
}
TWO = {**ONE, "teeth": 24, "profile_shift": 0.171, "tip_diameter_mm": 118.36}
DISTANCE = 91.5

MODIFICATIONS = {
    "linear": {"tip_relief_um": 30, "tip_relief_start_diameter_mm": 74},
    "parabolic": {
        "tip_relief_um": 30,
        "tip_relief_start_diameter_mm": 72,
        "tip_relief_shape": "parabolic",
    },
    "crowned": {"profile_crowning_um": 12},
    "crowned and relieved": {
        "profile_crowning_um": 8,
        "tip_relief_um": 20,
        "tip_relief_start_diameter_mm": 79,
    },
}


def scene(
    one: dict | None = None, two: dict | None = None, *, torque: float = 0, **tables: dict
) -> fl.Scene:
    return fl.Scene.from_dict(
        {
            "body_1": {**ONE, **(one or {})},
            "body_2": {**TWO, **(two or {})},
            "pair": {"center_distance_mm": DISTANCE, "face_width_mm": 14},
            "load": {"torque_Nm": torque},
            "positions": {"count": 12},
            "accuracy": {"estimate": False, "tangents": False},
            **tables,
        }
    )


def solved(*args: dict | None, **keys: object) -> fl.Result:
    result = solve(scene(*args, **keys))  # type: ignore[arg-type]
    assert isinstance(result, fl.Result)
    return result


# --- the deviation itself -------------------------------------------------------------------------
@pytest.mark.parametrize("keys", MODIFICATIONS.values(), ids=MODIFICATIONS)
def test_deviation_of_the_curve_is_the_metal_removed_by_the_keys(keys: dict) -> None:
    body = build_bodies(scene(keys)).body_1
    found = profile_deviation(body)
    assert found is not None
    assert body.involute is not None
    spec = Gear(**{name: value for name, value in {**ONE, **keys}.items() if name != "kind"})
    form = body.involute.roll_at(body.involute.form_radius_mm)
    off, _, _ = modifications_of(spec, body.involute, form, "body_1").at(
        found.roll_length_mm / found.base_radius_mm
    )
    np.testing.assert_allclose(found.deviation_um, -1000 * off, rtol=0, atol=1000 * GEOMETRY_MM)
    assert off.max() > 5e-3


def test_plain_flank_deviates_by_nothing() -> None:
    for body in (build_bodies(scene()).body_1, build_bodies(scene()).body_2):
        found = profile_deviation(body)
        assert found is not None
        np.testing.assert_allclose(found.deviation_um, 0.0, rtol=0, atol=1000 * GEOMETRY_MM)
        assert [name for name, _ in found.marks] == ["form", "tip"]


def test_marks_are_where_the_keys_place_them() -> None:
    relief = {"tip_relief_um": 30, "tip_relief_start_diameter_mm": 79}
    for tip, name in (
        ({"tip_radius_mm": 0.3}, "tip rounding"),
        ({"tip_chamfer_mm": 0.3}, "tip chamfer"),
    ):
        found = profile_deviation(build_bodies(scene({**relief, **tip})).body_1)
        assert found is not None
        marks = dict(found.marks)
        assert list(marks) == ["form", "relief", name, "tip"]
        diameter = {k: 2 * np.hypot(found.base_radius_mm, place) for k, place in marks.items()}
        assert diameter["relief"] == pytest.approx(79.0, abs=1e-6)
        assert diameter["tip"] == pytest.approx(82.46, abs=1e-9)
        assert marks[name] == pytest.approx(found.roll_length_mm[-1], abs=1e-6)


def test_relief_of_a_ring_takes_metal_off() -> None:
    """Its tip lies at the shorter end of the roll length; relief and crowning count as missing."""
    tables = tomllib.loads(Path("examples/scenes/internal_gear.toml").read_text(encoding="utf-8"))
    start = tables["body_2"]["tip_diameter_mm"] + tables["body_2"]["module_mm"]
    relief = {"tip_relief_um": 30, "tip_relief_start_diameter_mm": start}
    tables["body_2"] |= relief
    for tip in ("tip_radius_mm", "tip_chamfer_mm"):
        tables["body_1"].pop(tip, None)
        tables["body_2"].pop(tip, None)
    tables["load"] = {"torque_Nm": 0}
    result = solve(fl.Scene.from_dict(tables))
    assert isinstance(result, fl.Result)
    found = result.drawing.profiles[1]
    assert found is not None
    assert (np.diff(found.roll_length_mm) > 0).all()
    assert found.deviation_um[0] == pytest.approx(-30.0, rel=0.02)
    assert [name for name, _ in sorted(found.marks, key=lambda m: m[1])] == [
        "tip",
        "relief",
        "form",
    ]
    active_1, active_2 = result.drawing.active_roll_mm
    assert active_1 is not None
    assert active_2 is not None
    # what rolls off on one flank rolls off on the other, from the ring's tip to the pinion's
    assert active_1[1] - active_1[0] == pytest.approx(active_2[1] - active_2[0], rel=1e-12)
    assert active_2[0] == found.roll_length_mm[0]
    mesh = build_bodies(fl.Scene.from_dict(tables)).pairing.gear_geometry
    assert mesh is not None
    path = mesh.path_end_mm - mesh.path_start_mm
    assert active_1[1] - active_1[0] == pytest.approx(path, abs=0.2)


def test_active_profile_is_the_path_of_contact_of_plain_flanks() -> None:
    result, mesh = solved(), build_bodies(scene()).pairing.gear_geometry
    assert mesh is not None
    for active in result.drawing.active_roll_mm:
        assert active is not None
        length = mesh.path_end_mm - mesh.path_start_mm
        assert active[1] - active[0] == pytest.approx(length, abs=1e-6)


# --- without load ---------------------------------------------------------------------------------
def first_touch_mm(keys: dict, position_rad: float) -> float:
    """How far body 1 turns until its modified flank touches the plain involute of the mate.

    By the string construction alone: a place Q of flank 1, seen from O2, lies beyond the involute
    of body 2 by r_b2 (angle of its string) - length of its string. The least of it over the flanks
    of body 1 is zero where the bodies touch.
    """
    pair = build_bodies(scene(keys))
    one, two = pair.body_1.involute, pair.body_2.involute
    assert one is not None
    assert two is not None
    spec = Gear(**{name: value for name, value in {**ONE, **keys}.items() if name != "kind"})
    profile = gear_profile(spec, "body_1")
    form = one.roll_at(one.form_radius_mm)
    modifications = modifications_of(spec, one, form, "body_1")
    ratio = ONE["teeth"] / TWO["teeth"]
    step = 2 * np.pi / ONE["teeth"]
    turn_1, turn_2 = pair.pairing.turns_at_zero_rad
    turn_2 -= position_rad * ratio

    def beyond(roll: np.ndarray, site: int, rotation: float) -> np.ndarray:
        """Distance of places of flank 1 from the mate's flank along the mate's normal, mm."""
        off = modifications.at(roll)[0]
        angle = one.base_half_angle_rad - roll + turn_1 + position_rad + rotation + site * step
        length = one.base_radius_mm * roll - off
        x = one.base_radius_mm * np.cos(angle) - length * np.sin(angle) - DISTANCE
        y = one.base_radius_mm * np.sin(angle) + length * np.cos(angle)
        radius = np.hypot(x, y)
        string = np.sqrt(np.maximum(radius**2 - two.base_radius_mm**2, 0.0))
        polar = np.arctan2(y, x) - turn_2 + site * step * ratio
        polar = (polar + np.pi) % (2 * np.pi) - np.pi
        unwound = two.base_half_angle_rad - polar + np.arctan(string / two.base_radius_mm)
        there = (radius >= two.form_radius_mm) & (radius <= two.tip_radius_mm)
        return np.where(there, string - two.base_radius_mm * unwound, 1.0)

    end = profile.involute.roll_at(one.tip_radius_mm)
    grid = np.linspace(form, end, 400)

    def least(rotation: float) -> float:
        found = 1.0
        for site in (-1, 0, 1):
            values = beyond(grid, site, rotation)
            k = int(values.argmin())
            if values[k] >= 1.0:
                continue
            low, high = grid[max(k - 1, 0)], grid[min(k + 1, grid.size - 1)]
            best = minimize_scalar(
                lambda roll, site=site: float(beyond(np.array([roll]), site, rotation)[0]),
                bounds=(low, high),
                method="bounded",
                options={"xatol": 1e-12},
            )
            found = min(found, float(values[k]), float(best.fun))
        return found

    start, stop = -1e-4, 2e-3
    return float(one.base_radius_mm * brentq(least, start, stop, xtol=1e-15, rtol=1e-14))


@pytest.mark.parametrize("keys", MODIFICATIONS.values(), ids=MODIFICATIONS)
def test_unloaded_transmission_error_is_the_geometric_deviation(keys: dict) -> None:
    """Over a whole period; the mate's corner, which the construction does not know, stays free."""
    count = 9
    angles = np.linspace(-11.0, 11.0, count)
    found = solved(keys, positions={"angles_deg": angles.tolist()})
    expected = [first_touch_mm(keys, angle) for angle in np.radians(angles)]
    assert max(expected) > 1e-3
    np.testing.assert_allclose(
        found.transmission_error_um / 1000, expected, rtol=0, atol=GEOMETRY_MM
    )


def test_small_torque_goes_to_the_unloaded_transmission_error() -> None:
    """The difference vanishes with the torque, a little slower due to Hertz contact."""
    keys = MODIFICATIONS["crowned"]
    unloaded = solved(keys).rotation_rad
    torques = [1e-1, 1e-3, 1e-5]
    away = [np.abs(solved(keys, torque=t).rotation_rad - unloaded).max() for t in torques]
    slopes = np.diff(np.log(away)) / np.diff(np.log(torques))
    assert (slopes > 0.85).all()
    assert (slopes < 1.0).all()


def test_centre_distance_error_leaves_involutes_conjugate() -> None:
    """Only backlash, working angle and contact ratio change; without load the transmission error
    stays zero, and the mating flanks have moved apart by the backlash alone."""
    ratios = []
    for error in (-0.02, 0.0, 0.1, 0.4):
        pair = {"center_distance_mm": DISTANCE + error + 0.05, "face_width_mm": 14}
        found = solved(pair=pair)
        np.testing.assert_allclose(
            found.transmission_error_um / 1000, 0.0, rtol=0, atol=GEOMETRY_MM
        )
        mesh = build_bodies(scene(pair=pair)).pairing.gear_geometry
        assert mesh is not None
        ratios.append((mesh.backlash_mm, mesh.contact_ratio))
    backlash, contact_ratio = np.array(ratios).T
    assert (np.diff(backlash) > 0).all()
    assert (np.diff(contact_ratio) < 0).all()


# --- with load ------------------------------------------------------------------------------------
def relieved(side: str) -> tuple[dict, dict]:
    one = {"tip_relief_um": 300, "tip_relief_start_diameter_mm": 79.5}
    two = {"tip_relief_um": 300, "tip_relief_start_diameter_mm": 115.6}
    return (one if "1" in side else {}), (two if "2" in side else {})


def site_forces(result: fl.Result) -> dict[int, np.ndarray]:
    return {int(site): result.site_force_N[:, s] for s, site in enumerate(result.sites)}


def test_pair_relieved_by_more_than_its_deflection_does_not_touch() -> None:
    """Both tips relieved by 300 um: where one pair has not yet come to its relief, it is alone.

    Where the path of contact is free of relief on both flanks, the deviation of any second pair is
    read from the profile and exceeds the deflection of the bodies.
    """
    one, two = relieved("12")
    torque = 50.0
    found, plain = solved(one, two, torque=torque), solved(torque=torque)
    yielded = plain.transmission_error_um.max()
    assert (found.status >= 0).all()
    pair = build_bodies(scene(one, two))
    profiles = [profile_deviation(pair.body_1), profile_deviation(pair.body_2)]
    mesh = pair.pairing.gear_geometry
    assert mesh is not None
    alone = 0
    for p, position in enumerate(found.position_rad):
        deviation = {}
        for site in (-2, -1, 0, 1, 2):
            along = mesh.base_pitch_mm * (site + position / found.period_rad)
            if not mesh.path_start_mm < along < mesh.path_end_mm:
                continue
            tangent = np.tan(mesh.pressure_angle_rad)
            lengths = [
                profiles[0].base_radius_mm * tangent + along,
                profiles[1].base_radius_mm * tangent - along,
            ]
            deviation[site] = -sum(
                np.interp(length, profile.roll_length_mm, profile.deviation_um)
                for length, profile in zip(lengths, profiles, strict=True)
            )
        free = [site for site, value in deviation.items() if value < 1e-6]
        late = [site for site, value in deviation.items() if value > 1.5 * yielded]
        if not free:
            continue
        for site in late:
            force = site_forces(found).get(site)
            assert force is None or force[p] == 0.0
            assert site_forces(plain)[site][p] > 0.0
            alone += 1
    assert alone >= 2


@pytest.mark.parametrize("side", ["1", "2"])
@pytest.mark.parametrize("sign", [1, -1])
def test_tooth_set_back_by_more_than_the_deflection_does_not_touch(side: str, sign: int) -> None:
    """Pair -1 by its pitch error: 200 um back it never carries, 200 um early it carries alone."""
    errors = [0.0] * (16 if side == "1" else 24)
    errors[1] = -200.0 * sign
    keys = {"pitch_errors_um": errors}
    both = {"angles_deg": [10.0, 11.0, 12.0]}
    bodies = (keys,) if side == "1" else (None, keys)
    # a tooth that is so early takes up the backlash
    beyond = {"beyond_limits": True}
    found = solved(*bodies, torque=302, positions=both, effects=beyond)
    plain = site_forces(solved(torque=302, positions=both))
    assert (plain[-1] > 0).all()
    assert (plain[0] > 0).all()
    silent, loud = (-1, 0) if sign > 0 else (0, -1)
    forces = site_forces(found)
    assert (forces.get(silent, np.zeros(3)) == 0).all()
    assert (forces[loud] > 0).all()
