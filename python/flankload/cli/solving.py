"""The commands that solve and write: run, mesh, schema."""

from __future__ import annotations

import json
import sys
from functools import partial
from importlib import import_module
from pathlib import Path
from threading import Thread, Timer
from typing import TYPE_CHECKING, Any, Self

from flankload.cli.drawing import plot_options
from flankload.cli.outputs import STDOUT, check_apart, check_folder
from flankload.cli.result_files import check_outputs, files_of, places_of, write_files

if TYPE_CHECKING:
    from argparse import Namespace

    from flankload.mechanisms.duration import Duration
    from flankload.scene import Scene
    from flankload.studies.plan import Plan

#: Seconds after which a run first shows progress.
PATIENCE_S = 1.0

#: A run with a longer predicted duration, s, is announced before it starts.
LONG_S = 10.0


def run(arguments: Namespace) -> None:
    """Solve a scene; write and print the results."""
    options = plot_options(arguments)
    check_outputs(arguments, options["formats"])
    from flankload.scene import read_scene

    scene = read_scene(arguments.scene)
    check_apart(places_of(arguments), scene)
    from flankload.api import solve

    if arguments.plot is not None or arguments.report is not None:
        import_plot_meanwhile()
    with Progress(wanted=not arguments.quiet and sys.stderr.isatty()) as progress:
        plan = _plan(scene, progress) if arguments.cost else None
        on_duration = None if arguments.quiet else partial(announce, progress)
        found = solve(scene, progress=progress.tell, plan=plan, on_duration=on_duration)
    results = found.by_torque
    written: tuple[Path, ...] = ()
    if arguments.plot is not None:
        from flankload.plot import plot_all

        written = plot_all(results, arguments.plot, **options)
    said = write_files(arguments, scene, results, listed=found.has_torque_list)
    if arguments.report is not None:
        from flankload.cli.reporting import write_page

        write_page(found, scene, arguments.report, arguments.line)
        written += (Path(arguments.report),) * (arguments.report != STDOUT)
    from flankload.result import results_to_text

    texts = [] if arguments.quiet else [results_to_text(results)]
    if arguments.cost:  # for all torques together
        texts.append(results[0].cost_table())
    if written:
        said += [f"wrote {path}" for path in written]
    if said and not arguments.quiet:
        texts.append("\n".join(said))
    if texts and STDOUT not in files_of(arguments).values():
        print("\n\n".join(texts))


def import_plot_meanwhile() -> None:
    """Import the plots beside the run: that needs a third of the time of a small run."""
    Thread(target=import_module, args=("flankload.plot",), daemon=True).start()


def announce(progress: Progress, duration: Duration) -> None:
    """Announce the predicted duration of a long run."""
    if duration.seconds > LONG_S:
        progress.say(f"flankload: {duration}")


def _plan(scene: Scene, progress: Progress) -> Plan:
    """Predicted cost of the run."""
    from flankload.studies.plan import plan

    progress.tell("plan", 0, 1)
    return plan(scene)


class Progress:
    """A progress bar on stderr for long computations."""

    def __init__(self, *, wanted: bool) -> None:
        self._wanted = wanted
        self._bar: Any = None
        self._task: Any = None
        self._told = ("", 0, 1)
        self._timer = Timer(PATIENCE_S, self._show)
        self._timer.daemon = True

    def __enter__(self) -> Self:
        if self._wanted:
            self._timer.start()
        return self

    def __exit__(self, *_: object) -> None:
        if not self._wanted:
            return
        self._timer.cancel()
        self._timer.join()
        if self._bar is not None:
            self._bar.stop()

    def tell(self, stage: str, done: int, total: int) -> None:
        """Record the beginning of a stage."""
        self._told = (stage, done, total)
        if self._bar is not None:
            self._bar.update(self._task, description=stage, completed=done, total=total)

    def say(self, line: str) -> None:
        """Print a line on stderr, above the bar if there is one."""
        if self._bar is not None:
            self._bar.console.print(line, markup=False, highlight=False, soft_wrap=True)
        else:
            print(line, file=sys.stderr, flush=True)

    def _show(self) -> None:
        from rich.console import Console
        from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

        bar = Progress(
            TextColumn("{task.description:<20}"),
            BarColumn(),
            TimeElapsedColumn(),
            console=Console(stderr=True),
            transient=True,
        )
        stage, done, total = self._told
        self._task = bar.add_task(stage, completed=done, total=total)
        bar.start()
        self._bar = bar


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


def schema(arguments: Namespace) -> None:
    """Print the JSON schema of a scene file, or the paths of its keys."""
    from flankload.scene import scene_paths, scene_schema

    if arguments.paths:
        for key in scene_paths():
            kinds = f" ({key.kinds})" if key.kinds else ""
            unit = f" [{key.unit}]" if key.unit else ""
            print(f"{key.path}{unit}: {key.expected}; {key.meaning}{kinds}")
        return
    print(json.dumps(scene_schema(), indent=2, ensure_ascii=False))
