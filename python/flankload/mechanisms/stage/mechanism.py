"""Planetary stages as a kind of drive."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flankload.analysis.estimate import MOST_SWEEPS
from flankload.mechanisms.flank_pair.parameters import parameters_of_flanks
from flankload.mechanisms.stage import body_files as files
from flankload.mechanisms.stage.assembly import NAMES, StageAssembly, assemble
from flankload.mechanisms.stage.description import data_sheet, describe
from flankload.mechanisms.stage.from_states import stage_result
from flankload.mechanisms.stage.premises import broken_by_geometry, broken_by_load
from flankload.mechanisms.stage.states import (
    Compliances,
    StageStates,
    compliances_of,
    error_estimates,
    stage_states,
)
from flankload.mechanisms.stage_clock import elements_stage

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from flankload.cost import Account
    from flankload.mechanisms.protocol import Counted, FieldsOfBody, Mechanism, States
    from flankload.mechanisms.reuse import Parts
    from flankload.mechanisms.stage_clock import Kept, StageClock
    from flankload.result import Result
    from flankload.scene import Scene
    from flankload.scene.discretization import Discretization


class PlanetaryStage:
    """A sun, equal planets, and a ring."""

    body_names = NAMES
    no_flanks_reason: str | None = None

    def build(
        self,
        scene: Scene,
        discretization: Discretization | None,
        account: Account,
        parts: Parts | None = None,
        *,
        modified_elements: bool = False,
    ) -> StageAssembly:
        """Assemble all bodies."""
        return assemble(scene, discretization, parts)

    broken_by_geometry = staticmethod(broken_by_geometry)

    def work(self, scene: Scene, assembly: StageAssembly) -> Counted:
        """Number of states; the work of the elements and of the estimate is not predicted."""
        elements: Counted = {
            elements_stage(name): {}
            for name, job in zip(NAMES, assembly.jobs, strict=True)
            if job.elastic
        }
        states = {"states": assembly.position_rad.size * len(scene.torques_Nm)}
        estimate: Counted = {"estimate": {}} if scene.accuracy.estimate else {}
        return {"bodies": {}, **elements, "sweep": states, **estimate}

    def sweeps(self, scene: Scene) -> int:
        """Number of sweeps: states, and those of the estimate."""
        return 1 + (MOST_SWEEPS if scene.accuracy.estimate else 0)

    def compliances(
        self,
        scene: Scene,
        assembly: StageAssembly,
        clock: StageClock,
        kept: Kept,
        parts: Parts | None = None,
    ) -> tuple[StageAssembly, Compliances]:
        """Solve the elements of all bodies."""
        return assembly, compliances_of(scene, assembly, clock, kept, parts)

    def states(
        self,
        scene: Scene,
        assembly: StageAssembly,
        compliances: Compliances,
        clock: StageClock,
        similar: States | None = None,
        *,
        unloaded: bool = True,
    ) -> tuple[StageAssembly, StageStates]:
        """Solve all positions and torques; none is continued from similar states."""
        return assembly, stage_states(scene, assembly, compliances, clock)

    broken_by_load = staticmethod(broken_by_load)
    estimates = staticmethod(error_estimates)

    def results(
        self,
        scene: Scene,
        assembly: StageAssembly,
        compliances: Compliances,
        states: StageStates,
        estimates: Sequence[Mapping[str, object] | None],
    ) -> tuple[Result, ...]:
        """Results, one per torque."""
        return tuple(
            stage_result(scene, assembly, compliances, states, number, estimate)
            for number, estimate in enumerate(estimates)
        )

    parameters = staticmethod(parameters_of_flanks)
    describe = staticmethod(describe)
    data_sheet = staticmethod(data_sheet)
    mesh_files = staticmethod(files.mesh_files)
    compliance_files = staticmethod(files.compliance_files)

    def fields_of_bodies(self, scene: Scene) -> Mapping[str, FieldsOfBody | str]:
        """No fields: the reason."""
        return dict.fromkeys(NAMES, "this version has no fields of planetary stages")


MECHANISM: Mechanism[StageAssembly, Compliances, StageStates] = PlanetaryStage()
