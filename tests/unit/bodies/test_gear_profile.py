"""Gear profiles against formulas that the code does not use."""

from __future__ import annotations

from math import atan, cos, hypot, pi, radians, sin, sqrt, tan

import numpy as np
import pytest
from msgspec import structs
from scipy.optimize import minimize_scalar

from flankload.bodies.involute.involute_body import build_involute_body
from flankload.bodies.profile.gear_profile import gear_profile
from flankload.bodies.profile.involute import InvoluteFlank, Modifications
from flankload.bodies.profile.tooth_profile import ToothProfile
from flankload.errors import SceneError
from flankload.scene import Gear
from tests.support.ring_bodies import gear
from tests.support.tolerances import ROUND_OFF, SOLVER

# Largest distance of a profile from the exact one.
EXACT = 1e-9


def sized(teeth: int, shift: float, **keys) -> Gear:
    """A gear of module 2 with a tip that is not pointed."""
    most = 0.9 if teeth > 12 else 0.6
    tip = 2.0 * (teeth + 2 * shift + 2 * most)
    return gear(
        teeth=teeth,
        module_mm=2.0,
        profile_shift=shift,
        tip_diameter_mm=tip,
        bore_diameter_mm=2.0,
        **keys,
    )


def sampled(profile: ToothProfile, *labels: str, n: int = 400) -> np.ndarray:
    low, high = profile.curve.range_of(*labels)
    return np.linspace(low, high, n)


