"""A helical planetary stage as bodies, meshes and motions: a planet on a shaft, on both flanks."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from flankload.contact.body_record import packed_parts
from flankload.contact.meshes import Members, MeshStates, Motion, solve_meshes, with_members
from tests.support.involute_records import ALPHA, BASE, DISTANCE, LEVELS, TEETH, involute
from tests.support.packed_meshes import mesh_record

TORQUE = 15e3
EDGES = np.array([-6.0, -2.0, 1.0, 6.0])
SLICES = EDGES.size - 1
#: Rotation of the sections of the sun, rad/mm; of its mates by their teeth.
TWIST = 8e-3
TURNS = {name: (1 if name == "sun" else -1) * TEETH["sun"] / z for name, z in TEETH.items()}
EXACT = 1e-12


def helical(
    name: str, senses: tuple[int, ...], hand: int, *parts: tuple[str, NDArray[np.float64]]
) -> NDArray[np.float64]:
    """Record of a body with its slices in meshes whose frames are mirror images or not."""
    edges = hand * EDGES[::hand]
    middles = 0.5 * (edges[1:] + edges[:-1])
    twist = hand * TWIST * TURNS[name]
    smooth = np.zeros((2, 2, 2), order="F")
    smooth[..., 0] = [[2e-7, hand * 3e-8], [hand * 3e-8, 1e-7]]
    of_mesh = np.repeat(np.arange(len(senses)), SLICES)
    record = involute(
        name,
        SLICES * len(senses),
        ring=name == "ring",
        smooth=smooth,
        site_angles=np.concatenate([sense * twist * middles for sense in senses]),
        kernel=9e-6,
        block=np.asfortranarray(1 + (of_mesh[:, np.newaxis] != of_mesh), dtype=np.intc),
    )
    ends = [0.2, 0.9, 0.5, 0.4][::hand]
    # with the other hand, working flanks are as coast flanks at the same end
    ends = ends if hand > 0 else [*ends[2:], *ends[:2]]
    faces = sorted([hand * -7.0, hand * 6.5])
    return packed_parts(record, [("axial", np.array([2.0, *faces, twist, *ends])), *parts])


def stage(level: float, hand: int = 1, diagonal: tuple[float, ...] = (0.0,) * 6) -> MeshStates:
    """One planet at an angle, on a shaft with a diagonal compliance."""
    shaft = np.append(np.diag(diagonal).ravel(), 0.0)
    bodies = [
        helical("sun", (1,), hand),
        helical("planet", (1, -1), hand, ("shaft", shaft)),
        helical("ring", (-1,), hand),
    ]
    meshes = []
    for name, members in (
        ("sun", Members((0, 1), (0, 0), 0.4)),
        ("planet", Members((1, 2), (SLICES, 0), 0.4 + np.pi, -1)),
    ):
        twist = members.sense * hand * TWIST * TURNS[name]
        record = mesh_record(level, DISTANCE, n_sites=SLICES, twist=twist)
        edges = hand * EDGES[::hand]
        meshes.append(with_members(packed_parts(record, [("slices", edges)]), members))
    angles = np.array([[[0.0, np.pi], [np.pi, np.pi]]])
    motions = [Motion(0), Motion(1, sign=-1)]
    states = solve_meshes(bodies, meshes, motions, angles, [[TORQUE, 0.0]])
    assert (states.status == 0).all()
    return states


@pytest.mark.parametrize("level", LEVELS)
def test_torques_of_a_helical_stage(level: float) -> None:
    """With any elasticity: torque M z_r/z_s on the ring, no moment on the planets."""
    states = stage(level, diagonal=(3e-6, 2e-6, 1e-6, 1e-8, 1e-8, 0.0))
    sun, planet, ring = states.resultant[0, 0]
    assert sun[2] == pytest.approx(-TORQUE, rel=EXACT)
    assert planet[2] == pytest.approx(0.0, abs=EXACT * TORQUE)
    assert ring[2] == pytest.approx(-TORQUE * TEETH["ring"] / TEETH["sun"], rel=EXACT)
    push = 2 * np.cos(ALPHA) * TORQUE / BASE["sun"]
    np.testing.assert_allclose(planet[:2], push * np.array([-np.sin(0.4), np.cos(0.4)]), rtol=1e-3)


@pytest.mark.parametrize("level", LEVELS)
def test_axial_forces_of_a_planet_cancel(level: float) -> None:
    """They tilt the planet, but do not move it along its axis."""
    rigid, axial, tilting = (
        stage(level, diagonal=diagonal)
        for diagonal in ((0.0,) * 6, (0.0, 0.0, 1e-4, 0.0, 0.0, 0.0), (0, 0, 0, 1e-8, 1e-8, 0))
    )
    # lumped contacts press on the shaft along the normal at the point of least gap
    rtol = EXACT if level == 0.0 else 2e-4
    np.testing.assert_allclose(axial.motion, rigid.motion, rtol=rtol)
    np.testing.assert_allclose(axial.site_force_N, rigid.site_force_N, rtol=max(rtol, 1e-9))
    assert tilting.motion[0, 0, 0] / rigid.motion[0, 0, 0] - 1 > 1e-2


@pytest.mark.parametrize("level", LEVELS)
def test_the_other_hand_is_a_mirror_image(level: float) -> None:
    """Mirrored in a transverse plane, forces are those of the mirrored slices."""
    diagonal = (3e-6, 2e-6, 1e-6, 1e-8, 2e-8, 0.0)
    right, left = stage(level, 1, diagonal), stage(level, -1, diagonal)
    forces = right.site_force_N[0, 0].reshape(2, SLICES)
    np.testing.assert_allclose(
        left.site_force_N[0, 0].reshape(2, SLICES)[:, ::-1],
        forces,
        rtol=0,
        atol=1e-11 * forces.max(),
    )
    np.testing.assert_allclose(left.motion, right.motion, rtol=1e-11)
