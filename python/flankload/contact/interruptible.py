"""Calls of the core beside the main thread that can be interrupted and report progress."""

from __future__ import annotations

from threading import Event, Thread
from typing import TYPE_CHECKING, TypeVar

if TYPE_CHECKING:
    from collections.abc import Callable

    import numpy as np
    from numpy.typing import NDArray

    Outcome = TypeVar("Outcome")

#: Seconds between two reads of the core's progress.
TICK_S = 0.05


def call_and_watch(
    call: Callable[[], Outcome],
    control: NDArray[np.intc],
    *,
    tell: Callable[[int], None] | None = None,
) -> Outcome:
    """Return the value of a call of the core, which runs in a separate thread.

    An exception during the waiting (Ctrl-C, or from `tell`) stops the core and is raised again once
    the core has returned.

    Parameters
    ----------
    call : callable
        Releases the GIL while it runs.
    control : (2,) array of C ints
        Shared with the core: [0] requests it to stop, [1] is the completed work.
    tell : callable, optional
        Called with control[1] several times a second.
    """
    outcome: list[Outcome] = []
    failure: list[BaseException] = []
    ended = Event()

    def work() -> None:
        try:
            outcome.append(call())
        except BaseException as error:
            failure.append(error)
        finally:
            ended.set()

    Thread(target=work, name="flankload core").start()
    try:
        while not ended.wait(TICK_S):
            if tell is not None:
                tell(int(control[1]))
    except BaseException:
        control[0] = 1
        ended.wait()
        raise
    if failure:
        raise failure[0]
    return outcome[0]
