"""A chain on its sprocket as a kind of drive."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flankload.mechanisms.chain.drive import (
    assemble,
    describe_drive,
    error_estimate,
    predicted_work,
    states_of,
)
from flankload.mechanisms.chain.drive_result import result_of_chain, tangent_stiffness
from flankload.mechanisms.premises import broken_by_drive
from flankload.mechanisms.protocol import Description
from flankload.mechanisms.registry import require_flanks
from flankload.scene.usual import question_notes

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from flankload.cost import Account
    from flankload.mechanisms.chain.drive import ChainAssembly, ChainStates
    from flankload.mechanisms.parts import Parts
    from flankload.mechanisms.premises import Broken
    from flankload.mechanisms.protocol import Counted, Mechanism, MeshFile
    from flankload.mechanisms.screening import Screening
    from flankload.mechanisms.stage_clock import Kept, StageClock
    from flankload.result import Result
    from flankload.scene import Scene
    from flankload.scene.discretization import Discretization


class ChainOnSprocket:
    """A sprocket and the chain around it."""

    without_flanks: str | None = "'chain', whose sprocket has pockets and which is a truss"

    def build(
        self,
        scene: Scene,
        discretization: Discretization | None,
        account: Account,
        parts: Parts | None = None,
    ) -> ChainAssembly:
        """Assemble sprocket and chain; a truss has no discretization."""
        return assemble(scene)

    def work(self, scene: Scene, assembly: ChainAssembly) -> Counted:
        """Counters of a run by stage, as far as they are known before it."""
        return predicted_work(scene, assembly.position_rad.size)

    def sweeps(self, scene: Scene) -> int:
        """Number of sweeps: all positions, and two positions of the estimate."""
        return 1

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
        self, scene: Scene, assembly: ChainAssembly, compliances: None, clock: StageClock
    ) -> tuple[ChainAssembly, ChainStates]:
        """Solve all positions and torques."""
        return assembly, states_of(scene, assembly, clock)

    def broken_by_geometry(self, assembly: ChainAssembly) -> Iterator[Broken]:
        """None: the geometry of a chain violates no premise."""
        yield from ()

    def broken_by_load(
        self, scene: Scene, assembly: ChainAssembly, states: ChainStates, number: int
    ) -> Iterator[Broken]:
        """Premises that a torque violates; with large displacements rollers may move far."""
        if scene.effects.large_displacement:
            return
        stiffness = tangent_stiffness(states.found[number])
        pitch_rad = 2 * assembly.sprocket.half_pitch_rad
        yield from broken_by_drive(scene, scene.torques_Nm[number], stiffness, pitch_rad, number)

    def estimates(
        self,
        scene: Scene,
        assembly: ChainAssembly,
        compliances: None,
        states: ChainStates,
        clock: StageClock,
    ) -> Sequence[Mapping[str, object] | None]:
        """Error estimates, one per torque."""
        with clock.stage("estimate") as account:
            return [
                error_estimate(scene, assembly.chain, assembly.wraps, found, torque, account)
                for torque, found in zip(scene.torques_Nm, states.found, strict=True)
            ]

    def results(
        self,
        scene: Scene,
        assembly: ChainAssembly,
        compliances: None,
        states: ChainStates,
        estimates: Sequence[Mapping[str, object] | None],
    ) -> tuple[Result, ...]:
        """Results, one per torque."""
        return tuple(
            result_of_chain(scene, assembly, states.found[number], number, estimate)
            for number, estimate in enumerate(estimates)
        )

    def describe(self, scene: Scene) -> Description:
        """Describe sprocket, chain, load and effects."""
        return Description(describe_drive(scene), question_notes(scene))

    def meshes(self, scene: Scene) -> Iterator[MeshFile]:
        """Neither body has finite elements: a SceneError."""
        require_flanks(scene)
        yield from ()

    def duration(self, scene: Scene, assembly: ChainAssembly) -> None:
        """None: the duration for a chain is negligible."""

    def screening(self, scene: Scene, *, levels: bool) -> Screening:
        """Solve a scene on a coarse discretization, as it is and with each effect switched."""
        from flankload.mechanisms.chain.screening import ChainScreening

        return ChainScreening(scene, levels=levels)

    def default_element_mm(self, scene: Scene) -> None:
        """None: a truss has no finite elements."""


MECHANISM: Mechanism = ChainOnSprocket()
