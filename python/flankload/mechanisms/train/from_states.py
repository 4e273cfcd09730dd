"""Conversion of the states of a gear train to its result."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flankload.base.torque import in_newton_metres
from flankload.mechanisms.several.from_states import MeshResults, result_of_meshes
from flankload.result.train import TrainLoads

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from flankload.mechanisms.several.assembly import Compliances
    from flankload.mechanisms.several.states import MeshesStates
    from flankload.mechanisms.train.assembly import TrainAssembly
    from flankload.result.result import Result
    from flankload.scene import Scene


def train_results(
    scene: Scene,
    assembly: TrainAssembly,
    compliances: Compliances,
    states: MeshesStates,
    estimates: Sequence[Mapping[str, object] | None],
) -> tuple[Result, ...]:
    """Results, one per torque."""
    pairing, results = assembly.pairing, []
    for found, estimate in zip(states.found, estimates, strict=True):
        loads = TrainLoads(
            kind="idler" if pairing.is_idler else "two_pinions",
            teeth=pairing.teeth,
            centers_mm=pairing.axes_mm,
            phases=np.array([mesh.phase for mesh in pairing.meshes]),
            torque_2_Nm=in_newton_metres(found.resultants[:, 1, 2]),
            torque_3_Nm=in_newton_metres(found.resultants[:, 2, 2]),
            bearing_force_N=found.resultants[:, :, :2],
            orbit_um=1000.0 * found.moved_mm[:, pairing.common],
            common=pairing.common + 1,
            meshes=MeshResults(scene, assembly, compliances, found),
        )
        results.append(result_of_meshes(scene, assembly, compliances, found, estimate, loads))
    return tuple(results)
