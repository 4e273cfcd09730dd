"""A gear inside a ring: working geometry, position zero, and pairs that cannot mesh."""

from __future__ import annotations

import re
from math import acos, cos, pi, radians, sqrt, tan

import numpy as np
import pytest

import flankload as fl
from flankload.errors import SceneError
from flankload.mechanisms.flank_pair.assembly import build_bodies
from flankload.pairing.body_pair import BodyPair
from flankload.pairing.gear_pair import describe_gears
from tests.support.gear_scenes import usable_contact_ratio
from tests.support.random_scenes import inv
from tests.support.tolerances import SOLVER

PINION = {
    "kind": "gear",
    "teeth": 24,
    "module_mm": 3.0,
    "tip_diameter_mm": 78.0,
    "bore_diameter_mm": 35.0,
}
RING = {
    "kind": "ring",
    "teeth": 60,
    "module_mm": 3.0,
    "tip_diameter_mm": 175.2,
    "root_diameter_mm": 187.5,
    "outer_diameter_mm": 220.0,
    "rigid": True,
}
#: A pinion with almost as many teeth as the ring: the tips collide on their way out of the mesh.
NEAR = {"teeth": 54, "tip_diameter_mm": 168.0, "bore_diameter_mm": 100.0}


def scene(distance: float = 53.93, pinion: dict | None = None, **keys: object) -> fl.Scene:
    return fl.Scene.from_dict(
        {
            "body_1": {**PINION, **(pinion or {})},
            "body_2": {**RING, **keys},
            "pair": {"center_distance_mm": distance, "face_width_mm": 20},
            "load": {"torque_Nm": 300},
        }
    )


def pair(*args: object, **keys: object) -> BodyPair:
    return build_bodies(scene(*args, **keys))


def refused(*args: object, **keys: object) -> SceneError:
    with pytest.raises(SceneError) as caught:
        pair(*args, **keys)
    assert "\n" not in str(caught.value)
    return caught.value


def test_working_geometry_is_that_of_din_3960() -> None:
    """By hand, with the number of teeth, radii and centre distance of the ring negative."""
    mesh = pair().pairing.gear_geometry
    assert mesh is not None
    z, a, alpha = (24, -60), -53.93, radians(20.0)
    working = acos(0.5 * 3.0 * sum(z) * cos(alpha) / a)
    assert mesh.pressure_angle_rad == pytest.approx(working, rel=SOLVER)
    base = [0.5 * 3.0 * n * cos(alpha) for n in z]
    tip = [39.0, -87.6]
    lengths = [sqrt(t**2 - b**2) * np.sign(b) for t, b in zip(tip, base, strict=True)]
    path = sum(lengths) - a * np.sin(working)
    assert mesh.contact_ratio == pytest.approx(path / (pi * 3.0 * cos(alpha)), rel=1e-9)
    assert mesh.pitch_radius_1_mm == pytest.approx(53.93 * 24 / 36, rel=SOLVER)
    assert mesh.pitch_radius_2_mm == pytest.approx(53.93 * 60 / 36, rel=SOLVER)
    # without profile shift: space of the ring less tooth of the pinion on the working circles
    backlash = 2 * mesh.pitch_radius_1_mm * (24 - 60) / 24 * (inv(working) - inv(alpha))
    assert mesh.backlash_mm == pytest.approx(backlash, rel=1e-9)
    assert mesh.path_start_mm < 0 < mesh.path_end_mm
    assert dict(describe_gears(mesh))["contact ratio"] == f"{mesh.contact_ratio:.4f}"


@pytest.mark.parametrize("blunt", [{}, {"tip_radius_mm": 0.4}, {"tip_chamfer_mm": 0.4}])
def test_contact_ratio_on_both_involutes_inside_a_ring(blunt: dict) -> None:
    found = pair(pinion=blunt, **blunt)
    mesh = found.pairing.gear_geometry
    assert mesh is not None
    assert mesh.usable_contact_ratio == pytest.approx(usable_contact_ratio(found), rel=3e-5)
    assert (mesh.usable_contact_ratio < mesh.contact_ratio - 0.05) == bool(blunt)


