"""States of a drive with several gear meshes, and their work."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, ClassVar, TypeVar

from flankload.analysis.estimate import MOST_SWEEPS
from flankload.contact.meshes_contact import AnyContact, MeshesSweep, sweep_meshes
from flankload.cost import held_bytes
from flankload.mechanisms.elements import solve_bodies
from flankload.mechanisms.flank_pair.prediction import slice_variants, work_of_elements
from flankload.mechanisms.several.assembly import MeshesAssembly
from flankload.mechanisms.stage_clock import elements_stage
from flankload.scene.effects import effects_of

if TYPE_CHECKING:
    from flankload.mechanisms.protocol import Counted, States
    from flankload.mechanisms.reuse import Parts
    from flankload.mechanisms.several.assembly import Compliances
    from flankload.mechanisms.stage_clock import Kept, StageClock
    from flankload.scene import Scene

AnyAssembly = MeshesAssembly[Any, Any, Any]
AssemblyT = TypeVar("AssemblyT", bound=AnyAssembly)


@dataclass(frozen=True)
class MeshesStates:
    """States of a drive.

    Attributes
    ----------
    found : tuple of MeshesSweep
        One per torque.
    contact : MeshesContact
    known : None
        Similar states are not continued from these.
    """

    found: tuple[MeshesSweep, ...]
    contact: AnyContact
    known: ClassVar[None] = None


def counted_work(scene: Scene, assembly: AnyAssembly) -> Counted:
    """Work of the elements, and number of states; that of the estimate is not predicted."""
    # elements of any body have the work of those of an elastic body 1
    alike = replace(assembly, effects=replace(assembly.effects, elastic_body_1=True))
    elements: Counted = {
        elements_stage(name): work_of_elements(scene, alike, z, assembly.names[0])
        for z, (name, job) in enumerate(zip(assembly.names, assembly.jobs, strict=True))
        if job.elastic
    }
    states = {"states": assembly.position_rad.size * len(scene.torques_Nm)}
    estimate: Counted = {"estimate": {}} if scene.accuracy.estimate else {}
    return {"bodies": {}, **elements, "sweep": states, **estimate}


def sweeps_of_states(scene: Scene) -> int:
    """Number of sweeps: states, and those of the estimate."""
    if not scene.accuracy.estimate:
        return 1
    return 1 + MOST_SWEEPS + slice_variants(effects_of(scene))


def compliances_of(
    scene: Scene,
    assembly: AssemblyT,
    clock: StageClock,
    kept: Kept,
    parts: Parts | None = None,
) -> tuple[AssemblyT, Compliances]:
    """Solve one finite-element job for each elastic table: planets are equal."""
    return assembly, solve_bodies(scene, assembly, clock, kept, parts)


def states_of_meshes(
    scene: Scene,
    assembly: AssemblyT,
    compliances: Compliances,
    clock: StageClock,
    similar: States | None = None,
    *,
    unloaded: bool = True,
) -> tuple[AssemblyT, MeshesStates]:
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
    return assembly, MeshesStates(found, contact)
