"""Tooth thickness from allowance, span measurement and measurement over balls."""

from math import cos, pi, radians, tan

import numpy as np
import pytest

from flankload.bodies.profile.gear_profile import gear_profile
from flankload.bodies.profile.ring_profile import ring_profile
from flankload.bodies.profile.tooth_thickness import Measurements, measurements
from flankload.errors import SceneError
from flankload.scene import Gear
from tests.support.gear_scenes import RING, changed, one_line
from tests.support.ring_bodies import gear, ring
from tests.support.tolerances import SOLVER


def spur(**keys: object) -> Gear:
    tables = {"teeth": 20, "module_mm": 2.0, "profile_shift": 0.0, "tip_diameter_mm": 44.0}
    return gear(**{**tables, "bore_diameter_mm": 10.0, **keys})


def measured(spec: Gear) -> Measurements:
    return measurements(gear_profile(spec, "body_1").involute, spec.teeth, spec.helix_rad)


def test_span_measurement_of_a_textbook_gear() -> None:
    # z 20, m 2, 20 deg, x 0: W_3 = 15.321 mm (machinecalcs.com, span measurement)
    found = measured(spur())
    assert (found.span_teeth, round(found.span_mm or 0.0, 3)) == (3, 15.321)


def test_measurement_over_balls_of_a_textbook_spline() -> None:
    # z 20, m 2, 30 deg: inv(a_K) = D/(z m cos a) + inv(a) - pi/(2 z), M = d_b/cos(a_K) + D
    spec = spur(pressure_angle_deg=30.0, dedendum_factor=0.6, fillet_radius_factor=0.2)
    found = measured(spec)
    alpha = radians(30.0)
    half = (0.5 * pi / 20) + tan(alpha) - alpha
    involute = found.ball_diameter_mm / (40 * cos(alpha)) - (pi / 20 - half)
    angles = np.linspace(0.0, 1.2, 400001)
    at = float(np.interp(involute, np.tan(angles) - angles, angles))
    over = 40 * cos(alpha) / cos(at) + found.ball_diameter_mm
    assert found.ball_mm == pytest.approx(over, abs=1e-7)


@pytest.mark.parametrize("spec", [spur(), spur(teeth=21, profile_shift=0.3, tip_diameter_mm=47.0)])
def test_the_balls_touch_near_the_middle_of_the_flank(spec: Gear) -> None:
    involute, found = gear_profile(spec, "body_1").involute, measured(spec)
    # distance of a ball's centre from the axis; its roll less D/(2 r_b) is that of the contact
    over = 0.5 * (found.ball_mm - found.ball_diameter_mm)
    over /= cos(0.5 * pi / spec.teeth) if spec.teeth % 2 else 1.0
    at = involute.roll_at(over) - 0.5 * found.ball_diameter_mm / involute.base_radius_mm
    low, high = (involute.roll_at(r) for r in (involute.form_radius_mm, involute.tip_radius_mm))
    assert abs(at - 0.5 * (low + high)) < 0.1 * (high - low)


@pytest.mark.parametrize("helix", [0.0, 25.0])
@pytest.mark.parametrize("teeth", [20, 21])
def test_measurements_as_input_give_the_same_gear(helix: float, teeth: int) -> None:
    sizes = {"teeth": teeth, "helix_angle_deg": helix, "tip_diameter_mm": 48.0 if helix else 44.0}
    sizes |= {"hand": "right"} if helix else {}
    thin = spur(**sizes, tooth_thickness_allowance_um=-70.0)
    found = measured(thin)
    for keys in (
        {"span_measurement_mm": found.span_mm, "span_teeth": found.span_teeth},
        {"ball_measurement_mm": found.ball_mm, "measuring_ball_mm": found.ball_diameter_mm},
    ):
        again = gear_profile(spur(**sizes, **keys), "body_1").involute
        wanted = gear_profile(thin, "body_1").involute
        assert again.base_half_angle_rad == pytest.approx(wanted.base_half_angle_rad, rel=SOLVER)
        assert again.root_radius_mm == pytest.approx(wanted.root_radius_mm, rel=SOLVER)


