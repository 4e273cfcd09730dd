"""Flank pairs as a kind of drive: gears, rings, splines, cams and bodies from files."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from flankload.analysis.estimate import MOST_SWEEPS
from flankload.mechanisms.flank_pair import data_sheet as sheet
from flankload.mechanisms.flank_pair import description, premises
from flankload.mechanisms.flank_pair.assembly import build_bodies, with_flank_distance
from flankload.mechanisms.flank_pair.from_sweep import result_of
from flankload.mechanisms.flank_pair.iso_6336 import with_iso_factor
from flankload.mechanisms.flank_pair.prediction import predicted_work
from flankload.mechanisms.flank_pair.stages import (
    compliances_of,
    expanded_pair,
    with_compliance_period,
)
from flankload.mechanisms.flank_pair.states import (
    FlankStates,
    continued_states,
    error_estimates,
    flank_states,
    incomplete_estimate_notes,
    position_notes,
)
from flankload.pairing.body_pair import BodyPair

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from flankload.cost import Account
    from flankload.mechanisms.data_sheet import DataSheet
    from flankload.mechanisms.flank_pair.stages import Compliances
    from flankload.mechanisms.premises import Broken
    from flankload.mechanisms.protocol import Counted, Description, Mechanism, MeshFile, States
    from flankload.mechanisms.reuse import Parts
    from flankload.mechanisms.stage_clock import Kept, StageClock
    from flankload.result import Result
    from flankload.scene import Scene
    from flankload.scene.discretization import Discretization


class FlankPair:
    """Two bodies whose flanks touch."""

    no_flanks_reason: str | None = None

    def build(
        self,
        scene: Scene,
        discretization: Discretization | None,
        account: Account,
        parts: Parts | None = None,
    ) -> BodyPair:
        """Assemble both bodies."""
        return with_flank_distance(scene, build_bodies(scene, discretization, parts=parts), account)

    def broken_by_geometry(self, assembly: BodyPair) -> Iterator[Broken]:
        """Premises that the geometry violates without load."""
        return premises.broken_by_geometry(assembly)

    def work(self, scene: Scene, assembly: BodyPair) -> Counted:
        """Counters by stage that are known before a run."""
        return predicted_work(scene, assembly)

    def sweeps(self, scene: Scene) -> int:
        """Number of sweeps: states, tangents, and those of the estimate."""
        return 2 + (MOST_SWEEPS if scene.accuracy.estimate else 0)

    def compliances(
        self,
        scene: Scene,
        assembly: BodyPair,
        clock: StageClock,
        kept: Kept,
        parts: Parts | None = None,
    ) -> tuple[BodyPair, Compliances]:
        """Solve the elements of both bodies; return also the pair with period and expansion."""
        found = compliances_of(scene, assembly, clock, kept, parts)
        return expanded_pair(with_compliance_period(scene, assembly, found), found)

    def states(
        self,
        scene: Scene,
        assembly: BodyPair,
        compliances: Compliances,
        clock: StageClock,
        similar: States | None = None,
        *,
        unloaded: bool = True,
    ) -> tuple[BodyPair, FlankStates]:
        """Sweep all positions and torques, or continue those of a similar scene."""
        if similar is None:
            return flank_states(scene, assembly, compliances, clock, unloaded=unloaded)
        assert isinstance(similar, FlankStates)
        return continued_states(scene, assembly, compliances, clock, similar)

    def broken_by_load(
        self, scene: Scene, assembly: BodyPair, states: FlankStates, number: int
    ) -> Iterator[Broken]:
        """Premises that a torque violates."""
        return premises.broken_by_load(
            scene, assembly, states.geometry, states.found[number], number
        )

    def estimates(
        self,
        scene: Scene,
        assembly: BodyPair,
        compliances: Compliances,
        states: FlankStates,
        clock: StageClock,
    ) -> Sequence[Mapping[str, object] | None]:
        """Error estimates, one per torque; None without torque."""
        return error_estimates(scene, assembly, compliances, states, clock)

    def results(
        self,
        scene: Scene,
        assembly: BodyPair,
        compliances: Compliances,
        states: FlankStates,
        estimates: Sequence[Mapping[str, object] | None],
    ) -> tuple[Result, ...]:
        """Results, one per torque."""
        unseen = incomplete_estimate_notes(assembly, compliances) if any(estimates) else ()
        results = []
        for found, estimate, doubt in zip(
            states.found, estimates, states.position_errors, strict=True
        ):
            result = result_of(
                scene,
                assembly,
                compliances,
                found,
                estimate=estimate,
                geometry=states.geometry,
                notes=(*unseen, *position_notes(scene, assembly, doubt)),
            )
            cost = {**result.cost, "position_rounds": states.rounds}
            results.append(with_iso_factor(replace(result, cost=cost), scene, assembly))
        return tuple(results)

    def describe(self, scene: Scene) -> Description:
        """Describe bodies, pairing and effects."""
        return description.describe(scene)

    def data_sheet(self, scene: Scene) -> DataSheet:
        """Drawing data of both bodies."""
        return sheet.data_sheet(scene)

    def meshes(self, scene: Scene) -> Iterator[MeshFile]:
        """Meshes of both bodies at position zero."""
        return description.mesh_files(scene)


MECHANISM: Mechanism = FlankPair()
