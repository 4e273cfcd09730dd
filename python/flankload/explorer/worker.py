"""The runs of an explorer: one thread, in which the newest request ends the runs of older ones.

A request is solved coarsely at once, as its scene is when no other one follows, then with the
derivatives of its result.
"""

from __future__ import annotations

import time
from concurrent.futures import CancelledError, Future
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import partial
from threading import Condition, Thread
from typing import TYPE_CHECKING, Any

from msgspec import structs

from flankload.errors import FlankloadError
from flankload.explorer.keys import Key, changes_of
from flankload.mechanisms import Earlier, Parts, run_once
from flankload.mechanisms.registry import mechanism_of
from flankload.mechanisms.stage_clock import BODY_STEPS, FIXED_STEPS
from flankload.studies.coarse import few_positions
from flankload.studies.plan.choice import choose_effects
from flankload.studies.prepared import solve_scene
from flankload.studies.sensitivity import Sensitivity, sensitivity
from flankload.studies.tolerance import first_scene

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

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
#: Places in the range of a slider whose elements are compared.
TRIED = (0.6, 0.9)


class _EndedError(Exception):
    """A run is not needed any more, or would solve elements while a slider moves."""


class _ReadyError(Exception):
    """The bodies of a run are built."""


class _NotingParts(Parts):
    """Parts with the digest of the last call that was not among them."""

    missing = b""

    def find(self, call: partial[Any]) -> tuple[bytes, Any]:
        key, found = super().find(call)
        if found is None:
            self.missing = key
        return key, found


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
    asked_s: float = field(default_factory=time.monotonic)


