"""Profiles of rings against formulas that the code does not use."""

from __future__ import annotations

from math import cos, hypot, pi, radians, sqrt, tan

import numpy as np
import pytest

from flankload.bodies.involute.involute_body import build_involute_body
from flankload.bodies.profile.gear_profile import gear_profile
from flankload.bodies.profile.ring_profile import ring_profile
from flankload.bodies.profile.tooth_profile import ToothProfile
from flankload.errors import SceneError
from flankload.scene import Gear
from tests.support.ring_bodies import ring
from tests.support.tolerances import ROUND_OFF, SOLVER

# Largest distance of a profile from the exact one.
EXACT = 1e-9


def profile_of(**keys) -> ToothProfile:
    return ring_profile(ring(**keys), "body_2")


def sampled(profile: ToothProfile, *labels: str, n: int = 300) -> np.ndarray:
    low, high = profile.curve.range_of(*labels)
    return profile.curve.point(np.linspace(low, high, n))


def metal_off(profile: ToothProfile, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Roll and metal taken off, from radius and polar angle alone; positive widens the space."""
    base = profile.involute.base_radius_mm
    reach = np.sqrt(np.hypot(*points.T) ** 2 - base**2)
    polar = np.arctan2(points[:, 1], points[:, 0])
    roll = profile.involute.base_half_angle_rad - polar + np.arctan(reach / base)
    return roll, reach - base * roll


def test_curve_goes_from_root_to_tip_and_its_radius_falls() -> None:
    profile = profile_of(tip_radius_mm=0.3)
    curve = profile.curve
    assert (np.diff(curve.breaks) > 0).all()
    radii = np.hypot(*curve.point(np.linspace(0, curve.length_mm, 500)).T)
    assert radii[0] == pytest.approx(93.75, abs=EXACT)
    assert radii[-1] == pytest.approx(87.6, abs=EXACT)
    assert (np.diff(radii) < 0).all()
    assert list(dict.fromkeys(curve.labels)) == ["fillet", "flank", "tip_radius"]


def test_material_lies_beyond_the_flank() -> None:
    """The normal out of the material points into the space, towards smaller polar angles."""
    profile = profile_of()
    s = np.linspace(*profile.curve.range_of("flank"), 50)
    point, normal = profile.curve.point(s), profile.curve.normal(s)
    turning = point[:, 0] * normal[:, 1] - point[:, 1] * normal[:, 0]
    np.testing.assert_allclose(turning, -profile.involute.base_radius_mm, rtol=1e-9, atol=0)
    assert (point[:, 1] > 0).all()
    assert (profile.curve.curvature(s) < 0).all()


@pytest.mark.parametrize(("teeth", "shift"), [(30, 0.0), (60, 0.0), (60, 0.4), (151, -0.3)])
def test_space_is_the_tooth_of_an_external_gear(teeth: int, shift: float) -> None:
    reference = 3.0 * teeth
    profile = profile_of(
        teeth=teeth,
        profile_shift=shift,
        tip_diameter_mm=reference - 4.0 + 6 * shift,
        root_diameter_mm=reference + 7.0 + 6 * shift,
        outer_diameter_mm=reference + 50.0,
    )
    gear = gear_profile(
        Gear(
            teeth=teeth,
            module_mm=3.0,
            profile_shift=shift,
            tip_diameter_mm=reference + 5.0 + 6 * shift,
            bore_diameter_mm=10.0,
        ),
        "body_1",
    )
    radii = np.linspace(profile.involute.tip_radius_mm, profile.involute.form_radius_mm, 20)
    found = [profile.involute.polar_angle_at(radius) for radius in radii]
    assert found == pytest.approx([gear.involute.half_angle_at(r) for r in radii], rel=ROUND_OFF)
    space = 3.0 * (0.5 * pi + 2 * shift * tan(radians(20.0)))
    assert reference * profile.involute.half_angle_at(reference / 2) == pytest.approx(
        space, rel=SOLVER
    )
    _, off = metal_off(profile, sampled(profile, "flank"))
    np.testing.assert_allclose(off, 0.0, rtol=0, atol=EXACT)


@pytest.mark.parametrize("radius", [None, 0.2, 0.8])
def test_root_fillet_touches_flank_and_root_circle(radius: float | None) -> None:
    profile = profile_of(root_fillet_radius_mm=radius)
    curve = profile.curve
    low, high = curve.range_of("fillet")
    s = np.linspace(low, high, 50)[1:-1]
    bend = -curve.curvature(s)
    size = 1 / bend.mean()
    np.testing.assert_allclose(bend, 1 / size, rtol=1e-6, atol=0)
    assert size == pytest.approx(radius or size, rel=1e-6)
    # along the root circle at its start, along the flank at its end
    place, tangent = curve.point([0.0])[0], curve.tangent([0.0])[0]
    assert place @ tangent == pytest.approx(0.0, abs=1e-8)
    assert hypot(*place) == pytest.approx(93.75, rel=ROUND_OFF)
    before, after = curve.tangent([high - 1e-9, high + 1e-9])
    np.testing.assert_allclose(before, after, rtol=0, atol=1e-6)
    center = place - size * place / hypot(*place)
    if radius is None:
        assert center[1] == pytest.approx(0.0, abs=1e-8)
        assert profile.root_half_angle_rad == pytest.approx(0.0, abs=1e-9)
    form = profile.involute.form_radius_mm
    assert hypot(*curve.point([high])[0]) == pytest.approx(form, abs=EXACT)


def test_largest_fillet_of_the_message_is_the_full_rounding() -> None:
    with pytest.raises(SceneError) as caught:
        profile_of(root_fillet_radius_mm=5.0)
    largest = float(caught.value.expected.split()[2].rstrip(","))
    full, given = profile_of(), profile_of(root_fillet_radius_mm=largest - 1e-6)
    assert given.involute.form_radius_mm == pytest.approx(full.involute.form_radius_mm, abs=1e-5)
    with pytest.raises(SceneError):
        profile_of(root_fillet_radius_mm=largest + 1e-5)


@pytest.mark.parametrize(("shape", "power"), [("linear", 1), ("parabolic", 2)])
def test_tip_relief_removes_its_amount(shape: str, power: int) -> None:
    profile = profile_of(
        tip_relief_um=20.0, tip_relief_start_diameter_mm=178.0, tip_relief_shape=shape
    )
    base = profile.involute.base_radius_mm
    start, tip = (sqrt((d / 2 / base) ** 2 - 1) for d in (178.0, 175.2))
    _, off = metal_off(profile, sampled(profile, "flank"))
    np.testing.assert_allclose(off, 0.0, rtol=0, atol=EXACT)
    roll, off = metal_off(profile, sampled(profile, "relief"))
    part = (roll - start) / (tip - start)
    np.testing.assert_allclose(off, 0.020 * part**power, rtol=0, atol=EXACT)
    # the tip circle cuts the relieved flank a little beyond the roll of the plain one
    assert part[-1] == pytest.approx(1.0, abs=5e-3)


def test_linear_relief_is_not_cut_to_pieces() -> None:
    """Regression: with the slope of the relief at the kink, intervals were halved to 4e-8 mm."""
    spec = Gear(
        teeth=16,
        module_mm=4.5,
        tip_diameter_mm=81.0,
        bore_diameter_mm=30.0,
        tip_relief_um=20.0,
        tip_relief_start_diameter_mm=78.0,
    )
    keys = {"tip_relief_um": 20.0, "tip_relief_start_diameter_mm": 178.0}
    for curve in (gear_profile(spec, "body_1").curve, profile_of(**keys).curve):
        assert np.diff(curve.breaks).min() > 1e-4


def test_crowning_takes_off_metal_at_both_ends_and_the_fillet_follows() -> None:
    profile = profile_of(profile_crowning_um=8.0)
    _, off = metal_off(profile, sampled(profile, "flank", n=401))
    assert off[[0, -1]] == pytest.approx([0.008, 0.008], abs=3e-5)
    assert off.min() == pytest.approx(0.0, abs=1e-7)
    fillet = sampled(profile, "fillet")[-1]
    np.testing.assert_allclose(fillet, sampled(profile, "flank")[0], rtol=0, atol=EXACT)
    assert np.linalg.norm(fillet - sampled(profile_of(), "fillet")[-1]) == pytest.approx(
        0.008, rel=1e-6
    )


@pytest.mark.parametrize("keys", [{}, {"tip_radius_mm": 0.4}, {"profile_crowning_um": 4.0}])
def test_curve_has_no_gaps(keys: dict) -> None:
    curve = profile_of(**keys).curve
    ends = np.diff(curve.breaks)[:, None] ** np.arange(6)
    last = np.einsum("nck,nk->nc", curve.coefficients, ends)
    np.testing.assert_allclose(last[:-1], curve.coefficients[1:, :, 0], rtol=0, atol=EXACT)


def test_tip_rounding_touches_flank_and_tip_circle() -> None:
    profile = profile_of(tip_radius_mm=0.4)
    curve = profile.curve
    low, high = curve.range_of("tip_radius")
    s = np.linspace(low, high, 60)
    np.testing.assert_allclose(curve.curvature(s[1:-1]), 2.5, rtol=0, atol=1e-4)
    before, after = curve.tangent([low - 1e-9, low + 1e-9])
    np.testing.assert_allclose(before, after, rtol=0, atol=1e-6)
    end, tangent = curve.point([high])[0], curve.tangent([high])[0]
    assert hypot(*end) == pytest.approx(87.6, abs=EXACT)
    assert end @ tangent == pytest.approx(0.0, abs=1e-6)
    assert (np.hypot(*curve.point(s).T) >= 87.6 - EXACT).all()
    assert not curve.corners.any()


def test_tip_chamfer_has_its_height_and_two_corners() -> None:
    profile = profile_of(tip_chamfer_mm=0.5)
    curve = profile.curve
    low, high = curve.range_of("tip_chamfer")
    assert hypot(*curve.point([low])[0]) == pytest.approx(88.1, abs=EXACT)
    assert hypot(*curve.point([high])[0]) == pytest.approx(87.6, abs=EXACT)
    assert curve.breaks[curve.corners].tolist() == [low, high]
    assert profile.mode_range_mm == curve.range_of("flank")


def test_outline_goes_from_space_to_space() -> None:
    outline = profile_of().outline()
    polar = np.arctan2(outline[:, 1], outline[:, 0])
    assert polar[[0, -1]] == pytest.approx([0.0, 2 * pi / 60], abs=1e-12)
    c, s = cos(2 * pi / 60), np.sin(2 * pi / 60)
    mirrored = outline[::-1] @ np.array([[c, s], [s, -c]])
    np.testing.assert_allclose(outline, mirrored, rtol=0, atol=1e-10)
    radii = np.hypot(*outline.T)
    assert (radii.min(), radii.max()) == pytest.approx((87.6, 93.75), rel=ROUND_OFF)


def test_body_has_the_data_for_pairing() -> None:
    body = build_involute_body(ring(rigid=True), "body_2", flank_element_mm=1.0)
    assert (body.kind, body.outward, body.mesh) == ("ring", -1, None)
    assert body.reference_radius_mm == pytest.approx(90.0 * cos(radians(20.0)), rel=ROUND_OFF)
    assert (body.tip_radius_mm, body.root_radius_mm, body.bore_radius_mm) == (87.6, 93.75, 110.0)
    assert body.flank_angle_known


@pytest.mark.parametrize(
    ("keys", "key", "expected", "found"),
    [
        (
            {"tip_diameter_mm": 169.0},
            "tip_diameter_mm",
            "more than the base diameter 169.14",
            "169",
        ),
        (
            {"tip_diameter_mm": 170.0, "profile_shift": 3.0, "root_diameter_mm": 200.0},
            "tip_diameter_mm",
            "where the teeth are pointed",
            "170",
        ),
        (
            {"root_diameter_mm": 194.0, "outer_diameter_mm": 230.0},
            "root_diameter_mm",
            "less than 190.86",
            "194",
        ),
        ({"profile_shift": -2.0}, "root_diameter_mm", "where the spaces are pointed", "187.5"),
        ({"profile_shift": -5.0}, "profile_shift", "some width at the base circle", "-5"),
        ({"root_fillet_radius_mm": 1.5}, "root_fillet_radius_mm", "at most 1.295", "1.5"),
        (
            {"tip_diameter_mm": 186.5},
            "root_fillet_radius_mm",
            "some flank outside the tip diameter 186.5",
            "nothing: the largest arc, 1.29529,",
        ),
        ({"tip_radius_mm": 3.0}, "tip_radius_mm", "largest rounding", "3"),
        ({"tip_chamfer_mm": 9.0}, "tip_chamfer_mm", "less than the height of the flank", "9"),
        ({"tip_chamfer_mm": 5.0}, "tip_chamfer_mm", "about half the width of the tip", "5"),
        (
            {"tip_relief_um": 10.0, "tip_relief_start_diameter_mm": 187.0},
            "tip_relief_start_diameter_mm",
            "between the form diameter",
            "187",
        ),
        ({"pitch_errors_um": (1.0, 2.0)}, "pitch_errors_um", "one entry per tooth: 60", "2"),
    ],
)
def test_impossible_ring_is_refused(keys: dict, key: str, expected: str, found: str) -> None:
    with pytest.raises(SceneError) as caught:
        build_involute_body(ring(rigid=True, **keys), "body_2", flank_element_mm=1.0)
    assert caught.value.key == f"body_2.{key}"
    assert expected in caught.value.expected
    assert caught.value.found.startswith(found)
    assert "\n" not in str(caught.value)


def test_diameters_of_the_messages_are_those_of_the_points() -> None:
    with pytest.raises(SceneError) as caught:
        profile_of(root_diameter_mm=194.0)
    largest = float(caught.value.expected.split()[2].rstrip(","))
    profile_of(root_diameter_mm=largest - 1e-3)
    wide = {"profile_shift": 3.0, "root_diameter_mm": 200.0}
    with pytest.raises(SceneError) as caught:
        profile_of(tip_diameter_mm=170.0, **wide)
    least = float(caught.value.expected.split()[2].rstrip(","))
    profile_of(tip_diameter_mm=least + 1e-3, **wide)


def test_root_relief_of_a_ring_removes_material_of_its_teeth() -> None:
    profile = profile_of(root_relief_um=20.0, root_relief_start_diameter_mm=184.0)
    assert list(dict.fromkeys(profile.curve.labels))[:3] == ["fillet", "root_relief", "flank"]
    _, off = metal_off(profile, sampled(profile, "root_relief"))
    assert 1000.0 * abs(off[0]) == pytest.approx(20.0, abs=0.05)
    at_tip = profile_of(tip_relief_um=20.0, tip_relief_start_diameter_mm=177.0)
    assert off[0] * metal_off(at_tip, sampled(at_tip, "relief"))[1][-1] > 0.0