def test_the_allowance_is_the_change_of_thickness_in_the_normal_section() -> None:
    helix = {"helix_angle_deg": 20.0, "hand": "left", "tip_diameter_mm": 46.5}
    thick, thin = (
        gear_profile(spur(**helix, tooth_thickness_allowance_um=value), "body_1").involute
        for value in (0.0, -80.0)
    )
    radius = thick.reference_radius_mm
    change = 2 * radius * (thick.half_angle_at(radius) - thin.half_angle_at(radius))
    assert change * cos(radians(20.0)) == pytest.approx(0.08, rel=1e-9)
    deeper = 0.08 / (2 * tan(radians(20.0)))
    assert thick.root_radius_mm - thin.root_radius_mm == pytest.approx(deeper, rel=1e-9)


def test_thin_teeth_of_a_ring_have_wide_spaces() -> None:
    plain, thin = (
        ring_profile(ring(tooth_thickness_allowance_um=value), "body_2") for value in (0.0, -60.0)
    )
    radius = plain.involute.reference_radius_mm
    wider = thin.involute.half_angle_at(radius) - plain.involute.half_angle_at(radius)
    assert 2 * radius * wider == pytest.approx(0.06, rel=1e-9)
    found = measurements(thin.involute, thin.teeth)
    assert found.span_mm is None
    keys = {"ball_measurement_mm": found.ball_mm, "measuring_ball_mm": found.ball_diameter_mm}
    again = ring_profile(ring(**keys), "body_2").involute
    assert again.base_half_angle_rad == pytest.approx(thin.involute.base_half_angle_rad, rel=SOLVER)


def test_a_measurement_of_another_gear_is_refused() -> None:
    with pytest.raises(SceneError, match=r"body_1.span_measurement_mm: expected a measurement of"):
        gear_profile(spur(span_measurement_mm=40.0, span_teeth=2), "body_1")
    with pytest.raises(SceneError, match=r"body_1.ball_measurement_mm: expected a measurement of"):
        gear_profile(spur(ball_measurement_mm=12.0, measuring_ball_mm=3.5), "body_1")


@pytest.mark.parametrize(
    ("changes", "key", "expected", "found"),
    [
        (
            {"body_1__tooth_thickness_allowance_um": -50, "body_1__span_measurement_mm": 21.0},
            "body_1.span_measurement_mm",
            (
                "nothing beside body_1.tooth_thickness_allowance_um, which gives the tooth "
                "thickness as well"
            ),
            "21.0",
        ),
        (
            {"body_1__span_measurement_mm": 21.0},
            "body_1.span_teeth",
            "a number, since there is a body_1.span_measurement_mm",
            "nothing",
        ),
        (
            {"body_1__measuring_ball_mm": 7.0},
            "body_1.ball_measurement_mm",
            "a number, since there is a body_1.measuring_ball_mm",
            "nothing",
        ),
        (
            {"body_2": {**RING, "span_measurement_mm": 21.0, "span_teeth": 3}},
            "body_2.span_measurement_mm",
            "nothing for internal teeth (ball_measurement_mm instead)",
            "21.0",
        ),
    ],
)
def test_contradicting_keys_get_one_line(
    changes: dict[str, object], key: str, expected: str, found: str
) -> None:
    one_line(changes, key, expected, found)


def test_backlash_follows_from_the_allowance() -> None:
    import flankload as fl
    from flankload.mechanisms.flank_pair.assembly import build_bodies

    meshes = [
        build_bodies(fl.Scene.from_dict(changed(**keys))).pairing.gear_geometry
        for keys in ({}, {"body_1__tooth_thickness_allowance_um": -50.0})
    ]
    # j = E_st r_w/r on the working pitch circle
    ratio = meshes[0].pitch_radius_1_mm / (0.5 * 16 * 4.5)
    more = meshes[1].backlash_mm - meshes[0].backlash_mm
    assert more == pytest.approx(0.05 * ratio, rel=1e-9)
