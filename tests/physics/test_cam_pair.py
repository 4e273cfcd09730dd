"""A follower on its cam: statics, Hertz, two places at once, wind-up against plain elements."""

from __future__ import annotations

import numpy as np
import pytest

import flankload as fl
from flankload.bodies import WholeMesh
from flankload.elasticity.compliance import JobOptions, flank_compliance
from flankload.elasticity.finite_elements import degrees_of
from flankload.mechanisms.flank_pair.assembly import build_bodies
from flankload.pairing.body_pair import BodyPair
from flankload.pairing.cam_motion import CamContacts
from tests.support.cam_scenes import FLAT_FOLLOWER, TORQUE, WIDTH, cam_scene, lift_and_dwell, waves
from tests.support.plane_stiffness import factored, plane_stiffness
from tests.support.solving import solve

#: Steel in plane strain.
MODULUS = 206000.0 / (1 - 0.3**2)
#: Peak pressure against Hertz's line contact, whose bodies are half-planes.
HERTZ = 5e-3
#: Force against statics where the bodies are almost rigid.
STATICS = 1e-6
#: Wind-up against plain fine elements, and against finer modes and elements.
PLAIN, FINER = 2e-3, 3e-3

FOLLOWERS = pytest.mark.parametrize("follower", [{}, FLAT_FOLLOWER], ids=["roller", "flat"])


def solved(*args: object, **keys: object) -> tuple[fl.Result, BodyPair, CamContacts]:
    scene = fl.Scene.from_dict(cam_scene(*args, **keys))
    pair = build_bodies(scene)
    motion = pair.pairing.motion
    assert motion is not None
    result = solve(scene)
    assert isinstance(result, fl.Result)
    return result, pair, motion.contacts(pair.position_rad)


@FOLLOWERS
@pytest.mark.parametrize("profile", [None, waves()], ids=["disc", "hollows"])
def test_pressure_is_that_of_hertz(profile: list | None, follower: dict) -> None:
    """Curvatures are those at the place of contact, convex and concave."""
    result, pair, contacts = solved(profile, follower, positions={"count": 24})
    own = pair.body_2.curve.curvature(contacts.arc_length_mm)
    if profile is not None and not follower:
        assert own.min() < -0.02
    curvature = own + (0.0 if follower else 1 / 10.0)
    force = result.site_force_N[:, 0] / WIDTH
    peak = np.sqrt(force * MODULUS / 2 * curvature / np.pi)
    np.testing.assert_allclose(result.peak_pressure_MPa[:, 0], peak, rtol=HERTZ)
    half_width = 2 * force / (np.pi * peak)
    for table, expected in zip(result.pair_tables, half_width, strict=True):
        x, squared = table.arc_length_1_mm, table.pressure_MPa**2
        x = x - (x * squared).sum() / squared.sum()
        inside = np.abs(x) < 0.8 * expected
        bend, slope, top = np.polyfit(x[inside], squared[inside], 2)
        found = np.sqrt(slope**2 - 4 * bend * top) / (2 * abs(bend))
        assert found == pytest.approx(expected, rel=HERTZ)


@FOLLOWERS
@pytest.mark.parametrize(
    ("one", "two"),
    [
        ({"young_modulus_MPa": 1e9}, {"young_modulus_MPa": 1e9}),
        ({"rigid": True}, {"young_modulus_MPa": 1e9}),
        ({"young_modulus_MPa": 1e9}, {"rigid": True}),
    ],
    ids=["both stiff", "follower rigid", "cam rigid"],
)
def test_force_is_torque_over_lever(follower: dict, one: dict, two: dict) -> None:
    follower = {**(follower or {}), **one}
    result, _, contacts = solved(lift_and_dwell(), follower, two, positions={"count": 12})
    force = 1000 * TORQUE / contacts.levers()
    np.testing.assert_allclose(result.site_force_N[:, 0], force, rtol=STATICS)


