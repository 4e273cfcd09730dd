"""Gear trains as a kind of drive."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flankload.mechanisms.several.mechanism import SeveralMeshes
from flankload.mechanisms.train.assembly import NAMES, TrainAssembly, assemble
from flankload.mechanisms.train.description import data_sheet, describe
from flankload.mechanisms.train.from_states import loads_of_bodies

if TYPE_CHECKING:
    from flankload.mechanisms.protocol import Mechanism
    from flankload.mechanisms.several.assembly import Compliances
    from flankload.mechanisms.several.states import MeshesStates


class GearTrain(SeveralMeshes[TrainAssembly]):
    """External gears in two meshes."""

    body_names = NAMES

    build = staticmethod(assemble)
    loads = staticmethod(loads_of_bodies)
    describe = staticmethod(describe)
    data_sheet = staticmethod(data_sheet)


MECHANISM: Mechanism[TrainAssembly, Compliances, MeshesStates] = GearTrain()