def test_pair_zero_is_at_the_pitch_point_at_position_zero() -> None:
    """The pitch point lies beyond the axis of body 1, seen from that of body 2."""
    found = pair()
    turns = found.pairing.turns_at_zero_rad
    for body, turn, axis, radius in (
        (found.body_1, turns[0], 0.0, found.pairing.gear_geometry.pitch_radius_1_mm),
        (found.body_2, turns[1], 53.93, found.pairing.gear_geometry.pitch_radius_2_mm),
    ):
        s = np.linspace(0, body.curve.length_mm, 2001)
        radii = np.linalg.norm(body.curve.point(s), axis=1)
        near = np.interp(radius, radii[:: body.outward], s[:: body.outward])
        x, y = body.curve.rotated(turn).point(near)[0]
        assert np.hypot(axis + x + found.pairing.gear_geometry.pitch_radius_1_mm, y) < 1e-4


def test_both_bodies_turn_the_same_way() -> None:
    pairing = pair().pairing
    one = pairing.sites.tolist().index(1)
    assert pairing.site_angles_rad[0][one] == pytest.approx(2 * pi / 24)
    assert pairing.site_angles_rad[1][one] == pytest.approx(2 * pi / 60)
    assert pairing.site_teeth[1][one] == 1
    assert pairing.ratio == pytest.approx(-24 / 60)
    turn_1, turn_2 = pairing.turns(np.array([0.0, pairing.period_rad]))
    assert turn_1[1] - turn_1[0] == pytest.approx(2 * pi / 24)
    assert turn_2[1] - turn_2[0] == pytest.approx(2 * pi / 60)


def test_pitch_errors_of_a_ring_turn_its_flanks_towards_the_mate() -> None:
    """Metal that touches early is at a smaller angle: the material lies beyond the flank."""
    errors = [float(k) / 10 for k in range(60)]
    pairing = pair(pitch_errors_um=errors).pairing
    base_radius = 90.0 * cos(radians(20))
    for site, angle in zip(pairing.sites, pairing.site_angles_rad[1], strict=True):
        turn = (-site % 60) / 10 / 1000 / base_radius
        assert angle == pytest.approx(2 * pi * site / 60 - turn, rel=SOLVER, abs=SOLVER)


def test_sane_pair_has_no_warning() -> None:
    assert not pair().notes


# --- pairs that cannot mesh -----------------------------------------------------------------------
def test_pinion_with_as_many_teeth_as_the_ring() -> None:
    error = refused(0.5, pinion={"teeth": 60, "tip_diameter_mm": 186.0})
    assert error.key == "body_1.teeth"
    assert error.expected.startswith("fewer than the 60 teeth of body_2")
    assert error.found == "60"


def test_pinion_larger_than_the_ring() -> None:
    error = refused(pinion={"teeth": 59, "tip_diameter_mm": 187.7})
    assert error.key == "body_1.tip_diameter_mm"
    assert "less than the root diameter 187.5" in error.expected


def test_other_module_is_another_base_pitch() -> None:
    assert refused(module_mm=3.1).key == "body_2.module_mm"


def test_distance_below_the_difference_of_the_base_circles() -> None:
    error = refused(50.0)
    assert error.key == "pair.center_distance_mm"
    least = 54 * cos(radians(20))
    assert "difference of the base radii" in error.expected
    assert float(re.search(r"([\d.]+) mm too small", error.found)[1]) == pytest.approx(
        least - 50.0, abs=1e-4
    )


def test_tips_that_pass_each_other() -> None:
    """Closer to the axis of the ring the pinion leaves its teeth: 87.6 - 34.5 = 53.1 mm."""
    error = refused(52.0, pinion={"tip_diameter_mm": 69.0})
    assert error.key == "pair.center_distance_mm"
    assert "more than the difference of the tip radii, 53.1000 mm" in error.expected
    assert "1.1000 mm apart" in error.found


def test_overlapping_teeth_say_which_distance_would_do() -> None:
    error = refused(54.3)
    assert error.key == "pair.center_distance_mm"
    enough = float(re.search(r"([\d.]+) mm or less", error.expected)[1])
    assert enough == pytest.approx(54.0, abs=1e-4)
    assert pair(enough).pairing.gear_geometry.backlash_mm == pytest.approx(0.0, abs=1e-4)