@dataclass(frozen=True, eq=False)
class Answer:
    """Outcome of a run.

    Attributes
    ----------
    request : Request
    result : Result or None
        None if the scene has no solution, for the reason `error`, and beside derivatives.
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
    seconds: float = 0.0
    error: str = ""
    sensitivity: Sensitivity | None = None


class Worker:
    """A thread that solves the newest request.

    Parameters
    ----------
    scene : Scene
        The scene at the beginning.
    keys : mapping of str to Key
        All keys of the scene.
    shown : tuple of Key
        Those with sliders.
    tell : callable
        Called in the thread with each answer.
    progress : callable
        Called in the thread as progress(stage, done, total).

    Attributes
    ----------
    reaching : frozenset of str
        Paths of the keys with sliders that change the elements, so that they are solved on release.
    """

    def __init__(
        self,
        scene: Scene,
        keys: Mapping[str, Key],
        shown: tuple[Key, ...],
        tell: Callable[[Answer], None],
        progress: Progress,
    ) -> None:
        self.parts = _NotingParts(estimate=scene.accuracy.estimate)
        self.reaching: frozenset[str] = frozenset()
        self._scene, self._keys, self._shown = scene, keys, shown
        self._tell, self._progress = tell, progress
        #: The newest request, the steps of it that are not done, and jobs, which come first.
        self._newest: Request | None = None
        self._steps: Sequence[Callable[[Request], None]] = ()
        self._jobs: list[tuple[Callable[[Progress], Any], Future[Any]]] = []
        self._changed, self._closing = Condition(), False
        self._chosen: dict[str, Any] | None = None
        self._reuses_elements = mechanism_of(scene).no_flanks_reason is None
        self._first = [self._mark] * self._reuses_elements
        self._thread = Thread(target=self._run, name="flankload explorer", daemon=True)

    def start(self) -> None:
        """Start the thread."""
        self._thread.start()

    def ask(self, request: Request) -> None:
        """Solve a request; the run of an older one ends."""
        steps = [*[self._move] * request.moves, self._rest, *self._first, self._derive]
        with self._changed:
            self._newest, self._steps = request, steps
            self._changed.notify()

    def forget(self) -> None:
        """End the run of the newest request."""
        with self._changed:
            self._newest, self._steps = None, ()

    def do(self, job: Callable[[Progress], Any]) -> Future[Any]:
        """Call a function of the progress in the thread; no request ends it, but `close` does."""
        future: Future[Any] = Future()
        with self._changed:
            if self._closing:
                future.cancel()
                return future
            self._jobs.append((job, future))
            self._changed.notify()
        return future

    def change(self, request: Request) -> Future[Any]:
        """Solve the scene of a request as it is, which no other one ends; older ones are dropped.

        The result of the future is that of `flankload.solve`, as are its errors.
        """
        with self._changed:
            self._newest, self._steps = request, [*self._first, self._derive]
        return self.do(partial(self._solve, request))

    def close(self) -> None:
        """End the run and the thread."""
        with self._changed:
            self._closing = True
            for _, future in self._jobs:
                future.cancel()
            self._changed.notify()
        if self._thread.is_alive():
            self._thread.join()

    # --- in the thread ----------------------------------------------------------------------------
    def _run(self) -> None:
        while (work := self._next()) is not None:
            work()

    def _next(self) -> Callable[[], None] | None:
        """The next run when it is time; None at the end."""
        with self._changed:
            while not self._closing:
                if self._jobs:
                    return partial(self._do, *self._jobs.pop(0))
                wait = None
                if self._newest is not None and self._steps:
                    step, wait = self._steps[0], 0.0
                    if step == self._rest and self._newest.moves:
                        wait = self._newest.asked_s + REST_S - time.monotonic()
                    if wait <= 0:
                        return partial(self._step, step, self._newest)
                self._changed.wait(wait)
        return None

    def _do(self, job: Callable[[Progress], Any], future: Future[Any]) -> None:
        """Do a job; its errors are those of the caller."""
        try:
            future.set_result(job(self._watched(None)))
        except _EndedError:
            future.set_exception(CancelledError())
        except Exception as error:
            future.set_exception(error)

    def _step(self, step: Callable[[Request], None], request: Request) -> None:
        """Do a step of a request; a job may have ended it, after which it is done again."""
        done = 1
        try:
            step(request)
        except _EndedError:
            pass
        except FlankloadError:  # a design without solution has no derivatives
            done = len(self._steps)
        with self._changed:
            if self._newest is request and not self._jobs:
                self._steps = self._steps[done:]

    def _watched(self, request: Request | None, *, moves: bool = False) -> Progress:
        """Progress that ends the run of a request when it is old; of a job when all ends.

        While a slider moves, some patience is left, but no elements are solved.
        """
        until = time.monotonic() + PATIENCE_S * moves

        def progress(stage: str, done: int, total: int) -> None:
            old = request is not None and (self._newest is not request or self._jobs)
            slow = moves and self._reuses_elements and BODY_STEPS <= done < FIXED_STEPS
            if self._closing or slow or (old and time.monotonic() > until):
                raise _EndedError
            self._progress(stage, done, total)

        return progress

    def _solve(self, request: Request, progress: Progress, *, moves: bool = False) -> Result:
        """Solve the scene of a request, coarsely if it moves, and give the answer."""
        begin = time.perf_counter()
        scene = self._lean(request.scene) if moves else request.scene
        try:
            result = solve_scene(scene, progress, self.parts, unloaded=not moves)
        except FlankloadError as error:
            seconds = time.perf_counter() - begin
            self._tell(Answer(request, None, not moves, seconds, str(error)))
            raise
        self._tell(Answer(request, result, not moves, time.perf_counter() - begin))
        return result

    def _move(self, request: Request) -> None:
        """Solve coarsely, unless that takes elements, which are solved at rest."""
        with suppress(FlankloadError):
            self._solve(request, self._watched(request, moves=True), moves=True)

    def _rest(self, request: Request) -> None:
        """Solve the scene as it is."""
        self._solve(request, self._watched(request))

    def _mark(self, request: Request) -> None:
        """Find the keys with sliders that change the elements."""
        watched, found, lean = self._watched(request), set(), self._lean(request.scene)
        solved = set[bytes]()

        def progress(stage: str, done: int, total: int) -> None:
            watched("keys", 0, 1)
            if done >= BODY_STEPS:
                solved.add(self.parts.missing if done < FIXED_STEPS else b"")
                raise _ReadyError

        for key in self._shown:
            solved.clear()
            for part in TRIED:
                value = key.number(key.low + part * (key.high - key.low))
                with suppress(FlankloadError, _ReadyError):
                    changed = lean.replace(changes_of(self._keys, {key.path: value}))
                    run_once(changed, progress=progress, earlier=Earlier(parts=self.parts))
            found |= {key.path} if len(solved) > 1 else set()
        self.reaching, self._first = frozenset(found), []
        self._tell(Answer(request, None, True))

    def _derive(self, request: Request) -> None:
        """Derivatives of the coarse scene, as far as the drive has them."""
        values = {key.path: key.value for key in self._shown} | dict(request.values)
        paths = [key.path for key in self._shown if not key.whole]
        with suppress(FlankloadError):  # drives without flanks have none
            scene = self._lean(request.scene.replace(changes_of(self._keys, values)))
            progress = self._watched(request)
            found = sensitivity(scene, paths, self.parts, first_order=True, progress=progress)
            self._tell(Answer(request, None, True, sensitivity=found))

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