def test_long_arm_does_not_bend_the_gap() -> None:
    """Regression: the large rotation of the arm with a mean lever reduced the pressure by 2 %.

    Statics of steel: the place of contact moves along the roller as the end of the arm turns.
    """
    slender = {"arm_width_mm": 5.0}
    result, pair, contacts = solved(None, slender, positions={"count": 4})
    force = result.site_force_N[:, 0] / WIDTH
    curvature = pair.body_2.curve.curvature(contacts.arc_length_mm) + 0.1
    peak = np.sqrt(force * MODULUS / 2 * curvature / np.pi)
    assert result.rotation_rad.min() > 0.02
    np.testing.assert_allclose(result.peak_pressure_MPa[:, 0], peak, rtol=HERTZ)
    np.testing.assert_allclose(force * WIDTH * contacts.levers(), 1000 * TORQUE, rtol=2e-4)


def test_flat_over_a_hollow_goes_from_nose_to_nose() -> None:
    """If the flat lies on two noses, both carry load; forces and rotation do not jump."""
    _, pair, _ = solved(waves(), FLAT_FOLLOWER, {"rigid": True}, positions={"count": 1})
    low, high = 63.0, 65.0
    before, after = (place(pair, angle) for angle in (low, high))
    assert before - after > 10.0
    border = 0.5 * (before + after)
    for _ in range(40):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if place(pair, middle) > border else (low, middle)
    angles = (low + np.arange(-4, 14) * 0.01).tolist()
    result, _, _ = solved(waves(), FLAT_FOLLOWER, positions={"angles_deg": angles})
    shares = np.array(
        [
            table.force_N[table.arc_length_2_mm > border].sum() / table.force_N.sum()
            for table in result.pair_tables
        ]
    )
    assert shares[0] == pytest.approx(1.0)
    assert shares[-1] == pytest.approx(0.0)
    between = (shares > 0.02) & (shares < 0.98)
    assert between.sum() >= 3
    assert (np.diff(shares) < 1e-9).all()
    assert np.abs(np.diff(result.rotation_rad)).max() < 0.1 * np.mean(result.rotation_rad)


def place(pair: BodyPair, angle_deg: float) -> float:
    """Arc length on the cam where a follower lies without load, mm."""
    assert pair.pairing.motion is not None
    return float(pair.pairing.motion.contacts(np.radians([angle_deg])).arc_length_mm[0])


# --- wind-up against plain elements -------------------------------------------------------------


def pressed(flank, s: np.ndarray, widths: np.ndarray, forces: np.ndarray) -> np.ndarray:
    """Nodal loads along the normal of even pressures on cells, (2N,); total = sum of forces."""
    points, weights = np.polynomial.legendre.leggauss(60)
    shape = np.stack([points * (points - 1) / 2, points * (points + 1) / 2, 1 - points**2])
    slope = np.stack([points - 0.5, points + 0.5, -2 * points])
    loads, total = np.zeros((len(flank.nodes), 2)), 0.0
    for edge in flank.flank_edges:
        along = flank.flank_arc_length[edge]
        if along[0] > along[2]:
            along[0] = 2 * along[2] - along[1]  # a turn begins in this node
        if along[1] < along[2]:
            along[1] = 2 * along[2] - along[0]
        place = along @ shape
        inside = np.abs(place[:, None] - s) <= 0.5 * widths
        pressure = (inside * (forces / widths)).sum(axis=1)
        if not pressure.any():
            continue
        tangent = slope.T @ flank.nodes[edge]
        normal = np.stack([-tangent[:, 1], tangent[:, 0]], axis=1)
        total += weights @ (pressure * np.linalg.norm(normal, axis=1))
        loads[edge] += np.einsum("g,g,qg,gd->qd", weights, pressure, shape, normal)
    return loads.ravel() * (forces.sum() / total)


def recession_work(pair: BodyPair, z: int, table, cell: np.ndarray) -> float:
    """Twice the energy (N mm) that the forces of a position store in a body, by its elements."""
    body = (pair.body_1, pair.body_2)[z]
    mesh = body.mesh
    assert isinstance(mesh, WholeMesh)
    on = table.force_N > 0
    s = (table.arc_length_1_mm, table.arc_length_2_mm)[z][on]
    loads = pressed(mesh.flanks[0], s, cell[on], table.force_N[on])
    matrix = plane_stiffness(mesh.nodes, mesh.cells, body.material, "strain")
    free = np.setdiff1d(np.arange(matrix.shape[0]), degrees_of(mesh.fixed_nodes))
    moved = factored(matrix[free][:, free].tocsc())(loads[free, None])[:, 0]
    return float(loads[free] @ moved) / WIDTH


