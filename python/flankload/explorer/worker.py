"""The runs of an explorer: one thread, in which the newest request ends the runs of older ones.

A request is solved coarsely at once, as its scene is when no other one follows, then with the
derivatives of its result.
"""

from __future__ import annotations

import time
from concurrent.futures import CancelledError, ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import cached_property
from threading import Condition
from typing import TYPE_CHECKING, Any

from msgspec import structs

from flankload.errors import FlankloadError
from flankload.explorer.keys import Key, changes_of
from flankload.mechanisms import Earlier, Parts, run_once
from flankload.mechanisms.registry import mechanism_of
from flankload.mechanisms.stage_clock import ELEMENTS, FIXED_STEPS
from flankload.studies.coarse import few_positions
from flankload.studies.prepared import scene_of_one_run, solve_scene
from flankload.studies.sensitivity import Sensitivity, sensitivity

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping
    from concurrent.futures import Future

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
#: Line of requests after the end.
CLOSED = "the explorer is closed"


class _EndedError(CancelledError):
    """A run is not needed any more."""


class _ElementsError(Exception):
    """A run would solve elements while a slider moves."""


class _ReadyError(Exception):
    """The compliances of a run are known."""


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
    """Outcome of a run of so many seconds: a result, or the `error` why there is none.

    Neither: the keys that reach the elements are known, or the derivatives, which arrive last.
    """

    request: Request
    result: Result | None
    seconds: float = 0.0
    error: str = ""
    sensitivity: Sensitivity | None = None

    @property
    def at_rest(self) -> bool:
        """Whether the scene was solved as it is, otherwise coarsely."""
        return not self.request.moves


