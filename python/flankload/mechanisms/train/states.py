"""States of a gear train and their error estimates."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from flankload.analysis.estimate import MOST_SWEEPS, estimate_errors
from flankload.analysis.lumped_error import measured_error
from flankload.contact.meshes_contact import MeshesSweep, sweep_meshes
from flankload.contact.record_files import meshes_records
from flankload.contact.train_supports import TrainContact
from flankload.cost import held_bytes
from flankload.elasticity.compliance import BodyCompliance
from flankload.mechanisms.elements import (
    account_errors_of_elements,
    reduced_compliances,
    solve_bodies,
)
from flankload.mechanisms.flank_pair.prediction import work_of_elements
from flankload.mechanisms.stage_clock import StageClock, elements_stage
from flankload.mechanisms.train.assembly import NAMES, TrainAssembly, assemble

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flankload.base.arrays import Floats
    from flankload.contact.sweep import Sweep
    from flankload.mechanisms.protocol import Counted, States
    from flankload.mechanisms.reuse import Parts
    from flankload.mechanisms.stage_clock import Kept
    from flankload.scene import Scene

Compliances = tuple[BodyCompliance, BodyCompliance, BodyCompliance]


@dataclass(frozen=True)
class TrainStates:
    """States of a train.

    Attributes
    ----------
    found : tuple of MeshesSweep
        One per torque.
    contact : TrainContact
    known : None
        Similar states are not continued from these.
    """

    found: tuple[MeshesSweep, ...]
    contact: TrainContact
    known: ClassVar[None] = None


def counted_work(scene: Scene, assembly: TrainAssembly) -> Counted:
    """Work of the elements, and number of states; that of the estimate is not predicted."""
    elements: Counted = {
        elements_stage(name): work_of_elements(scene, assembly, z, NAMES[0])
        for z, (name, job) in enumerate(zip(NAMES, assembly.jobs, strict=True))
        if job.elastic
    }
    states = {"states": assembly.position_rad.size * len(scene.torques_Nm)}
    estimate: Counted = {"estimate": {}} if scene.accuracy.estimate else {}
    return {"bodies": {}, **elements, "sweep": states, **estimate}


def train_sweeps(scene: Scene) -> int:
    """Number of sweeps: states, and those of the estimate."""
    return 1 + (MOST_SWEEPS if scene.accuracy.estimate else 0)


def compliances_of(
    scene: Scene,
    assembly: TrainAssembly,
    clock: StageClock,
    kept: Kept,
    parts: Parts | None = None,
) -> tuple[TrainAssembly, Compliances]:
    """Solve one finite-element job for each elastic body."""
    one, two, three = solve_bodies(scene, assembly, clock, kept, parts)
    return assembly, (one, two, three)


def train_states(
    scene: Scene,
    assembly: TrainAssembly,
    compliances: Compliances,
    clock: StageClock,
    similar: States | None = None,
    *,
    unloaded: bool = True,
) -> tuple[TrainAssembly, TrainStates]:
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
    return assembly, TrainStates(found, contact)


def record_files(scene: Scene) -> Mapping[str, Floats]:
    """Records of all bodies and meshes, and their motions."""
    assembly = assemble(scene)
    assembly, compliances = compliances_of(scene, assembly, StageClock(None, NAMES, 1, {}), {})
    contact = assembly.contact(scene, compliances)
    return meshes_records(contact, assembly.position_rad, scene.torques_Nmm)


def error_estimates(
    scene: Scene,
    assembly: TrainAssembly,
    compliances: Compliances,
    states: TrainStates,
    clock: StageClock,
) -> list[Mapping[str, object] | None]:
    """Estimate the errors of the states, one entry per torque: as of a pair, over both meshes."""
    contact, found = states.contact, tuple(one.whole for one in states.found)
    lumped, count = contact.level == "lumped", assembly.position_rad.size
    with clock.stage("estimate") as account:

        def run_again(*, part: int, **other: Any) -> tuple[Sweep, ...]:
            again = sweep_meshes(
                replace(contact, **other),
                assembly.position_rad,
                scene.torques_Nmm,
                keep_pairs=False,
                account=account,
                progress=clock.sweep_progress("estimate", sweep=part),
            )
            return tuple(one.whole for one in again)

        estimated = estimate_errors(
            found,
            run_again,
            compliances,
            contact.grid if lumped else contact.grid.coarser(),
            np.full(count, 1.0 / count),
            variants={**reduced_compliances(compliances)},
            lumped=(lambda t: measured_error(found[t], compliances)) if lumped else None,
        )
    account_errors_of_elements(clock, NAMES, compliances)
    return [one.as_dict() for one in estimated]
