"""The commands scene, mesh and compliance: write a scene of a gearbox model, and its bodies."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flankload.cli.outputs import (
    STDOUT,
    Output,
    check_apart,
    check_outputs,
    refuse,
    say,
    write_text,
)
from flankload.cli.settings import scene_of, settings_of
from flankload.errors import SceneError

if TYPE_CHECKING:
    from argparse import Namespace
    from pathlib import Path

    from flankload.scene import Scene


def scene(arguments: Namespace) -> None:
    """Read the model; write the scene of a stage and print what it lacks, or print the stages."""
    from flankload.base.text_table import text_table
    from flankload.exchange.rexs import Choices, read_model, scene_of_stage, stage_rows
    from flankload.mechanisms.registry import mechanism_of

    settings = settings_of(arguments.settings)
    if arguments.torque_Nm is not None:
        settings["load.torque_Nm"] = arguments.torque_Nm
    path: Path | None = arguments.output
    printed = str(path) == STDOUT
    check_apart(check_outputs([("-o", path)]), None, {"the model": arguments.file})
    if path is None and arguments.stage is not None:
        refuse("-o", "a file for the scene of the stage", "nothing")
    model = read_model(arguments.file)
    if path is None:
        print("\n".join(text_table(stage_rows(model), left=5)))
        return
    choices = Choices(arguments.stage, arguments.load_case, arguments.flank, settings)
    made = scene_of_stage(model, choices, file=None if printed else path)
    try:
        notes = mechanism_of(made.scene).describe(made.scene).notes
    except SceneError as error:
        raise error.with_file(arguments.file) from None
    write_text(path, made.scene.to_toml())
    speak = say if printed else print
    if not printed:
        print(f"{path}: {made.stage} of {arguments.file}")
    for line in (*made.lines, *(f"warning: {note}" for note in notes)):
        speak(line)


def mesh(arguments: Namespace) -> None:
    """Write the meshes of both bodies at position zero."""
    folder: Path = arguments.folder
    check_outputs([], [("-o", folder, "both meshes", ())])
    scene = scene_of(arguments)
    bodies = (folder / f"body_{z}.{arguments.format}" for z in (1, 2))
    check_apart((Output("-o", path) for path in bodies), scene)
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
    check_outputs([], [("-o", folder, "both files", ())])
    scene = scene_of(arguments)
    check_apart((Output("-o", folder / f"body_{z}.npz") for z in (1, 2)), scene)
    if not (scene.is_drive or scene.body_2.has_teeth):
        expected = "bodies with teeth: no scene could read the file of a cam"
        refuse("body_2.kind", expected, "'cam'", scene.file)
    if scene.effects.near_field == "nodes":
        expected = "'analytic': the files hold pressure modes"
        refuse("effects.near_field", expected, "'nodes'", scene.file)
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
