"""The command benchmark: compare with the reference results of the benchmark set."""

from __future__ import annotations

import json
import sys
from typing import TYPE_CHECKING

from flankload.cli.outputs import STDOUT, check_file, write_text
from flankload.cli.solving import Progress
from flankload.errors import SceneError

if TYPE_CHECKING:
    from argparse import Namespace

    from flankload.studies.benchmark import Answers, Case


def benchmark(arguments: Namespace) -> None:
    """Solve the cases, or read the answers of a program, and print the comparison."""
    from flankload.studies.benchmark import check_answers, compare, read_answers, read_cases

    printed = str(arguments.output) == STDOUT
    if printed and arguments.json:
        raise SceneError(key="-o", expected="a file, since --json uses stdout", found="-")
    if arguments.output is not None and not printed:
        check_file("-o", arguments.output)
    cases = read_cases(arguments.folder, arguments.cases)
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
    with Progress(wanted=sys.stderr.isatty()) as progress:
        for number, case in enumerate(cases):
            progress.tell("benchmark", number, len(cases))
            values[case.name], seconds[case.name] = answers_of(case, arguments.folder)
    return Answers(f"flankload {flankload.__version__}", values, seconds)
