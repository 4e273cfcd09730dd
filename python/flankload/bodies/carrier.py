"""Compliance of the carrier of a planetary stage: imported, or of two plates with pins as beams.

Pins are Timoshenko beams between both plates, loaded in the middle of their planets. Plates are
rigid; the one from which the torque does not leave turns by its moment over the torsional stiffness
of the webs. With the stiffness K_I, K_II (2 x 2, displacement and slope) of both parts of a pin in
its section, K = K_I + K_II, tangential motions q_j of n sections on the radius a, and the rotation
phi of the other plate, say II,

    K q_j - a k_II phi = f_j,   -sum_j a k_II' q_j + (k_t + n a² k_II,1) phi = 0

with the first column k_II of K_II. phi is eliminated by the formula of Sherman and Morrison, so
that torque and tilt of all planets are coupled.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flankload.base.files import path_of
from flankload.base.rotation import directions
from flankload.bodies.shaft import PER_RAD, round_section
from flankload.errors import SceneError
from flankload.scene.carrier import check_compliance

if TYPE_CHECKING:
    from pathlib import Path

    from flankload.base.arrays import Floats
    from flankload.scene.carrier import Carrier


def carrier_compliance(
    table: Carrier, angles_rad: Floats, center_distance_mm: float, folder: Path
) -> Floats:
    """(n, 6, n, 6) Motions of the pins under forces and moments on all of them.

    mm and rad per N and N mm in the frame of the carrier, without rotations about z.

    Raises
    ------
    SceneError
        If a file has no such matrix.
    """
    n = len(angles_rad)
    if table.compliance is not None:
        found = np.array(table.compliance)
    elif table.compliance_file is not None:
        found = _read(folder / path_of(table.compliance_file), n)
    else:
        found = _two_plates(table, angles_rad, center_distance_mm)
    blocks = (0.5 * (found + found.T)).reshape(n, 6, n, 6)
    blocks[:, 5], blocks[..., 5] = 0.0, 0.0
    return blocks


def _read(path: Path, planets: int) -> Floats:
    """Matrix of a file."""
    key = "stage.carrier.compliance_file"
    try:
        if path.suffix == ".npy":
            found = np.load(path, allow_pickle=False)
        else:
            found = np.loadtxt(path, delimiter=",", ndmin=2)
    except (OSError, ValueError) as error:
        raise SceneError(
            key=key, expected="a .csv or .npy file of numbers", found=f"{path.name}: {error}"
        ) from None
    if found.ndim != 2:
        raise SceneError(key=key, expected="rows of numbers", found=f"{found.ndim} axes")
    check_compliance(found, planets, key)
    return np.asarray(found, dtype=float)


def _two_plates(table: Carrier, angles_rad: Floats, radius_mm: float) -> Floats:
    """(6 n, 6 n) Compliance of pins between two plates."""
    n = len(angles_rad)
    parts = _parts(table)
    alone = np.linalg.inv(parts[0] + parts[1])
    radial, tangential = directions(angles_rad), directions(angles_rad + 0.5 * np.pi)
    found = np.zeros((6 * n, 6 * n))
    for across in (radial, tangential):
        rows = _rows(across)
        found += rows.T @ np.kron(np.eye(n), alone) @ rows
    if table.torsional_stiffness_Nm_per_mrad is None:
        return found
    # of the plate that turns
    turning = parts[0 if table.torque_end == "II" else 1]
    pushed = np.tile(radius_mm * (alone @ turning[:, 0]), n)
    stiffness = PER_RAD * table.torsional_stiffness_Nm_per_mrad + n * radius_mm**2 * (
        turning[0, 0] - turning[:, 0] @ alone @ turning[:, 0]
    )
    moved = pushed @ _rows(tangential)
    return np.asarray(found + np.outer(moved, moved) / stiffness)


def _rows(across: Floats) -> Floats:
    """(2 n, 6 n) Displacement and slope of sections along directions (n, 2), from their motions."""
    n = len(across)
    found = np.zeros((n, 2, n, 6))
    own = np.arange(n)
    found[own, 0, own, :2] = across
    # du/dz along d is the rotation e_z x d
    found[own, 1, own, 3], found[own, 1, own, 4] = -across[:, 1], across[:, 0]
    return found.reshape(2 * n, 6 * n)


def _parts(table: Carrier) -> tuple[Floats, Floats]:
    """(2, 2) Force and moment on the section of a pin by its motion, of the parts to both plates.

    A part of the length L, clamped in its plate, has the flexibility

        [L³/(3 E I) + L/(k G A), L²/(2 E I); L²/(2 E I), L/(E I)]

    of displacement and slope away from the plate; hinged, it carries a force at the hinge alone.
    """
    assert table.plate_distance_mm is not None
    assert table.pin_diameter_mm is not None
    modulus, nu = table.young_modulus_MPa, table.poisson_ratio
    _, moment, sheared = round_section(
        np.array(table.pin_diameter_mm), table.pin_bore_diameter_mm or 0.0, nu
    )
    bending, shear = modulus * float(moment), modulus / (2.0 * (1.0 + nu)) * float(sheared)
    found = []
    for side in (-1.0, 1.0):
        length = 0.5 * table.plate_distance_mm + side * table.plate_offset_mm
        deflection = length**3 / (3.0 * bending) + length / shear
        if table.pin_ends == "hinged":
            at_hinge = np.array([1.0, side * length])
            found.append(np.outer(at_hinge, at_hinge) / deflection)
            continue
        # slopes are those along z, away from the plate for the part at smaller z
        across = -side * length**2 / (2.0 * bending)
        found.append(np.linalg.inv(np.array([[deflection, across], [across, length / bending]])))
    return found[0], found[1]
