"""A timing belt on its pulley as a kind of drive."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flankload.cost import held_bytes
from flankload.mechanisms.belt.contact import spring_row, state_under
from flankload.mechanisms.belt.description import rows_of_belt, sheet_of_belt
from flankload.mechanisms.belt.drive import (
    PULLEY,
    STRIP,
    BeltStates,
    assemble,
    error_estimates,
    parameters_of_belt,
    predicted_work,
    pulley_mesh,
    response_at,
    solved_pulley,
)
from flankload.mechanisms.belt.drive_result import result_of_belt, tangent_stiffness
from flankload.mechanisms.protocol import MeshFile
from flankload.mechanisms.registry import require_flanks
from flankload.mechanisms.wrapped import WrappedMechanism

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from flankload.mechanisms.belt.contact import BeltState
    from flankload.mechanisms.belt.drive import BeltAssembly
    from flankload.mechanisms.belt.pulley_compliance import PulleyResponse
    from flankload.mechanisms.protocol import Mechanism, States
    from flankload.mechanisms.reuse import Parts
    from flankload.mechanisms.stage_clock import Kept, StageClock
    from flankload.scene import Scene


class TimingBelt(WrappedMechanism["BeltAssembly", BeltStates]):
    """A pulley and the belt around it."""

    no_flanks_reason: str | None = "'belt', which lies on its pulley as a strip"

    assemble = staticmethod(assemble)
    work = staticmethod(predicted_work)
    stiffness = staticmethod(tangent_stiffness)
    result = staticmethod(result_of_belt)
    parameters = staticmethod(parameters_of_belt)
    rows = staticmethod(rows_of_belt)
    data_sheet = staticmethod(sheet_of_belt)

    def compliances(
        self,
        scene: Scene,
        assembly: BeltAssembly,
        clock: StageClock,
        kept: Kept,
        parts: Parts | None = None,
    ) -> tuple[BeltAssembly, PulleyResponse | None]:
        """Solve the elements of an elastic pulley, and the cell of the belt."""
        pulley = None
        if not scene.body_1.rigid:
            with clock.stage(PULLEY) as account:
                mesh = assembly.pulley.of(assembly.row.elements)
                pulley = solved_pulley(scene, mesh, account)
                account.bytes = held_bytes(pulley)
        with clock.stage(STRIP) as account:
            assembly.row.solve_cell(account)
        return assembly, pulley

    def states(
        self,
        scene: Scene,
        assembly: BeltAssembly,
        compliances: PulleyResponse | None,
        clock: StageClock,
        similar: States | None = None,
        *,
        unloaded: bool = True,
    ) -> tuple[BeltAssembly, BeltStates]:
        """Solve all positions and torques; none is continued from similar states."""
        strip, torques = assembly.strip, scene.torques_Nmm
        found: tuple[list[BeltState], ...] = tuple([] for _ in torques)
        springs = None
        progress = clock.sweep_progress("sweep")
        for p, angle in enumerate(assembly.position_rad):
            progress(p, assembly.position_rad.size)
            with clock.account(STRIP) as account:
                response = response_at(assembly.row, compliances, float(angle), account)
                springs = springs or spring_row(strip, response)
                account.bytes = max(account.bytes, held_bytes(response))
            with clock.account("sweep") as account:
                for torque, states in zip(torques, found, strict=True):
                    states.append(state_under(scene, strip, response, torque, account))
        assert springs is not None
        clock.account("sweep").bytes = held_bytes(found)
        return assembly, BeltStates(found, springs)

    def estimates(
        self,
        scene: Scene,
        assembly: BeltAssembly,
        compliances: PulleyResponse | None,
        states: BeltStates,
        clock: StageClock,
    ) -> Sequence[Mapping[str, object] | None]:
        if not any(scene.torques_Nm):
            return [None] * len(states.found)
        with clock.stage("estimate") as account:
            return error_estimates(scene, assembly, compliances, states.found, account)

    def mesh_files(self, scene: Scene) -> Iterator[MeshFile]:
        """Mesh of an elastic pulley at its first tooth; a SceneError for a rigid one."""
        if scene.body_1.rigid:
            require_flanks(scene)
        sector = pulley_mesh(scene).sector
        yield MeshFile("body_1", sector, f"one of {sector.teeth} sectors")
        yield MeshFile("body_2", None, "a strip around the pulley, which has no file")


MECHANISM: Mechanism[BeltAssembly, PulleyResponse | None, BeltStates] = TimingBelt()
