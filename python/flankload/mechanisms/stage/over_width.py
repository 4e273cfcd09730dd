"""Axial forces, tilts and load factors over the width of a stage, from its states."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flankload.analysis.load_factors import face_load_factor, largest_line_loads
from flankload.base.torque import in_newton_metres
from flankload.contact.wrenches import tilts_of, wrenches_of
from flankload.mechanisms.several.estimates import weights_of

if TYPE_CHECKING:
    from flankload.base.arrays import Floats
    from flankload.contact.meshes_contact import MeshesSweep
    from flankload.contact.stage_supports import StageContact
    from flankload.mechanisms.stage.assembly import StageAssembly

#: Radians in microradians.
PER_RAD = 1e6


def loads_over_width(
    assembly: StageAssembly, contact: StageContact, found: MeshesSweep
) -> dict[str, Floats]:
    """Fields of `StageLoadsOverWidth` by name."""
    wrenches = wrenches_of(contact, found.meshes)
    sun, ring = wrenches[:, 0], wrenches[:, -1]
    planets, tilts = wrenches[:, 1:-1], PER_RAD * tilts_of(contact, wrenches)
    weights = weights_of(assembly)
    factors = [face_load_factor(mesh, weights) for mesh in found.meshes]
    largest = np.stack([largest_line_loads(mesh) for mesh in found.meshes], axis=-1)
    return {
        "planet_line_load_N_per_mm": np.maximum(
            largest[:, : assembly.pairing.count], largest[:, assembly.pairing.count :]
        ),
        "mesh_face_load_factor": np.reshape(factors, (2, assembly.pairing.count)),
        "sun_axial_force_N": sun[:, 2],
        "ring_axial_force_N": ring[:, 2],
        "planet_axial_force_N": planets[..., 2],
        "planet_moment_Nm": in_newton_metres(planets[..., 3:5]),
        "planet_tilt_urad": tilts[:, 1:-1],
        "sun_tilt_urad": tilts[:, 0],
        "ring_tilt_urad": tilts[:, -1],
    }
