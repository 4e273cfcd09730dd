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
    from flankload.scene import Scene

#: Radians in microradians.
PER_RAD = 1e6


def loads_over_width(
    scene: Scene, assembly: StageAssembly, contact: StageContact, found: MeshesSweep
) -> dict[str, Floats]:
    """Fields of `StageLoadsOverWidth` by name."""
    assert scene.stage is not None
    low, high = assembly.bodies[1].axial.range_mm
    bearing_mm = scene.stage.pin_bearing_width_mm or high - low
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
        "pin_line_force_N_per_mm": _on_bearings(
            found.resultants[:, 1:-1, :2], planets[..., 3:5], bearing_mm
        ),
        "planet_tilt_urad": tilts[:, 1:-1],
        "sun_tilt_urad": tilts[:, 0],
        "ring_tilt_urad": tilts[:, -1],
    }


def _on_bearings(forces: Floats, moments: Floats, width_mm: float) -> Floats:
    """(P, n, 2, 2) Forces per mm at the ends of bearings on evenly elastic rollers.

    By forces and moments (P, n, 2) along and about x and y. A rigid bore moves the rollers
    linearly along z: q = F/L + 12 z (M x e_z)/L^3.
    """
    evenly = forces / width_mm
    bending = 6.0 / width_mm**2 * np.stack([moments[..., 1], -moments[..., 0]], axis=-1)
    return np.stack([evenly - bending, evenly + bending], axis=2)
