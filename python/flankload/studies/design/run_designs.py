"""All runs of a study: those that the store lacks are solved by an executor."""

from __future__ import annotations

import os
from concurrent.futures import BrokenExecutor, Executor, Future, ThreadPoolExecutor, wait
from contextlib import nullcontext
from dataclasses import dataclass, field, replace
from difflib import get_close_matches
from functools import partial
from queue import SimpleQueue
from threading import Event
from typing import TYPE_CHECKING, Any

from flankload.base.digest import digest_of
from flankload.errors import FlankloadError, SceneError
from flankload.mechanisms.displaced import are_displaced
from flankload.scene.refusal import refuse
from flankload.studies.design.run import FAILED, SOLVED, Outcome, Task, release, run_tasks
from flankload.studies.design.store import Store, key_of, key_of_refused, names_in

if TYPE_CHECKING:
    from collections.abc import Callable

    from flankload.scene import Scene
    from flankload.studies.design.designs import ChosenDesigns, Designs

    Progress = Callable[[str, int, int], None]

#: Runs in flight: they bound the memory, and a cluster of as many workers is busy.
MOST_IN_FLIGHT = 1000
#: Designs that differ by known displacements only are solved together, at most this many: some 10
#: MB of states.
MOST_TOGETHER = 100


@dataclass(frozen=True, eq=False)
class Row:
    """A design with its outcome, in which are the chosen quantities only.

    `number` counts from 0 in the order of the designs; `values` has the values by name of the
    variable, without those that keep the value of the scene.
    """

    number: int
    values: dict[str, Any]
    outcome: Outcome


def run_designs(
    scene: Scene,
    designs: Designs | ChosenDesigns,
    names: tuple[str, ...],
    store: Store,
    executor: Executor | None = None,
    progress: Progress | None = None,
) -> tuple[Row, ...]:
    """Solve all designs that the store lacks, by default with a thread for each processor.

    The first run is finished before others begin: it checks the names of the quantities, and
    threads find the parts that it has solved. `progress` is called as progress("designs", done,
    total), and as progress("store", done, total) for a run that is in the store.

    Raises SceneError if the first result does not have a quantity, FlankloadError if a worker is
    lost, and KeyboardInterrupt after an interrupt, with the number of finished designs as text:
    runs in flight are stopped (threads) or finished (processes), all that is finished is stored.
    """
    runs = _Runs(scene, designs, names, store, progress)
    with nullcontext(executor) if executor else ThreadPoolExecutor(processors()) as pool:
        most = MOST_IN_FLIGHT if executor else 2 * processors()
        try:
            for number, values in enumerate(designs):
                runs.begin(pool, number, values)
                while len(runs.pending) >= (most if runs.warm else 1):
                    runs.collect()
            runs.submit(pool)
            while runs.pending:
                runs.collect()
        except BaseException as error:
            runs.stop()
            if isinstance(error, KeyboardInterrupt):
                raise KeyboardInterrupt(f"interrupted: {runs.finished}") from None
            raise
        finally:
            release(runs.study)
    return tuple(runs.rows[number] for number in range(len(designs)))


