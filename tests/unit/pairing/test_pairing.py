"""Two bodies together: working geometry, position zero, sites, and pairs that cannot mesh."""

from __future__ import annotations

import re

import numpy as np
import pytest

import flankload as fl
from flankload.errors import SceneError
from flankload.mechanisms.flank_pair.assembly import build_bodies
from flankload.pairing.body_pair import BodyPair
from tests.support.gear_pair import ONE, TWO
from tests.support.gear_scenes import usable_contact_ratio
from tests.support.tolerances import SOLVER

FZG_1 = {**ONE, "rigid": True}


def scene(distance: float = 91.5, body_1: dict | None = None, **keys: object) -> fl.Scene:
    return fl.Scene.from_dict(
        {
            "body_1": {**FZG_1, **(body_1 or {})},
            "body_2": {**TWO, **keys},
            "pair": {"center_distance_mm": distance, "face_width_mm": 14},
            "load": {"torque_Nm": 302},
        }
    )


def pair(*args: object, **keys: object) -> BodyPair:
    return build_bodies(scene(*args, **keys))


def refused(*args: object, **keys: object) -> SceneError:
    with pytest.raises(SceneError) as caught:
        pair(*args, **keys)
    assert "\n" not in str(caught.value)
    return caught.value


def test_working_geometry_of_the_fzg_pair() -> None:
    """By hand: cos(alpha_w) = 90 cos(20 deg)/91.5; contact ratio of FZG type C about 1.44."""
    mesh = pair().pairing.gear_geometry
    assert mesh is not None
    assert np.degrees(mesh.pressure_angle_rad) == pytest.approx(
        np.degrees(np.arccos(90 * np.cos(np.radians(20)) / 91.5)), rel=SOLVER
    )
    assert mesh.pitch_radius_1_mm == pytest.approx(36.6, rel=SOLVER)
    assert mesh.contact_ratio == pytest.approx(1.44, abs=0.01)
    assert mesh.path_start_mm < 0 < mesh.path_end_mm
    # the published nominal backlash of these numbers is 0.6 um
    assert mesh.backlash_mm == pytest.approx(0.0006, abs=1e-4)


#: Places along the path of contact are counted.
COUNTED = 3e-5


@pytest.mark.parametrize(
    "changes",
    [{}, {"tip_radius_mm": 0.5}, {"tip_chamfer_mm": 0.5}, {"profile_crowning_um": 20}],
    ids=["sharp", "rounded", "chamfered", "crowned"],
)
def test_contact_ratio_on_both_involutes_ends_at_tip_roundings(changes: dict) -> None:
    found = pair(body_1=changes, **changes)
    mesh = found.pairing.gear_geometry
    assert mesh.usable_contact_ratio == pytest.approx(usable_contact_ratio(found), rel=COUNTED)
    blunt = bool({"tip_radius_mm", "tip_chamfer_mm"}.intersection(changes))
    assert (mesh.usable_contact_ratio < mesh.contact_ratio - 0.05) == blunt
    if not blunt:
        assert mesh.usable_contact_ratio == pytest.approx(mesh.contact_ratio, rel=SOLVER)


def test_relieved_tip_is_part_of_the_contact_ratio_on_both_involutes() -> None:
    relief = {"tip_relief_um": 20, "tip_relief_start_diameter_mm": 116}
    mesh = pair(**relief).pairing.gear_geometry
    assert mesh.usable_contact_ratio == pytest.approx(mesh.contact_ratio, rel=SOLVER)


def test_contact_ratio_on_both_involutes_ends_at_the_form_circle() -> None:
    """The tip of a large gear reaches far below where the undercut of a small one ends."""
    module = {"module_mm": 1.0, "profile_shift": 0.0, "bore_diameter_mm": 3.0}
    found = pair(
        56.5,
        {**module, "teeth": 10, "tip_diameter_mm": 12.0},
        **{**module, "teeth": 103, "tip_diameter_mm": 105.0},
    )
    mesh, one = found.pairing.gear_geometry, found.body_1.involute
    reach = [np.sqrt(r**2 - one.base_radius_mm**2) for r in (one.form_radius_mm, 6.0)]
    by_hand = (reach[1] - reach[0]) / (np.pi * np.cos(np.radians(20)))
    assert mesh.usable_contact_ratio == pytest.approx(by_hand, rel=SOLVER)
    assert mesh.usable_contact_ratio == pytest.approx(usable_contact_ratio(found), rel=COUNTED)
    assert mesh.contact_ratio > mesh.usable_contact_ratio + 0.5


