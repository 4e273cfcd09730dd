"""The fillet that the rack of a helical gear generates in the transverse section."""

from __future__ import annotations

from math import atan, cos, pi, radians, tan

import numpy as np
import pytest
from msgspec import structs

from flankload.bodies.profile.basic_rack import BasicRack, HelicalRack, basic_rack
from flankload.bodies.profile.gear_profile import gear_profile
from flankload.scene import Gear, Scene
from tests.support.gear_scenes import changed
from tests.support.tolerances import ROUND_OFF

GEAR = Gear(
    teeth=25,
    module_mm=3.0,
    profile_shift=0.1,
    fillet_radius_factor=0.3,
    tip_diameter_mm=81.0,
    bore_diameter_mm=30.0,
)


def helical_rack() -> HelicalRack:
    rack = basic_rack(structs.replace(GEAR, helix_angle_deg=25.0, hand="left"), 25, 0.1, "body_1")
    assert isinstance(rack, HelicalRack)
    return rack


def parameters(rack: BasicRack, n: int = 60) -> np.ndarray:
    return np.linspace(rack.flank_angle_rad, 0.5 * pi, n)


def test_without_a_helix_the_ellipse_is_the_circle() -> None:
    spur = basic_rack(GEAR, 25, 0.1, "body_1")
    round_tip = HelicalRack(
        spur.reference_radius_mm,
        spur.pressure_angle_rad,
        spur.center_mm,
        spur.tip_radius_mm,
        helix_cosine=1.0,
    )
    beta = parameters(spur)
    for found, expected in zip(round_tip.fillet(beta), spur.fillet(beta), strict=True):
        np.testing.assert_allclose(found, expected, rtol=0, atol=ROUND_OFF * 40)
    np.testing.assert_allclose(round_tip.slope(beta), spur.slope(beta), rtol=1e-13)
    assert round_tip.roll_of_form_point(0.1) == pytest.approx(spur.roll_of_form_point(0.1))


def test_no_place_of_the_rack_cuts_into_the_fillet() -> None:
    """In the frame of the rack, each point of the fillet moves past the ellipse and touches it."""
    rack = helical_rack()
    points = rack.fillet(parameters(rack))[0]
    roll = np.linspace(-0.6, 0.6, 20001)
    radius, polar = np.hypot(*points.T), np.arctan2(points[:, 1], points[:, 0])
    for r, angle in zip(radius, polar, strict=True):
        # e_r and e_theta of the roll angle are the axes of the rack
        xi = r * np.cos(angle - roll) - rack.reference_radius_mm
        eta = r * np.sin(angle - roll) + rack.reference_radius_mm * roll
        height = (xi - rack.center_mm[0]) / rack.tip_radius_mm
        width = (eta - rack.center_mm[1]) * rack.helix_cosine / rack.tip_radius_mm
        beyond = np.hypot(height, width)[(xi < rack.center_mm[0]) & (eta < rack.center_mm[1])] - 1
        assert beyond.min() == pytest.approx(0.0, abs=1e-6)


def test_derivatives_are_those_of_the_fillet() -> None:
    rack, step = helical_rack(), 1e-5
    beta = parameters(rack)
    _, first, second = rack.fillet(beta)
    (above, above_1, _), (below, below_1, _) = (rack.fillet(beta + h) for h in (step, -step))
    np.testing.assert_allclose((above - below) / (2 * step), first, rtol=0, atol=1e-6)
    np.testing.assert_allclose((above_1 - below_1) / (2 * step), second, rtol=0, atol=1e-5)
    np.testing.assert_allclose(rack.slope(beta), np.hypot(*first.T), rtol=1e-12)


def test_profile_of_a_helical_gear_is_that_of_its_transverse_section() -> None:
    scene = Scene.from_dict(
        changed(
            body_1__helix_angle_deg=20,
            body_1__hand="left",
            body_1__tip_diameter_mm=86.0,
            body_2__helix_angle_deg=20,
            body_2__hand="right",
            body_2__tip_diameter_mm=86.0,
        )
    )
    profile = gear_profile(scene.body_1, "body_1")  # type: ignore[arg-type]
    helix, normal = radians(20), radians(20)
    transverse = atan(tan(normal) / cos(helix))
    reference = 0.5 * 16 * 4.5 / cos(helix)
    assert profile.involute.reference_radius_mm == pytest.approx(reference)
    assert profile.involute.base_radius_mm == pytest.approx(reference * cos(transverse))
    assert profile.root_radius_mm == pytest.approx(reference - 1.25 * 4.5)
    # normal tooth thickness on the reference circle: half a pitch of the normal section
    thickness = 2 * reference * profile.involute.half_angle_at(reference) * cos(helix)
    assert thickness == pytest.approx(0.5 * pi * 4.5)
    assert scene.body_1.base_pitch_mm == pytest.approx(  # type: ignore[union-attr]
        2 * pi * profile.involute.base_radius_mm / 16
    )
