"""The command scene: write the scene of a gear stage of a gearbox model, or list the stages."""

from __future__ import annotations

import sys
import tomllib
from typing import TYPE_CHECKING, Any

from flankload.cli.outputs import STDOUT, check_apart, check_file, write_text
from flankload.errors import SceneError

if TYPE_CHECKING:
    from argparse import Namespace
    from collections.abc import Iterable, Sequence
    from pathlib import Path

    from flankload.scene import Scene


def scene(arguments: Namespace) -> None:
    """Read the model; write the scene of a stage and print what it lacks, or print the stages."""
    from flankload.base.text_table import text_table
    from flankload.exchange.rexs import Choices, read_model, scene_of_stage, stage_rows

    settings = _settings(arguments.settings)
    if arguments.torque_Nm is not None:
        settings["load.torque_Nm"] = arguments.torque_Nm
    path: Path | None = arguments.output
    printed = path is not None and str(path) == STDOUT
    if path is not None and not printed:
        check_file("-o", path)
        check_apart([("-o", path)], None, {"the model": arguments.file})
    elif arguments.stage is not None:
        raise SceneError(key="-o", expected="a file for the scene of the stage", found="nothing")
    model = read_model(arguments.file)
    if path is None:
        print("\n".join(text_table(stage_rows(model), left=5)))
        return
    choices = Choices(arguments.stage, arguments.load_case, arguments.flank, settings)
    made = scene_of_stage(model, choices, file=None if printed else path)
    try:
        notes = _notes(made.scene)
    except SceneError as error:
        raise error.with_file(arguments.file) from None

    write_text(path, made.scene.to_toml())
    stream = sys.stderr if printed else sys.stdout
    if not printed:
        print(f"{path}: {made.stage} of {arguments.file}")
    for line in (*made.lines, *(f"warning: {note}" for note in notes)):
        print(line, file=stream)


def _notes(made: Scene) -> Sequence[str]:
    """Build the bodies, as the command check does; return its warnings."""
    from flankload.mechanisms.registry import mechanism_of

    return mechanism_of(made).describe(made).notes


def _settings(given: Iterable[str]) -> dict[str, Any]:
    """Keys of a scene with their values, which are those of TOML or plain words."""
    found: dict[str, Any] = {}
    for text in given:
        key, equals, value = text.partition("=")
        if not (key and equals):
            raise SceneError(key="--set", expected="KEY=VALUE", found=text)
        try:
            found[key.strip()] = tomllib.loads(f"value = {value}")["value"]
        except tomllib.TOMLDecodeError:
            found[key.strip()] = value.strip()
    return found
