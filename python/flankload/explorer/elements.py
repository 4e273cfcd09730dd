"""Whether a run would solve elements, and which, without solving them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from flankload.mechanisms import Earlier, Parts, run_once
from flankload.mechanisms.stage_clock import BODY_STEPS, FIXED_STEPS

if TYPE_CHECKING:
    from functools import partial

    from flankload.mechanisms.stage_clock import Progress
    from flankload.scene import Scene


class NeedsElementsError(Exception):
    """A run that must be fast would solve elements."""


class _ReachedError(Exception):
    """The bodies are built; `elements` are those that would be solved next."""

    def __init__(self, elements: bytes | None) -> None:
        super().__init__()
        self.elements = elements


class _Watched(Parts):
    """Parts of earlier runs with the digest of the last call that was not among them."""

    def __init__(self, parts: Parts) -> None:
        super().__init__(estimate=parts.estimate, tangential=parts.tangential)
        self._parts, self.missing = parts, b""

    def find(self, call: partial[Any]) -> tuple[bytes, Any]:
        key, found = self._parts.find(call)
        if found is None:
            self.missing = key
        return key, found

    def add(self, key: bytes, part: object) -> None:
        self._parts.add(key, part)


def without_elements(progress: Progress) -> Progress:
    """Progress of a run that ends with NeedsElementsError before it solves elements."""

    def watched(stage: str, done: int, total: int) -> None:
        progress(stage, done, total)
        if BODY_STEPS <= done < FIXED_STEPS:
            raise NeedsElementsError

    return watched


def elements_of_run(scene: Scene, parts: Parts) -> bytes | None:
    """Digest of the elements that a run of a scene would solve first; None if it has all of them.

    Bodies are built and added to `parts`. Errors are those of `run_once`.
    """
    watched = _Watched(parts)

    def stop(stage: str, done: int, total: int) -> None:
        if done >= FIXED_STEPS:
            raise _ReachedError(None)
        if done >= BODY_STEPS:
            raise _ReachedError(watched.missing)

    try:
        run_once(scene, progress=stop, earlier=Earlier(parts=watched))
    except _ReachedError as reached:
        return reached.elements
    return None
