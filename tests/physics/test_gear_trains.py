"""Gear trains: forces on the bearings of an idler, two pinions on one wheel, limits as pairs."""

from typing import Any

import numpy as np
import pytest

import flankload as fl
from flankload.mechanisms.registry import mechanism_of
from tests.support.planetary_stages import gear
from tests.support.solving import solve
from tests.support.tolerances import SOLVER

#: Forces on the line of action: levers of elastic flanks differ by 0.1 um (measured 7e-6).
LEVERS = 2e-5
#: Two springs about a loaded state, for an error of a fiftieth of the deflection (measured 3e-4).
SPRINGS = 2e-3
RADII = {teeth: 1.5 * teeth * np.cos(np.radians(20.0)) for teeth in (20, 27, 33, 60)}


def common(torque: float, positions: dict[str, Any]) -> dict[str, Any]:
    """Tables that trains and pairs have alike."""
    return {
        "pair": {"face_width_mm": 20},
        "load": {"torque_Nm": torque},
        "positions": positions,
        "effects": {"contact": "lumped"},
        "accuracy": {"estimate": False},
    }


def train(
    kind: str,
    torque: float,
    *teeth: int,
    angles: list[float] | None = None,
    rigid: str = "",
    solved: bool = True,
    **keys: Any,
) -> Any:
    """Gears 1, 2, 3 of module 3 without profile shift or backlash; at angles, or 8 positions."""
    bodies = {f"body_{k + 1}": gear(z, 3, 1.8, 20) for k, z in enumerate(teeth)}
    if rigid:
        bodies[rigid]["rigid"] = True
    tables = common(torque, {"angles_deg": angles} if angles else {"count": 8})
    scene = fl.Scene.from_dict({**bodies, "train": {"kind": kind, **keys}, **tables})
    return solve(scene) if solved else scene


def on_lines_of_action(found: fl.Result) -> np.ndarray:
    """(P,) Whether no mesh carries load on a corner."""
    return ~found.corner_contact.any(axis=1)


def test_fields_of_an_idler_have_the_forces_of_both_meshes():
    scene = train("idler", 20.0, 20, 33, 27, angles=[5.0], angle_deg=120.0, solved=False)
    found = solve(scene)
    for number, body in enumerate(mechanism_of(scene).fields_of_bodies(scene).values()):
        fields, bearing = body.at(found, 0), found.train.bearing_force_N[0, number]
        assert (fields.force_N * fields.displacement_mm).sum() > 0.0
        np.testing.assert_allclose(fields.force_N.sum(axis=0)[:2], bearing, atol=0.1)


@pytest.mark.parametrize("angle", [180.0, 120.0, 250.0])
def test_the_bearings_of_an_idler_carry_both_meshes(angle):
    """2 F sin(angle/2 + 20 deg): 2 F cos 20 deg with all axes in a line."""
    found = train("idler", 20.0, 20, 33, 27, angle_deg=angle)
    smooth = on_lines_of_action(found)
    assert smooth.sum() > 2
    force = 20e3 / RADII[20]
    expected = 2 * force * abs(np.sin(np.radians(angle / 2 + 20)))
    np.testing.assert_allclose(found.site_force_N[smooth], force, rtol=LEVERS)
    np.testing.assert_allclose(found.train.common_force_N[smooth], expected, rtol=LEVERS)
    np.testing.assert_allclose(found.train.torque_2_Nm[smooth], 20 * 33 / 20, rtol=LEVERS)
    np.testing.assert_allclose(found.train.torque_3_Nm[smooth], 0.0, atol=20 * LEVERS)
    # all forces of the train are in balance
    balance = found.train.bearing_force_N[smooth].sum(axis=1)
    np.testing.assert_allclose(balance, 0.0, atol=SOLVER * force)


def test_the_layout_of_an_idler_moves_the_phase_of_its_second_mesh():
    """Turned by a pitch of the idler, 360/27 deg, the second mesh of a rigid idler is the same."""
    keys = {"angles": [1.0, 4.0], "rigid": "body_3"}
    one, other, half = (
        train("idler", 20.0, 20, 33, 27, angle_deg=120.0 + 360.0 / 27 * part, **keys)
        for part in (0.0, 1.0, 0.5)
    )
    np.testing.assert_allclose(one.rotation_rad, other.rotation_rad, rtol=1e-9)
    assert abs(half.rotation_rad / one.rotation_rad - 1.0).max() > 1e-2
    assert np.diff([one.train.phases[1], half.train.phases[1]]) % 1.0 == pytest.approx(0.5)


