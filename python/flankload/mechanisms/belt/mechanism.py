"""A timing belt on its pulley as a kind of drive."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flankload.mechanisms.belt.drive import (
    assemble,
    compliances_of,
    default_element_mm,
    describe_belt,
    error_estimates,
    predicted_work,
    pulley_mesh,
    states_of,
)
from flankload.mechanisms.belt.drive_result import result_of_belt, tangent_stiffness
from flankload.mechanisms.belt.sizes import duration_of
from flankload.mechanisms.duration import Duration
from flankload.mechanisms.premises import broken_by_drive
from flankload.mechanisms.protocol import Description, MeshFile
from flankload.mechanisms.registry import require_flanks
from flankload.scene.usual import question_notes

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from flankload.cost import Account
    from flankload.mechanisms.belt.drive import BeltAssembly, BeltCompliances, BeltStates
    from flankload.mechanisms.parts import Parts
    from flankload.mechanisms.premises import Broken
    from flankload.mechanisms.protocol import Counted, Mechanism
    from flankload.mechanisms.screening import Screening
    from flankload.mechanisms.stage_clock import Kept, StageClock
    from flankload.result import Result
    from flankload.scene import Scene
    from flankload.scene.discretization import Discretization


class TimingBelt:
    """A pulley and the belt around it."""

    without_flanks: str | None = "'belt', which lies on its pulley as a strip"

    def build(
        self,
        scene: Scene,
        discretization: Discretization | None,
        account: Account,
        parts: Parts | None = None,
    ) -> BeltAssembly:
        """Assemble belt and pulley; the element size follows from the scene."""
        return assemble(scene)

    def work(self, scene: Scene, assembly: BeltAssembly) -> Counted:
        """Counters of a run by stage, exact."""
        return predicted_work(scene, assembly.strip, assembly.position_rad)

    def sweeps(self, scene: Scene) -> int:
        """Number of sweeps: all positions, and the few positions of the estimate."""
        return 1

    def compliances(
        self,
        scene: Scene,
        assembly: BeltAssembly,
        clock: StageClock,
        kept: Kept,
        parts: Parts | None = None,
    ) -> tuple[BeltAssembly, BeltCompliances]:
        """Solve the elements of both bodies."""
        return assembly, compliances_of(scene, assembly.strip, clock)

    def states(
        self,
        scene: Scene,
        assembly: BeltAssembly,
        compliances: BeltCompliances,
        clock: StageClock,
    ) -> tuple[BeltAssembly, BeltStates]:
        """Solve all positions and torques."""
        return assembly, states_of(scene, assembly, compliances, clock)

    def broken_by_geometry(self, assembly: BeltAssembly) -> Iterator[Broken]:
        """None: the geometry of a belt violates no premise."""
        yield from ()

    def broken_by_load(
        self, scene: Scene, assembly: BeltAssembly, states: BeltStates, number: int
    ) -> Iterator[Broken]:
        """Premises that a torque violates."""
        strip = assembly.strip
        stiffness = tangent_stiffness(states.found[number], strip)
        torque_Nm = scene.torques_Nm[number]
        return broken_by_drive(scene, torque_Nm, stiffness, strip.pitch_rad, number)

    def estimates(
        self,
        scene: Scene,
        assembly: BeltAssembly,
        compliances: BeltCompliances,
        states: BeltStates,
        clock: StageClock,
    ) -> Sequence[Mapping[str, object] | None]:
        """Error estimates, one per torque."""
        if not any(scene.torques_Nm):
            return [None] * len(states.found)
        with clock.stage("estimate") as account:
            return error_estimates(scene, assembly, compliances, states.found, account)

    def results(
        self,
        scene: Scene,
        assembly: BeltAssembly,
        compliances: BeltCompliances,
        states: BeltStates,
        estimates: Sequence[Mapping[str, object] | None],
    ) -> tuple[Result, ...]:
        """Results, one per torque."""
        return tuple(
            result_of_belt(scene, assembly, states, number, estimate)
            for number, estimate in enumerate(estimates)
        )

    def describe(self, scene: Scene) -> Description:
        """Describe pulley, belt, load and effects."""
        return Description(describe_belt(scene), question_notes(scene))

    def meshes(self, scene: Scene) -> Iterator[MeshFile]:
        """Mesh of an elastic pulley at its first tooth; a SceneError for a rigid one."""
        if scene.body_1.rigid:
            require_flanks(scene)
        sector = pulley_mesh(scene).sector
        yield MeshFile("body_1", sector, f"one of {sector.teeth} sectors")
        yield MeshFile("body_2", None, "a strip around the pulley, which has no file")

    def duration(self, scene: Scene, assembly: BeltAssembly) -> Duration:
        """Predict the duration of a run from counted work."""
        return duration_of(scene, assembly)

    def screening(self, scene: Scene, *, levels: bool) -> Screening:
        """Solve a scene on a coarse discretization, as it is and with each effect switched."""
        from flankload.mechanisms.belt.screening import BeltScreening

        return BeltScreening(scene, levels=levels)

    def default_element_mm(self, scene: Scene) -> float | None:
        """Length of the elements on the flank of a tooth."""
        return default_element_mm(scene)


MECHANISM: Mechanism = TimingBelt()
