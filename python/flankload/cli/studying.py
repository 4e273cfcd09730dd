"""The command accuracy: errors and CPU seconds by discretization parameter."""

from __future__ import annotations

import sys
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING

from flankload.cli.outputs import STDOUT, check_apart, check_file, check_folder, write_text
from flankload.cli.solving import Progress
from flankload.errors import SceneError

if TYPE_CHECKING:
    from argparse import Namespace


def accuracy(arguments: Namespace) -> None:
    """Run, write and print the study; after an interruption, the finished part of it."""
    if not (isfinite(arguments.budget) and arguments.budget > 0):
        raise SceneError(key="--budget", expected="CPU seconds > 0", found=f"{arguments.budget:g}")
    files = {"--csv": arguments.csv, "--json": arguments.json}
    if STDOUT in files.values() and files["--csv"] == files["--json"]:
        raise SceneError(key="--json", expected="a file, since --csv uses stdout", found="-")
    named = {**files, "--resume": arguments.resume}
    places = {key: Path(path) for key, path in named.items() if path not in (None, STDOUT)}
    for key, path in places.items():
        check_file(key, path)
    if arguments.plot is not None:
        check_folder("--plot", arguments.plot, content="PNG files")
        places["--plot"] = arguments.plot
    from flankload.scene import read_scene

    scene = read_scene(arguments.scene)
    check_apart(places.items(), scene)
    from flankload.studies.accuracy import accuracy as study_of

    with Progress(wanted=sys.stderr.isatty()) as progress:
        study = study_of(
            scene,
            tuple(arguments.quantities.split(",")),
            arguments.budget,
            progress=progress.tell,
            resume=arguments.resume,
        )
    for path, text_of in ((arguments.csv, study.to_csv), (arguments.json, study.to_json)):
        if path is not None:
            write_text(path, text_of())
    if arguments.plot is not None:
        from flankload.plot.work_precision import write_work_precision

        write_work_precision(study, arguments.plot)
    if STDOUT not in files.values():
        print(study)
    if study.interrupted:
        raise KeyboardInterrupt