def test_contact_ratio_below_one_on_both_involutes_is_said() -> None:
    rounded = {"tip_radius_mm": 0.8}
    found = pair(body_1={**rounded, "tip_diameter_mm": 80.0}, **rounded, tip_diameter_mm=116.0)
    mesh = found.pairing.gear_geometry
    assert mesh.usable_contact_ratio < 1.0 < mesh.contact_ratio
    (said,) = [note for note in found.notes if "both flanks are involutes" in note]
    assert said.startswith(
        f"both flanks are involutes over {mesh.usable_contact_ratio:.3f} of the contact ratio of "
        f"{mesh.contact_ratio:.3f}"
    )


def test_pair_zero_is_at_the_pitch_point_at_position_zero() -> None:
    found = pair()
    pitch_radius = found.pairing.gear_geometry.pitch_radius_1_mm
    for body, turn, axis, radius in (
        (found.body_1, found.pairing.turns_at_zero_rad[0], 0.0, pitch_radius),
        (found.body_2, found.pairing.turns_at_zero_rad[1], 91.5, 91.5 - pitch_radius),
    ):
        s = np.linspace(0, body.curve.length_mm, 2001)
        near = np.interp(radius, np.linalg.norm(body.curve.point(s), axis=1), s)
        x, y = body.curve.rotated(turn).point(near)[0]
        assert np.hypot(axis + x - pitch_radius, y) < 1e-4


def test_sites_turn_with_the_motion() -> None:
    """Pair +1 has gone one pitch ahead: up on body 1 (counter-clockwise), down on body 2."""
    pairing = pair().pairing
    one = pairing.sites.tolist().index(1)
    assert pairing.site_angles_rad[0][one] == pytest.approx(2 * np.pi / 16)
    assert pairing.site_angles_rad[1][one] == pytest.approx(-2 * np.pi / 24)
    turn_1, turn_2 = pairing.turns(np.array([0.0, pairing.period_rad]))
    assert turn_1[1] - turn_1[0] == pytest.approx(2 * np.pi / 16)
    assert turn_2[1] - turn_2[0] == pytest.approx(-2 * np.pi / 24)
    assert {-1, 0, 1} <= set(pairing.sites.tolist())


def test_pitch_errors_follow_the_order_of_contact() -> None:
    """Entry 0 belongs to the tooth of pair 0, entry 1 to the one that follows, pair -1."""
    errors = [float(k) for k in range(16)]
    pairing = pair(body_1={"pitch_errors_um": errors}).pairing
    base_radius = 36.0 * np.cos(np.radians(20))
    for site, angle in zip(pairing.sites, pairing.site_angles_rad[0], strict=True):
        turn = (-site % 16) / 1000 / base_radius
        assert angle == pytest.approx(2 * np.pi * site / 16 + turn, rel=SOLVER, abs=SOLVER)


@pytest.mark.parametrize("distance", [84.0, 84.5])
def test_distance_below_the_base_circles_says_by_how_much(distance: float) -> None:
    error = refused(distance)
    assert error.key == "pair.center_distance_mm"
    least = 90 * np.cos(np.radians(20))
    assert float(re.search(r"([\d.]+) mm too small", error.found)[1]) == pytest.approx(
        least - distance, abs=1e-4
    )


def test_overlapping_teeth_say_which_distance_would_do() -> None:
    error = refused(91.2)
    assert error.key == "pair.center_distance_mm"
    enough = float(re.search(r"([\d.]+) mm or more", error.expected)[1])
    assert "backlash of -0.2" in error.found
    # taken at its word: no backlash there, to the four digits it names
    assert pair(enough + 5e-5).pairing.gear_geometry.backlash_mm == pytest.approx(0.0, abs=1e-4)


def test_tips_that_pass_each_other() -> None:
    error = refused(101.0)
    assert error.key == "pair.center_distance_mm"
    assert "0.5900 mm apart" in error.found


def test_path_of_contact_that_vanishes() -> None:
    error = refused(100.40)
    assert error.key == "pair.center_distance_mm"


def test_tip_in_the_root_of_the_mate() -> None:
    """A tip circle grown by 1.3 mm runs into the other root; thin teeth keep their backlash."""
    error = refused(91.5, body_1={"tip_diameter_mm": 85.2})
    assert error.key == "pair.center_distance_mm"
    assert "tip of body_1" in error.expected


def test_other_module_is_another_base_pitch() -> None:
    error = refused(body_1={"module_mm": 4.0, "tip_diameter_mm": 73.0, "bore_diameter_mm": 20})
    assert error.key == "body_2.module_mm"
    assert "base pitch" in error.expected


def test_slightly_negative_backlash_is_a_warning_with_its_value() -> None:
    found = pair(91.49)
    mesh = found.pairing.gear_geometry
    assert -0.02 < mesh.backlash_mm < 0
    (warning,) = [note for note in found.notes if "backlash" in note]
    assert f"{1000 * mesh.backlash_mm:.2f} um" in warning


def test_sane_pair_has_no_warning() -> None:
    assert not pair(91.55).pairing.warnings
