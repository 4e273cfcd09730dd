"""Helical gear trains and double helical gears: balance, limits as pairs, closed forms."""

from typing import Any

import numpy as np
import pytest

import flankload as fl
from tests.support.paths import SCENES
from tests.support.planetary_stages import gear
from tests.support.solving import solve
from tests.support.tolerances import SOLVER

#: A position and a torque without contact on corners: statics are exact.
EXACT, TORQUE = {"angles_deg": [5.0]}, 6.0
HELIX = 15.0
#: Levers of flanks whose curves are accurate to 1e-9 mm.
LEVERS = 1e-9
#: Elastic flanks turn the forces on lines of action by 0.1 um.
DIRECTIONS = 2e-5
#: Reliefs turn them by up to 2 mrad in parts of the mesh (measured 1e-3).
RELIEVED = 2e-3
#: Share of the lean in the deflection of a leaning half.
LEANING = 0.05
#: Two springs about a loaded state, for an error of a fiftieth of the deflection.
SPRINGS = 2e-3
PER = 1 / np.cos(np.radians(HELIX))
#: Working transverse pressure angle, base helix.
ALPHA = np.arctan(np.tan(np.radians(20.0)) * PER)
SLOPE = np.tan(np.radians(HELIX)) * np.cos(ALPHA)


def helical(teeth: int, hand: str, **keys: Any) -> dict[str, Any]:
    own = gear(teeth, 3, 0, 20) | {"helix_angle_deg": HELIX, "hand": hand}
    return own | {"tip_diameter_mm": 3 * teeth * PER + 5.4} | keys


def common(torque: float) -> dict[str, Any]:
    """Tables that trains and pairs have alike."""
    degrees = {"axial_degree": 6, "load_degree_z": 2, "modes": 3, "flank_element_mm": 2.0}
    return {
        "pair": {"face_width_mm": 15},
        "load": {"torque_Nm": torque},
        "positions": dict(EXACT),
        "effects": {"tip_contact": False},
        "accuracy": {"slices": 5, "estimate": False, **degrees},
    }


def halves(torque: float = TORQUE, pair: Any = None, **train: Any) -> fl.Result:
    """Double helical gears."""
    tables = common(torque)
    tables["pair"] |= pair or {}
    bodies = {"body_1": helical(20, "right"), "body_2": helical(33, "left")}
    keys = {"kind": "double_helical", "groove_width_mm": 10.0, **train}
    return solve(fl.Scene.from_dict({**bodies, "train": keys, **tables}))


def alone(torque: float = TORQUE / 2, **pair: Any) -> fl.Result:
    """One half as a pair."""
    tables = common(torque)
    tables["pair"] |= pair
    bodies = {"body_1": helical(20, "right"), "body_2": helical(33, "left")}
    return solve(fl.Scene.from_dict({**bodies, **tables}))


def test_a_double_helical_pinion_that_is_free_along_its_axis():
    """With any error between them, both halves are pairs with half of the torque."""
    found, half = halves(timing_error_um=20.0), alone()
    for number in (1, 2):
        mesh = found.train.mesh(number)
        np.testing.assert_allclose(mesh.slices.force_N, half.slices.force_N, rtol=1e-8)
    np.testing.assert_allclose(found.load_share, 0.5, rtol=LEVERS)
    # half 2 touches early: the mean of both rotations is that of half of the error
    late = half.transmission_error_um - found.transmission_error_um
    np.testing.assert_allclose(late, 10.0, rtol=1e-7)
    np.testing.assert_allclose(found.train.axial_motion_um, -10.0 / SLOPE, rtol=1e-7)
    np.testing.assert_allclose(
        found.stiffness_tangent_N_per_um, 2 * half.stiffness_tangent_N_per_um, rtol=1e-6
    )
    axial = 500 * TORQUE * np.tan(np.radians(HELIX)) / (30 * PER)
    np.testing.assert_allclose(found.train.axial_force_N, [[axial, -axial]], rtol=LEVERS)
    np.testing.assert_allclose(found.train.torque_2_Nm, -TORQUE * 33 / 20, rtol=LEVERS)


@pytest.mark.parametrize("bearing", [1e9, 200.0])
def test_axial_bearings_of_a_double_helical_pinion(bearing):
    """F2 - F1 = k e/(1 + 2 k tan(beta_b)²/k_a) about the state without an error."""
    even = halves(axial_stiffness_N_per_um=bearing)
    np.testing.assert_allclose(even.load_share, 0.5, rtol=LEVERS)
    found = halves(axial_stiffness_N_per_um=bearing, timing_error_um=0.01)
    k = even.stiffness_tangent_N_per_um / 2
    expected = k * 0.01 / (1 + 2 * k * SLOPE**2 / bearing)
    # transverse forces on the base circle
    forces = 1000 * TORQUE / (30 * PER * np.cos(ALPHA)) * found.load_share
    np.testing.assert_allclose(np.diff(forces)[:, 0], expected, rtol=SPRINGS)
    total = found.train.axial_force_N.sum(axis=1)
    np.testing.assert_allclose(found.train.axial_motion_um, total / bearing, rtol=SOLVER)


