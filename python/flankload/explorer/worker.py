"""The runs of an explorer: one thread, in which the newest request cancels the older ones.

A request is solved coarsely at once, as its scene is when no other one follows, then with the
derivatives of its result.
"""

from __future__ import annotations

import time
from concurrent.futures import CancelledError, Future
from contextlib import suppress
from dataclasses import dataclass, field, replace
from threading import Condition, Thread
from typing import TYPE_CHECKING, Any

from msgspec import structs

from flankload.errors import FlankloadError
from flankload.explorer.elements import NeedsElementsError, elements_of_run, without_elements
from flankload.explorer.keys import Key, changes_of
from flankload.mechanisms import Parts
from flankload.mechanisms.registry import mechanism_of
from flankload.studies.coarse import few_positions
from flankload.studies.plan.choice import choose_effects
from flankload.studies.prepared import solve_scene
from flankload.studies.sensitivity import Sensitivity, sensitivity
from flankload.studies.tolerance import first_scene

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from flankload.mechanisms.stage_clock import Progress
    from flankload.result import Result
    from flankload.scene import Scene

#: Seconds without a request after which its scene is solved as it is.
REST_S = 0.15
#: Seconds that a run while a slider moves may take beside a newer request: the curves follow a hand
#: that does not pause.
PATIENCE_S = 0.25
#: Most positions while a slider moves, per tooth pitch.
MOVING_POSITIONS = 16


class SupersededError(Exception):
    """A newer request, or the end of the explorer, ends a run."""


@dataclass(frozen=True, eq=False)
class Request:
    """A design that is asked for.

    `values` are those of keys by path, `moves` is set while a slider moves, `source` asks and
    already shows the values; `asked_s` is on the clock `time.monotonic`.
    """

    number: int
    values: Mapping[str, float]
    scene: Scene
    moves: bool = False
    source: object = None
    asked_s: float = 0.0


@dataclass(frozen=True, eq=False)
class Answer:
    """Outcome of a run.

    Attributes
    ----------
    request : Request
    result : Result or None
        None if the scene has no solution, for the reason `error`, and with a sensitivity.
    at_rest : bool
        Whether the scene was solved as it is, otherwise coarsely.
    seconds : float
        Time of the run.
    sensitivity : Sensitivity or None
        Derivatives with respect to the keys with sliders, which arrive last.
    """

    request: Request
    result: Result | None
    at_rest: bool
    seconds: float
    error: str = ""
    sensitivity: Sensitivity | None = None


@dataclass
class _State:
    """The newest request and the last numbers of each kind of run; `jobs` come first."""

    newest: Request | None = None
    moved: int = 0
    rested: int = 0
    derived: int = 0
    closing: bool = False
    jobs: list[tuple[Callable[[Progress], Any], Future[Any]]] = field(default_factory=list)


