"""Stiffness of the contacts of a stage about its states: forces by displacements of its bodies."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from flankload.contact.meshes import Motion, solve_meshes
from flankload.contact.stage_supports import StageContact, StageSupports
from flankload.contact.status import raise_first_failure

if TYPE_CHECKING:
    from flankload.base.arrays import Floats
    from flankload.contact.meshes_contact import MeshesSweep

#: Step of the displacements over the largest one of a body: the differences change by 1e-4 between
#: a third of it and three times it, as by the cells of a contact that follow its width.
STEP = 1e-3


def contact_stiffness(contact: StageContact, found: MeshesSweep, position_rad: Floats) -> Floats:
    """Stiffness of the contacts at each position under the torque of a sweep.

    The bodies are displaced one by one from their places in the state while the torque turns the
    sun; the tangent of its rotation completes the derivatives for a sun that does not turn.

    Returns
    -------
    (P, 3 n + 6, 3 n + 6) array
        Force (N) and moment (N mm) of all contacts against displacements x, y (mm) and rotations
        (rad, counter-clockwise) of sun, planets and ring; symmetric.

    Raises
    ------
    ContactError
        If a displaced state has no solution.
    """
    places = _places(contact, found, position_rad)
    n_positions, n = places.shape[:2]
    turn, torque = 2, found.whole.torque_Nmm
    # one rotation moves the flanks of a body by about one displacement
    radius = contact.bodies[0].reference_radius_mm
    scale = np.tile([1.0, 1.0, 1.0 / radius], n)
    moved = [k for k in range(3 * n) if k != turn]
    step = STEP * float(np.abs(places.reshape(n_positions, -1) / scale).max()) * scale
    steps = np.zeros((2 * len(moved) + 1, 3 * n))
    for at, k in enumerate(moved):
        steps[2 * at + 1 : 2 * at + 3, k] = step[k], -step[k]
    displaced = places[:, None] + steps.reshape(-1, n, 3)
    states = _solved(contact, np.repeat(position_rad, len(steps)), displaced, torque)
    rotation = states[0].reshape(n_positions, -1)
    force = states[1].reshape(n_positions, -1, 3 * n)
    width = 2.0 * step[moved]
    slope = (rotation[:, 1::2] - rotation[:, 2::2]) / width
    by = (force[:, 1::2] - force[:, 2::2]) / width[:, None]
    own = 1.0 / states[2].reshape(n_positions, -1)[:, 0]
    # the sun turned back: its moment over the rotation that a displacement had caused
    stiffness = np.zeros((n_positions, 3 * n, 3 * n))
    to_turn = -own[:, None] * slope
    stiffness[np.ix_(range(n_positions), moved, moved)] = (
        to_turn[:, :, None] * to_turn[:, None, :] / own[:, None, None] - by[:, :, moved]
    )
    stiffness[:, turn, moved] = stiffness[:, moved, turn] = to_turn
    stiffness[:, turn, turn] = own
    return 0.5 * (stiffness + stiffness.transpose(0, 2, 1))


def _places(contact: StageContact, found: MeshesSweep, position_rad: Floats) -> Floats:
    """(P, n + 2, 3) Displacements of sun, planets and ring in their states; the sun does not turn.

    The rotation of a planet without load is arbitrary: 0.
    """
    places = contact.errors.displacements(contact.pairing, position_rad).copy()
    places[:, :, :2] += found.moved_mm
    planets = len(contact.pairing.axes_mm) - 2
    places[:, 1:-1, 2] -= np.nan_to_num(found.motions[:, 1 : 1 + planets])
    return places


def _solved(
    contact: StageContact, position_rad: Floats, displaced: Floats, torque_Nmm: float
) -> tuple[Floats, Floats, Floats]:
    """Rotation of the sun, forces on the bodies and tangent, with all other bodies held."""
    held = replace(
        contact, supports=StageSupports(tilt_Nmm_per_rad=contact.supports.tilt_Nmm_per_rad)
    )
    states = solve_meshes(
        held.body_records(),
        held.mesh_records(),
        [Motion(0)],
        np.stack([mesh.turns(position_rad) for mesh in contact.pairing.meshes], axis=1),
        np.array([[torque_Nmm]]),
        displaced.reshape(position_rad.size, -1, 3),
        keep_pairs=False,
    )
    raise_first_failure(
        states.status,
        position_rad,
        np.array([torque_Nmm]),
        states.certificate.transpose(2, 0, 1),
        has_friction=False,
    )
    return states.motion[:, 0, 0], states.resultant[:, 0], states.tangent[:, 0, 0, 0]
