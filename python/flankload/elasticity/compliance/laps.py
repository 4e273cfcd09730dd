"""The stopwatch of a finite-element job."""

from __future__ import annotations

from time import perf_counter, process_time


class Laps:
    """CPU seconds of the steps of a job."""

    def __init__(self) -> None:
        self._seconds: dict[str, float] = {}
        self._wall, self._clock = perf_counter(), process_time()

    def __call__(self, step: str) -> None:
        """A step ends."""
        now = process_time()
        self._seconds[step] = self._seconds.get(step, 0.0) + now - self._clock
        self._clock = now

    def whole(self) -> dict[str, float]:
        """All steps, and the time on the wall."""
        return {**self._seconds, "wall": perf_counter() - self._wall}