def test_teeth_that_fit_at_no_distance() -> None:
    """Spaces of -0.8 modules of shift: inv(alpha_w) would have to be negative."""
    shift = {"profile_shift": 0.3, "tip_diameter_mm": 79.5}
    error = refused(pinion=shift, profile_shift=-0.5, root_diameter_mm=184.0)
    assert error.key == "body_2.profile_shift"
    assert "into which the teeth of body_1 fit" in error.expected


def test_slightly_negative_backlash_is_a_warning_with_its_value() -> None:
    found = pair(54.01)
    (warning,) = [note for note in found.notes if "backlash" in note]
    assert f"{1000 * found.pairing.gear_geometry.backlash_mm:.2f} um" in warning


@pytest.mark.parametrize(
    ("pinion", "ring", "words", "limit"),
    [
        ({"tip_diameter_mm": 80.0}, {}, "tip of body_1 clears the root of body_2", 53.75),
        ({}, {"tip_diameter_mm": 172.0}, "tip of body_2 clears the root of body_1", 53.75),
    ],
)
def test_tip_in_the_root_of_the_mate(pinion: dict, ring: dict, words: str, limit: float) -> None:
    error = refused(pinion=pinion, **ring)
    assert error.key == "pair.center_distance_mm"
    assert words in error.expected
    assert f"less than {limit:.4f} mm" in error.expected
    assert error.found == f"53.93 mm, {53.93 - limit:.4f} mm too large"


def test_path_of_contact_that_vanishes() -> None:
    error = refused(51.4, pinion={"tip_diameter_mm": 73.0})
    assert error.key == "pair.center_distance_mm"
    assert "path of contact is -0.9361 mm long" in error.found


# --- interference ---------------------------------------------------------------------------------
def tip_clearance(z_1: int, z_2: int, a: float, tip_1: float, tip_2: float) -> float:
    """Textbook condition against colliding tips, as an angle about O2; negative: they collide."""
    base_1, base_2 = (0.5 * 3.0 * z * cos(radians(20)) for z in (z_1, z_2))
    at_1 = acos((tip_2**2 - a**2 - tip_1**2) / (2 * a * tip_1))
    at_2 = acos((a**2 + tip_2**2 - tip_1**2) / (2 * a * tip_2))
    working = acos((base_2 - base_1) / a)
    one, two = inv(acos(base_1 / tip_1)), inv(acos(base_2 / tip_2))
    return (z_1 * (one + at_1) - z_2 * (two + at_2) + (z_2 - z_1) * inv(working)) / z_2


def test_colliding_tips_are_refused_with_their_depth() -> None:
    error = refused(8.97, pinion=NEAR)
    assert error.key == "body_2.tip_diameter_mm"
    assert "tips that clear each other" in error.expected
    depth = -87.6 * tip_clearance(54, 60, 8.97, 84.0, 87.6)
    assert float(re.search(r"overlap by ([\d.]+) mm", error.found)[1]) == pytest.approx(
        depth, abs=1e-4
    )


@pytest.mark.parametrize("teeth", range(46, 57))
def test_tips_collide_where_the_textbook_says(teeth: int) -> None:
    distance = 1.5 * (60 - teeth) - 0.03
    tip = 1.5 * teeth + 2.7
    body = {"teeth": teeth, "tip_diameter_mm": 2 * tip, "bore_diameter_mm": 100.0}
    clear = tip_clearance(teeth, 60, distance, tip, 87.6)
    if clear > 0.0:
        assert pair(distance, pinion=body).pairing.gear_geometry is not None
    else:
        assert "tips overlap" in refused(distance, pinion=body).found


def test_rounded_tips_may_pass_where_sharp_ones_collide() -> None:
    sharp = {**NEAR, "tip_diameter_mm": 166.4}
    assert "tips overlap" in refused(8.97, pinion=sharp).found
    assert pair(
        8.97, pinion={**sharp, "tip_radius_mm": 0.3}, tip_radius_mm=0.3
    ).pairing.gear_geometry


