"""Meshes and compliances of both bodies, for files."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flankload.bodies import WholeMesh
from flankload.bodies.free_corner import forces_turn
from flankload.elasticity.modal_arrays import modal_arrays
from flankload.mechanisms.elements import compliance_of
from flankload.mechanisms.flank_pair.assembly import build_bodies
from flankload.mechanisms.protocol import ComplianceFile, MeshFile
from flankload.pairing.body_pair import BodyJob
from flankload.scene.refusal import refuse

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from flankload.bodies import Body
    from flankload.scene import Scene


def mesh_files(scene: Scene) -> Iterator[MeshFile]:
    """Meshes of both bodies at position zero."""
    pair = build_bodies(scene)
    yield from files_of_meshes(pair.names, pair.bodies, pair.pairing.turns_at_zero_rad)


def files_of_meshes(
    names: Sequence[str], bodies: Sequence[Body], turns_rad: Sequence[float]
) -> Iterator[MeshFile]:
    """Meshes of bodies at their angles."""
    for name, body, turn in zip(names, bodies, turns_rad, strict=True):
        if body.mesh is None:
            why = "its compliance comes from a file" if body.imported is not None else "rigid"
            yield MeshFile(name, None, f"{why}, so it has no mesh")
            continue
        part = f"one of {body.teeth} sectors"
        if isinstance(body.mesh, WholeMesh):
            flanks = len(body.mesh.flanks)
            part = f"the whole body with {flanks} flank{'s' * (flanks > 1)}"
        yield MeshFile(name, body.mesh, part, turn)


def compliance_files(scene: Scene) -> Iterator[ComplianceFile]:
    """Compliances of both bodies; a SceneError if no scene could read their files."""
    if not (scene.is_drive or scene.body_2.has_teeth):
        expected = "bodies with teeth: no scene could read the file of a cam"
        refuse("body_2.kind", expected, "'cam'", scene.file)
    if scene.effects.near_field == "nodes":
        expected = "'analytic': the files hold pressure modes"
        refuse("effects.near_field", expected, "'nodes'", scene.file)
    pair = build_bodies(scene)
    yield from files_of_compliances(scene, pair.names, pair.bodies)


def files_of_compliances(
    scene: Scene, names: Sequence[str], bodies: Sequence[Body]
) -> Iterator[ComplianceFile]:
    """Compliances of bodies that touch."""
    job = BodyJob(elastic=True, turns=forces_turn(bodies))
    for name, body in zip(names, bodies, strict=True):
        if body.rigid:
            yield ComplianceFile(name, None, "rigid, so it has no compliance")
            continue
        found = compliance_of(body, scene, job=job)
        arrays = modal_arrays(body, found, plane=scene.accuracy.plane)
        shape = body.axial
        extent = f"plane {scene.accuracy.plane}" if shape.plane else f"{shape.width_mm:g} mm wide"
        words = (
            f"{body.teeth} teeth, {found.smooth.shape[1]} pressure modes, "
            f"{extent}{_less_than_whole(scene)}"
        )
        yield ComplianceFile(name, arrays, words)


def _less_than_whole(scene: Scene) -> str:
    """Note on the part of a body that the scene omits, which the file omits too."""
    if scene.sectors is None:
        return "" if scene.effects.tooth_coupling else ", without coupling between teeth"
    return ", of a single tooth" if scene.sectors == 1 else f", of {scene.sectors} teeth"