def test_misaligned_double_helical_gears():
    """A pair with the misalignment, and one with the opposite: z counts away from the groove."""
    found, rotations = halves(pair={"deviation_um_per_mm": 0.01}), []
    for number, sign in ((1, 1.0), (2, -1.0)):
        half = alone(deviation_um_per_mm=0.01 * sign)
        rotations.append(half.transmission_error_um[0])
        mesh = found.train.mesh(number)
        np.testing.assert_allclose(mesh.slices.force_N, half.slices.force_N, rtol=1e-8)
        factor = found.train.mesh_face_load_factor[number - 1]
        assert factor == pytest.approx(half.slices.face_load_factor, rel=1e-8)
    # by the gap in the middle of the halves, and by the difference of their deflections
    gap = 0.01 * np.cos(ALPHA) * 12.5
    expected = -(gap + 0.5 * (rotations[0] - rotations[1])) / SLOPE
    np.testing.assert_allclose(found.train.axial_motion_um, expected, rtol=1e-6)


def test_bearings_of_a_double_helical_pinion_carry_its_moment():
    """Each half moves and leans as the pinion does: an error of timing loads one side more."""
    keys = {"bearing_stiffness_N_per_um": 300.0, "bearing_tilt_stiffness_Nm_per_mrad": 20.0}
    even = halves(axial_stiffness_N_per_um=1e9, **keys)
    rigid = halves(axial_stiffness_N_per_um=1e9)
    # as seen in the mirror image, halves are alike and the pinion does not lean
    one, two = (even.train.mesh(k).slices.force_N for k in (1, 2))
    np.testing.assert_allclose(one, two, rtol=1e-9)
    push = 1000 * TORQUE / (30 * PER) * np.array([-np.tan(ALPHA), -1.0])
    np.testing.assert_allclose(rigid.train.bearing_force_N[0], [push, -push], rtol=DIRECTIONS)
    np.testing.assert_allclose(even.train.tilt_urad, 0.0, atol=1e-9)
    softer = even.transmission_error_um - rigid.transmission_error_um
    # on the line of action; the contact stiffens
    force = 1000 * TORQUE / (30 * PER * np.cos(ALPHA))
    np.testing.assert_allclose(softer, force / 300.0, rtol=0.02)
    found = halves(axial_stiffness_N_per_um=1e9, timing_error_um=0.2, **keys)
    np.testing.assert_allclose(
        found.train.tilt_urad, found.train.moment_Nm * 1000 / 20.0, rtol=SOLVER
    )
    moment = np.hypot(*found.train.moment_Nm[0])
    apart = force * np.diff(found.load_share[0])[0]
    assert moment == pytest.approx(12.5e-3 * apart, rel=0.2)


def test_a_shaft_between_the_halves():
    """Its twist is an error of half 2, its bending adds to the deflection and leans the halves."""
    width, diameter, modulus, nu = 10.0, 16.0, 206000.0, 0.3
    rigid, found = halves(), halves(groove_diameter_mm=diameter)
    base_radius = 30 * PER * np.cos(ALPHA)
    twist = 500 * TORQUE * width / (modulus / 2 / (1 + nu) * np.pi / 32 * diameter**4)
    late = 1000 * base_radius * twist
    np.testing.assert_allclose(rigid.train.axial_motion_um, 0.0, atol=1e-9)
    np.testing.assert_allclose(found.train.axial_motion_um, late / (2 * SLOPE), rtol=DIRECTIONS)
    np.testing.assert_allclose(found.load_share, 0.5, rtol=1e-9)
    one, two = (found.train.mesh(k).slices.force_N for k in (1, 2))
    np.testing.assert_allclose(one, two, rtol=DIRECTIONS)
    # a cantilever of half of the groove under the force in the middle of the half
    half, arm = 0.5 * width, 12.5
    bending = modulus * np.pi / 64 * diameter**4
    shear = modulus / 2 / (1 + nu) * np.pi / 4 * diameter**2 * 6 * (1 + nu) / (7 + 6 * nu)
    beyond = arm - half
    moved = (half**3 / 3 + half**2 * beyond + half * beyond**2) / bending + half / shear
    across, slope = (half**2 / 2 + half * beyond) / bending, half / bending
    force = 500 * TORQUE / base_radius
    # the axial force at the pitch point bends it in the plane of the axes
    push, about_y = -force * np.sin(ALPHA), -30 * PER * found.train.axial_force_N[0, 0]
    energy = moved * force**2 + 2 * across * push * about_y + slope * about_y**2
    softer = found.transmission_error_um - rigid.transmission_error_um - late / 2
    # halves that lean have other line loads
    np.testing.assert_allclose(softer, 1000 * energy / force, rtol=LEANING)
    assert found.train.mesh_face_load_factor[0] != rigid.train.mesh_face_load_factor[0]


