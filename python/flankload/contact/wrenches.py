"""Forces and moments of all contacts of a drive on its bodies, and their motions on supports.

A wrench is a force (x, y, z), N, and its moment, N mm, about the axis of the body in the middle of
its face width, in the common frame.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flankload.base.arrays import Floats
    from flankload.contact.meshes_contact import AnyContact
    from flankload.contact.sweep import Sweep


def wrenches_of(contact: AnyContact, meshes: Sequence[Sweep]) -> Floats:
    """(P, B, 6) Wrenches on the bodies, from the stored pairs of all meshes."""
    axes = contact.pairing.axes_mm
    found = np.zeros((meshes[0].status.size, len(axes), 6))
    for m, (mesh, sweep) in enumerate(zip(contact.pairing.meshes, meshes, strict=True)):
        points, forces = _contacts(contact, m, sweep)
        for b, sign in zip(mesh.members, (-1.0, 1.0), strict=True):
            center = np.append(axes[b], contact.axial_shape(b).middle_mm)
            moments = np.cross(points - center, sign * forces)
            every = np.concatenate([sign * forces, moments], axis=1)
            np.add.at(found[:, b], sweep.pairs.position, every)
    return found


def _contacts(contact: AnyContact, m: int, sweep: Sweep) -> tuple[Floats, Floats]:
    """Points (N, 3) of the pairs of a mesh in the common frame; forces on body 2."""
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
    points = points + contact.pairing.axes_mm[mesh.members[0]]
    z_mm = own.slices.z_mm[pairs.slices]
    return (
        np.column_stack([points, z_mm]),
        in_section[:, np.newaxis] * np.column_stack([normals, slope]),
    )


def tilts_of(contact: AnyContact, wrenches: Floats) -> Floats:
    """(P, B, 2) Rotations of the bodies about x and y on their supports, rad."""
    return np.einsum("bxcy,pcy->pbx", contact.springs[:, 3:5], wrenches)
