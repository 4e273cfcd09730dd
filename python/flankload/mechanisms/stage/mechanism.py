"""Planetary stages as a kind of drive."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flankload.mechanisms.protocol import Displaced
from flankload.mechanisms.several.mechanism import SeveralMeshes
from flankload.mechanisms.stage.assembly import NAMES, StageAssembly, assemble
from flankload.mechanisms.stage.description import data_sheet, describe
from flankload.mechanisms.stage.from_states import loads_of_members
from flankload.mechanisms.stage.modes import stage_modes
from flankload.mechanisms.stage.states import are_displaced, compliances_of, displaced_states

if TYPE_CHECKING:
    from flankload.mechanisms.protocol import Mechanism
    from flankload.mechanisms.several.assembly import Compliances
    from flankload.mechanisms.several.states import MeshesStates


class PlanetaryStage(SeveralMeshes[StageAssembly]):
    """A sun, equal planets, and a ring."""

    body_names = NAMES
    displaced = Displaced(are_displaced, displaced_states)

    build = staticmethod(assemble)
    compliances = staticmethod(compliances_of)
    loads = staticmethod(loads_of_members)
    describe = staticmethod(describe)
    data_sheet = staticmethod(data_sheet)
    modes = staticmethod(stage_modes)


MECHANISM: Mechanism[StageAssembly, Compliances, MeshesStates] = PlanetaryStage()
