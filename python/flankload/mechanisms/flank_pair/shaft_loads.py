"""Loads on shafts and bearings from the forces of the slices."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flankload.result.parts import ShaftLoads

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from flankload.contact.pair_table import PackedPairs
    from flankload.pairing.body_pair import BodyPair
    from flankload.pairing.slices import Slices

    Floats = NDArray[np.float64]

UM_PER_MM = 1000.0


def shaft_loads(pair: BodyPair, slices: Slices, pairs: PackedPairs) -> ShaftLoads | None:
    """Tilt of the teeth and forces on the bearings at all positions.

    Parameters
    ----------
    pair : BodyPair
    slices : Slices
    pairs : PackedPairs
        Contacts of all positions, with their slices.

    Returns
    -------
    ShaftLoads or None
        None if no body has a shaft.
    """
    axials = (pair.body_1.axial, pair.body_2.axial)
    shafts = [None if axial is None else axial.shaft for axial in axials]
    if axials[0] is None or shafts == [None, None]:
        return None
    count = len(pairs.count)
    tilt, bearings = np.zeros(count), [np.zeros((count, 0, 3)), np.zeros((count, 0, 3))]
    for z, (shaft, sign) in enumerate(zip(shafts, (-1.0, 1.0), strict=True)):
        if shaft is None:
            continue
        axis = np.array([z * pair.pairing.center_distance_mm, 0.0, shaft.z_mm])
        bearings[z] = np.zeros((count, len(shaft.bearing_loads), 3))
        for p in range(count):
            points, normal, rubbing = _contacts(pairs, slices, axials[0].twist_rad_per_mm, p)
            if not normal.any():
                continue
            force = sign * (normal + rubbing)
            wrench = np.concatenate([force.sum(axis=0), np.cross(points - axis, force).sum(axis=0)])
            turned = (shaft.compliance @ wrench)[3:]
            across = normal[:, :2].sum(axis=0)
            across /= np.linalg.norm(across)
            tilt[p] += sign * (across[0] * turned[1] - across[1] * turned[0])
            bearings[z][p] = shaft.bearing_loads @ wrench
    return ShaftLoads(UM_PER_MM * tilt, bearings[0], bearings[1])


def _contacts(
    pairs: PackedPairs, slices: Slices, twist_rad_per_mm: float, p: int
) -> tuple[Floats, Floats, Floats]:
    """Points (n, 3) of the contacts of a position, normal forces on body 2 and friction there."""
    _, table = pairs.at(p)
    number = pairs.slices_at(p)
    column = dict(zip(pairs.names, table.T, strict=True))
    x, y, across, up = (column[name] for name in ("x", "y", "normal_x", "normal_y"))
    # n = (cos b n_t, -twist l cos b) with the lever l of the transverse normal
    slope = -twist_rad_per_mm * (x * up - y * across)
    normals = np.column_stack([across, up, slope]) / np.hypot(1.0, slope)[:, np.newaxis]
    force = column["force"][:, np.newaxis]
    rubbing = np.zeros_like(normals)
    if "friction" in column:  # against the tangent: the normal turned backward
        along = np.column_stack([-up, across, np.zeros_like(up)])
        rubbing = column["friction"][:, np.newaxis] * force * along
    return np.column_stack([x, y, slices.z_mm[number]]), force * normals, rubbing
