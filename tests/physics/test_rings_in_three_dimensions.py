"""Rings in three dimensions: plane limits, hands, statics, misalignment, end faces, Hertz."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import flankload as fl
from flankload.elasticity.prism.flank_surface import edge_angles
from flankload.mechanisms.flank_pair.assembly import build_bodies
from tests.support.three_dimensional import MIRRORED, deviation, solved, tree_of
from tests.support.tolerances import SOLVER

SPUR, HELICAL = "internal_gear", "internal_helical"
#: Sharp tips: fewer modes, and no contact beside the flanks.
PLAIN = {
    **{f"body_{z}__tip_radius_mm": None for z in (1, 2)},
    **{f"body_{z}__tip_relief_{key}": None for z in (1, 2)
       for key in ("um", "shape", "start_diameter_mm")},
}  # fmt: skip
PLANE = {"accuracy__axial_degree": None, "accuracy__load_degree_z": None, "accuracy__slices": None}
#: The elements of the ring alone.
RIGID = {"body_1__rigid": True}
TEETH, TORQUE_NMM = (24, 60), 450e3


def solve(name: str, **changes: Any) -> fl.Result:
    """A small pair; a scene is solved once."""
    return solved(name, {"positions__count": 2, **changes})


def spur(**changes: Any) -> fl.Result:
    """The spur pair with sharp tips in three dimensions."""
    return solve(SPUR, effects__dimension=3, **PLAIN, **changes)


# --- plane limits ---------------------------------------------------------------------------------


def test_a_wide_spur_ring_is_in_plane_strain() -> None:
    """Free ends are more compliant, less so in wide pairs; plane stress is the upper limit."""
    lumped = {**PLAIN, **PLANE, **RIGID, "effects__contact": "lumped"}
    strain, stress = (solve(SPUR, **lumped, accuracy__plane=kind) for kind in ("strain", "stress"))
    ratios = []
    for times, degree in ((1.0, 6), (3.0, 10), (9.0, 16)):
        wide = spur(
            **RIGID,
            pair__face_width_mm=20.0 * times,
            load__torque_Nm=450.0 * times,
            accuracy__axial_degree=degree,
            accuracy__load_degree_z=2,
        )
        ratios.append(float(strain.rotation_rad[0] / wide.rotation_rad[0]))
    assert strain.rotation_rad[0] / stress.rotation_rad[0] < ratios[0] < ratios[1] < ratios[2] < 1.0
    # an external pair of m 4.5 and 14 mm: 0.96; half of it at three times the width in modules
    assert ratios[0] == pytest.approx(0.966, abs=0.01)
    assert ratios[2] > 0.99


def test_the_helix_of_a_ring_begins_at_zero() -> None:
    helix = {f"body_{z}__{key}": value for z in (1, 2)
             for key, value in (("helix_angle_deg", 1e-4), ("hand", "right"))}  # fmt: skip
    found, none = spur(**RIGID, **helix), spur(**RIGID)
    assert deviation(found.rotation_rad, none.rotation_rad) < 1e-6
    assert deviation(found.slice_line_load_N_per_mm, none.slice_line_load_N_per_mm) < 1e-3


# --- symmetries -----------------------------------------------------------------------------------

ONE_SIDED = {
    **RIGID,
    "body_1__helix_slope_um": 12.0,
    "body_2__end_relief_um": [0.0, 15.0],
    "body_2__end_relief_length_mm": [4.0, 6.0],
    "body_2__axial_offset_mm": 2.0,
    "body_2__profile_twist_um": 10.0,
    "pair__inclination_um_per_mm": 0.2,
}
ONE_SIDED_MIRRORED = {
    **RIGID,
    "body_1__helix_slope_um": -12.0,
    "body_2__end_relief_um": [15.0, 0.0],
    "body_2__end_relief_length_mm": [6.0, 4.0],
    "body_2__axial_offset_mm": -2.0,
    "body_2__profile_twist_um": -10.0,
    "pair__inclination_um_per_mm": -0.2,
}


def test_a_mirrored_helical_ring() -> None:
    """z becomes -z and both hands change: mirrored line loads, the same rotation."""
    one = solve(HELICAL, **ONE_SIDED)
    two = solve(HELICAL, **ONE_SIDED_MIRRORED, body_1__hand="left", body_2__hand="left")
    assert deviation(two.rotation_rad, one.rotation_rad) < MIRRORED
    loads = two.slice_line_load_N_per_mm[..., ::-1]
    assert deviation(loads, one.slice_line_load_N_per_mm) < 10 * MIRRORED
    assert one.slices is not None
    assert two.slices is not None
    assert deviation(-two.slices.axial_force_N, one.slices.axial_force_N) < MIRRORED


def test_a_helix_slope_of_planet_or_ring_is_the_same_gap() -> None:
    equal = {**RIGID, "body_1__face_width_mm": None}
    one, two = (solve(HELICAL, **equal, **{f"body_{z}__helix_slope_um": 15.0}) for z in (1, 2))
    assert deviation(one.rotation_rad, two.rotation_rad) < SOLVER
    assert deviation(one.slice_line_load_N_per_mm, two.slice_line_load_N_per_mm) < SOLVER
    assert one.slices is not None
    even = solve(HELICAL, **equal).slices
    assert even is not None
    assert (one.slices.tilting_moment_Nm < even.tilting_moment_Nm).all()


# --- statics --------------------------------------------------------------------------------------


def test_forces_on_planet_and_ring() -> None:
    """Torques in the ratio of the teeth, axial forces equal and opposite, by both normals."""
    found = solve(HELICAL, accuracy__slices=16, positions__count=8)
    slope, distance_mm = np.tan(np.radians(15.0)), 55.84
    radii = [3.0 * z / 2.0 / np.cos(np.radians(15.0)) for z in TEETH]
    torques, axial = [], []
    for p in range(found.position_rad.size):
        table = found.pairs(p)
        levers = [
            x_mm * table.normal_y - table.y_mm * table.normal_x
            for x_mm in (table.x_mm, table.x_mm - distance_mm)
        ]
        in_section = table.force_N / np.hypot(1.0, slope / radii[0] * levers[0])
        torques.append([in_section @ lever for lever in levers])
        # equal hands: the normal of each body is perpendicular to its helices
        axial.append([in_section @ levers[z] * slope / radii[z] for z in (0, 1)])
    one, two = np.abs(torques).T
    np.testing.assert_allclose(one, TORQUE_NMM, rtol=1e-4)
    assert (two / one).mean() == pytest.approx(TEETH[1] / TEETH[0], rel=5e-4)
    np.testing.assert_allclose(*np.transpose(axial), rtol=2e-3)
    assert found.slices is not None
    np.testing.assert_allclose(np.abs(axial)[:, 0], found.slices.axial_force_N, rtol=2e-3)
    # a right-hand planet that turns counter-clockwise is pushed along z, as beside a wheel
    assert (found.slices.axial_force_N > 0).all()


def test_a_ring_on_springs() -> None:
    """Radial springs of the ring deflect along the line of action: c T/r_b² of rotation."""
    softness = 2e-6
    springs = np.diag([softness, softness, 0.0, 0.0, 0.0, 0.0]).tolist()
    even, moved = spur(), spur(body_2__shaft={"compliance": springs})
    base_mm = float(even.reference_radius_mm)
    # tip corners push along other normals
    normal = ~even.corner_contact.any(axis=1)
    assert normal.any()
    np.testing.assert_allclose(
        (moved.rotation_rad - even.rotation_rad)[normal],
        softness * TORQUE_NMM / base_mm**2,
        rtol=1e-3,
    )


def test_friction_of_a_ring_as_in_the_plane() -> None:
    """Friction reduces the rotation of the pinion of a spur pair by the same part."""
    lumped = {**PLAIN, **PLANE, **RIGID, "effects__contact": "lumped"}
    friction = {"effects__friction_coefficient": 0.1}
    plane = solve(SPUR, **lumped, **friction).rotation_rad / solve(SPUR, **lumped).rotation_rad
    found = spur(**RIGID, **friction).rotation_rad / spur(**RIGID).rotation_rad
    np.testing.assert_allclose(found, plane, atol=2e-3)
    assert (plane < 0.995).all()


def test_hertz_in_a_slice() -> None:
    """The concave flank of the ring lies closer: 1/R = 1/R_1 - 1/R_2."""
    found = spur(positions__count=8)
    p, s = np.unravel_index(found.load_share.argmax(), found.load_share.shape)
    table = found.pairs(int(p))
    j = found.slice_z_mm.size // 2
    here = (table.site == found.sites[s]) & (table.z_mm == found.slice_z_mm[j])
    radii_mm = [
        float(np.abs((table.x_mm - x) * table.normal_x + table.y_mm * table.normal_y)[here][0])
        for x in (0.0, 53.93)
    ]
    load = found.slice_line_load_N_per_mm[p, s, j]
    curvature = 1.0 / radii_mm[0] - 1.0 / radii_mm[1]
    wanted = np.sqrt(load * curvature * 206000.0 / (2.0 * np.pi * (1.0 - 0.3**2)))
    assert found.slice_peak_pressure_MPa[p, s, j] == pytest.approx(wanted, rel=1e-3)


# --- geometry -------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["helical_gear", HELICAL])
@pytest.mark.parametrize("key", ["inclination", "deviation"])
def test_a_misalignment_by_an_exact_rotation(name: str, key: str) -> None:
    """Axis 2 is rotated in space; the gap along the base tangent grows by the key times z."""
    tree = tree_of(name, {"body_1__lead_crowning_um": None, "body_2__lead_crowning_um": None})
    pair = build_bodies(fl.Scene.from_dict(tree))
    assert pair.pairing.gear_geometry is not None
    alpha = pair.pairing.gear_geometry.pressure_angle_rad
    # the axes of an internal pair approach where the gap opens
    outward = 1.0 if name == "helical_gear" else -1.0
    angle, z = 1e-5, 10.0
    at_z = angle * z * outward * np.array([[1.0, 0.0], [0.0, 1.0]][key == "deviation"])
    opened = _gap_rad(pair, z, angle * outward, key) - _gap_rad(pair, z, 0.0, key)
    assert pair.body_1.base_radius_mm is not None
    factor = np.sin(alpha) if key == "inclination" else np.cos(alpha)
    assert np.hypot(*at_z) == pytest.approx(1e-4)
    assert opened * pair.body_1.base_radius_mm == pytest.approx(angle * z * factor, rel=2e-3)


def _gap_rad(pair: Any, z: float, angle: float, key: str) -> float:
    """Least angle between both flanks of pair 0 at z, body 2 rotated in space about its middle."""
    (s_1, s_2) = (np.linspace(*body.mode_range_mm, 4001) for body in (pair.body_1, pair.body_2))
    flank_1 = _turned(pair.body_1.curve.point(s_1), pair.pairing.turns_at_zero_rad[0])
    flank_2 = _turned(pair.body_2.curve.point(s_2), pair.pairing.turns_at_zero_rad[1])
    # straight teeth: the section at z is that at 0
    c, s = np.cos(angle), np.sin(angle)
    if key == "inclination":
        x, y = c * flank_2[:, 0] + s * z, flank_2[:, 1]
    else:
        x, y = flank_2[:, 0], c * flank_2[:, 1] + s * z
    x = x + pair.pairing.center_distance_mm
    polar_1, polar_2 = np.arctan2(*flank_1.T[::-1]) % (2 * np.pi), np.arctan2(y, x) % (2 * np.pi)
    radius_1, radius_2 = np.hypot(*flank_1.T), np.hypot(x, y)
    order = np.argsort(radius_1)
    inside = (radius_2 > radius_1.min()) & (radius_2 < radius_1.max())
    gaps = polar_2 - np.interp(radius_2, radius_1[order], np.unwrap(polar_1)[order])
    return float(((gaps[inside] + np.pi) % (2 * np.pi) - np.pi).min())


def _turned(points: np.ndarray, angle: float) -> np.ndarray:
    c, s = np.cos(angle), np.sin(angle)
    return np.asarray(points @ np.array([[c, s], [-s, c]]))


def test_edges_of_a_ring() -> None:
    """The angle of the metal between flank and end face, by normals in space."""
    body = build_bodies(fl.Scene.from_dict(tree_of(HELICAL, {}))).body_2
    twist, middle = body.axial.twist_rad_per_mm, 0.5 * sum(body.mode_range_mm)
    step = 1e-5
    ahead, behind = (body.curve.point([middle + sign * step])[0] for sign in (1, -1))
    place = body.curve.point([middle])[0]
    along_s = np.append(ahead - behind, 0.0) / (2 * step)
    along_z = np.array([-twist * place[1], twist * place[0], 1.0])
    normal = np.cross(along_z, along_s)
    normal /= np.linalg.norm(normal)
    # out of the metal: beside the flank, at the same radius, the metal is at larger angles
    around = np.array([-place[1], place[0], 0.0])
    normal *= -np.sign(normal @ around)
    low, high = edge_angles(body, twist)
    assert high == pytest.approx(90.0 + np.degrees(np.arcsin(normal[2])), abs=1e-3)
    assert low == pytest.approx(180.0 - high)
    assert high > 100.0


# --- scene ----------------------------------------------------------------------------------------


def test_planet_and_ring_have_the_same_hand() -> None:
    with pytest.raises(fl.SceneError) as caught:
        fl.Scene.from_dict(tree_of(HELICAL, {"body_2__hand": "left"}))
    assert caught.value.key == "body_2.hand"
    assert caught.value.expected == "'right', as body_1.hand, since body_2 has internal teeth"


def test_the_transverse_section_of_a_helical_ring() -> None:
    """Its profile is that of the plane scene beside it: pressure angle, module, thickness."""
    from flankload.scene.plane_section import plane_section

    scene = fl.Scene.from_dict(tree_of(HELICAL, {"body_2__root_fillet_radius_mm": 0.5}))
    helical, plane = build_bodies(scene).body_2, build_bodies(plane_section(scene)).body_2
    assert helical.involute is not None
    assert plane.involute is not None
    for key in ("base_radius_mm", "reference_radius_mm", "base_half_angle_rad", "form_radius_mm"):
        one, two = getattr(helical.involute, key), getattr(plane.involute, key)
        assert one == pytest.approx(two, rel=1e-12)
    assert helical.involute.reference_radius_mm == pytest.approx(90.0 / np.cos(np.radians(15.0)))
