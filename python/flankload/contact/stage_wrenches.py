"""Forces and moments of all contacts of a stage on its members, and their motions on supports.

A wrench is a force (x, y, z), N, and its moment, N mm, about the axis of the member in the middle
of its face width, in the frame of the carrier.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flankload.base.arrays import Floats
    from flankload.contact.stage_contact import StageContact
    from flankload.contact.sweep import Sweep


def wrenches_of(contact: StageContact, meshes: Sequence[Sweep]) -> Floats:
    """(P, n + 2, 6) Wrenches on sun, planets and ring, from the stored pairs of all meshes."""
    n = contact.count
    found = np.zeros((meshes[0].status.size, n + 2, 6))
    for m, (mesh, sweep) in enumerate(zip(contact.pairing.meshes, meshes, strict=True)):
        first, second = (1 + mesh.planet, n + 1) if mesh.with_ring else (0, 1 + mesh.planet)
        points, forces = _contacts(contact, m, sweep)
        for b, sign in ((first, -1.0), (second, 1.0)):
            center = np.zeros(3)
            if 0 < b <= n:
                center[:2] = contact.pairing.centers_mm[b - 1]
            center[2] = contact.axial_shape(b).middle_mm
            moments = np.cross(points - center, sign * forces)
            every = np.concatenate([sign * forces, moments], axis=1)
            np.add.at(found[:, b], sweep.pairs.position, every)
    return found


def _contacts(contact: StageContact, m: int, sweep: Sweep) -> tuple[Floats, Floats]:
    """Points (N, 3) of the pairs of a mesh in the frame of the carrier; forces on body 2."""
    mesh, own, pairs = contact.pairing.meshes[m], contact.meshes[m], sweep.pairs
    x, y, across, up, force = (
        pairs.column(name) for name in ("x", "y", "normal_x", "normal_y", "force")
    )
    # n = (cos b n_t, -twist l cos b) with the lever l of the transverse normal
    slope = -own.body_1.axial.twist_rad_per_mm * (x * up - y * across)
    in_section = force / np.hypot(1.0, slope)
    points, normals = (
        mesh.in_common_frame(np.column_stack(parts)) for parts in ((x, y), (across, up))
    )
    if mesh.with_ring:
        points = points + contact.pairing.centers_mm[mesh.planet]
    z_mm = own.slices.z_mm[pairs.slices]
    return (
        np.column_stack([points, z_mm]),
        in_section[:, np.newaxis] * np.column_stack([normals, slope]),
    )


def tilts_of(contact: StageContact, wrenches: Floats) -> Floats:
    """(P, n + 2, 2) Rotations of sun, planets and ring about x and y on their supports, rad."""
    return np.einsum("bxcy,pcy->pbx", contact.springs[:, 3:5], wrenches)
