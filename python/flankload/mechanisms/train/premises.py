"""Premises of the model that a gear train can violate."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flankload.base.rounding import TIE
from flankload.mechanisms.flank_pair.premises import CONTACT_RATIO, broken_rims
from flankload.mechanisms.premises import Broken
from flankload.mechanisms.several_meshes import broken_by_torque

if TYPE_CHECKING:
    from collections.abc import Iterator

    from flankload.mechanisms.train.assembly import TrainAssembly
    from flankload.mechanisms.train.states import TrainStates
    from flankload.scene import Scene

#: Keys of the centre distances of both meshes.
DISTANCES = ("pair.center_distance_mm", "train.center_distance_2_mm")


def broken_by_geometry(assembly: TrainAssembly) -> Iterator[Broken]:
    """Premises that are violated at any load: rims, contact ratios."""
    yield from broken_rims(assembly.names, assembly.bodies)
    for mesh, key in zip(assembly.pairing.meshes, DISTANCES, strict=True):
        gears = mesh.pairing.gear_geometry
        if gears is not None and gears.contact_ratio < CONTACT_RATIO.limit - TIE:
            distance = mesh.pairing.center_distance_mm
            found = f"{gears.contact_ratio:.4g} of {' and '.join(mesh.names)} on {distance:g} mm"
            yield Broken(CONTACT_RATIO, key, found)


def broken_by_load(
    scene: Scene, assembly: TrainAssembly, states: TrainStates, number: int
) -> Iterator[Broken]:
    """Premises that a torque violates: small deflections, small strains."""
    found, width = states.found[number].whole, assembly.face_width_mm
    yield from broken_by_torque(scene, assembly, found, number, width)
