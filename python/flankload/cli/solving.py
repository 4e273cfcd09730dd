"""The commands that solve one scene, or predict it: run, report, plan."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from threading import Thread
from typing import TYPE_CHECKING

from flankload.cli.outputs import STDOUT, check_apart, check_outputs, write_text
from flankload.cli.progress import Progress
from flankload.cli.result_files import (
    check_files,
    check_tables,
    files_of,
    plot_options,
    write_files,
)
from flankload.cli.settings import scene_of

if TYPE_CHECKING:
    from argparse import Namespace

    from flankload.result import Result
    from flankload.scene import Scene


def run(arguments: Namespace) -> None:
    """Solve a scene; write and print the results."""
    options = plot_options(arguments)
    places = check_files(arguments, options["formats"])
    scene = scene_of(arguments)
    check_apart(places, scene)
    check_tables(arguments, scene)
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
    scene = scene_of(arguments)
    check_apart(places, scene)
    from flankload.report import scene_of_report

    scene = scene_of_report(scene)
    found = _solve(scene, quiet=arguments.quiet, drawn=True)
    _write_page(found, scene, output, arguments.line)
    if output != STDOUT and not arguments.quiet:
        print(f"wrote {output}")


def plan(arguments: Namespace) -> None:
    """Print the effects of a run, their cost and their size."""
    scene = scene_of(arguments)
    from flankload.studies.plan import plan as plan_of

    found = plan_of(scene, levels=arguments.levels, dimension=arguments.dimension)
    print(found.to_json() if arguments.json else found)


def _write_page(found: Result, scene: Scene, output: str, line: str) -> None:
    """Write the page of a report to a file, or to stdout."""
    from flankload.report import report_html

    write_text(output, report_html(found, scene, line=line))


def _solve(scene: Scene, *, quiet: bool, drawn: bool, planned: bool = False) -> Result:
    """Solve with progress, which announces a run that takes long."""
    from flankload.api import solve
    from flankload.mechanisms.stage_clock import end_of_phase

    if drawn:  # the import needs a third of the time of a small run: beside it
        Thread(target=import_module, args=("flankload.plot",), daemon=True).start()
    with Progress(wanted=not quiet, announced=not quiet, end_of=end_of_phase) as progress:
        predicted = None
        if planned:
            from flankload.studies.plan import plan as plan_of

            progress.tell("plan", 0, 1)
            predicted = plan_of(scene)
        return solve(scene, progress=progress.tell, plan=predicted)
