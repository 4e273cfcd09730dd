"""States of a planetary stage and their error estimates."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, ClassVar

from msgspec import structs

from flankload.analysis.estimate import MOST_SWEEPS
from flankload.contact.meshes_contact import (
    MeshesSweep,
    sweep_displaced,
    sweep_meshes,
)
from flankload.contact.record_files import meshes_records
from flankload.contact.stage_supports import StageContact
from flankload.cost import held_bytes
from flankload.elasticity.bolts import Bolts, on_bolts
from flankload.elasticity.compliance import BodyCompliance
from flankload.mechanisms.elements import (
    solve_bodies,
)
from flankload.mechanisms.flank_pair.prediction import SLICE_VARIANTS, work_of_elements
from flankload.mechanisms.stage.assembly import NAMES, StageAssembly, assemble, errors_of
from flankload.mechanisms.stage_clock import StageClock, elements_stage
from flankload.scene.effects import effects_of

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from flankload.base.arrays import Floats
    from flankload.mechanisms.protocol import Counted, States
    from flankload.mechanisms.reuse import Parts
    from flankload.mechanisms.stage_clock import Kept
    from flankload.scene import Scene

Compliances = tuple[BodyCompliance, BodyCompliance, BodyCompliance]


@dataclass(frozen=True)
class StageStates:
    """States of a stage.

    Attributes
    ----------
    found : tuple of MeshesSweep
        One per torque.
    contact : StageContact
    known : None
        Similar states are not continued from these.
    """

    found: tuple[MeshesSweep, ...]
    contact: StageContact
    known: ClassVar[None] = None


def counted_work(scene: Scene, assembly: StageAssembly) -> Counted:
    """Work of the elements, and number of states; that of the estimate is not predicted."""
    # elements of any body have the work of those of an elastic body 1
    alike = replace(assembly, effects=replace(assembly.effects, elastic_body_1=True))
    elements: Counted = {
        elements_stage(name): work_of_elements(scene, alike, z, NAMES[0])
        for z, (name, job) in enumerate(zip(NAMES, assembly.jobs, strict=True))
        if job.elastic
    }
    states = {"states": assembly.position_rad.size * len(scene.torques_Nm)}
    estimate: Counted = {"estimate": {}} if scene.accuracy.estimate else {}
    return {"bodies": {}, **elements, "sweep": states, **estimate}


def stage_sweeps(scene: Scene) -> int:
    """Number of sweeps: states, and those of the estimate."""
    if not scene.accuracy.estimate:
        return 1
    return 1 + MOST_SWEEPS + (SLICE_VARIANTS if effects_of(scene).three_dimensions else 0)


def compliances_of(
    scene: Scene,
    assembly: StageAssembly,
    clock: StageClock,
    kept: Kept,
    parts: Parts | None = None,
) -> tuple[StageAssembly, Compliances]:
    """Solve one finite-element job for each elastic body: the planets are equal."""
    sun, planet, ring = solve_bodies(scene, assembly, clock, kept, parts)
    return assembly, (sun, planet, _on_bolts(scene, ring))


def _on_bolts(scene: Scene, ring: BodyCompliance) -> BodyCompliance:
    """The compliance of a ring with its bolts."""
    assert scene.stage is not None
    stiffness, count = scene.stage.bolt_stiffness_N_per_mm, scene.stage.bolts
    if stiffness is None or count is None:
        return ring
    radial, tangential = stiffness
    width = scene.pair.face_width_mm
    return on_bolts(ring, Bolts(count, (radial / width, tangential / width)))


def stage_states(
    scene: Scene,
    assembly: StageAssembly,
    compliances: Compliances,
    clock: StageClock,
    similar: States | None = None,
    *,
    unloaded: bool = True,
) -> tuple[StageAssembly, StageStates]:
    """Solve all positions and torques; none is continued from similar states."""
    contact = assembly.contact(scene, compliances)
    with clock.stage("sweep") as account:
        found = sweep_meshes(
            contact,
            assembly.position_rad,
            scene.torques_Nmm,
            account=account,
            progress=clock.sweep_progress("sweep"),
        )
        account.bytes += held_bytes(found)
    return assembly, StageStates(found, contact)


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
) -> tuple[tuple[StageAssembly, StageStates], ...]:
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
    states = [StageStates(one, contact) for one, contact in zip(found, contacts, strict=True)]
    return tuple(zip(assemblies, states, strict=True))


def record_files(scene: Scene) -> Mapping[str, Floats]:
    """Records of all bodies and meshes, and their motions."""
    assembly = assemble(scene)
    assembly, compliances = compliances_of(scene, assembly, StageClock(None, NAMES, 1, {}), {})
    contact = assembly.contact(scene, compliances)
    return meshes_records(contact, assembly.position_rad, scene.torques_Nmm)