def metal_off(profile: ToothProfile, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Roll and metal taken off, from radius and polar angle alone.

    sqrt(r² - r_b²) = r_b t - delta, and the polar angle is th0 - t + atan((r_b t - delta)/r_b).
    """
    base = profile.involute.base_radius_mm
    radius = np.hypot(*points.T)
    reach = np.sqrt(np.maximum(radius**2 - base**2, 0.0))
    polar = np.arctan2(points[:, 1], points[:, 0])
    roll = profile.involute.base_half_angle_rad - polar + np.arctan(reach / base)
    return roll, base * roll - reach


def depth_in_rack(spec: Gear, point: np.ndarray) -> float:
    """Least distance of a place of the gear from the generating rack, over all of the rack's rolls.

    The rack is drawn anew: tip line, rounding and flank as the signed distance of a convex corner.
    With a protuberance its flank takes the place of the flank, which ends where they cross.
    """
    m, alpha = spec.module_mm, radians(spec.pressure_angle_deg)
    r = 0.5 * m * spec.teeth
    depth = (spec.dedendum_factor - spec.profile_shift) * m
    rho = spec.fillet_radius_factor * m
    flank = m * (0.25 * pi + spec.profile_shift * tan(alpha))
    main, slope = flank + spec.grinding_stock_mm / cos(alpha), alpha
    if spec.protuberance_mm is not None:
        # the rounding touches the flank, moved by the protuberance; so does the protuberance flank
        moved = main - spec.protuberance_mm / cos(alpha)
        middle = moved + (depth - rho) * tan(alpha) + rho / cos(alpha)
        alpha = radians(spec.protuberance_angle_deg)
        flank = middle - (depth - rho) * tan(alpha) - rho / cos(alpha)

    def distance(phi: float) -> float:
        xi = point[0] * cos(phi) + point[1] * sin(phi) - r
        eta = -point[0] * sin(phi) + point[1] * cos(phi) + r * phi
        if alpha == slope:
            return corner(xi, eta)
        eta = min(eta, pi * m - eta)  # both flanks of the rack's tooth
        beside = max((main - xi * tan(slope) - eta) * cos(slope), rho - depth - xi)
        return min(corner(xi, eta), beside)

    def corner(xi: float, eta: float) -> float:
        # shrunk by rho, the corner is sharp; its outside distance less rho is that of the round one
        over_tip = -(depth - rho) - xi
        over_flank = (flank - xi * tan(alpha) - eta) * cos(alpha) + rho
        corner_xi = -(depth - rho)
        corner_eta = flank - corner_xi * tan(alpha) + rho / cos(alpha)
        along_tip = eta - corner_eta
        along_flank = (xi - corner_xi) * cos(alpha) - (eta - corner_eta) * sin(alpha)
        if along_tip < 0 and along_flank < 0:
            return hypot(xi - corner_xi, eta - corner_eta) - rho
        return max(over_tip, over_flank) - rho

    # a protuberance touches far from the pitch point
    most = 1.5 if spec.protuberance_mm is None else 3.0
    rolls = np.linspace(-most * pi * m / r, most * pi * m / r, int(160 * most) + 1)
    near = rolls[np.argmin([distance(phi) for phi in rolls])]
    step = rolls[1] - rolls[0]
    found = minimize_scalar(
        distance, bounds=(near - step, near + step), method="bounded", options={"xatol": 1e-12}
    )
    return float(found.fun)


def test_fzg_type_c_has_the_published_root_diameters() -> None:
    assert 2 * gear_profile(gear(), "body_1").involute.root_radius_mm == pytest.approx(
        62.388, abs=1e-9
    )
    wheel = gear(teeth=24, profile_shift=0.171, tip_diameter_mm=118.36)
    assert 2 * gear_profile(wheel, "body_2").involute.root_radius_mm == pytest.approx(
        98.289, abs=1e-9
    )


def test_tooth_has_the_thickness_of_din_3960_on_the_reference_circle() -> None:
    involute = gear_profile(gear(), "body_1").involute
    thickness = 4.5 * (0.5 * pi + 2 * 0.182 * tan(radians(20.0)))
    assert involute.base_radius_mm == pytest.approx(36.0 * cos(radians(20.0)), rel=ROUND_OFF)
    assert 2 * 36.0 * involute.half_angle_at(36.0) == pytest.approx(thickness, rel=ROUND_OFF)
    assert involute.polar_angle_at(36.0) == involute.half_angle_at(36.0)


@pytest.mark.parametrize("teeth", [8, 16, 24, 100, 200])
@pytest.mark.parametrize("shift", [-0.3, 0.0, 0.8])
def test_flank_is_the_involute(teeth: int, shift: float) -> None:
    spec = sized(teeth, shift)
    profile = gear_profile(spec, "body_1")
    s = sampled(profile, "flank")
    points, normals = profile.curve.point(s), profile.curve.normal(s)
    _, off = metal_off(profile, points)
    # reach and roll are ill-conditioned on the base circle itself, by sqrt(eps) r_b
    inner = np.hypot(*points.T) > 1.0005 * profile.involute.base_radius_mm
    np.testing.assert_allclose(off[inner], 0.0, rtol=0, atol=EXACT)
    lever = points[:, 0] * normals[:, 1] - points[:, 1] * normals[:, 0]
    np.testing.assert_allclose(lever[inner], profile.involute.base_radius_mm, rtol=1e-7, atol=0)
    assert np.hypot(*points[-1]) == pytest.approx(spec.tip_diameter_mm / 2, rel=1e-12)


@pytest.mark.parametrize(
    "spec",
    [
        gear(),
        sized(8, 0.0),
        sized(8, -0.3),
        sized(100, 0.8),
        sized(20, 0.3, fillet_radius_factor=0.05),
        sized(20, 0.0, dedendum_factor=1.4, fillet_radius_factor=0.39),
    ],
    ids=["fzg", "undercut", "deep undercut", "shifted", "sharp rack", "long dedendum"],
)
def test_fillet_is_the_envelope_of_the_rack(spec: Gear) -> None:
    """The rack touches each point of the fillet at one roll angle and cuts none at any."""
    profile = gear_profile(spec, "body_1")
    points = profile.curve.point(sampled(profile, "fillet", n=15))
    depths = [depth_in_rack(spec, point) for point in points]
    np.testing.assert_allclose(depths, 0.0, rtol=0, atol=EXACT)


def test_fillet_begins_on_the_root_circle_along_it() -> None:
    profile = gear_profile(gear(), "body_1")
    place, tangent = profile.curve.point([0.0])[0], profile.curve.tangent([0.0])[0]
    assert np.hypot(*place) == pytest.approx(profile.involute.root_radius_mm, rel=ROUND_OFF)
    assert place @ tangent == pytest.approx(0.0, abs=1e-8)
    assert np.arctan2(place[1], place[0]) == pytest.approx(profile.root_half_angle_rad)
    assert profile.root_half_angle_rad < pi / 16


def test_ordinary_flank_touches_its_fillet() -> None:
    curve = gear_profile(gear(), "body_1").curve
    low, _ = curve.range_of("flank")
    before, after = curve.tangent([low - 1e-9, low + 1e-9])
    np.testing.assert_allclose(before, after, rtol=0, atol=1e-6)
    assert np.flatnonzero(curve.corners).tolist() == [curve.corners.size - 1]


def test_undercut_flank_begins_in_a_corner_on_fillet_and_involute() -> None:
    spec = sized(8, 0.0)
    profile = gear_profile(spec, "body_1")
    low, _ = profile.curve.range_of("flank")
    corner = int(np.searchsorted(profile.curve.breaks, low))
    assert profile.curve.corners[corner]
    place = profile.curve.point([low])
    assert metal_off(profile, place)[1][0] == pytest.approx(0.0, abs=EXACT)
    assert depth_in_rack(spec, place[0]) == pytest.approx(0.0, abs=EXACT)
    assert profile.involute.form_radius_mm > profile.involute.base_radius_mm
    assert np.hypot(*place[0]) == pytest.approx(profile.involute.form_radius_mm, abs=EXACT)
    # 17 teeth without shift are just free of undercut with a full dedendum of 1, 8 are not
    free = sized(18, 0.0, dedendum_factor=1.0, fillet_radius_factor=0.0)
    assert not gear_profile(free, "body_1").curve.corners[:-1].any()
    cut = sized(17, 0.0, dedendum_factor=1.0, fillet_radius_factor=0.0)
    assert gear_profile(cut, "body_1").curve.corners[:-1].any()


@pytest.mark.parametrize("teeth", [8, 12, 17, 40, 200])
@pytest.mark.parametrize("keys", [{}, {"tip_radius_mm": 0.15}, {"profile_crowning_um": 4.0}])
def test_curve_has_no_gaps(teeth: int, keys: dict) -> None:
    curve = gear_profile(sized(teeth, 0.1, **keys), "body_1").curve
    ends = np.diff(curve.breaks)[:, None] ** np.arange(6)
    last = np.einsum("nck,nk->nc", curve.coefficients, ends)
    np.testing.assert_allclose(last[:-1], curve.coefficients[1:, :, 0], rtol=0, atol=EXACT)


def test_linear_relief_begins_in_a_corner_and_parabolic_relief_does_not() -> None:
    """Regression: the pressure on the kink, which has no limit under refinement, was not marked."""
    keys = {"tip_relief_um": 20.0, "tip_relief_start_diameter_mm": 79.0, "tip_radius_mm": 0.2}
    for shape, corners in (("linear", 1), ("parabolic", 0)):
        curve = gear_profile(gear(**keys, tip_relief_shape=shape), "body_1").curve
        assert np.count_nonzero(curve.corners) == corners
        start = curve.range_of("relief")[0]
        assert bool(curve.corners[np.searchsorted(curve.breaks, start)]) == bool(corners)


@pytest.mark.parametrize(("shape", "half"), [("linear", 0.5), ("parabolic", 0.25)])
def test_tip_relief_removes_its_amount(shape: str, half: float) -> None:
    spec = gear(tip_relief_um=20.0, tip_relief_start_diameter_mm=79.0, tip_relief_shape=shape)
    profile = gear_profile(spec, "body_1")
    base = profile.involute.base_radius_mm
    start, tip = (sqrt((d / 2 / base) ** 2 - 1) for d in (79.0, 82.46))
    flank = profile.curve.point(sampled(profile, "flank")[20:])
    np.testing.assert_allclose(metal_off(profile, flank)[1], 0.0, rtol=0, atol=EXACT)
    roll, off = metal_off(profile, profile.curve.point(sampled(profile, "relief")))
    part = (roll - start) / (tip - start)
    np.testing.assert_allclose(
        off, 0.020 * part ** (1 if shape == "linear" else 2), rtol=0, atol=EXACT
    )
    assert np.interp(0.5, part, off) == pytest.approx(0.020 * half, rel=1e-4)


def test_crowning_takes_off_nothing_in_the_middle_and_all_at_the_ends() -> None:
    profile = gear_profile(gear(profile_crowning_um=6.0), "body_1")
    plain = gear_profile(gear(), "body_1").involute
    roll, off = metal_off(profile, profile.curve.point(sampled(profile, "flank")[20:]))
    first, last = plain.roll_at(plain.form_radius_mm), plain.roll_at(plain.tip_radius_mm)
    x = (roll - 0.5 * (first + last)) / (0.5 * (last - first))
    np.testing.assert_allclose(off, 0.006 * x**2, rtol=0, atol=EXACT)
    # the fillet goes along at its upper end and stays where it was at its lower one
    low, _ = profile.curve.range_of("flank")
    exact = gear_profile(gear(), "body_1").curve
    _, moved = exact.arc_length_of(profile.curve.point([0.0, low]))
    np.testing.assert_allclose(moved, [0.0, 0.006], rtol=0, atol=1e-6)


@pytest.mark.parametrize("outward", [1, -1])
@pytest.mark.parametrize("power", [1, 2])
@pytest.mark.parametrize(("relief", "crowning"), [(0.02, 0.0), (0.0, 0.006), (0.02, 0.006)])
def test_derivatives_of_modifications_are_those_of_the_metal_taken_off(
    relief: float, crowning: float, power: int, outward: int
) -> None:
    """Wrong ones left every place of the flank where it was and bent only the fitted curve.

    Central differences of parabolas are exact, on both sides of the start of the relief.
    """
    form, start, tip = (0.2, 0.5, 0.8)[::outward]
    step = 0.01
    roll = np.array([0.25, 0.4, 0.47, 0.53, 0.6, 0.75])
    made = Modifications(outward * relief, start, power, outward * crowning, form, tip)
    (less, *_), (off, first, second), (more, *_) = (made.at(roll + d) for d in (-step, 0.0, step))
    np.testing.assert_allclose(first, (more - less) / (2 * step), rtol=0, atol=1e-12)
    np.testing.assert_allclose(second, (more - 2 * off + less) / step**2, rtol=0, atol=1e-12)


@pytest.mark.parametrize("power", [1, 2])
def test_derivatives_of_a_modified_flank_are_those_of_its_places(power: int) -> None:
    """Differences, with metal taken off as deep as the flank is high: a wrong factor is seen."""
    flank = InvoluteFlank(30.0, 0.1, Modifications(4.0, 0.5, power, 3.0, 0.2, 0.8))
    roll, step = np.array([0.25, 0.45, 0.55, 0.75]), 1e-4
    (less, *_), (here, first, second), (more, *_) = (
        flank.place(roll + d) for d in (-step, 0.0, step)
    )
    np.testing.assert_allclose(first, (more - less) / (2 * step), rtol=0, atol=1e-5)
    np.testing.assert_allclose(second, (more - 2 * here + less) / step**2, rtol=0, atol=1e-4)


def test_tip_rounding_touches_flank_and_tip_circle() -> None:
    curve = gear_profile(gear(tip_radius_mm=0.5), "body_1").curve
    assert not curve.corners.any()
    s = np.linspace(*curve.range_of("tip_radius"), 100)
    np.testing.assert_allclose(curve.curvature(s[1:-1]), 2.0, rtol=0, atol=1e-4)
    before, after = curve.tangent([s[0] - 1e-9, s[0] + 1e-9])
    np.testing.assert_allclose(before, after, rtol=0, atol=1e-6)
    end, tangent = curve.point(s[-1:])[0], curve.tangent(s[-1:])[0]
    assert np.hypot(*end) == pytest.approx(41.23, abs=EXACT)
    assert end @ tangent / 41.23 == pytest.approx(0.0, abs=1e-7)
    assert (np.hypot(*curve.point(s).T) <= 41.23 + EXACT).all()


def test_tip_chamfer_has_its_height_and_two_corners() -> None:
    profile = gear_profile(gear(tip_chamfer_mm=0.5), "body_1")
    curve = profile.curve
    low, high = curve.range_of("tip_chamfer")
    assert np.hypot(*curve.point([low])[0]) == pytest.approx(41.23 - 0.5, abs=EXACT)
    assert np.hypot(*curve.point([high])[0]) == pytest.approx(41.23, abs=EXACT)
    assert curve.breaks[curve.corners].tolist() == [low, high]
    assert profile.mode_range_mm == curve.range_of("flank")


def test_modes_live_on_flank_and_relief_not_on_the_tip_rounding() -> None:
    spec = gear(tip_radius_mm=0.3, tip_relief_um=10.0, tip_relief_start_diameter_mm=79.0)
    profile = gear_profile(spec, "body_1")
    assert profile.mode_range_mm == profile.curve.range_of("flank", "relief")
    assert profile.mode_range_mm[1] == profile.curve.range_of("tip_radius")[0]


def test_rotated_profile_turns_curve_and_angles() -> None:
    profile = gear_profile(gear(), "body_1")
    turned = profile.rotated(0.3)
    place = turned.curve.point([turned.curve.length_mm])[0]
    assert np.arctan2(place[1], place[0]) == pytest.approx(turned.involute.polar_angle_at(41.23))
    assert turned.involute.half_angle_at(36.0) == profile.involute.half_angle_at(36.0)
    np.testing.assert_allclose(
        np.hypot(*turned.outline().T), np.hypot(*profile.outline().T), rtol=ROUND_OFF, atol=0
    )


def test_outline_goes_from_cut_to_cut() -> None:
    outline = gear_profile(gear(), "body_1").outline()
    polar = np.arctan2(outline[:, 1], outline[:, 0])
    assert polar[[0, -1]] == pytest.approx([-pi / 16, pi / 16], rel=ROUND_OFF)
    np.testing.assert_allclose(outline, outline[::-1] * [1.0, -1.0], rtol=0, atol=1e-12)
    assert np.hypot(*outline.T).max() == pytest.approx(41.23, rel=ROUND_OFF)


@pytest.mark.parametrize(
    ("keys", "key", "expected", "found"),
    [
        ({"teeth": 2}, "teeth", "at least 3", "2"),
        ({"tip_diameter_mm": 100.0}, "tip_diameter_mm", "less than 86.2204", "100"),
        ({"tip_diameter_mm": 67.0}, "tip_diameter_mm", "more than the form diameter 67.72", "67"),
        ({"bore_diameter_mm": 62.4}, "bore_diameter_mm", "root diameter 62.3880", "62.4"),
        ({"fillet_radius_factor": 0.48}, "fillet_radius_factor", "at most 0.471911", "0.48"),
        ({"dedendum_factor": 2.2}, "dedendum_factor", "less than 2.1579", "2.2"),
        ({"profile_shift": -5.0}, "profile_shift", "thickness at its base", "-5"),
        ({"tip_radius_mm": 5.0}, "tip_radius_mm", "largest rounding", "5"),
        ({"tip_chamfer_mm": 9.0}, "tip_chamfer_mm", "less than the height of the flank", "9"),
        (
            {"tip_relief_um": 10.0, "tip_relief_start_diameter_mm": 60.0},
            "tip_relief_start_diameter_mm",
            "between the form diameter",
            "60",
        ),
        ({"profile_crowning_um": 3000.0}, "profile_crowning_um", "less material", "3000"),
        ({"pitch_errors_um": (1.0, 2.0)}, "pitch_errors_um", "one entry per tooth: 16", "2"),
    ],
)
def test_impossible_gear_is_refused(keys: dict, key: str, expected: str, found: str) -> None:
    with pytest.raises(SceneError) as caught:
        build_involute_body(gear(rigid=True, **keys), "body_1", flank_element_mm=1.0)
    assert caught.value.key == f"body_1.{key}"
    assert expected in caught.value.expected
    assert caught.value.found.startswith(found)
    assert "\n" not in str(caught.value)


def test_largest_tip_diameter_of_the_message_is_that_of_the_pointed_tooth() -> None:
    with pytest.raises(SceneError) as caught:
        gear_profile(gear(tip_diameter_mm=100.0), "body_1")
    largest = float(caught.value.expected.split()[2].rstrip(","))
    involute = gear_profile(gear(), "body_1").involute
    roll = sqrt((largest / 2 / involute.base_radius_mm) ** 2 - 1)
    assert roll - atan(roll) == pytest.approx(involute.base_half_angle_rad, abs=1e-5)
    gear_profile(gear(tip_diameter_mm=largest - 1e-3), "body_1")


def test_largest_tip_rounding_of_the_message_fits() -> None:
    with pytest.raises(SceneError) as caught:
        gear_profile(gear(tip_radius_mm=5.0), "body_1")
    largest = float(caught.value.expected.split()[2].rstrip(","))
    gear_profile(gear(tip_radius_mm=largest - 1e-3), "body_1")
    with pytest.raises(SceneError):
        gear_profile(gear(tip_radius_mm=largest + 1e-3), "body_1")


def test_missing_metal_below_the_flank_is_refused() -> None:
    with pytest.raises(SceneError) as caught:
        gear_profile(gear(teeth=4, profile_shift=-0.6, tip_diameter_mm=18.0), "body_1")
    assert caught.value.key.startswith("body_1.")


def test_relief_that_is_too_steep_is_not_called_too_deep() -> None:
    spec = gear(tip_relief_um=20.0, tip_relief_start_diameter_mm=82.45)
    with pytest.raises(SceneError) as caught:
        gear_profile(spec, "body_1")
    assert caught.value.key == "body_1.tip_relief_um"
    assert caught.value.expected.startswith("a less steep modification")


def test_profile_of_a_mesh_takes_its_teeth_from_outside() -> None:
    profile = gear_profile(gear(), "body_1.profile", teeth=16)
    np.testing.assert_allclose(
        profile.curve.breaks, gear_profile(gear(), "body_1").curve.breaks, rtol=SOLVER, atol=0
    )


def removed_at(profile: ToothProfile, diameters: list[float]) -> np.ndarray:
    """Metal off, um, along the normals of the involute at these diameters."""
    points = profile.curve.point(sampled(profile, "root_relief", "flank", "relief", n=20001))
    roll, off = metal_off(profile, points)
    rolls = np.sqrt((0.5 * np.array(diameters) / profile.involute.base_radius_mm) ** 2 - 1.0)
    return np.interp(rolls, roll, 1000.0 * off)


def test_double_linear_tip_relief_and_root_relief_follow_their_lines() -> None:
    spec = gear(
        tip_relief_um=40.0,
        tip_relief_start_diameter_mm=76.0,
        tip_relief_shape="double_linear",
        tip_relief_knee_um=10.0,
        tip_relief_knee_diameter_mm=79.0,
        root_relief_um=15.0,
        root_relief_start_diameter_mm=70.0,
    )
    profile = gear_profile(spec, "body_1")
    base = profile.involute.base_radius_mm
    form, tip = profile.involute.form_radius_mm, profile.involute.tip_radius_mm

    def roll(diameter: float) -> float:
        return sqrt((0.5 * diameter / base) ** 2 - 1.0)

    at = [69.0, 70.0, 73.0, 76.0, 77.5, 79.0, 81.0]
    wanted = [
        15.0 * (roll(70.0) - roll(69.0)) / (roll(70.0) - roll(2 * form)),
        *(0.0, 0.0, 0.0),
        10.0 * (roll(77.5) - roll(76.0)) / (roll(79.0) - roll(76.0)),
        10.0,
        10.0 + 30.0 * (roll(81.0) - roll(79.0)) / (roll(2 * tip) - roll(79.0)),
    ]
    np.testing.assert_allclose(removed_at(profile, at), wanted, rtol=0, atol=2e-3)
    marks = [label for label in dict.fromkeys(profile.curve.labels) if label != "fillet"]
    assert marks == ["root_relief", "flank", "relief"]
    assert profile.curve.corners.sum() == 4  # two starts, the knee, the tip
    at_form = metal_off(profile, profile.curve.point([profile.mode_range_mm[0]]))[1]
    np.testing.assert_allclose(1000.0 * at_form, 15.0, rtol=0, atol=1e-6)


def test_parabolic_root_relief_begins_without_a_kink() -> None:
    keys = {"root_relief_um": 20.0, "root_relief_start_diameter_mm": 72.0}
    profile = gear_profile(gear(**keys, root_relief_shape="parabolic"), "body_1")
    assert profile.curve.corners.sum() == 1
    base = profile.involute.base_radius_mm

    def roll(diameter: float) -> float:
        return sqrt((0.5 * diameter / base) ** 2 - 1.0)

    x = (roll(72.0) - roll(70.0)) / (roll(72.0) - roll(2 * profile.involute.form_radius_mm))
    assert removed_at(profile, [70.0])[0] == pytest.approx(20.0 * x**2, abs=2e-3)


@pytest.mark.parametrize(
    ("keys", "line"),
    [
        (
            {"root_relief_um": 10.0, "root_relief_start_diameter_mm": 60.0},
            "body_1.root_relief_start_diameter_mm: expected between the form diameter 67.7289 and",
        ),
        (
            {
                **{"root_relief_um": 10.0, "root_relief_start_diameter_mm": 78.0},
                **{"tip_relief_um": 10.0, "tip_relief_start_diameter_mm": 77.0},
            },
            (
                "body_1.tip_relief_start_diameter_mm: expected between "
                "body_1.root_relief_start_diameter_mm (78) and the tip diameter 82.46, found 77"
            ),
        ),
        (
            {
                **{"tip_relief_um": 10.0, "tip_relief_start_diameter_mm": 77.0},
                **{"tip_relief_shape": "double_linear", "tip_relief_knee_um": 5.0},
                "tip_relief_knee_diameter_mm": 76.0,
            },
            (
                "body_1.tip_relief_knee_diameter_mm: expected between "
                "body_1.tip_relief_start_diameter_mm (77) and"
            ),
        ),
    ],
)
def test_reliefs_in_the_wrong_order_are_refused(keys: dict[str, object], line: str) -> None:
    with pytest.raises(SceneError) as found:
        gear_profile(gear(**keys), "body_1")
    assert str(found.value).startswith(line)


PROTUBERANCE = {"protuberance_mm": 0.12, "grinding_stock_mm": 0.07}


@pytest.mark.parametrize(
    "keys",
    [
        {"teeth": 20, "shift": 0.2},
        {"teeth": 40, "shift": 0.0},
        {"teeth": 90, "shift": 0.1, "fillet_radius_factor": 0.1},
        # the fillet ends on the involute of the protuberance flank
        {"teeth": 90, "shift": 0.5, "fillet_radius_factor": 0.1, "protuberance_angle_deg": 17.0},
    ],
    ids=["few teeth", "many teeth", "sharp rack", "steep protuberance"],
)
def test_protuberance_frees_the_root_up_to_the_form_circle(keys: dict[str, float]) -> None:
    spec = sized(**keys, **PROTUBERANCE)
    profile = gear_profile(spec, "body_1")
    points = profile.curve.point(sampled(profile, "fillet", n=25))
    cut = [depth_in_rack(spec, point) for point in points]
    np.testing.assert_allclose(cut, 0.0, rtol=0, atol=2e-7)
    involute = profile.involute
    plain = InvoluteFlank(
        involute.base_radius_mm, involute.base_half_angle_rad, Modifications.none()
    )
    form = involute.roll_at(involute.form_radius_mm)
    assert depth_in_rack(spec, plain.point(form + 2e-3)) > 1e-6
    assert depth_in_rack(spec, plain.point(form - 2e-3)) < -1e-6
    assert (
        involute.form_radius_mm
        > gear_profile(
            structs.replace(spec, protuberance_mm=None, grinding_stock_mm=0.0), "body_1"
        ).involute.form_radius_mm
    )
