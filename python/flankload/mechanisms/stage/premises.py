"""Premises of the model that a planetary stage can violate."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flankload.base.rounding import TIE
from flankload.mechanisms.flank_pair.premises import (
    CONTACT_RATIO,
    broken_rims,
)
from flankload.mechanisms.premises import Broken
from flankload.mechanisms.several_meshes import broken_by_torque

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
    width = assembly.slices[0].compliance_width_mm
    yield from broken_by_torque(scene, assembly, states.found[number].whole, number, width)
