"""Premises of the model that a torque of a drive with several gear meshes can violate."""

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

    from flankload.mechanisms.several.states import AnyAssembly, MeshesStates
    from flankload.scene import Scene


def broken_by_geometry(assembly: AnyAssembly) -> Iterator[Broken]:
    """Premises that are violated at any load: rims, contact ratios."""
    yield from broken_rims(assembly.names, assembly.bodies)
    for name, key, mesh in assembly.different_meshes:
        if mesh.gears.contact_ratio < CONTACT_RATIO.limit - TIE:
            distance = mesh.pairing.center_distance_mm
            found = f"{mesh.gears.contact_ratio:.4g} of {name} on {distance:g} mm"
            yield Broken(CONTACT_RATIO, key, found)


def broken_by_load(
    scene: Scene, assembly: AnyAssembly, states: MeshesStates, number: int
) -> Iterator[Broken]:
    """Premises that a torque violates: small deflections, small strains."""
    found, width_mm = states.found[number].whole, assembly.slices[0].compliance_width_mm
    torque = Torque(scene, number)
    turned_rad = largest_turn(found.torque_Nmm * found.tangent_rad_per_Nmm)
    yield from broken_by_turn(turned_rad, assembly.pairing.pitch_rad, torque)
    first = assembly.bodies[0]
    deflection = turned_rad * first.reference_radius_mm / scene.body_1.module_mm  # type: ignore[union-attr]
    if deflection > DEFLECTION.limit:
        yield torque.broken(DEFLECTION, f"{deflection:.3g} of a module")
    modulus = min(body.material.young_modulus_MPa for body in assembly.bodies)
    smooth = ~on_corner(found.site_corner)
    peaks = found.site_peak_N_per_mm / width_mm
    largest = float(np.max(peaks, initial=0.0, where=smooth)) / modulus
    if largest > PRESSURE.limit:
        yield torque.broken(PRESSURE, f"{largest:.3g} of Young's modulus")
