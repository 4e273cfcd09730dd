"""The commands that judge the program: accuracy, verify, benchmark."""

from __future__ import annotations

import json
from math import isfinite
from typing import TYPE_CHECKING

from flankload.cli.outputs import (
    PNG,
    STDOUT,
    Output,
    check_apart,
    check_file,
    check_outputs,
    refuse,
    write_text,
)
from flankload.cli.progress import Progress
from flankload.cli.settings import scene_of

if TYPE_CHECKING:
    from argparse import Namespace

    from flankload.studies.benchmark import Answers, Case

#: Range of elements on the half-width of a contact of plane bodies: fewer do not resolve the
#: pressure, more take hours.
FEWEST, MOST = 1.0, 100.0


def accuracy(arguments: Namespace) -> None:
    """Run, write and print the study; after an interruption, the finished part of it."""
    if not (isfinite(arguments.budget) and arguments.budget > 0):
        refuse("--budget", "CPU seconds > 0", f"{arguments.budget:g}")
    files = {"--csv": arguments.csv, "--json": arguments.json}
    places = check_outputs(files.items(), [("--plot", arguments.plot, "PNG files", PNG)])
    if arguments.resume is not None:
        check_file("--resume", arguments.resume)
        places.append(Output("--resume", arguments.resume))
    scene = scene_of(arguments)
    check_apart(places, scene)
    from flankload.studies.accuracy import accuracy as study_of

    with Progress(wanted=True) as progress:
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


def verify(arguments: Namespace) -> None:
    """Print both solutions side by side."""
    check_outputs([], [("-o", arguments.folder, "the deck", ())])
    limit = arguments.time_limit
    if limit is not None and not (isfinite(limit) and limit > 0):
        refuse("--time-limit", "seconds > 0", f"{limit:g}")
    from flankload.scene.effects import is_spatial

    scene = scene_of(arguments)
    if arguments.dimension is not None:
        scene = scene.replace({"effects.dimension": arguments.dimension})
    most = arguments.most_unknowns
    if most is not None and most < 1:
        refuse("--most-unknowns", "an integer > 0", most)
    from flankload.studies.verification import FEWEST_SOLID, MOST_UNKNOWNS, files_of_deck

    fewest, elements = FEWEST_SOLID if is_spatial(scene).on else FEWEST, arguments.elements
    if elements is not None and not fewest <= elements <= MOST:
        refuse("--elements", f"a number from {fewest:g} to {MOST:g}", f"{elements:g}")
    from flankload.studies.verification import verify as compared

    if arguments.folder is not None:
        check_apart((Output("-o", path) for path in files_of_deck(arguments.folder)), scene)

    with Progress(wanted=True, announced=True) as progress:
        found = compared(
            scene,
            position=arguments.position,
            folder=arguments.folder,
            run=not arguments.no_run,
            time_limit_s=limit,
            elements_per_half_width=elements,
            large_displacement=arguments.large_displacement,
            program=arguments.program,
            most_unknowns=MOST_UNKNOWNS if most is None else most,
            progress=progress.tell,
        )
    print(found.to_json() if arguments.json else found.table(), end="" if arguments.json else "\n")


def benchmark(arguments: Namespace) -> None:
    """Solve the cases, or read the answers of a program, and print the comparison."""
    from flankload.studies.benchmark import check_answers, compare, read_answers, read_cases

    printed = str(arguments.output) == STDOUT
    if printed and arguments.json:
        refuse("-o", "a file, since --json uses stdout", STDOUT)
    outputs = check_outputs([("-o", arguments.output)])
    cases = read_cases(arguments.folder, arguments.cases)
    read = {f"case {one.name}": arguments.folder / one.name / "case.json" for one in cases}
    if arguments.answers is not None:
        read["the answers"] = arguments.answers
    check_apart(outputs, None, read)
    if arguments.answers is None:
        answers = _solve(cases, arguments)
    else:
        answers = read_answers(arguments.answers)
        check_answers(answers, read_cases(arguments.folder), arguments.answers)
    if arguments.output is not None:
        values = {"program": answers.program, "values": answers.values, "seconds": answers.seconds}
        write_text(arguments.output, json.dumps(values, indent=1) + "\n")
    if printed:
        return
    found = compare(cases, answers)
    if arguments.json:
        print(json.dumps(found.as_dict(), indent=1))
        return
    texts = [found.case_text(case.name) for case in cases] if arguments.cases else []
    print("\n\n".join([*texts, found.to_text()]))


def _solve(cases: tuple[Case, ...], arguments: Namespace) -> Answers:
    """Answers of this program."""
    import flankload
    from flankload.studies.benchmark import Answers, answers_of

    values, seconds = {}, {}
    with Progress(wanted=True) as progress:
        for number, case in enumerate(cases):
            progress.tell("benchmark", number, len(cases))
            values[case.name], seconds[case.name] = answers_of(case, arguments.folder)
    return Answers(f"flankload {flankload.__version__}", values, seconds)
