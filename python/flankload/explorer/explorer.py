"""An explorer: a scene, its sliders, the thread that solves it and the server of its page."""

from __future__ import annotations

from collections.abc import Mapping
from concurrent.futures import CancelledError
from html import escape
from itertools import count
from threading import Event, Lock, Thread
from typing import TYPE_CHECKING, Any, Self

from flankload.base.arguments import require
from flankload.errors import FlankloadError, SceneError
from flankload.explorer.keys import changes_of, keys_of, shown_keys
from flankload.explorer.page import Page
from flankload.explorer.server import Server
from flankload.explorer.worker import CLOSED, Answer, Request, Worker
from flankload.mechanisms.registry import mechanism_of

if TYPE_CHECKING:
    from collections.abc import Sequence
    from concurrent.futures import Future

    from bokeh.document import Document

    from flankload.result import Result
    from flankload.scene import Scene

#: Height of the page in a notebook, pixels.
INLINE_HEIGHT = 900
#: Starts of an optimisation, the design that is shown among them: figures have several minima.
STARTS = 4


class Explorer:
    """A page on which sliders change a scene while its results follow; from `flankload.explore`.

    Attributes
    ----------
    url : str
        Address of the page on this machine, with its token.
    """

    def __init__(self, scene: Scene, vary: Sequence[str], port: int) -> None:
        self.url = ""
        self.keys = keys_of(scene)
        self.shown = shown_keys(scene, self.keys, vary)
        #: Designs at rest in their order, those with a result.
        self.trail: list[Answer] = []
        self._given, self._scene, self._values = scene, scene, dict[str, float]()
        self._numbers, self._lock, self._closed = count(1), Lock(), Event()
        self._pages: set[Page] = set()
        self._rested: Answer | None = None
        self._shown = 0
        self.worker = Worker(scene, self.keys, self.shown, self._tell, self._progress)
        mechanism_of(scene).build(scene, None, self.worker.parts)  # refuses impossible bodies
        self._server = Server(self._fill, {"report": self._report, "scene.toml": self._toml}, port)
        self.url = self._server.url
        self.ask({})

    # --- for Python -------------------------------------------------------------------------------
    @property
    def scene(self) -> Scene:
        """The scene as the sliders have it."""
        return self._scene

    @property
    def result(self) -> Result:
        """Result of `scene`; waits until it is solved. Errors are those of `change`."""
        rested = self._rested
        if rested is not None and rested.request.scene is self._scene and rested.result:
            return rested.result
        return self.change({})

    def change(self, values: Mapping[str, float]) -> Result:
        """Set numeric keys, as their sliders do, and solve the scene as it is.

        Parameters
        ----------
        values : mapping of str to float
            By path, as "body_1.tip_relief_um". A relief that the scene does not have begins at the
            end of single contact (`tip_relief_length = "long"`) and is parabolic.

        Returns
        -------
        Result
            With the bits of `prepare(scene).solve(values)`.

        Raises
        ------
        SceneError
            If a path is not a numeric key of the scene, a value is not a number or out of range,
            or the scene is impossible: the page keeps its values.
        FlankloadError
            If a position has no solution, or the explorer is closed.
        """
        require("values", values, "a mapping of paths to numbers", fits=isinstance(values, Mapping))
        request = self._request({**self._values, **values}, None, moves=False)
        try:
            return self.worker.change(request).result()
        except CancelledError:
            raise FlankloadError(CLOSED) from None

    def close(self) -> None:
        """End the page, the run and the server; nothing is left."""
        with self._lock:
            if self._closed.is_set():
                return
            self._closed.set()
        self.worker.close()
        self._server.close()

    def wait(self) -> None:
        """Wait until the explorer is closed, on its page or by `close`."""
        while not self._closed.wait(0.5):  # a limit lets Ctrl-C through on every system
            pass

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __repr__(self) -> str:
        return f"Explorer({self.url!r})"

    def _repr_html_(self) -> str:
        """The page inside a notebook."""
        url = escape(self.url, quote=True)
        return f'<iframe src="{url}" width="100%" height="{INLINE_HEIGHT}" title="{url}"></iframe>'

    # --- for the page -----------------------------------------------------------------------------
    def ask(
        self, values: Mapping[str, float], *, moves: bool = False, source: object = None
    ) -> None:
        """Solve other values of keys; pages show the result, or why there is none."""
        try:
            request = self._request(values, source, moves=moves)
        except SceneError as error:
            with self._lock:
                self._values = dict(values)
                request = Request(next(self._numbers), dict(values), self._scene, moves, source)
            self.worker.ask(None)
            self._tell(Answer(request, None, error=str(error)))
        else:
            self.worker.ask(request)

    def undo(self) -> None:
        """Return to the design before; to the last one with a result if this one has none."""
        if len(self.trail) > 1 and self.trail[-1].request.values == self._values:
            self.trail.pop()
        if self.trail:
            self.ask(self.trail[-1].request.values)

    def optimise(self, figure: str) -> Future[Any]:
        """Minimise a figure over the keys with sliders, from here; the page goes to the optimum."""
        from flankload.studies.optimisation import optimise

        scene, values = self._scene, dict(self._values)
        start = {key: values.get(key.path, key.value) for key in self.shown}
        variables = [
            {"paths": key.path, "start": value, "step": key.step,
             "lower": min(key.low, value), "upper": max(key.high, value)}
            for key, value in start.items()
            if not key.whole and not key.path.startswith("load.")
        ]  # fmt: skip

        def run() -> None:
            best: dict[str, float] = {}
            try:
                named = scene.replace(changes_of(self.keys, {k.path: x for k, x in start.items()}))
                progress = self.worker.watched()
                found = optimise(named, variables, figure, progress=progress, starts=STARTS)
                best = {path: self.keys[path].number(x) for path, x in found.values.items()}
            finally:
                self.ask({**values, **best})

        self.worker.ask(None)
        return self.worker.do(run)

    def close_soon(self) -> None:
        """Close from the thread of the server, which cannot wait for itself."""
        Thread(target=self.close, name="flankload explorer end", daemon=True).start()

    def leave(self, page: Page) -> None:
        """Forget a page that is closed."""
        self._pages.discard(page)

    # --- inside -----------------------------------------------------------------------------------
    def _request(self, values: Mapping[str, float], source: object, *, moves: bool) -> Request:
        scene = self._given.replace(changes_of(self.keys, values))
        with self._lock:
            self._scene, self._values = scene, dict(values)
            return Request(next(self._numbers), dict(values), scene, moves, source)

    def _fill(self, document: Document) -> None:
        page = Page(self, document)
        self._pages.add(page)
        if self._rested is not None:
            page.take(self._rested)

    def _tell(self, answer: Answer) -> None:
        with self._lock:
            if answer.request.number < self._shown:
                return
            self._shown = answer.request.number
        if answer.at_rest and answer.result is not None:
            self._rested = answer
            if not self.trail or self.trail[-1].request.values != answer.request.values:
                self.trail.append(answer)
        for page in tuple(self._pages):
            page.take_soon(answer)

    def _progress(self, stage: str, done: int, total: int) -> None:
        for page in tuple(self._pages):
            page.progress(stage, done, total)

    def _report(self) -> tuple[str, str]:
        from flankload.report import report_html

        return "text/html", report_html(self.result, self.scene, line="flankload explore")

    def _toml(self) -> tuple[str, str]:
        return "text/plain", self.scene.to_toml()