def test_meshes_that_are_not_coupled_are_two_pairs_in_series():
    """The first one is the pair alone; the approach of both meshes adds up."""
    scene = train("idler", 20.0, 20, 33, 27, angles=[1.0, 4.0], solved=False)
    found = solve(scene.replace({"effects.mesh_coupling": False}))
    bodies = {"body_1": gear(20, 3, 1.8, 20), "body_2": gear(27, 3, 1.8, 20)}
    alone = solve(fl.Scene.from_dict({**bodies, **common(20.0, {"angles_deg": [1.0, 4.0]})}))
    one, two = found.train.mesh(1), found.train.mesh(2)
    np.testing.assert_allclose(one.rotation_rad, alone.rotation_rad, rtol=SOLVER)
    total = one.rotation_rad * RADII[20] + two.rotation_rad * RADII[27]
    np.testing.assert_allclose(found.rotation_rad * RADII[20], total, rtol=SOLVER)


@pytest.mark.parametrize("bearing", [None, 100.0])
def test_two_pinions_share_as_springs(bearing):
    """F3 - F2 = k e/(1 + 2 k/k_b) about the loaded state of a rigid wheel."""
    keys: dict[str, Any] = {"bearing_stiffness_N_per_um": bearing} if bearing else {}
    keys |= {"angles": [0.0], "rigid": "body_1"}
    even = train("two_pinions", 1200.0, 60, 20, 20, **keys)
    np.testing.assert_allclose(even.load_share, 0.5, atol=SOLVER)
    found = train("two_pinions", 1200.0, 60, 20, 20, timing_error_um=0.5, **keys)
    stiffness = even.stiffness_tangent_N_per_um[0] / 2
    expected = stiffness * 0.5 / (1 + 2 * stiffness / bearing if bearing else 1.0)
    apart = found.site_force_N[0, 1] - found.site_force_N[0, 0]
    assert apart == pytest.approx(expected, rel=SPRINGS)
    assert found.site_force_N.sum() == pytest.approx(1200e3 / RADII[60], rel=LEVERS)
    moved = found.train.orbit_um[0] @ [np.sin(np.radians(20)), np.cos(np.radians(20))]
    assert moved == pytest.approx(apart / bearing if bearing else 0.0, rel=LEVERS)


def test_a_floating_wheel_loads_both_pinions_alike():
    """It moves by half of the timing error along the line of action."""
    found = train(
        "two_pinions", 1200.0, 60, 20, 20, angles=[0.0], timing_error_um=20.0, floating=True
    )
    np.testing.assert_allclose(found.load_share, 0.5, atol=LEVERS)
    push = np.array([np.sin(np.radians(20)), np.cos(np.radians(20))])
    np.testing.assert_allclose(found.train.orbit_um[0], 10.0 * push, rtol=1e-6)
    assert found.train.common_force_N == pytest.approx(0.0, abs=1e-6 * found.site_force_N.sum())
    torques = found.train.torque_2_Nm, found.train.torque_3_Nm
    np.testing.assert_allclose(torques, -200.0, rtol=LEVERS)


def test_pinions_of_different_sizes_and_places():
    """Torques by their radii; the phase follows from the teeth of the wheel and the angle."""
    found = train("two_pinions", 120.0, 60, 20, 33, angle_deg=100.0, rigid="body_1")
    p = int(np.flatnonzero(on_lines_of_action(found))[0])
    force = found.site_force_N[p]
    assert force.sum() == pytest.approx(120e3 / RADII[60], rel=LEVERS)
    torques = [found.train.torque_2_Nm[p], found.train.torque_3_Nm[p]]
    expected = -force * [RADII[20], RADII[33]] / 1000
    np.testing.assert_allclose(torques, expected, rtol=LEVERS)
    # 60 * 100/360 = 16.667 pitches
    assert found.train.phases[1] == pytest.approx(1 / 3, rel=1e-12)
    turned = train("two_pinions", 120.0, 60, 20, 33, angle_deg=106.0, rigid="body_1")
    np.testing.assert_allclose(turned.rotation_rad, found.rotation_rad, rtol=1e-9)


def test_without_torque_the_flanks_touch():
    found = train("idler", 0.0, 20, 33, 27, angles=[1.0])
    assert found.transmission_error_um == pytest.approx(0.0, abs=1e-3)
    assert not found.site_force_N.any()
