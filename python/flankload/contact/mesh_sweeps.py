"""States of several meshes as one sweep for each."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from flankload.contact.body_record import core_sites
from flankload.contact.sweep import SITE_RESULTS, Sweep, over_slices

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flankload.base.arrays import Floats
    from flankload.contact.meshes import MeshStates
    from flankload.pairing.gear_mesh import GearMesh


def states_of_torque(found: MeshStates, t: int) -> dict[str, Any]:
    """Arrays of the states under the case of loads with this index that all meshes share."""
    return {name: getattr(found, name)[:, t] for name in ("status", "certificate", "counters")}


def sweeps_of_meshes(
    found: MeshStates,
    t: int,
    meshes: Sequence[GearMesh],
    torques_Nmm: Sequence[float],
) -> tuple[Sweep, ...]:
    """A sweep for each mesh under the case of loads with index t, without rotations.

    `torques_Nmm` (M,) are nominal ones on body 1 of each mesh.
    """
    none = np.zeros(len(found.motion))
    counts = [core_sites(mesh) for mesh in meshes]
    ends = np.cumsum(counts)[:-1]
    sites = [np.split(getattr(found, name)[:, t], ends, axis=1) for name in SITE_RESULTS]
    pairs, sweeps = found.pairs[t], []
    for m, (mesh, torque) in enumerate(zip(meshes, torques_Nmm, strict=True)):
        first, pairs = pairs.split_at(counts[m])
        own = over_slices([parts[m] for parts in sites], mesh.slices)
        sweeps.append(
            Sweep(
                torque_Nmm=torque,
                rotation_rad=none,
                tangent_rad_per_Nmm=none,
                site_force_per_torque=own["site_force_N"] / (torque or 1.0),
                n_pairs=first.count,
                pairs=replace(first, slice_count=mesh.slices.count),
                **states_of_torque(found, t),
                **own,
            )
        )
    return tuple(sweeps)


def with_rotations(sweeps: Sequence[Sweep], rotations_rad: Floats) -> tuple[Sweep, ...]:
    """The sweeps of meshes with the approach (P, M) of their flanks over the base radii."""
    columns = zip(sweeps, rotations_rad.T, strict=True)
    return tuple(replace(sweep, rotation_rad=rotation) for sweep, rotation in columns)
