"""Premises of the model that a planetary stage can violate."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flankload.base.rounding import TIE
from flankload.contact.status import on_corner
from flankload.mechanisms.flank_pair.premises import (
    CONTACT_RATIO,
    DEFLECTION,
    PRESSURE,
    broken_rims,
)
from flankload.mechanisms.premises import Broken, Torque, broken_by_turn, largest_turn

if TYPE_CHECKING:
    from collections.abc import Iterator

    from flankload.mechanisms.stage.assembly import StageAssembly
    from flankload.mechanisms.stage.states import StageStates
    from flankload.scene import Scene


def broken_by_geometry(assembly: StageAssembly) -> Iterator[Broken]:
    """Premises that are violated at any load: rims, contact ratios."""
    yield from broken_rims(assembly.names, assembly.bodies)
    meshes = assembly.pairing.meshes
    for mesh, name in ((meshes[0], "sun and planets"), (meshes[-1], "planets and ring")):
        gears = mesh.pairing.gear_geometry
        if gears is not None and gears.contact_ratio < CONTACT_RATIO.limit - TIE:
            distance = assembly.pairing.center_distance_mm
            found = f"{gears.contact_ratio:.4g} of {name} on {distance:g} mm"
            yield Broken(CONTACT_RATIO, "pair.center_distance_mm", found)


def broken_by_load(
    scene: Scene, assembly: StageAssembly, states: StageStates, number: int
) -> Iterator[Broken]:
    """Premises that a torque violates: small deflections, small strains."""
    torque, found = Torque(scene, number), states.found[number]
    turned_rad = largest_turn(found.planets.torque_Nmm * found.planets.tangent_rad_per_Nmm)
    yield from broken_by_turn(turned_rad, assembly.pairing.pitch_rad, torque)
    sun = assembly.bodies[0]
    deflection = turned_rad * sun.reference_radius_mm / scene.body_1.module_mm  # type: ignore[union-attr]
    if deflection > DEFLECTION.limit:
        yield torque.broken(DEFLECTION, f"{deflection:.3g} of a module")
    modulus = min(body.material.young_modulus_MPa for body in assembly.bodies)
    smooth = ~on_corner(found.planets.site_corner)
    peaks = found.planets.site_peak_N_per_mm / assembly.slices[0].compliance_width_mm
    largest = float(np.max(peaks, initial=0.0, where=smooth)) / modulus
    if largest > PRESSURE.limit:
        yield torque.broken(PRESSURE, f"{largest:.3g} of Young's modulus")
