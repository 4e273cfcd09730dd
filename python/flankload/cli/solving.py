"""The commands that solve one scene, or predict it: run, report, plan."""

from __future__ import annotations

import sys
from importlib import import_module
from pathlib import Path
from threading import Thread, Timer
from typing import TYPE_CHECKING, Any, Self

from flankload.cli.outputs import STDOUT, check_apart, check_outputs, write_text
from flankload.cli.result_files import check_files, files_of, plot_options, write_files

if TYPE_CHECKING:
    from argparse import Namespace

    from flankload.mechanisms.duration import Duration
    from flankload.result import Result
    from flankload.scene import Scene

#: Seconds after which a run first shows progress.
PATIENCE_S = 1.0

#: A run with a longer predicted duration, s, is announced before it starts.
LONG_S = 10.0


def run(arguments: Namespace) -> None:
    """Solve a scene; write and print the results."""
    options = plot_options(arguments)
    places = check_files(arguments, options["formats"])
    from flankload.scene import read_scene

    scene = read_scene(arguments.scene)
    check_apart(places, scene)
    drawn = arguments.plot is not None or arguments.report is not None
    found = _solve(scene, quiet=arguments.quiet, drawn=drawn, planned=arguments.cost)
    results = found.by_torque
    written: tuple[Path, ...] = ()
    if arguments.plot is not None:
        from flankload.plot import plot_all

        written = plot_all(results, arguments.plot, **options)
    said = write_files(arguments, scene, results, listed=found.has_torque_list)
    if arguments.report is not None:
        _write_page(found, scene, arguments.report, arguments.line)
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


def report(arguments: Namespace) -> None:
    """Solve a scene and write its report."""
    output: str = arguments.output
    places = check_outputs([("-o", output)])
    from flankload.scene import read_scene

    scene = read_scene(arguments.scene)
    check_apart(places, scene)
    from flankload.report import scene_of_report

    scene = scene_of_report(scene)
    found = _solve(scene, quiet=arguments.quiet, drawn=True)
    _write_page(found, scene, output, arguments.line)
    if output != STDOUT and not arguments.quiet:
        print(f"wrote {output}")


def plan(arguments: Namespace) -> None:
    """Print the effects of a run, their cost and their size."""
    from flankload.scene import read_scene

    scene = read_scene(arguments.scene)
    from flankload.studies.plan import plan as plan_of

    found = plan_of(scene, levels=arguments.levels, dimension=arguments.dimension)
    print(found.to_json() if arguments.json else found)


def _write_page(found: Result, scene: Scene, output: str, line: str) -> None:
    """Write the page of a report to a file, or to stdout."""
    from flankload.report import report_html

    write_text(output, report_html(found, scene, line=line))


def _solve(scene: Scene, *, quiet: bool, drawn: bool, planned: bool = False) -> Result:
    """Solve with progress; announce a run that takes long by its prediction."""
    from flankload.api import solve

    if drawn:  # the import needs a third of the time of a small run: beside it
        Thread(target=import_module, args=("flankload.plot",), daemon=True).start()
    with Progress(wanted=not quiet and sys.stderr.isatty()) as progress:

        def announce(duration: Duration) -> None:
            if duration.seconds > LONG_S:
                progress.say(f"flankload: {duration}")

        predicted = None
        if planned:
            from flankload.studies.plan import plan as plan_of

            progress.tell("plan", 0, 1)
            predicted = plan_of(scene)
        on_duration = None if quiet else announce
        return solve(scene, progress=progress.tell, plan=predicted, on_duration=on_duration)


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
