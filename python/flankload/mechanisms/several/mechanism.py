"""A drive with several gear meshes as a kind of drive: the methods that all of them share."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any, Generic

import numpy as np

from flankload.contact.record_files import meshes_records
from flankload.mechanisms.flank_pair.body_files import files_of_compliances, files_of_meshes
from flankload.mechanisms.flank_pair.parameters import parameters_of_flanks
from flankload.mechanisms.several.estimates import OF_MESHES, error_estimates
from flankload.mechanisms.several.from_states import result_of_mesh, result_of_meshes
from flankload.mechanisms.several.premises import broken_by_geometry, broken_by_load
from flankload.mechanisms.several.states import (
    AssemblyT,
    compliances_of,
    counted_work,
    states_of_meshes,
    sweeps_of_states,
)
from flankload.mechanisms.stage_clock import StageClock
from flankload.result.pairs import MadeWhenRead

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping, Sequence

    from flankload.base.arrays import Floats
    from flankload.contact.meshes_contact import AnyContact, MeshesSweep
    from flankload.mechanisms.protocol import ComplianceFile, Displaced, FieldsOfBody, MeshFile
    from flankload.mechanisms.several.assembly import Compliances
    from flankload.mechanisms.several.states import MeshesStates
    from flankload.result.result import Result
    from flankload.scene import Scene


class SeveralMeshes(Generic[AssemblyT]):
    """Bodies in several gear meshes.

    Subclasses have `body_names`, `build`, `loads` (what only this kind of drive has in its result),
    `describe` and `data_sheet`.
    """

    body_names: tuple[str, ...]
    build: Callable[..., AssemblyT]
    loads: Callable[[Scene, AssemblyT, AnyContact, MeshesSweep, Sequence[Result]], Any]
    compliances: Callable[..., tuple[AssemblyT, Compliances]] = staticmethod(compliances_of)
    no_flanks_reason: str | None = None
    displaced: Displaced | None = None
    modes: Any = None

    work = staticmethod(counted_work)
    sweeps = staticmethod(sweeps_of_states)
    states = staticmethod(states_of_meshes)
    broken_by_geometry = staticmethod(broken_by_geometry)
    broken_by_load = staticmethod(broken_by_load)
    estimates = staticmethod(error_estimates)
    parameters = staticmethod(parameters_of_flanks)

    def results(
        self,
        scene: Scene,
        assembly: AssemblyT,
        compliances: Compliances,
        states: MeshesStates,
        estimates: Sequence[Mapping[str, object] | None],
    ) -> tuple[Result, ...]:
        """Results, one per torque."""
        results = []
        for found, estimate in zip(states.found, estimates, strict=True):
            of_meshes: Any = (estimate or {}).get(OF_MESHES, ())
            made = partial(result_of_mesh, scene, assembly, compliances, found, of_meshes)
            meshes = MadeWhenRead(len(found.meshes), made)
            loads = self.loads(scene, assembly, states.contact, found, meshes)
            results.append(result_of_meshes(scene, assembly, compliances, found, estimate, loads))
        return tuple(results)

    def fields_of_bodies(self, scene: Scene) -> Mapping[str, FieldsOfBody | str]:
        """Bodies with elements for the contact forces of results, or why there are none."""
        from flankload.mechanisms.several.loaded_bodies import fields_of_bodies

        return fields_of_bodies(scene, self.build(scene))

    def mesh_files(self, scene: Scene) -> Iterator[MeshFile]:
        """Meshes of the tables at position zero, each at the angle of its first body."""
        assembly = self.build(scene)
        turns, tables = assembly.pairing.body_angles(np.zeros(1))[0], assembly.pairing.tables
        own = [float(turns[tables.index(z)]) for z in range(len(assembly.bodies))]
        yield from files_of_meshes(assembly.names, assembly.bodies, own)

    def compliance_files(self, scene: Scene) -> Iterator[ComplianceFile]:
        """Compliances of the tables."""
        assembly = self.build(scene)
        yield from files_of_compliances(scene, assembly.names, assembly.bodies)

    def record_files(self, scene: Scene) -> Mapping[str, Floats]:
        """Records of all bodies and meshes, and their motions."""
        clock = StageClock(None, self.body_names, 1, {})
        assembly, compliances = self.compliances(scene, self.build(scene), clock, {})
        contact = assembly.contact(scene, compliances)
        return meshes_records(contact, assembly.position_rad, scene.torques_Nmm)
