"""The commands mesh and compliance: write both bodies of a scene, with and without elements."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from flankload.cli.outputs import check_apart, check_folder
from flankload.errors import SceneError

if TYPE_CHECKING:
    from argparse import Namespace

    from flankload.scene import Scene


def mesh(arguments: Namespace) -> None:
    """Write the meshes of both bodies at position zero."""
    folder: Path = arguments.folder
    check_folder("-o", folder, content="both meshes")
    from flankload.scene import read_scene

    scene = read_scene(arguments.scene)
    bodies = (folder / f"body_{z}.{arguments.format}" for z in (1, 2))
    check_apart((("-o", path) for path in bodies), scene)
    from flankload.bodies.imported.body_file import write_body
    from flankload.mechanisms.registry import mechanism_of
    from flankload.studies.tolerance import first_scene

    scene = first_scene(scene)
    meshes = list(mechanism_of(scene).meshes(scene))
    if any(item.mesh is not None for item in meshes):
        folder.mkdir(parents=True, exist_ok=True)
    for item in meshes:
        if item.mesh is None:
            print(f"{item.name}: {item.words}")
            continue
        path = folder / f"{item.name}.{arguments.format}"
        write_body(path, item.mesh, turn_rad=item.turn_rad)
        print(f"{path}: {len(item.mesh.nodes)} nodes, {item.words}")


def compliance(arguments: Namespace) -> None:
    """Write body_1.npz and body_2.npz; everything is computed before the first is written."""
    folder: Path = arguments.folder
    check_folder("-o", folder, content="both files")
    from flankload.scene import read_scene

    scene = read_scene(arguments.scene)
    check_apart((("-o", folder / f"body_{z}.npz") for z in (1, 2)), scene)
    if not (scene.is_drive or scene.body_2.has_teeth):
        raise SceneError(
            file=scene.file,
            key="body_2.kind",
            expected="bodies with teeth: no scene could read the file of a cam",
            found="'cam'",
        )
    if scene.effects.near_field == "nodes":
        raise SceneError(
            file=scene.file,
            key="effects.near_field",
            expected="'analytic': the files hold pressure modes",
            found="'nodes'",
        )
    from flankload.scene.effects import require_plane

    require_plane(scene, "the files hold the compliance of plane bodies")
    from flankload.base.array_archive import archive_of
    from flankload.base.files import write_atomically
    from flankload.elasticity.modal_arrays import modal_arrays
    from flankload.mechanisms.flank_pair.assembly import build_bodies
    from flankload.mechanisms.flank_pair.stages import compliance_of

    pair = build_bodies(scene)
    files: dict[str, bytes] = {}
    said = []
    for name, body in (("body_1", pair.body_1), ("body_2", pair.body_2)):
        if body.rigid:
            said.append(f"{name}: rigid, so it has no compliance")
            continue
        found = compliance_of(body, scene)
        arrays = modal_arrays(body, found, plane=scene.accuracy.plane)
        files[f"{name}.npz"] = archive_of(arrays)
        said.append(
            f"{folder / name}.npz: {body.teeth} teeth, {found.smooth.shape[1]} pressure modes, "
            f"plane {scene.accuracy.plane}{_less_than_whole(scene)}"
        )
    folder.mkdir(parents=True, exist_ok=True)
    for file, content in files.items():
        write_atomically(folder / file, content)
    print("\n".join(said))


def _less_than_whole(scene: Scene) -> str:
    """Note on the part of a body that the scene omits, which the file omits too."""
    if scene.sectors is None:
        return "" if scene.effects.tooth_coupling else ", without coupling between teeth"
    return ", of a single tooth" if scene.sectors == 1 else f", of {scene.sectors} teeth"
