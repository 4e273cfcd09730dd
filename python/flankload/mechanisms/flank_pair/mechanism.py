"""Flank pairs as a kind of drive: gears, rings, splines, cams and bodies from files."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from flankload.analysis.estimate import MOST_SWEEPS
from flankload.cost import Account
from flankload.mechanisms.flank_pair import body_files as files
from flankload.mechanisms.flank_pair.assembly import build_bodies, with_flank_distance
from flankload.mechanisms.flank_pair.data_sheet import data_sheet
from flankload.mechanisms.flank_pair.description import describe
from flankload.mechanisms.flank_pair.from_sweep import result_of
from flankload.mechanisms.flank_pair.iso_6336 import with_iso_factor
from flankload.mechanisms.flank_pair.parameters import parameters_of_flanks
from flankload.mechanisms.flank_pair.prediction import predicted_work
from flankload.mechanisms.flank_pair.premises import broken_by_geometry, broken_by_load
from flankload.mechanisms.flank_pair.stages import Compliances, compliances_of
from flankload.mechanisms.flank_pair.states import (
    FlankStates,
    error_estimates,
    flank_states,
    incomplete_estimate_notes,
    position_notes,
    record_files,
    unturned_notes,
)
from flankload.mechanisms.scene_bodies import PAIR
from flankload.pairing.body_pair import BodyPair

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from flankload.mechanisms.premises import Broken
    from flankload.mechanisms.protocol import FieldsOfBody, Mechanism
    from flankload.mechanisms.reuse import Parts
    from flankload.result import Result
    from flankload.scene import Scene
    from flankload.scene.discretization import Discretization


class FlankPair:
    """Two bodies whose flanks touch."""

    body_names = PAIR
    no_flanks_reason: str | None = None
    modes = None
    displaced = None

    def build(
        self,
        scene: Scene,
        discretization: Discretization | None = None,
        parts: Parts | None = None,
        *,
        account: Account | None = None,
        modified_elements: bool = False,
    ) -> BodyPair:
        """Assemble both bodies."""
        pair = build_bodies(scene, discretization, parts=parts, modified_elements=modified_elements)
        return with_flank_distance(scene, pair, account or Account())

    broken_by_geometry = staticmethod(broken_by_geometry)
    work = staticmethod(predicted_work)

    def sweeps(self, scene: Scene) -> int:
        """Number of sweeps: states, and those of the estimate."""
        return 1 + (MOST_SWEEPS if scene.accuracy.estimate else 0)

    compliances = staticmethod(compliances_of)
    states = staticmethod(flank_states)

    def broken_by_load(
        self, scene: Scene, assembly: BodyPair, states: FlankStates, number: int
    ) -> Iterator[Broken]:
        """Premises that a torque violates."""
        return broken_by_load(scene, assembly, states.geometry, states.found[number], number)

    estimates = staticmethod(error_estimates)

    def results(
        self,
        scene: Scene,
        assembly: BodyPair,
        compliances: Compliances,
        states: FlankStates,
        estimates: Sequence[Mapping[str, object] | None],
    ) -> tuple[Result, ...]:
        """Results, one per torque."""
        unseen: tuple[str, ...] = ()
        if any(estimates):
            unseen = incomplete_estimate_notes(assembly, compliances)
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
                notes=(
                    *unturned_notes(assembly, compliances, found),
                    *unseen,
                    *position_notes(scene, assembly, doubt),
                ),
            )
            cost = {**result.cost, "position_rounds": states.rounds}
            results.append(with_iso_factor(replace(result, cost=cost), scene, assembly))
        return tuple(results)

    parameters = staticmethod(parameters_of_flanks)
    describe = staticmethod(describe)
    data_sheet = staticmethod(data_sheet)
    mesh_files = staticmethod(files.mesh_files)
    compliance_files = staticmethod(files.compliance_files)
    record_files = staticmethod(record_files)

    def fields_of_bodies(self, scene: Scene) -> Mapping[str, FieldsOfBody | str]:
        """Both bodies with elements for the contact forces of results, or why there are none."""
        from flankload.mechanisms.flank_pair.loaded_bodies import field_bodies

        return field_bodies(scene)


MECHANISM: Mechanism[BodyPair, Compliances, FlankStates] = FlankPair()
