"""Meshes, compliances and fields of the bodies of a gear train, for files."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flankload.mechanisms.flank_pair.body_files import files_of_compliances, files_of_meshes
from flankload.mechanisms.train.assembly import NAMES, assemble

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from flankload.mechanisms.protocol import ComplianceFile, FieldsOfBody, MeshFile
    from flankload.scene import Scene


def mesh_files(scene: Scene) -> Iterator[MeshFile]:
    """Meshes of the bodies at position zero."""
    assembly = assemble(scene)
    turns = assembly.pairing.body_angles(np.zeros(1))[0].tolist()
    yield from files_of_meshes(NAMES, assembly.bodies, turns)


def compliance_files(scene: Scene) -> Iterator[ComplianceFile]:
    """Compliances of the bodies."""
    yield from files_of_compliances(scene, NAMES, assemble(scene).bodies)


def fields_of_bodies(scene: Scene) -> Mapping[str, FieldsOfBody | str]:
    """No fields: the reason."""
    return dict.fromkeys(NAMES, "this version has no fields of gear trains")
