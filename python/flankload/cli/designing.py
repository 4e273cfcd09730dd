"""The commands that run many designs of a scene: study, optimise."""

from __future__ import annotations

import os
import signal
from contextlib import AbstractContextManager, contextmanager, nullcontext
from importlib.util import find_spec
from pathlib import Path
from threading import Thread
from time import monotonic
from typing import TYPE_CHECKING, Any

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
from flankload.errors import FlankloadError

if TYPE_CHECKING:
    from argparse import Namespace
    from collections.abc import Callable, Iterator
    from concurrent.futures import Executor

    from flankload.scene import Scene
    from flankload.studies.design import DesignStudy

#: Tables of the file of an optimisation; its other keys are options.
TABLES = ("variables", "objective", "constraints")
#: Seconds for which a scheduler may take to answer.
PATIENCE_S = 10


def study(arguments: Namespace) -> None:
    """Solve the designs of a study that its store lacks, write and print them."""
    outputs = list(dict.fromkeys(arguments.outputs))
    _check_suffixes(outputs)
    places = check_outputs(
        (("-o", path) for path in outputs), [("--plot", arguments.plot, "PNG files", PNG)]
    )
    if arguments.workers is not None and arguments.workers < 1:
        refuse("--workers", "an integer > 0", arguments.workers)
    if arguments.workers is not None and arguments.scheduler is not None:
        expected = "no such option with --scheduler, which has its own workers"
        refuse("--workers", expected, arguments.workers)
    from flankload.scene.refusal import in_file
    from flankload.studies.design import read_study, run_study

    asked = read_study(arguments.file)
    store = f"{asked.file}: store"
    check_file(store, asked.store)
    read = {"the study": asked.file} | asked.designs.files(asked.scene.folder)
    check_apart([Output(store, asked.store), *places], asked.scene, read)
    try:
        with (
            in_file(asked.file),
            Progress(wanted=not arguments.quiet, announced=not arguments.quiet) as progress,
            _executor(arguments) as executor,
        ):
            tell = _Rate(progress, said=not arguments.quiet).tell
            found = run_study(
                asked.scene, asked.designs, asked.quantities, asked.store, executor, tell
            )
    except KeyboardInterrupt as stop:
        said = str(stop) or "interrupted"
        raise KeyboardInterrupt(f"{said}; {arguments.line} resumes") from None
    for path in outputs:
        if path.lower().endswith(".parquet"):
            found.to_parquet(path)
        else:
            write_text(path, found.to_csv())
    pictures = _pictures(found, arguments.plot)
    if not arguments.quiet and STDOUT not in outputs:
        print("\n".join([str(found), *pictures]))
    if len(found.failed) == len(found.rows):
        raise FlankloadError(f"no design has a solution: {found.failed[0].outcome.error}")


class _Rate:
    """Progress with designs per second and the time left, from the designs after the first one.

    The first design has no elements to reuse and takes longer; `said`: one line says when it is
    finished, and how many designs there are.
    """

    def __init__(
        self, progress: Progress, *, said: bool, now: Callable[[], float] = monotonic
    ) -> None:
        self._progress, self._said, self._now = progress, said, now
        self._began, self._solved, self._stored = 0.0, 0, 0

    def tell(self, stage: str, done: int, total: int) -> None:
        """Count a design; those of the store do not change the rate."""
        self._stored += stage == "store"
        self._solved += stage != "store"
        words, left = f"{done} of {total} designs", None
        if self._stored:
            words += f" ({self._stored} from the store)"
        if self._solved == 1 and stage != "store":
            self._began = self._now()
            if self._said and done < total:
                self._progress.say(f"flankload: {words} finished")
        if self._solved > 1 and (spent := self._now() - self._began) > 0.0:
            seconds = spent / (self._solved - 1)
            words += f", {1 / seconds:.1f}/s" if seconds < 1 else f", {60 / seconds:.1f}/min"
            left = seconds * (total - done)
        self._progress.tell(words, done, total, left)