def processors() -> int:
    """Return the number of processors that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


@dataclass(eq=False)
class _Runs:
    """State of a study: runs in flight and finished rows; `warm`: whether a run has ended."""

    scene: Scene
    designs: Designs | ChosenDesigns
    names: tuple[str, ...]
    store: Store
    progress: Progress | None
    rows: dict[int, Row] = field(default_factory=dict)
    pending: dict[Future[list[Outcome]], list[str]] = field(default_factory=dict)
    together: dict[str, Task] = field(default_factory=dict)
    waiting: dict[str, list[tuple[int, dict[str, Any]]]] = field(default_factory=dict)
    done: SimpleQueue[Future[list[Outcome]]] = field(default_factory=SimpleQueue)
    stopped: Event = field(default_factory=Event)
    checked: bool = False
    warm: bool = False

    def __post_init__(self) -> None:
        file = self.scene.file
        self.absolute = None if file is None else file.resolve()
        self.study = digest_of(key_of(self.scene))

    @property
    def finished(self) -> str:
        """Number of finished designs in words."""
        return f"{len(self.rows)} of {len(self.designs)} designs are finished"

    def begin(self, pool: Executor, number: int, values: dict[str, Any]) -> None:
        """Find a run in the store, or start it."""
        changes = self.designs.changes(values)
        refused = None
        try:
            scene = self.scene.replace(changes)
            key = key_of(scene)
        except SceneError as error:
            key, refused = key_of_refused(self.scene, changes), str(error)
        if key in self.waiting:
            self.waiting[key].append((number, values))
            return
        found = self.store.find(key)
        if found is not None and (found.status == FAILED or names_in(found) >= set(self.names)):
            self.checked |= found.status == SOLVED
            self._add(number, values, found, "store")
            return
        self.waiting[key] = [(number, values)]
        if refused is not None:
            self._keep(key, Outcome(FAILED, error=refused))
            return
        names = set(self.names) | (names_in(found) if found else set())
        absolute = replace(scene, file=self.absolute)
        task = Task(self.study, absolute, tuple(sorted(names)), whole=self.store.is_file)
        if self.together:
            last = next(reversed(self.together.values()))
            if last.names != task.names or not are_displaced(last.scene, absolute):
                self.submit(pool)
        self.together[key] = task
        most = MOST_TOGETHER if self.warm and are_displaced(absolute, absolute) else 1
        if len(self.together) >= most:
            self.submit(pool)

    def submit(self, pool: Executor) -> None:
        """Start the runs that are solved together."""
        if not self.together:
            return
        tasks = tuple(self.together.values())
        # only threads see the event
        threads = isinstance(pool, ThreadPoolExecutor)
        call = partial(run_tasks, tasks, self.stopped) if threads else partial(run_tasks, tasks)
        try:
            future = pool.submit(call)
        except Exception as error:  # a worker has died, or the caller shut the pool down
            raise self._lost(error) from error
        self.pending[future] = list(self.together)
        self.together = {}
        future.add_done_callback(self.done.put)

    def collect(self) -> None:
        """Wait for a run and store it."""
        future = self.done.get()
        keys = self.pending.pop(future)
        try:
            outcomes = future.result()
        except Exception as error:
            raise self._lost(error) from error
        self.warm = True
        for key, outcome in zip(keys, outcomes, strict=True):
            self._keep(key, outcome)

    def _lost(self, error: Exception) -> FlankloadError:
        """The error after a worker has ended, whichever call shows it."""
        if isinstance(error, BrokenExecutor):
            reason = "it was killed or had not enough memory; fewer workers need less"
        else:
            reason = f"{type(error).__name__}: {error}".removesuffix(": ")
        kept = "the store has them" if self.store.is_file else "a store keeps them"
        return FlankloadError(f"{self.finished} ({kept}), then a worker was lost: {reason}")

    def stop(self) -> None:
        """Stop the runs in flight and store those that have ended nevertheless."""
        self.stopped.set()
        wait([future for future in self.pending if not future.cancel()])
        for future, keys in self.pending.items():
            if not future.cancelled() and future.exception() is None:
                for key, outcome in zip(keys, future.result(), strict=True):
                    self._keep(key, outcome)

    def _keep(self, key: str, outcome: Outcome) -> None:
        """Store a run and add the rows of all its designs."""
        if outcome.status == SOLVED and not self.checked:
            refuse_unknown(outcome)
            self.checked = True
        designs = self.waiting.pop(key)
        self.store.add(key, designs[0][1], outcome)
        for number, values in designs:
            self._add(number, values, outcome, "designs")

    def _add(self, number: int, values: dict[str, Any], outcome: Outcome, stage: str) -> None:
        """Add a row with the chosen quantities, and the positions of curves."""
        results = []
        for row in outcome.results:
            found = row["quantities"]
            lists = {len(found[name]) for name in self.names if isinstance(found[name], list)}
            names = list(self.names)
            if len(found.get("position_rad") or ()) in lists:
                names = ["position_rad", *names]
            results.append(row | {"quantities": {name: found[name] for name in names}})
        self.rows[number] = Row(number, values, replace(outcome, results=tuple(results)))
        if self.progress is not None:
            self.progress(stage, len(self.rows), len(self.designs))


def refuse_unknown(outcome: Outcome) -> None:
    """Refuse quantities that a result does not have."""
    if outcome.unknown:
        name = outcome.unknown[0]
        known = sorted(names_in(outcome) - set(outcome.unknown))
        near = get_close_matches(name, known, n=1, cutoff=0.6)
        expected = f"did you mean {near[0]}?" if near else ", ".join(known)
        refuse("quantities", f"names in Result.summary or curves ({expected})", f"'{name}'")
