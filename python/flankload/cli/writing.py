"""The commands scene, mesh, compliance and record: a scene of a gearbox model, and its bodies."""

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
    from flankload.bodies.imported.body_file import write_body
    from flankload.mechanisms.registry import mechanism_of
    from flankload.studies.tolerance import first_scene

    mechanism = mechanism_of(scene)
    paths = (folder / f"{name}.{arguments.format}" for name in mechanism.body_names)
    check_apart((Output("-o", path) for path in paths), scene)
    meshes = list(mechanism.mesh_files(first_scene(scene)))
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
    from flankload.base.array_archive import archive_of
    from flankload.base.files import write_atomically
    from flankload.mechanisms.registry import mechanism_of

    mechanism = mechanism_of(scene)
    check_apart((Output("-o", folder / f"{name}.npz") for name in mechanism.body_names), scene)
    files: dict[str, bytes] = {}
    said = []
    for found in mechanism.compliance_files(scene):
        if found.arrays is None:
            said.append(f"{found.name}: {found.words}")
            continue
        files[f"{found.name}.npz"] = archive_of(found.arrays)
        said.append(f"{folder / found.name}.npz: {found.words}")
    folder.mkdir(parents=True, exist_ok=True)
    for file, content in files.items():
        write_atomically(folder / file, content)
    print("\n".join(said))


def record(arguments: Namespace) -> None:
    """Write a file per body and mesh, and one of motions and torques; all are computed before."""
    folder: Path = arguments.folder
    check_outputs([], [("-o", folder, "the records", ())])
    scene = scene_of(arguments)
    from flankload.base.files import write_atomically
    from flankload.contact.record_files import bytes_of, text_of
    from flankload.mechanisms.registry import mechanism_of
    from flankload.studies.prepared import scene_of_one_run

    found = mechanism_of(scene).record_files(scene_of_one_run(scene))
    suffix = "dat" if arguments.format == "text" else "bin"
    paths = {folder / f"{name}.{suffix}": numbers for name, numbers in found.items()}
    check_apart((Output("-o", path) for path in paths), scene)
    folder.mkdir(parents=True, exist_ok=True)
    for path, numbers in paths.items():
        text = arguments.format == "text"
        title = f"{path.stem} of {scene.file}"
        write_atomically(path, text_of(numbers, title) if text else bytes_of(numbers))
        print(f"{path}: {int(numbers[1])} numbers")