class Worker:
    """A thread that solves the newest request for the keys with sliders, `shown`.

    It calls `tell` with each answer and `progress(stage, done, total)`. `reaching` has the paths of
    the keys with sliders that change the elements, so that they are solved on release, and
    `has_elements` is set if the drive has elements and derivatives.
    """

    def __init__(
        self,
        scene: Scene,
        keys: Mapping[str, Key],
        shown: tuple[Key, ...],
        tell: Callable[[Answer], None],
        progress: Progress,
    ) -> None:
        self.parts = Parts(estimate=scene.accuracy.estimate)
        self.reaching: frozenset[str] = frozenset()
        self._scene, self._keys, self._shown = scene, keys, shown
        self._tell, self._progress = tell, progress
        self._newest: Request | None = None
        self._changed, self._closing = Condition(), False
        self.has_elements = mechanism_of(scene).no_flanks_reason is None
        self._thread = ThreadPoolExecutor(1, "flankload explorer")

    def ask(self, request: Request | None) -> None:
        """Solve a request; the run of an older one ends. None: do nothing more."""
        self._replace(request)
        if request is not None:
            self.do(self._follow, request)

    def change(self, request: Request) -> Future[Any]:
        """Solve the scene of a request as it is, which no other one ends; older ones are dropped.

        The result of the future is that of `flankload.solve`, as are its errors.
        """
        self._replace(request)
        future = self.do(self._solve, request, self.watched())
        self.do(self._derive, request)
        return future

    def do(self, job: Callable[..., Any], *arguments: Any) -> Future[Any]:
        """Call a function in the thread; no request ends it, but `close` does.

        Raises FlankloadError after `close`.
        """
        try:
            return self._thread.submit(job, *arguments)
        except RuntimeError:
            raise FlankloadError(CLOSED) from None

    def close(self) -> None:
        """End the run and the thread."""
        self._closing = True
        self._replace(None)
        self._thread.shutdown(cancel_futures=True)

    def watched(self, request: Request | None = None, *, moves: bool = False) -> Progress:
        """Progress that ends the run of a request when it is old; of a job when all ends.

        While a slider moves, some patience is left, but no elements are solved.
        """
        until = time.monotonic() + PATIENCE_S * moves

        def progress(stage: str, done: int, total: int) -> None:
            old = request is not None and self._newest is not request
            if self._closing or (old and time.monotonic() > until):
                raise _EndedError
            if moves and self.has_elements and stage.startswith(ELEMENTS):
                raise _ElementsError
            self._progress(stage, done, total)

        return progress

    def _replace(self, request: Request | None) -> None:
        with self._changed:
            self._newest = request
            self._changed.notify()

    # --- in the thread ----------------------------------------------------------------------------
    def _follow(self, request: Request) -> None:
        """Solve a request, unless a newer one follows."""
        if self._newest is not request:
            return
        with suppress(CancelledError, FlankloadError):
            if request.moves:
                with suppress(_ElementsError, FlankloadError):
                    self._solve(request, self.watched(request, moves=True))
                with self._changed:
                    left_s = request.asked_s + REST_S - time.monotonic()
                    self._changed.wait_for(lambda: self._newest is not request, left_s)
            self._solve(replace(request, moves=False), self.watched(request))
            self._derive(request)

    def _solve(self, request: Request, progress: Progress) -> Result:
        """Solve the scene of a request, coarsely if it moves, and give the answer."""
        begin, rests = time.perf_counter(), not request.moves
        try:
            scene = request.scene if rests else self._coarse(request.values)
            result = solve_scene(scene, progress, self.parts, unloaded=rests)
        except (CancelledError, _ElementsError):
            raise
        except Exception as error:
            line = str(error) if isinstance(error, FlankloadError) else repr(error)
            self._tell(Answer(request, None, time.perf_counter() - begin, line))
            raise
        self._tell(Answer(request, result, time.perf_counter() - begin))
        return result

    def _derive(self, request: Request) -> None:
        """Find the keys that reach the elements, and derivatives, as far as the drive has them."""
        if not self.has_elements or self._newest is not request:
            return
        progress = self.watched(request)
        reaching = frozenset(self._reaching(request.values, progress))
        if reaching != self.reaching:
            self.reaching = reaching
            self._tell(Answer(request, None))
        scene = self._coarse({key.path: key.value for key in self._shown} | dict(request.values))
        paths = [key.path for key in self._shown if not key.whole]
        found = sensitivity(scene, paths, self.parts, first_order=True, progress=progress)
        self._tell(Answer(request, None, sensitivity=found))

    def _reaching(self, values: Mapping[str, float], watched: Progress) -> Iterator[str]:
        """Keys with sliders of which another value needs other elements."""
        for key in self._shown:
            # without a modification the elements are others, but the same for all its values
            present = {key.path: key.at(TRIED[0])} if key.absent else {}
            with suppress(FlankloadError):
                self._has_compliances({**values, **present}, watched, solves=True)
                tried = {**values, key.path: key.at(TRIED[1])}
                if not self._has_compliances(tried, watched, solves=False):
                    yield key.path

    def _has_compliances(
        self, values: Mapping[str, float], watched: Progress, *, solves: bool
    ) -> bool:
        """Whether the compliances of a design are known; true after they are solved."""

        def progress(stage: str, done: int, total: int) -> None:
            watched(stage, done, total)
            if stage.startswith(ELEMENTS) and not solves:
                raise _ElementsError
            if done >= FIXED_STEPS and not stage.startswith(ELEMENTS):
                raise _ReadyError

        try:
            run_once(self._coarse(values), progress=progress, earlier=Earlier(parts=self.parts))
        except _ElementsError:
            return False
        except _ReadyError:
            pass
        return True

    def _coarse(self, values: Mapping[str, float]) -> Scene:
        """The scene with other values, at few positions, without estimate and tangents."""
        scene = self._plain.replace(changes_of(self._keys, values))
        accuracy = structs.replace(scene.accuracy, estimate=False, tangents=False)
        positions = few_positions(scene.positions, MOVING_POSITIONS)
        return replace(scene, accuracy=accuracy, positions=positions)

    @cached_property
    def _plain(self) -> Scene:
        """The scene without tolerance and choice of effects."""
        return scene_of_one_run(self._scene)
