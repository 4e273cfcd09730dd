"""Motion of the rim of a ring that is free or on bolts, under the loads of all its flanks."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flankload.base.rotation import turned
from flankload.elasticity.bolts import rim_motion
from flankload.mechanisms.stage.mode_loads import mode_values_at

if TYPE_CHECKING:
    from flankload.base.arrays import Floats
    from flankload.contact.meshes_contact import MeshesSweep
    from flankload.elasticity.compliance import BodyCompliance
    from flankload.mechanisms.stage.assembly import StageAssembly


def motion_of_rim(
    assembly: StageAssembly, ring: BodyCompliance, found: MeshesSweep
) -> tuple[Floats, Floats]:
    """Radial displacement of the rim behind each space of the ring, outwards, and its orbit.

    Returns
    -------
    radial_mm : (P, z) array
        From the space that planet 1 meets at position 0 on, counter-clockwise; of a free rim
        beyond the motion of the ring, 0 of a clamped one; mean over the width.
    orbit_mm : (P, 2) array
        Mean displacement of the ring by its bolts, in the frame of the carrier.
    """
    pairing, (_, _, teeth) = assembly.pairing, assembly.pairing.teeth
    motion = ring.rim_motion
    if motion is None and ring.rim is not None:
        motion = rim_motion(ring.rim, teeth)
    if motion is None:
        return np.zeros((len(found.motions), teeth)), np.zeros((len(found.motions), 2))
    loads = np.zeros((len(found.motions), teeth, motion.radial.shape[1] // teeth))
    for mesh, sweep, slices in zip(pairing.meshes, found.meshes, assembly.slices, strict=True):
        if not mesh.with_ring:
            continue
        pairs = sweep.pairs
        # the mirror image of the ring, whose teeth run clockwise
        tooth = -mesh.pairing.site_teeth[1][pairs.sites] % teeth
        values = mode_values_at(ring, slices, sweep, 1)
        # modes act out of the material, forces into it
        force = -pairs.column("force")[:, None]
        np.add.at(loads, (pairs.position, tooth), force * values)
    every = loads.reshape(len(loads), -1)
    mesh = pairing.meshes[-1]
    # of the image's frame in that of the mesh, by the place and the tooth of a site
    first, own = mesh.pairing.site_angles_rad[1][0], mesh.pairing.site_teeth[1][0]
    turns = mesh.turns(assembly.position_rad)[:, 1] + first + 2.0 * np.pi * own / teeth
    orbit = turned(every @ motion.body.T, turns)
    radial = every @ motion.radial.T
    return radial[:, -np.arange(teeth) % teeth], mesh.in_common_frame(orbit)
