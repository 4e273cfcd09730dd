"""States of a planetary stage and their error estimates."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from flankload.analysis.estimate import estimate_errors
from flankload.analysis.lumped_error import measured_error
from flankload.contact.stage_contact import StageContact, StageSweep, sweep_stage
from flankload.cost import held_bytes
from flankload.elasticity.compliance import BodyCompliance
from flankload.mechanisms.elements import solve_body
from flankload.mechanisms.stage.assembly import NAMES, StageAssembly
from flankload.mechanisms.stage_clock import elements_stage

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flankload.contact.sweep import Sweep
    from flankload.mechanisms.reuse import Parts
    from flankload.mechanisms.stage_clock import Kept, StageClock
    from flankload.scene import Scene

Compliances = tuple[BodyCompliance, BodyCompliance, BodyCompliance]


@dataclass(frozen=True)
class StageStates:
    """States of a stage.

    Attributes
    ----------
    found : tuple of StageSweep
        One per torque.
    contact : StageContact
    known : None
        Similar states are not continued from these.
    """

    found: tuple[StageSweep, ...]
    contact: StageContact
    known: ClassVar[None] = None


def compliances_of(
    scene: Scene, assembly: StageAssembly, clock: StageClock, kept: Kept, parts: Parts | None
) -> Compliances:
    """Solve one finite-element job for each elastic body: the planets are equal."""
    sun, planet, ring = (
        solve_body(scene, name, body, job, assembly.discretization, clock, kept, parts)
        for name, body, job in zip(NAMES, assembly.bodies, assembly.jobs, strict=True)
    )
    return sun, planet, ring


def stage_states(
    scene: Scene, assembly: StageAssembly, compliances: Compliances, clock: StageClock
) -> StageStates:
    """Solve all positions and torques."""
    contact = assembly.contact(scene, compliances)
    with clock.stage("sweep") as account:
        found = sweep_stage(
            contact,
            assembly.position_rad,
            scene.torques_Nmm,
            account=account,
            progress=clock.sweep_progress("sweep"),
        )
        account.bytes += held_bytes(found)
    return StageStates(found, contact)


def error_estimates(
    scene: Scene,
    assembly: StageAssembly,
    compliances: Compliances,
    states: StageStates,
    clock: StageClock,
) -> list[Mapping[str, object] | None]:
    """Estimate the errors of the states, one entry per torque: as of a pair, over all meshes."""
    contact, torques = states.contact, scene.torques_Nmm
    lumped, grid = contact.level == "lumped", contact.grid
    weights = np.full(assembly.position_rad.size, 1.0 / assembly.position_rad.size)
    planets = tuple(one.planets for one in states.found)
    with clock.stage("estimate") as account:

        def run_again(*, part: int, **other: Any) -> tuple[Sweep, ...]:
            again = sweep_stage(
                replace(contact, **other),
                assembly.position_rad,
                torques,
                keep_pairs=False,
                account=account,
                progress=clock.sweep_progress("estimate", sweep=part),
            )
            return tuple(one.planets for one in again)

        variants: dict[str, dict[str, object]] = {
            "modes": {"compliances": tuple(each.fewer_modes() for each in compliances)}
        }
        if any(each.fe_error is not None for each in compliances):
            softer = tuple(each.with_fe_error(1.0) for each in compliances)
            variants["elements"] = {"compliances": softer}
        estimated = estimate_errors(
            planets,
            run_again,
            compliances,
            grid if lumped else grid.coarser(),
            weights,
            variants=variants,
            lumped=(lambda t: measured_error(planets[t], compliances)) if lumped else None,
        )
    for name, compliance in zip(NAMES, compliances, strict=True):
        account.bytes += held_bytes(compliance.fe_error)
        if compliance.job.seconds:
            clock.move(compliance.job.seconds, elements_stage(name), "estimate")
    return [one.as_dict() for one in estimated]
