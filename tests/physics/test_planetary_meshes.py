"""A planetary stage as bodies, meshes and motions: sun, planets on both flanks, ring.

All teeth in contact are involutes at the pitch point, with one pair in each mesh.
"""

from __future__ import annotations

import numpy as np
import pytest

from flankload.contact.meshes import (
    Members,
    MeshStates,
    Motion,
    solve_meshes,
    with_members,
    with_support,
)
from tests.support.involute_records import ALPHA, BASE, DISTANCE, LEVELS, TEETH, involute
from tests.support.packed_meshes import mesh_record

#: Torque on the sun for each planet, N mm.
TORQUE = 50e3


def stage(
    level: float,
    psi: list[float],
    *,
    errors_mm: list[float] | None = None,
    floating: bool = False,
    pin: float = 0.0,
) -> MeshStates:
    """Stage with planets at angles `psi`, with pins displaced along the push of the sun.

    `pin`: tangential compliance of the pins, mm/N.
    """
    n = len(psi)
    sun, ring = involute("sun", n), involute("ring", n, ring=True)
    across = [np.array([-np.sin(a), np.cos(a)]) for a in psi]
    planets = []
    for c in across:
        support = np.zeros((3, 3))
        support[:2, :2] = pin * np.outer(c, c)
        planets.append(with_support(involute("planet", 2), support))
    meshes = []
    for j, a in enumerate(psi):
        meshes += [
            with_members(mesh_record(level, DISTANCE), Members((0, 1 + j), (j, 0), a)),
            with_members(
                mesh_record(level, DISTANCE), Members((1 + j, n + 1), (1, j), a + np.pi, -1)
            ),
        ]
    motions = [Motion(0), *(Motion(1 + j, sign=-1) for j in range(n))]
    if floating:
        motions += [Motion(0, "x"), Motion(0, "y")]
    loads = np.zeros((1, len(motions)))
    loads[0, 0] = n * TORQUE
    displacements = np.zeros((1, n + 2, 3))
    for j, e in enumerate(errors_mm or [0.0] * n):
        displacements[0, 1 + j, :2] = e * across[j]
    angles = np.tile([[0.0, np.pi], [np.pi, np.pi]], (1, n, 1))
    return solve_meshes([sun, *planets, ring], meshes, motions, angles, loads, displacements)


def shares(states: MeshStates) -> np.ndarray:
    """(n,) Part of each planet in the torque of the sun."""
    force = states.site_force_N[0, 0, ::2]
    return np.asarray(force / force.sum())


def even(n: int, start: float = 0.0) -> list[float]:
    return [start + 2 * np.pi * j / n for j in range(n)]


@pytest.mark.parametrize("level", LEVELS)
def test_torques_follow_from_the_tooth_numbers(level: float) -> None:
    """With any elasticity: M z_r/z_s on the ring, no moment on planets, pins twice the force."""
    states = stage(level, [0.4], pin=3e-6)
    assert (states.status == 0).all()
    sun, planet, ring = states.resultant[0, 0]
    assert sun[2] == pytest.approx(-TORQUE, rel=1e-12)
    assert planet[2] == pytest.approx(0.0, abs=1e-12 * TORQUE)
    assert ring[2] == pytest.approx(-TORQUE * TEETH["ring"] / TEETH["sun"], rel=1e-12)
    push = 2 * np.cos(ALPHA) * TORQUE / BASE["sun"]
    np.testing.assert_allclose(planet[:2], push * np.array([-np.sin(0.4), np.cos(0.4)]), rtol=1e-3)


@pytest.mark.parametrize("level", LEVELS)
def test_sharing_of_pin_errors(level: float) -> None:
    """Fixed sun: K = 1 + (n - 1) x with x of the tangent stiffness; floating: equal shares."""
    error = 1e-3
    even_state = stage(level, even(3))
    assert (even_state.status == 0).all()
    np.testing.assert_allclose(shares(even_state), 1 / 3, rtol=1e-12)
    stiffness = 1 / (3 * even_state.tangent[0, 0, 0, 0] * BASE["sun"] ** 2)
    x = stiffness * error * 2 * np.cos(ALPHA) / (3 * TORQUE / BASE["sun"])
    fixed = shares(stage(level, even(3), errors_mm=[-error, 0.0, 0.0]))
    assert 3 * fixed.max() == pytest.approx(1 + 2 * 3 * x / 3, rel=2e-3)
    floating = stage(level, even(3), errors_mm=[-error, 0.0, 0.0], floating=True)
    assert (floating.status == 0).all()
    np.testing.assert_allclose(shares(floating), 1 / 3, rtol=2e-3)
    assert np.hypot(*floating.motion[0, 0, -2:]) > 0.3 * error


@pytest.mark.parametrize("level", LEVELS)
def test_a_turned_stage_is_the_same(level: float) -> None:
    """Planets renumbered and the stage turned: shares move along, the rotation stays."""
    error = 5e-3
    one = stage(level, even(4), errors_mm=[-error, 0.0, 0.0, 0.0], floating=True)
    other = stage(level, even(4, 1.1), errors_mm=[0.0, 0.0, -error, 0.0], floating=True)
    np.testing.assert_allclose(np.roll(shares(one), 2), shares(other), rtol=1e-11)
    np.testing.assert_allclose(one.motion[0, 0, 0], other.motion[0, 0, 0], rtol=1e-11)


@pytest.mark.parametrize("level", LEVELS)
def test_a_planet_that_lifts_off(level: float) -> None:
    """A pin far behind: its planet carries nothing and turns freely; the others have the state of
    a stage without it.
    """
    states = stage(level, even(3), errors_mm=[1.0, 0.0, 0.0])
    assert (states.status == 0).all()
    assert np.isnan(states.motion[0, 0, 1])
    assert np.isfinite(states.motion[0, 0, [0, 2, 3]]).all()
    np.testing.assert_allclose(shares(states), [0.0, 0.5, 0.5], atol=1e-12)
