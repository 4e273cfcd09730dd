"""The command report: solve a scene and write one page about it."""

from __future__ import annotations

import sys
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from flankload.cli.outputs import STDOUT, check_apart, check_file
from flankload.cli.solving import Progress, announce, import_plot_meanwhile

if TYPE_CHECKING:
    from argparse import Namespace

    from flankload.result import Result
    from flankload.scene import Scene


def report(arguments: Namespace) -> None:
    """Solve a scene and write its report."""
    output: str = arguments.output
    if output != STDOUT:
        check_file("-o", Path(output))
    from flankload.scene import read_scene

    scene = read_scene(arguments.scene)
    if output != STDOUT:
        check_apart([("-o", Path(output))], scene)
    from flankload.api import solve
    from flankload.report.positions import scene_of_report

    scene = scene_of_report(scene)
    import_plot_meanwhile()
    with Progress(wanted=not arguments.quiet and sys.stderr.isatty()) as progress:
        on_duration = None if arguments.quiet else partial(announce, progress)
        found = solve(scene, progress=progress.tell, on_duration=on_duration)
    write_page(found, scene, output, arguments.line)
    if output != STDOUT and not arguments.quiet:
        print(f"wrote {output}")


def write_page(found: Result, scene: Scene, output: str, line: str) -> None:
    """Write the page to a file, or to stdout."""
    from flankload.report import report_html, write_report

    if output == STDOUT:
        print(report_html(found, scene, line=line), end="")
    else:
        write_report(found, scene, output, line=line)
