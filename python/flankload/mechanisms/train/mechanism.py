"""Gear trains as a kind of drive."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flankload.mechanisms.flank_pair.parameters import parameters_of_flanks
from flankload.mechanisms.train import body_files as files
from flankload.mechanisms.train.assembly import NAMES, TrainAssembly, assemble
from flankload.mechanisms.train.description import data_sheet, describe
from flankload.mechanisms.train.from_states import train_results
from flankload.mechanisms.train.premises import broken_by_geometry, broken_by_load
from flankload.mechanisms.train.states import (
    Compliances,
    TrainStates,
    compliances_of,
    counted_work,
    error_estimates,
    record_files,
    train_states,
    train_sweeps,
)

if TYPE_CHECKING:
    from flankload.mechanisms.protocol import Mechanism


class GearTrain:
    """Three external gears in two meshes."""

    body_names = NAMES
    no_flanks_reason: str | None = None
    displaced = None
    modes = None

    build = staticmethod(assemble)
    broken_by_geometry = staticmethod(broken_by_geometry)
    work = staticmethod(counted_work)
    sweeps = staticmethod(train_sweeps)
    compliances = staticmethod(compliances_of)
    states = staticmethod(train_states)
    broken_by_load = staticmethod(broken_by_load)
    estimates = staticmethod(error_estimates)
    results = staticmethod(train_results)
    parameters = staticmethod(parameters_of_flanks)
    describe = staticmethod(describe)
    data_sheet = staticmethod(data_sheet)
    mesh_files = staticmethod(files.mesh_files)
    compliance_files = staticmethod(files.compliance_files)
    record_files = staticmethod(record_files)
    fields_of_bodies = staticmethod(files.fields_of_bodies)


MECHANISM: Mechanism[TrainAssembly, Compliances, TrainStates] = GearTrain()
