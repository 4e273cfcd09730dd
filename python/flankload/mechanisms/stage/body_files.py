"""Meshes, compliances and fields of the bodies of a stage, for files."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flankload.mechanisms.flank_pair.body_files import files_of_compliances, files_of_meshes
from flankload.mechanisms.stage.assembly import NAMES, assemble
from flankload.mechanisms.stage.loaded_bodies import fields_of_members

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from flankload.mechanisms.protocol import ComplianceFile, FieldsOfBody, MeshFile
    from flankload.scene import Scene


def mesh_files(scene: Scene) -> Iterator[MeshFile]:
    """Meshes of the bodies at position zero, that of the planets at the angle of planet 1."""
    assembly = assemble(scene)
    sun, planets, ring = assembly.pairing.body_angles(np.zeros(1))
    turns = float(sun[0]), float(planets[0, 0]), float(ring[0])
    yield from files_of_meshes(NAMES, assembly.bodies, turns)


def compliance_files(scene: Scene) -> Iterator[ComplianceFile]:
    """Compliances of the bodies."""
    yield from files_of_compliances(scene, NAMES, assemble(scene).bodies)


def fields_of_bodies(scene: Scene) -> Mapping[str, FieldsOfBody | str]:
    """Sun, planets and ring with elements for the contact forces of results, or why not."""
    return fields_of_members(scene, assemble(scene))
