"""Loads of the members of a stage from its states."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from flankload.base.torque import in_newton_metres
from flankload.mechanisms.stage.over_width import loads_over_width
from flankload.mechanisms.stage.planet_bending import bending_of_planets
from flankload.mechanisms.stage.rim import motion_of_rim
from flankload.mechanisms.stage.sliding import sliding_losses
from flankload.pairing.gear_pair import cosine_base_helix
from flankload.pairing.stage import orbit_orders, surviving_order
from flankload.result.stage import HIGHEST_ORDER, StageLoads
from flankload.result.stage_over_width import StageLoadsOverWidth

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flankload.base.arrays import Floats
    from flankload.contact.meshes_contact import MeshesSweep
    from flankload.contact.stage_supports import StageContact
    from flankload.mechanisms.stage.assembly import StageAssembly
    from flankload.result.result import Result
    from flankload.scene import Scene


def loads_of_members(
    scene: Scene,
    assembly: StageAssembly,
    contact: StageContact,
    found: MeshesSweep,
    meshes: Sequence[Result],
) -> StageLoads:
    """Loads of the members."""
    compliances = contact.compliances
    pairing, n = assembly.pairing, assembly.pairing.count
    sun_force, force = found.whole.site_force_N, found.resultants
    total = sun_force.sum(axis=1)
    factor = np.full(total.shape, np.nan)
    np.divide(n * sun_force.max(axis=1), total, out=factor, where=total > 0)
    # the moments of all contacts on the ring; the carrier carries the rest of the torques
    ring_torque = -force[:, -1, 2]
    on_planets = np.stack([_force_on_body_2(assembly, found, m) for m in range(n)], axis=1)
    on_planets *= cosine_base_helix(assembly.bodies[0])
    zs, _, zr = pairing.teeth
    even = pairing.equally_spaced and not assembly.errors.any and assembly.period_pitches == 1
    radial, by_bolts = motion_of_rim(assembly, compliances[2], found)
    floats = assembly.supports.moving == "carrier"
    carrier_mm = found.motions[:, -2:] if floats else np.zeros((total.size, 2))
    with_sun, with_ring = sliding_losses(assembly, found)
    kind: type[StageLoads] = StageLoads
    over_width: dict[str, Any] = {}
    if not assembly.is_plane:
        kind, over_width = StageLoadsOverWidth, loads_over_width(scene, assembly, contact, found)
    return kind(
        **over_width,
        teeth=pairing.teeth,
        center_distance_mm=pairing.center_distance_mm,
        planet_angles_rad=pairing.angles_rad,
        phases=np.stack([pairing.sun_phases, pairing.ring_phases]),
        order=surviving_order(n, zs) if even else None,
        orbit_orders=orbit_orders(n, zs, HIGHEST_ORDER) if even else (),
        mesh_load_factor=factor,
        ring_torque_Nm=in_newton_metres(ring_torque),
        carrier_torque_Nm=in_newton_metres(found.whole.torque_Nmm + ring_torque),
        transmission_error_output_urad=1e6 * found.whole.rotation_rad * zs / (zs + zr),
        sun_orbit_um=1000.0 * (found.moved_mm[:, 0] + np.asarray(assembly.errors.sun_at_mm)),
        ring_orbit_um=1000.0 * (found.moved_mm[:, -1] + by_bolts),
        ring_deflection_um=1000.0 * radial,
        carrier_orbit_um=1000.0 * carrier_mm,
        planet_force_N=on_planets,
        pin_force_N=force[:, 1:-1, :2],
        sun_mesh_sliding_loss_Nm=with_sun,
        ring_mesh_sliding_loss_Nm=with_ring,
        planet_bending=bending_of_planets(assembly, compliances[1], found),
        meshes=meshes,
    )


def _force_on_body_2(assembly: StageAssembly, found: MeshesSweep, m: int) -> Floats:
    """(P, 2) Sum of the normal forces of a mesh on its body 2, in the frame of the carrier, N."""
    pairs, mesh = found.meshes[m].pairs, assembly.pairing.meshes[m]
    force = pairs.column("force")
    parts = [
        np.bincount(pairs.position, force * pairs.column(f"normal_{k}"), pairs.count.size)
        for k in "xy"
    ]
    return mesh.in_common_frame(np.stack(parts, axis=-1))
