"""Several meshes in slices in one call, with bodies on shafts."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from flankload.contact.meshes import MeshStates, Motion, solve_meshes
from tests.support.sliced_meshes import SLICES, TWIST, shaft, sliced_mesh, sliced_roller

#: Torques on two pinions, N mm.
TORQUES = (36000.0, 15000.0)
ANGLES = np.array([[[0.0, np.pi]]])
BOTH = np.array([[[0.0, np.pi], [0.0, np.pi]]])
EXACT = 1e-12
#: Compliance of a section of a shaft, the same along x and y: mm and rad per N and N mm.
ROUND = 1e-6 * np.diag([3.0, 3.0, 1.0, 2e-3, 2e-3, 0.0])
ROUND[0, 4] = ROUND[4, 0] = 3e-8
ROUND[1, 3] = ROUND[3, 1] = -3e-8


@cache
def alone(level: float, torque: float) -> MeshStates:
    """A pinion on a shaft and the wheel."""
    bodies = [sliced_roller(shaft=shaft(ROUND)), sliced_roller(hand=-1)]
    return solve_meshes(bodies, [sliced_mesh(level)], [Motion(0)], ANGLES, [[torque]])


@cache
def two_pinions(
    level: float, torques: tuple[float, float], coupling: float = 0.0, axial: float | None = None
) -> MeshStates:
    """Two pinions on one wheel, opposite to each other.

    `coupling` in the wheel, part of its compliance; `axial`: the wheel is on a shaft with this
    compliance along its axis.
    """
    own = {}
    if axial is not None:
        compliance = ROUND.copy()
        compliance[2, 2] = axial
        own["shaft"] = shaft(compliance)
    return solve_meshes(
        [
            sliced_roller(shaft=shaft(ROUND)),
            sliced_roller(shaft=shaft(ROUND)),
            sliced_roller(2, hand=-1, coupling=coupling, **own),
        ],
        [
            sliced_mesh(level, bodies=(0, 2)),
            sliced_mesh(level, bodies=(1, 2), sites_before=(0, SLICES), angle_rad=np.pi),
        ],
        [Motion(0), Motion(1)],
        BOTH,
        [torques],
    )


@pytest.mark.parametrize("level", [0.0, 1.0])
def test_pinions_in_slices_apart(level: float) -> None:
    """Without coupling through the wheel, each mesh has the state that it has alone."""
    found = two_pinions(level, TORQUES)
    assert (found.status == 0).all()
    for k, torque in enumerate(TORQUES):
        pair = alone(level, torque)
        forces = pair.site_force_N[0, 0]
        of_mesh = found.site_force_N[0, 0, k * SLICES : (k + 1) * SLICES]
        np.testing.assert_allclose(found.motion[0, 0, k], pair.motion[0, 0, 0], rtol=EXACT)
        np.testing.assert_allclose(of_mesh, forces, rtol=0, atol=EXACT * forces.max())
        np.testing.assert_allclose(
            found.tangent[0, 0, k, k], pair.tangent[0, 0, 0, 0], rtol=100 * EXACT
        )


@pytest.mark.parametrize("level", [0.0, 1.0])
@pytest.mark.parametrize("coupled", [{"coupling": 0.2}, {"axial": 2e-6}])
def test_pinions_in_slices_together(level: float, coupled: dict[str, float]) -> None:
    """Coupled by modes or a shaft, equal loads give a symmetric state, and torques balance."""
    torque = TORQUES[0]
    found = two_pinions(level, (torque, torque), **coupled)
    assert (found.status == 0).all()
    forces = found.site_force_N[0, 0]
    np.testing.assert_allclose(forces[:SLICES], forces[SLICES:], rtol=0, atol=EXACT * forces.max())
    np.testing.assert_allclose(found.motion[0, 0, 0], found.motion[0, 0, 1], rtol=EXACT)
    assert found.motion[0, 0, 0] / alone(level, torque).motion[0, 0, 0] - 1 > 1e-3
    np.testing.assert_allclose(found.resultant[0, 0, :2, 2], -torque, rtol=EXACT)
    uneven = two_pinions(level, TORQUES, **coupled)
    np.testing.assert_allclose(uneven.resultant[0, 0, :2, 2], [-t for t in TORQUES], rtol=EXACT)


@pytest.mark.parametrize("level", [0.0, 1.0])
def test_opposite_forces_on_a_shaft(level: float) -> None:
    """Equal pinions opposite to each other bend and tilt no shaft: only axial forces add up."""
    torque = TORQUES[0]
    stiff = two_pinions(level, (torque, torque), axial=0.0)
    pair = alone(level, torque)
    np.testing.assert_allclose(stiff.motion[0, 0, 0], pair.motion[0, 0, 0], rtol=EXACT)
    one_sided = two_pinions(level, TORQUES, axial=0.0)
    assert one_sided.motion[0, 0, 0] / pair.motion[0, 0, 0] - 1 > 1e-3


@pytest.mark.parametrize("level", [0.0, 1.0])
def test_frames_of_shafts(level: float) -> None:
    """A mesh turned, and its mirror image, with shafts turned and mirrored: the same state."""
    compliance = ROUND + 1e-7 * np.diag([9.0, 2.0, 4.0, 1e-3, 2e-3, 0.0])
    compliance[0, 1] = compliance[1, 0] = 4e-7
    compliance[2, 3] = compliance[3, 2] = 1e-8
    c, s = np.cos(0.7), np.sin(0.7)
    turn = np.kron(np.eye(2), [[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    image = np.diag([1.0, -1.0, 1.0, -1.0, 1.0, -1.0])
    strengths = [0.3, 0.9, 0.5, 1.1]

    def state(matrix: np.ndarray, sense: int, angle_rad: float) -> MeshStates:
        # flanks that touch as working flanks in a mirror image are coast flanks
        ends = strengths if sense > 0 else [*strengths[2:], *strengths[:2]]
        bodies = [
            sliced_roller(
                hand=hand,
                axial=[3.0, -5.0, 4.0, hand * sense * TWIST, *ends],
                shaft=shaft(matrix @ compliance @ matrix.T),
            )
            for hand in (1, -1)
        ]
        mesh = sliced_mesh(level, bodies=(0, 1), angle_rad=angle_rad, sense=sense)
        return solve_meshes(bodies, [mesh], [Motion(0, sign=sense)], ANGLES, [[TORQUES[0]]])

    plain = state(np.eye(6), 1, 0.0)
    assert (plain.status == 0).all()
    for other in (state(turn, 1, 0.7), state(image, -1, 0.0), state(turn @ image, -1, 0.7)):
        np.testing.assert_allclose(other.motion, plain.motion, rtol=EXACT)
        np.testing.assert_allclose(
            other.site_force_N, plain.site_force_N, rtol=0, atol=EXACT * plain.site_force_N.max()
        )
