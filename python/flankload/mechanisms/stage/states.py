"""Compliances of a planetary stage with its bolts; states that share positions."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from msgspec import structs

from flankload.contact.meshes_contact import sweep_displaced
from flankload.elasticity.bolts import Bolts, on_bolts
from flankload.mechanisms.several import states as several
from flankload.mechanisms.several.states import MeshesStates
from flankload.mechanisms.stage.assembly import StageAssembly, errors_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flankload.elasticity.compliance import BodyCompliance
    from flankload.mechanisms.reuse import Parts
    from flankload.mechanisms.several.assembly import Compliances
    from flankload.mechanisms.stage_clock import Kept, StageClock
    from flankload.scene import Scene


def compliances_of(
    scene: Scene,
    assembly: StageAssembly,
    clock: StageClock,
    kept: Kept,
    parts: Parts | None = None,
) -> tuple[StageAssembly, Compliances]:
    """Solve one finite-element job for each elastic body: the planets are equal."""
    assembly, (sun, planet, ring) = several.compliances_of(scene, assembly, clock, kept, parts)
    return assembly, (sun, planet, _on_bolts(scene, assembly, ring))


def _on_bolts(scene: Scene, assembly: StageAssembly, ring: BodyCompliance) -> BodyCompliance:
    """The compliance of a ring with its bolts, of its flanks in mesh."""
    assert scene.stage is not None
    stiffness, count = scene.stage.bolt_stiffness_N_per_mm, scene.stage.bolts
    if stiffness is None or count is None:
        return ring
    radial, tangential = stiffness
    pairing, width_mm = assembly.pairing, assembly.slices[0].compliance_width_mm
    of_ring = pairing.meshes[pairing.count :]
    # in the mirror image of the ring, teeth run clockwise
    teeth = -np.concatenate([mesh.pairing.site_teeth[1] for mesh in of_ring]) % pairing.teeth[2]
    bolts = Bolts(count, (radial / width_mm, tangential / width_mm))
    return on_bolts(ring, bolts, teeth.tolist())


def are_displaced(one: Scene, other: Scene) -> bool:
    """Whether two scenes without estimates differ by the errors of their pins only."""
    if one.stage is None or other.stage is None:
        return False
    if one.accuracy.estimate or one.names_tolerance:
        return False
    none = {"pin_tangential_errors_um": (), "pin_radial_errors_um": ()}
    plain = [replace(scene, stage=structs.replace(scene.stage, **none)) for scene in (one, other)]  # type: ignore[type-var]
    return plain[0] == plain[1] and all(one.torques_Nm)


def displaced_states(
    scenes: Sequence[Scene], assembly: StageAssembly, compliances: Compliances, clock: StageClock
) -> tuple[tuple[StageAssembly, MeshesStates], ...]:
    """Assemblies and states of scenes that differ by the errors of their pins only."""
    angles = assembly.pairing.angles_rad
    assemblies = [
        replace(assembly, errors=errors_of(scene.stage, angles))
        for scene in scenes
        if scene.stage is not None
    ]
    contacts = [
        one.contact(scene, compliances) for one, scene in zip(assemblies, scenes, strict=True)
    ]
    with clock.stage("sweep") as account:
        found = sweep_displaced(
            contacts, assembly.position_rad, scenes[0].torques_Nmm, account=account
        )
    states = [MeshesStates(one, contact) for one, contact in zip(found, contacts, strict=True)]
    return tuple(zip(assemblies, states, strict=True))
