"""Planetary stages as a kind of drive."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flankload.mechanisms.flank_pair.parameters import parameters_of_flanks
from flankload.mechanisms.protocol import Displaced
from flankload.mechanisms.stage import body_files as files
from flankload.mechanisms.stage.assembly import NAMES, StageAssembly, assemble
from flankload.mechanisms.stage.description import data_sheet, describe
from flankload.mechanisms.stage.estimates import error_estimates
from flankload.mechanisms.stage.from_states import stage_results
from flankload.mechanisms.stage.modes import stage_modes
from flankload.mechanisms.stage.premises import broken_by_geometry, broken_by_load
from flankload.mechanisms.stage.states import (
    Compliances,
    StageStates,
    are_displaced,
    compliances_of,
    counted_work,
    displaced_states,
    record_files,
    stage_states,
    stage_sweeps,
)

if TYPE_CHECKING:
    from flankload.mechanisms.protocol import Mechanism


class PlanetaryStage:
    """A sun, equal planets, and a ring."""

    body_names = NAMES
    no_flanks_reason: str | None = None
    displaced = Displaced(are_displaced, displaced_states)

    build = staticmethod(assemble)
    broken_by_geometry = staticmethod(broken_by_geometry)
    work = staticmethod(counted_work)
    sweeps = staticmethod(stage_sweeps)
    compliances = staticmethod(compliances_of)
    states = staticmethod(stage_states)
    broken_by_load = staticmethod(broken_by_load)
    estimates = staticmethod(error_estimates)
    results = staticmethod(stage_results)
    parameters = staticmethod(parameters_of_flanks)
    describe = staticmethod(describe)
    data_sheet = staticmethod(data_sheet)
    mesh_files = staticmethod(files.mesh_files)
    compliance_files = staticmethod(files.compliance_files)
    record_files = staticmethod(record_files)
    fields_of_bodies = staticmethod(files.fields_of_bodies)
    modes = staticmethod(stage_modes)


MECHANISM: Mechanism[StageAssembly, Compliances, StageStates] = PlanetaryStage()