@pytest.mark.parametrize(
    ("z", "element_mm", "torque", "angle"),
    [(0, 0.6, 20.0, 40.0), (1, 0.35, 200.0, 40.0), (1, 0.35, 200.0, 125.0)],
    ids=["follower", "cam", "cam nose"],
)
def test_wind_up_is_that_of_plain_elements(
    z: int, element_mm: float, torque: float, angle: float
) -> None:
    """One body is soft, so that elements can resolve the contact; no modes, no near field.

    Along the normal of the elastic body phi b_i = eps_i b_i + rec_i at every cell that carries;
    with the forces as weights the recession becomes the work of the forces.
    """
    soft, rigid = {"young_modulus_MPa": 3000.0}, {"rigid": True}
    bodies = (soft, rigid) if z == 0 else (rigid, soft)
    keys = {"positions": {"angles_deg": [angle]}, "load": {"torque_Nm": torque}}
    result, pair, contacts = solved(lift_and_dwell(), *bodies, **keys)
    fine = {
        **keys,
        "accuracy": {"estimate": False, "tangents": False, "flank_element_mm": element_mm},
    }
    plain = build_bodies(fl.Scene.from_dict(cam_scene(lift_and_dwell(), *bodies, **fine)))
    table = result.pairs(0)
    one = np.stack([table.x_mm, table.y_mm], axis=1)
    curve = pair.body_2.curve.rotated(float(contacts.turn_2[0]))
    two = curve.point(table.arc_length_2_mm) + np.array([80.0, 0.0])
    gap = np.arctan2(one[:, 0] * two[:, 1] - one[:, 1] * two[:, 0], (one * two).sum(axis=1))
    own = pair.body_1.curve.rotated(float(contacts.turn_1[0])).tangent(table.arc_length_1_mm)
    tangents, places = (own, curve.tangent(table.arc_length_2_mm)), (one, two)
    lever = np.abs((places[z] * tangents[z]).sum(axis=1))
    cell = table.cell_mm
    work = recession_work(plain, z, table, cell)
    rotation = (table.force_N @ (lever * gap) + work) / (table.force_N @ lever)
    assert result.rotation_rad[0] == pytest.approx(rotation, rel=PLAIN)


@pytest.mark.parametrize(
    ("follower", "cam"),
    [
        ({}, {"rigid": True}),
        (FLAT_FOLLOWER, {"rigid": True}),
        ({"rigid": True}, {}),
        ({"rigid": True}, {"bore_diameter_mm": 46.0}),
    ],
    ids=["roller", "flat", "cam", "thin cam"],
)
def test_wind_up_does_not_change_with_finer_elements(follower: dict, cam: dict) -> None:
    keys: dict = {"positions": {"count": 8}}
    coarse, *_ = solved(lift_and_dwell(), follower, cam, **keys)
    keys["accuracy"] = {"estimate": False, "tangents": False, "tolerance": 1.5e-3}
    fine, *_ = solved(lift_and_dwell(), follower, cam, **keys)
    np.testing.assert_allclose(coarse.rotation_rad, fine.rotation_rad, rtol=FINER)
    np.testing.assert_allclose(coarse.peak_pressure_MPa, fine.peak_pressure_MPa, rtol=HERTZ)


def test_harmonics_of_a_disc_are_those_of_the_disc() -> None:
    """On a disc, a rotated load has the rotated response: harmonics do not mix."""
    scene = cam_scene([[a, 30.0] for a in range(0, 360, 5)])
    body = build_bodies(fl.Scene.from_dict(scene)).body_2
    smooth = flank_compliance(body, JobOptions(n_modes=21, plane="strain")).smooth[0]
    mixed = smooth - np.diag(np.diag(smooth))
    assert np.abs(mixed).max() < 1e-6 * np.abs(smooth).max()
    cosines, sines = np.diag(smooth)[1::2], np.diag(smooth)[2::2]
    np.testing.assert_allclose(cosines, sines, rtol=0, atol=1e-6 * np.abs(smooth).max())