@pytest.mark.parametrize("angle", [180.0, 100.0])
def test_a_helical_idler(angle):
    """Its axial forces cancel, its bearings carry 2 F sin(angle/2 + alpha) and a moment."""
    bodies = {
        "body_1": helical(20, "right"),
        "body_3": helical(27, "left"),
        "body_2": helical(33, "right"),
    }
    keys = {"kind": "idler", "angle_deg": angle, "bearing_tilt_stiffness_Nm_per_mrad": 40.0}
    tables = common(150.0) | {"positions": {"angles_deg": [3.0]}}
    found = solve(fl.Scene.from_dict({**bodies, "train": keys, **tables}))
    train, radius = found.train, 30 * PER
    push = 150e3 / radius / np.cos(ALPHA)
    expected = 2 * push * np.sin(np.radians(angle / 2) + ALPHA)
    np.testing.assert_allclose(train.common_force_N, expected, rtol=DIRECTIONS)
    np.testing.assert_allclose(train.torque_2_Nm, 150 * 33 / 20, rtol=LEVERS)
    axial = 150e3 * np.tan(np.radians(HELIX)) / radius
    np.testing.assert_allclose(
        train.axial_force_N, [[axial, -axial, 0.0]], rtol=LEVERS, atol=LEVERS * axial
    )
    np.testing.assert_allclose(
        train.common_tilt_urad, train.common_moment_Nm * 1000 / 40.0, rtol=SOLVER
    )
    # about the idler: forces and axial forces of both meshes
    assert np.hypot(*train.common_moment_Nm[0]) > 0.5e-3 * axial * 40.5 * PER
    assert (train.mesh_face_load_factor > 1.05).all()


def test_helical_trains_of_the_examples():
    """Closed forms, up to the relieved flanks, whose forces have other directions."""
    coarse = {"accuracy.slices": 5, "accuracy.flank_element_mm": 3, "positions.count": 2}
    idler, pinions = (
        solve(fl.read_scene(SCENES / name).replace(coarse | {"accuracy.estimate": False}))
        for name in ("helical_idler.toml", "helical_pinions.toml")
    )
    push = 200e3 / (30 * PER) / np.cos(ALPHA)
    expected = 2 * push * np.sin(np.radians(60.0) + ALPHA)
    np.testing.assert_allclose(idler.train.common_force_N, expected, rtol=RELIEVED)
    axial = np.tan(np.radians(HELIX)) / PER
    on_idler = 200e3 * axial / 30 * np.array([1.0, -1.0, 0.0])
    np.testing.assert_allclose(
        idler.train.axial_force_N, [on_idler, on_idler], atol=RELIEVED * on_idler[0]
    )
    np.testing.assert_allclose(pinions.load_share, 0.5, atol=RELIEVED)
    on_wheel = 1200e3 * axial / 90 * np.array([1.0, -0.5, -0.5])
    np.testing.assert_allclose(pinions.train.axial_force_N, [on_wheel, on_wheel], rtol=RELIEVED)


def test_helical_meshes_that_are_not_coupled_are_two_pairs():
    """The first one of an idler is the pair alone; two pinions that float share alike."""
    bodies = {
        "body_1": helical(20, "right"),
        "body_3": helical(27, "left"),
        "body_2": helical(33, "right"),
    }
    tables = common(150.0)
    tables["effects"] |= {"mesh_coupling": False}
    found = solve(fl.Scene.from_dict({**bodies, "train": {"kind": "idler"}, **tables}))
    pair = {"body_1": bodies["body_1"], "body_2": bodies["body_3"], **common(150.0)}
    first = solve(fl.Scene.from_dict(pair))
    np.testing.assert_allclose(found.train.mesh(1).slices.force_N, first.slices.force_N, rtol=1e-8)
    two = {
        "body_1": helical(60, "left", bore_diameter_mm=80),
        "body_2": helical(20, "right"),
        "body_3": helical(20, "right"),
    }
    keys = {"kind": "two_pinions", "floating": True, "timing_error_um": 20.0}
    both = solve(fl.Scene.from_dict({**two, "train": keys, **common(900.0)}))
    np.testing.assert_allclose(both.load_share, 0.5, atol=DIRECTIONS)
    np.testing.assert_allclose(both.train.axial_force_N.sum(), 0.0, atol=1e-6 * 900e3)
