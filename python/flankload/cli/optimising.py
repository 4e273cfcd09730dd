"""The command optimise: search for the best values of keys, write the optimal scene."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from flankload.cli.outputs import check_apart, check_file
from flankload.cli.solving import Progress
from flankload.errors import SceneError

if TYPE_CHECKING:
    from argparse import Namespace

    from flankload.scene import Scene

TABLES = ("variables", "objective", "constraints")


def optimise(arguments: Namespace) -> None:
    """Read the file and its scene, search, write and print."""
    from flankload.scene import read_scene
    from flankload.scene.form import read_table
    from flankload.scene.reader import read_tables
    from flankload.studies.optimisation import OptimisationFile
    from flankload.studies.optimisation import optimise as optimum_of

    file: Path = arguments.file
    tree = read_tables(file, "a file of an optimisation")
    options = {key: value for key, value in tree.items() if key not in TABLES}
    try:
        scene_path = file.parent / read_table(OptimisationFile, options, "").scene
    except SceneError as error:
        raise error.with_file(file) from None
    scene = read_scene(scene_path)
    if arguments.output is not None:
        _check_output(arguments.output, scene, file)
    del options["scene"]
    tables: dict[str, Any] = {"variables": (), "objective": {}, "constraints": ()}
    tables |= {key: tree[key] for key in TABLES if key in tree}
    try:
        with Progress(wanted=sys.stderr.isatty()) as progress:
            optimum = optimum_of(scene, **tables, progress=progress.tell, **options)
    except SceneError as error:
        raise (error if error.file is not None else error.with_file(file)) from None
    if arguments.output is not None:
        from flankload.base.files import write_atomically

        write_atomically(arguments.output, optimum.scene.to_toml())
    print(optimum)


def _check_output(path: Path, scene: Scene, file: Path) -> None:
    """Refuse an output that could not be written, or where the files of the scene are not found."""
    check_file("-o", path)
    check_apart([("-o", path)], scene, {"the optimisation": file})
    if scene.files and path.resolve().parent != scene.folder.resolve():
        raise SceneError(
            key="-o",
            expected=f"a file in the folder {scene.folder} of the scene, which names other files",
            found=path,
        )