class Worker:
    """A thread that solves the newest request.

    Parameters
    ----------
    scene : Scene
        The scene at the beginning.
    keys : mapping of str to Key
        All keys of the scene.
    tell : callable
        Called in the thread with each answer.
    progress : callable
        Called in the thread as progress(stage, done, total).
    """

    def __init__(
        self,
        scene: Scene,
        keys: Mapping[str, Key],
        tell: Callable[[Answer], None],
        progress: Progress,
    ) -> None:
        self.parts = Parts(estimate=scene.accuracy.estimate)
        #: Keys whose derivatives are solved at rest.
        self.derived_keys: tuple[Key, ...] = ()
        self._scene, self._keys, self._tell, self._progress = scene, keys, tell, progress
        self._state, self._changed = _State(), Condition()
        self._chosen: dict[str, Any] | None = None
        self._reuses_elements = mechanism_of(scene).no_flanks_reason is None
        self._thread = Thread(target=self._run, name="flankload explorer", daemon=True)

    def start(self) -> None:
        """Start the thread."""
        self._thread.start()

    def ask(self, request: Request) -> None:
        """Solve a request; the run of an older one ends."""
        with self._changed:
            state = self._state
            state.newest = replace(request, asked_s=time.monotonic())
            if not request.moves:
                state.moved = request.number
            self._changed.notify()

    def forget(self) -> None:
        """End the run of the newest request."""
        with self._changed:
            self._state.newest = None

    def do(self, job: Callable[[Progress], Any]) -> Future[Any]:
        """Call a function of the progress in the thread; no request ends it, but `close` does."""
        future: Future[Any] = Future()
        with self._changed:
            if self._state.closing:
                future.cancel()
                return future
            self._state.jobs.append((job, future))
            self._changed.notify()
        return future

    def change(self, request: Request) -> Future[Any]:
        """Solve the scene of a request as it is, which no other one ends; older ones are dropped.

        The result of the future is that of `flankload.solve`, as are its errors.
        """
        with self._changed:
            self._state.newest = request
            self._state.moved = self._state.rested = request.number
        return self.do(lambda progress: self._solve(request, progress))

    def close(self) -> None:
        """End the run and the thread."""
        with self._changed:
            self._state.closing = True
            for _, future in self._state.jobs:
                future.cancel()
            self._changed.notify()
        if self._thread.is_alive():
            self._thread.join()

    # --- in the thread ----------------------------------------------------------------------------
    def reaching(self, progress: Progress) -> frozenset[str]:
        """Paths of the keys with sliders that change the elements, so that dragging is slow."""
        if not self._reuses_elements:
            return frozenset()
        lean, found = self._lean(self._scene), set()
        for key in self.derived_keys:
            progress("keys", 0, 1)
            values = (key.number(key.low + part * (key.high - key.low)) for part in (0.6, 0.9))
            calls = set()
            for value in values:
                with suppress(FlankloadError):
                    changed = lean.replace(changes_of(self._keys, {key.path: value}))
                    calls.add(elements_of_run(changed, self.parts))
            found |= {key.path} if len(calls) > 1 else set()
        return frozenset(found)

    def _run(self) -> None:
        while (work := self._next()) is not None:
            with suppress(SupersededError):
                work()

    def _next(self) -> Callable[[], None] | None:
        """The next run when it is time; None at the end."""
        with self._changed:
            while not self._state.closing:
                state, wait = self._state, None
                if state.jobs:
                    job, future = state.jobs.pop(0)
                    return lambda: self._do(job, future)
                newest = state.newest
                if newest is not None and state.moved < newest.number:
                    state.moved = newest.number
                    return lambda: self._move(newest)
                if newest is not None and state.rested < newest.number:
                    wait = newest.asked_s + REST_S * newest.moves - time.monotonic()
                    if wait <= 0:
                        return lambda: self._rest(newest)
                elif newest is not None and state.derived < newest.number:
                    state.derived = newest.number
                    return lambda: self._derive(newest)
                self._changed.wait(wait)
        return None

    def _do(self, job: Callable[[Progress], Any], future: Future[Any]) -> None:
        """Do a job; its errors are those of the caller."""

        def progress(stage: str, done: int, total: int) -> None:
            if self._state.closing:
                raise SupersededError
            self._progress(stage, done, total)

        try:
            future.set_result(job(progress))
        except SupersededError:
            future.set_exception(CancelledError())
        except Exception as error:
            future.set_exception(error)

    def _solve(self, request: Request, progress: Progress) -> Result:
        """Solve the scene of a request as it is, and tell the answer."""
        begin = time.perf_counter()
        try:
            result = solve_scene(request.scene, progress, self.parts)
        except FlankloadError as error:
            self._tell(Answer(request, None, True, time.perf_counter() - begin, str(error)))
            raise
        self._tell(Answer(request, result, True, time.perf_counter() - begin))
        return result

    def _rest(self, request: Request) -> None:
        try:
            self._solve(request, self._unless_old(request))
        except FlankloadError:
            self._state.derived = request.number
        self._state.rested = request.number

    def _move(self, request: Request) -> None:
        """Solve coarsely, unless that takes elements, which are solved at rest."""
        begin = time.perf_counter()
        progress = self._unless_old(request, PATIENCE_S)
        if self._reuses_elements:
            progress = without_elements(progress)
        try:
            result = solve_scene(self._lean(request.scene), progress, self.parts)
        except NeedsElementsError:
            return
        except FlankloadError as error:
            self._tell(Answer(request, None, False, time.perf_counter() - begin, str(error)))
            return
        self._tell(Answer(request, result, False, time.perf_counter() - begin))

    def _derive(self, request: Request) -> None:
        """Derivatives of the coarse scene, as far as the drive has them."""
        begin = time.perf_counter()
        values = {key.path: key.value for key in self.derived_keys} | dict(request.values)
        paths = [key.path for key in self.derived_keys if not key.whole]
        try:
            scene = self._lean(request.scene.replace(changes_of(self._keys, values)))
            progress = self._unless_old(request)
            found = sensitivity(scene, paths, self.parts, first_order=True, progress=progress)
        except FlankloadError:  # drives without flanks have none
            return
        seconds = time.perf_counter() - begin
        self._tell(Answer(request, None, True, seconds, sensitivity=found))

    def _lean(self, scene: Scene) -> Scene:
        """The scene at few positions, without estimate, tangents, tolerance and choice."""
        if scene.effects.choose is not None:
            if self._chosen is None:
                chosen = {one.key: one.value for one in choose_effects(self._scene)[1]}
                self._chosen = chosen | {"effects.choose": None}
            scene = scene.replace(self._chosen)
        if scene.names_tolerance:
            scene = first_scene(scene)
        return replace(
            scene,
            accuracy=structs.replace(scene.accuracy, estimate=False, tangents=False),
            positions=few_positions(scene.positions, MOVING_POSITIONS),
        )

    def _unless_old(self, request: Request, patience_s: float = 0.0) -> Progress:
        """Progress that ends the run of a request when a newer one waits, after some time."""
        until = time.monotonic() + patience_s

        def progress(stage: str, done: int, total: int) -> None:
            state = self._state
            old = state.newest is None or state.newest.number != request.number
            if state.closing or ((old or state.jobs) and time.monotonic() > until):
                raise SupersededError
            self._progress(stage, done, total)

        return progress
