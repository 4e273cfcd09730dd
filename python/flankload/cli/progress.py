"""Progress on stderr: a bar with the time left, and a line if a computation takes long."""

from __future__ import annotations

import sys
from collections import deque
from threading import Event, Thread, Timer
from time import monotonic
from typing import TYPE_CHECKING, Any, Self

from flankload.cli.outputs import say

if TYPE_CHECKING:
    from collections.abc import Callable

#: Seconds after which a computation first shows its bar.
PATIENCE_S = 1.0
#: A computation that takes longer, s, is announced once.
LONG_S = 10.0
#: Seconds between two lines where a bar cannot be shown.
LINE_S = 60.0
#: Least time, s, from which the rest is extrapolated: shorter ones are mostly those of first calls.
LEAST_S = 0.3
#: Number of the last steps whose median time is that of the steps to come.
LAST_STEPS = 32


class TimeLeft:
    """Time left of a computation, from the time that its steps have taken so far.

    A step to come takes the median time of the last ones of its phase, so that one long step, such
    as a factorization before many loads, is not multiplied. Steps of a finished phase, such as
    finite elements before the states, do not count.

    Parameters
    ----------
    end_of : callable, optional
        Number of steps completed at the end of the phase of a stage; by default all steps are one
        phase.
    now : callable
        Seconds of a clock.
    """

    def __init__(
        self,
        end_of: Callable[[str, int], int] = lambda stage, total: total,
        now: Callable[[], float] = monotonic,
    ) -> None:
        self._end_of, self._now = end_of, now
        self._start_s = now()
        self._end = -1  # of the phase
        self._reached, self._began_s, self._last_s = 0, 0.0, 0.0
        self._step_s: deque[float] = deque(maxlen=LAST_STEPS)

    @property
    def spent_s(self) -> float:
        """Seconds since the beginning."""
        return self._now() - self._start_s

    def after(self, stage: str, done: int, total: int) -> float | None:
        """Least seconds left when steps are done: those of the phase; None if unknown."""
        end, now = self._end_of(stage, total), self._now()
        if end != self._end:
            self._end, self._reached, self._began_s, self._last_s = end, done, now, now
            self._step_s.clear()
        elif done > self._reached:
            self._step_s.append((now - self._last_s) / (done - self._reached))
            self._reached, self._last_s = done, now
        if not self._step_s or now - self._began_s < LEAST_S:
            return None
        return max(0, end - done) * sorted(self._step_s)[(len(self._step_s) - 1) // 2]


def in_words(seconds: float) -> str:
    """A duration with one or two digits."""
    if seconds >= 5400:
        return f"{seconds / 3600:.1f} h"
    return f"{seconds / 60:.0f} min" if seconds > 90 else f"{seconds:.0f} s"


class Progress:
    """A progress bar on stderr for long computations.

    Parameters
    ----------
    wanted : bool
        Whether progress is shown: as a bar on a terminal, else as a line every `LINE_S`.
    announced : bool
        Whether one line says that a computation takes more than `LONG_S`, also without the bar.
    end_of : callable, optional
        As in `TimeLeft`.
    """

    def __init__(
        self,
        *,
        wanted: bool,
        announced: bool = False,
        end_of: Callable[[str, int], int] = lambda stage, total: total,
    ) -> None:
        self._wanted, self._announced = wanted, not announced
        self._has_terminal = sys.stderr is not None and sys.stderr.isatty()
        self._bar: Any = None
        self._task: Any = None
        self._reached = ("", 0, 1)
        self._left_s: float | None = None
        self._left = TimeLeft(end_of)
        self._timer = Timer(PATIENCE_S, self._show)
        self._timer.daemon = True
        self._ended = Event()
        self._lines = Thread(target=self._print_lines, daemon=True)

    def __enter__(self) -> Self:
        if self._wanted:
            (self._timer if self._has_terminal else self._lines).start()
        return self

    def __exit__(self, *_: object) -> None:
        if not self._wanted:
            return
        self._ended.set()
        if not self._has_terminal:
            self._lines.join()
            return
        self._timer.cancel()
        self._timer.join()
        if self._bar is not None:
            self._bar.stop()

    def tell(self, stage: str, done: int, total: int, left_s: float | None = None) -> None:
        """Record the progress of a stage; `left_s` replaces the time left that follows from it."""
        left = self._left.after(stage, done, total) if left_s is None else left_s
        self._reached, self._left_s = (stage, done, total), left
        if not self._announced and left is not None and left + self._left.spent_s > LONG_S:
            self._announced = True
            seconds = float(f"{left + self._left.spent_s:.1g}")
            self.say(f"flankload: this takes about {in_words(seconds)} or more (now: {stage})")
        if self._bar is not None:
            words = "" if left is None else f"{in_words(left)} left"
            self._bar.update(self._task, description=stage, completed=done, total=total, left=words)

    def say(self, line: str) -> None:
        """Print a line on stderr, above the bar if there is one."""
        if self._bar is not None:
            self._bar.console.print(line, markup=False, highlight=False, soft_wrap=True)
        else:
            say(line)

    def _print_lines(self) -> None:
        """Print a line from time to time, until the end."""
        while not self._ended.wait(LINE_S):
            (stage, done, total), left = self._reached, self._left_s
            words = f"flankload: {stage}, {100 * done // max(total, 1)} %"
            self.say(words + ("" if left is None else f", {in_words(left)} left"))

    def _show(self) -> None:
        from rich.console import Console
        from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

        bar = Progress(
            TextColumn("{task.description:<20}"),
            BarColumn(),
            TimeElapsedColumn(),
            TextColumn("{task.fields[left]}"),
            console=Console(stderr=True),
            transient=True,
        )
        stage, done, total = self._reached
        self._task = bar.add_task(stage, completed=done, total=total, left="")
        bar.start()
        self._bar = bar