def _check_suffixes(paths: list[str]) -> None:
    """Refuse output files of a kind that is not written."""
    for path in paths:
        suffix = Path(path).suffix.lower()
        if path != STDOUT and suffix not in (".csv", ".parquet"):
            refuse("-o", "a file ending in .csv or .parquet", path)
        if suffix == ".parquet" and find_spec("pyarrow") is None:
            expected = "a CSV file, since Parquet needs pyarrow: pip install 'flankload[parquet]'"
            refuse("-o", expected, path)


def _pictures(found: DesignStudy, folder: Path | None) -> list[str]:
    """Write the pictures that suit the study, if a folder is given; say where they are."""
    if folder is None or len(found.failed) == len(found.rows):
        return []
    from flankload.plot import write_study

    paths = write_study(found, folder)
    names = ", ".join(path.name for path in paths) or "none suits this study"
    return [f"plots in {folder}: {names}"]


def _executor(arguments: Namespace) -> AbstractContextManager[Executor | None]:
    """Workers: threads, processes, or those of a dask scheduler."""
    if arguments.scheduler is not None:
        return _dask(arguments.scheduler)
    from flankload.studies.design.run_designs import processors

    workers = arguments.workers or processors()
    if arguments.processes:
        import multiprocessing
        from concurrent.futures import ProcessPoolExecutor

        # processes that are forked from one with threads of OpenMP hang in their first sweep
        context = multiprocessing.get_context("spawn")
        return ProcessPoolExecutor(workers, context, initializer=_begin_worker)
    if arguments.workers is None:
        return nullcontext()
    from concurrent.futures import ThreadPoolExecutor

    return ThreadPoolExecutor(workers)


def _begin_worker() -> None:
    """Leave Ctrl-C to the process that has the store, and end with it, also if it is killed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    """Wait for the end of a pipe that the parent holds open, then end this process at once."""
    from multiprocessing import parent_process

    parent = parent_process()
    assert parent is not None
    parent.join()
    os._exit(1)


@contextmanager
def _dask(address: str) -> Iterator[Executor]:
    """Workers of a dask scheduler."""
    if find_spec("distributed") is None:
        expected = "the package distributed: pip install 'flankload[dask]'"
        refuse("--scheduler", expected, "no such package")
    from distributed import Client

    try:
        client = Client(address, timeout=PATIENCE_S)
    except (OSError, ValueError) as error:
        raise FlankloadError(f"--scheduler {address}: no connection: {error}") from None
    with client, client.get_executor() as executor:
        yield executor


def optimise(arguments: Namespace) -> None:
    """Read the file and its scene, search, write and print."""
    from flankload.base.files import path_of
    from flankload.scene import read_scene
    from flankload.scene.form import read_table
    from flankload.scene.reader import read_tables
    from flankload.scene.refusal import in_file
    from flankload.studies.optimisation import OptimisationFile
    from flankload.studies.optimisation import optimise as optimum_of

    file: Path = arguments.file
    tree = read_tables(file, "a file of an optimisation")
    options = {key: value for key, value in tree.items() if key not in TABLES}
    with in_file(file):
        scene_path = file.parent / path_of(read_table(OptimisationFile, options, "").scene)
    scene = read_scene(scene_path)
    if arguments.output is not None:
        _check_output(arguments.output, scene, file)
    del options["scene"]
    tables: dict[str, Any] = {"variables": (), "objective": {}, "constraints": ()}
    tables |= {key: tree[key] for key in TABLES if key in tree}
    with in_file(file), Progress(wanted=True) as progress:
        optimum = optimum_of(scene, **tables, progress=progress.tell, **options)
    if arguments.output is not None:
        from flankload.base.files import write_atomically

        write_atomically(arguments.output, optimum.scene.to_toml())
    print(optimum)


def _check_output(path: Path, scene: Scene, file: Path) -> None:
    """Refuse an output that could not be written, or where the files of the scene are not found."""
    check_file("-o", path)
    check_apart([Output("-o", path)], scene, {"the optimisation": file})
    if scene.files and path.resolve().parent != scene.folder.resolve():
        expected = f"a file in the folder {scene.folder} of the scene, which names other files"
        refuse("-o", expected, path)