def swept_overlap(found: BodyPair) -> float:
    """Deepest overlap along the circumference, by turning both bodies step by step."""
    a = found.pairing.center_distance_mm
    body_1, body_2 = found.body_1, found.body_2
    s = np.linspace(0, body_2.curve.length_mm, 4001)
    turn_1, turn_2 = found.pairing.turns_at_zero_rad
    x, y = body_2.curve.rotated(turn_2).point(s).T
    radius, angle = np.hypot(x, y)[::-1], np.unwrap(np.arctan2(y, x) % (2 * pi))[::-1]
    x, y = body_1.curve.rotated(turn_1).point(np.linspace(0, body_1.curve.length_mm, 801)).T
    deepest = 0.0
    for turn in np.linspace(-0.8, 0.8, 1601):
        c, s = np.cos(turn), np.sin(turn)
        px, py = x * c - y * s - a, x * s + y * c
        r = np.hypot(px, py)
        inside = (r > radius[0]) & (r < radius[-1])
        here = np.arctan2(py, px) % (2 * pi) + found.pairing.ratio * turn
        beyond = here - np.interp(r, radius, angle)
        deepest = max(deepest, float((r * beyond)[inside].max(initial=0.0)))
    return deepest


def test_ring_tip_in_the_pinion_fillet_is_a_warning_that_says_how_deep_and_where() -> None:
    found = pair(tip_diameter_mm=174.0)
    below, overlap = found.notes
    form = found.body_1.involute.form_radius_mm
    base = 36.0 * cos(radians(20))
    mesh = found.pairing.gear_geometry
    reached = sqrt(base**2 + (base * tan(mesh.pressure_angle_rad) + mesh.path_start_mm) ** 2)
    assert f"reaches {form - reached:.3f} mm below the form circle of body_1" in below
    depth = float(re.search(r"by up to ([\d.]+) mm", overlap)[1])
    assert depth == pytest.approx(swept_overlap(found), rel=0.02)
    assert "174.000 mm of body_2" in overlap
    # both reach the result
    result = fl.solve(scene(tip_diameter_mm=174.0))
    assert below in result.warnings
    assert overlap in result.warnings


def test_pinion_tip_beyond_the_form_circle_of_the_ring_is_a_warning() -> None:
    found = pair(53.9, pinion={"tip_diameter_mm": 79.4}, root_diameter_mm=187.6)
    beyond, overlap = found.notes
    assert "0.054 mm beyond the form circle of body_2" in beyond
    depth = float(re.search(r"by up to ([\d.]+) mm", overlap)[1])
    assert depth == pytest.approx(swept_overlap(found), rel=0.02)


def test_conjugate_flanks_do_not_overlap() -> None:
    assert swept_overlap(pair()) < 1e-3


@pytest.mark.parametrize("turns", [1, -3])
def test_positions_turns_apart_are_solved_as_each_alone(turns: int) -> None:
    """Regression: inside a ring, angles a turn apart in one list took flanks for far ones."""
    angles = [3.0, 3.0 + 360.0 * turns, 3.0 - 75.0]
    together, alone = (
        fl.solve(
            fl.Scene.from_dict(
                {
                    "body_1": {**PINION, "rigid": True},
                    "body_2": {**RING, "rigid": False},
                    "pair": {"center_distance_mm": 53.93, "face_width_mm": 20},
                    "load": {"torque_Nm": 300},
                    "positions": {"angles_deg": wanted},
                    "accuracy": {"estimate": False, "tangents": False, "flank_element_mm": 2},
                }
            )
        )
        for wanted in (angles, angles[:1])
    )
    assert isinstance(together, fl.Result)
    assert isinstance(alone, fl.Result)
    np.testing.assert_allclose(together.rotation_rad, alone.rotation_rad[0], rtol=1e-8, atol=0)
    shares = np.sort(alone.site_force_N[0])[::-1]
    for forces in together.site_force_N:
        found = np.sort(forces)[::-1]
        np.testing.assert_allclose(found[: shares.size], shares, rtol=0, atol=1e-5 * shares.sum())
