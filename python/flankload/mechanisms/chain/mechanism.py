"""A chain on its sprocket as a kind of drive."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flankload.cost import held_bytes
from flankload.mechanisms.chain.contact import work_of
from flankload.mechanisms.chain.description import rows_of_chain, sheet_of_chain
from flankload.mechanisms.chain.drive import (
    assemble,
    error_estimate,
    parameters_of_chain,
    predicted_work,
    solve_position,
)
from flankload.mechanisms.chain.drive_result import result_of_chain, tangent_stiffness
from flankload.mechanisms.wrapped import WrappedMechanism, WrappedStates

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from flankload.mechanisms.chain.contact import WrapState
    from flankload.mechanisms.chain.drive import ChainAssembly
    from flankload.mechanisms.premises import Broken
    from flankload.mechanisms.protocol import Mechanism, States
    from flankload.mechanisms.reuse import Parts
    from flankload.mechanisms.stage_clock import Kept, StageClock
    from flankload.scene import Scene


class ChainOnSprocket(WrappedMechanism["ChainAssembly", WrappedStates]):
    """A sprocket and the chain around it."""

    no_flanks_reason: str | None = "'chain', whose sprocket has pockets and which is a truss"

    assemble = staticmethod(assemble)
    work = staticmethod(predicted_work)
    stiffness = staticmethod(tangent_stiffness)
    result = staticmethod(result_of_chain)
    parameters = staticmethod(parameters_of_chain)
    rows = staticmethod(rows_of_chain)
    data_sheet = staticmethod(sheet_of_chain)

    def compliances(
        self,
        scene: Scene,
        assembly: ChainAssembly,
        clock: StageClock,
        kept: Kept,
        parts: Parts | None = None,
    ) -> tuple[ChainAssembly, None]:
        """No finite elements: links and rollers have stiffnesses."""
        return assembly, None

    def states(
        self,
        scene: Scene,
        assembly: ChainAssembly,
        compliances: None,
        clock: StageClock,
        similar: States | None = None,
        *,
        unloaded: bool = True,
    ) -> tuple[ChainAssembly, WrappedStates]:
        """Solve all positions and torques; none is continued from similar states."""
        progress, count = clock.sweep_progress("sweep"), len(assembly.wraps)
        found: list[list[WrapState]] = []
        with clock.stage("sweep") as account:
            for torque in scene.torques_Nmm:
                found.append([])
                for p in range(count):
                    progress((len(found) - 1) * count + p, count * len(scene.torques_Nm))
                    found[-1].append(solve_position(scene, assembly, torque, p))
                account.count(**work_of(found[-1]))
            account.bytes = held_bytes(found)
        return assembly, WrappedStates(tuple(found))

    def broken_by_load(
        self, scene: Scene, assembly: ChainAssembly, states: WrappedStates, number: int
    ) -> Iterator[Broken]:
        """Premises that a torque violates; with large displacements rollers may move far."""
        if not scene.effects.large_displacement:
            yield from super().broken_by_load(scene, assembly, states, number)

    def estimates(
        self,
        scene: Scene,
        assembly: ChainAssembly,
        compliances: None,
        states: WrappedStates,
        clock: StageClock,
    ) -> Sequence[Mapping[str, object] | None]:
        with clock.stage("estimate") as account:
            return [
                error_estimate(scene, assembly, found, torque, account)
                for torque, found in zip(scene.torques_Nmm, states.found, strict=True)
            ]


MECHANISM: Mechanism[ChainAssembly, None, WrappedStates] = ChainOnSprocket()
