"""Several bodies and meshes in one call: motions, loads, supports, known displacements."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from flankload.contact.meshes import Members, MeshStates, Motion, solve_meshes, with_members
from flankload.contact.meshes import with_support as on_support
from flankload.errors import InputError
from tests.support.packed_meshes import body_record, mesh_record

if TYPE_CHECKING:
    from numpy.typing import NDArray

#: Torque on a roller, N mm.
TORQUE = 3600.0
#: Two cylinders press each other; the second is the first one turned over.
ANGLES = np.array([[[0.0, np.pi]]])
BOTH = np.array([[[0.0, np.pi], [0.0, np.pi]]])
EXACT = 1e-12


def roller(n_sites: int = 1, coupling: float = 0.0) -> NDArray[np.float64]:
    """One of two cylinders; `coupling` [mm/N] between its sites."""
    n_modes = 3
    smooth = np.zeros((n_modes, n_modes, 2), order="F")
    smooth[..., 0] = 1e-6 * np.eye(n_modes)
    smooth[0, 0, 1] = coupling
    return body_record(n_sites, smooth)


def mesh(level: float, **members: Any) -> NDArray[np.float64]:
    """Mesh of two cylinders."""
    record = mesh_record(level)
    return with_members(record, Members(**members)) if members else record


@cache
def alone(level: float, torque: float = TORQUE) -> MeshStates:
    """Body 1 drives body 2, which does not move."""
    return solve_meshes([roller(), roller()], [mesh(level)], [Motion(0)], ANGLES, [[torque]])


@pytest.mark.parametrize("level", [0.0, 1.0])
def test_a_wheel_with_two_pinions(level: float) -> None:
    """Apart, each mesh is alone; together, each pinion turns further by the wheel between them."""
    motions = [Motion(0), Motion(1)]
    meshes = [
        mesh(level, bodies=(0, 2)),
        mesh(level, bodies=(1, 2), sites_before=(0, 1), angle_rad=2.0),
    ]
    coupling = 3e-7
    apart, together = (
        solve_meshes([roller(), roller(), roller(2, c)], meshes, motions, BOTH, [[TORQUE, TORQUE]])
        for c in (0.0, coupling)
    )
    pair = alone(level)
    assert (apart.status == 0).all()
    assert (together.status == 0).all()
    np.testing.assert_allclose(apart.motion[0, 0], pair.motion[0, 0, 0], rtol=EXACT)
    np.testing.assert_allclose(apart.site_force_N[0, 0], pair.site_force_N[0, 0, 0], rtol=EXACT)
    np.testing.assert_allclose(together.motion[0, 0, 0], together.motion[0, 0, 1], rtol=EXACT)
    lever = TORQUE / pair.site_force_N[0, 0, 0]
    further = together.motion[0, 0, 0] - pair.motion[0, 0, 0]
    assert further * lever == pytest.approx(coupling * pair.site_force_N[0, 0, 0], rel=1e-3)
    np.testing.assert_allclose(together.resultant[0, 0, :2, 2], -TORQUE, rtol=EXACT)


@pytest.mark.parametrize("level", [0.0, 1.0])
def test_a_body_without_load_is_free(level: float) -> None:
    """An idler between a driving and a fixed body carries; one without load has no rotation."""
    meshes = [
        mesh(level, bodies=(0, 2)),
        mesh(level, bodies=(1, 2), sites_before=(0, 1)),
    ]
    states = solve_meshes(
        [roller(), roller(), roller(2)],
        meshes,
        [Motion(0), Motion(1)],
        BOTH,
        [[TORQUE, 0.0], [0.0, 0.0]],
    )
    assert (states.status == 0).all()
    assert np.isnan(states.motion[0, :, 1]).all()
    assert np.isnan(states.tangent[0, 0, 1]).all()
    np.testing.assert_allclose(states.motion[0, 0, 0], alone(level).motion[0, 0, 0], rtol=EXACT)
    assert states.site_force_N[0, 0, 1] == 0.0
    assert np.isnan(states.motion[0, 1]).all()
    assert (states.site_force_N[0, 1] == 0.0).all()


@pytest.mark.parametrize("level", [0.0, 1.0])
def test_frames_do_not_matter(level: float) -> None:
    """A mesh turned, and one that is the mirror image: only the directions of forces change."""
    bodies = [roller(), roller()]
    pair = alone(level)
    turned = solve_meshes(
        bodies, [mesh(level, bodies=(0, 1), angle_rad=0.7)], [Motion(0)], ANGLES, [[TORQUE]]
    )
    mirrored = solve_meshes(
        bodies, [mesh(level, bodies=(0, 1), sense=-1)], [Motion(0, sign=-1)], ANGLES, [[TORQUE]]
    )
    for other in (turned, mirrored):
        np.testing.assert_allclose(other.motion, pair.motion, rtol=EXACT)
        np.testing.assert_allclose(other.tangent, pair.tangent, rtol=1e-9)
    force = pair.resultant[0, 0, 0]
    c, s = np.cos(0.7), np.sin(0.7)
    np.testing.assert_allclose(
        turned.resultant[0, 0, 0],
        [c * force[0] - s * force[1], s * force[0] + c * force[1], force[2]],
        rtol=EXACT,
    )
    np.testing.assert_allclose(mirrored.resultant[0, 0, 0], force * [1, -1, -1], rtol=EXACT)


@pytest.mark.parametrize("level", [0.0, 1.0])
def test_a_support_is_a_motion_under_its_force(level: float) -> None:
    """An elastic pin of body 2: the same as its displacement by the force on it."""
    bodies, meshes, motions = [roller(), roller()], [mesh(level)], [Motion(0)]
    pin = np.array([[3e-6, 1e-6, 0.0], [1e-6, 4e-6, 0.0], [0.0, 0.0, 0.0]])
    on_pin = solve_meshes(
        [bodies[0], on_support(bodies[1], pin)], meshes, motions, ANGLES, [[TORQUE]]
    )
    moved = pin @ on_pin.resultant[0, 0, 1]
    displacements = np.zeros((1, 2, 3))
    displacements[0, 1] = moved
    displaced = solve_meshes(bodies, meshes, motions, ANGLES, [[TORQUE]], displacements)
    further = on_pin.motion - alone(level).motion
    assert further[0, 0, 0] > 1e-6
    np.testing.assert_allclose(displaced.motion, on_pin.motion, rtol=3e-4)
    np.testing.assert_allclose(displaced.motion - alone(level).motion, further, rtol=3e-3, atol=0)


def test_states_without_their_pairs() -> None:
    """Pairs are optional: all else is the same to the last bit."""
    arguments = ([roller(), roller()], [mesh(0.0)], [Motion(0)], ANGLES, [[TORQUE]])
    states = solve_meshes(*arguments, keep_pairs=False)
    assert states.pairs[0].count.sum() == 0
    assert alone(0.0).pairs[0].count.sum() > 0
    np.testing.assert_array_equal(states.motion, alone(0.0).motion)


def test_what_several_meshes_exclude() -> None:
    """Finite forces have a status of their own; wrong members and motions are arguments."""
    bodies = [roller(), roller()]
    finite = mesh_record(0.0, steps=4)
    states = solve_meshes(bodies, [finite], [Motion(0), Motion(1)], ANGLES, [[TORQUE, 0.0]])
    assert (states.status == -23).all()
    with pytest.raises(InputError, match="records: mesh 1: expected bodies from 1 to 2, found 3"):
        solve_meshes(bodies, [mesh(0.0, bodies=(0, 2))], [Motion(0)], ANGLES, [[TORQUE]])
    with pytest.raises(InputError, match="motions: expected bodies from 1 to 2"):
        solve_meshes(bodies, [mesh(0.0)], [Motion(2)], ANGLES, [[TORQUE]])
