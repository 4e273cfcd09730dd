"""A long call of the core beside the main thread: it can be stopped, and tells how far it is."""

from __future__ import annotations

from threading import Event, Thread
from typing import TYPE_CHECKING, TypeVar

if TYPE_CHECKING:
    from collections.abc import Callable

    import numpy as np
    from numpy.typing import NDArray

    Outcome = TypeVar("Outcome")

#: Seconds between two looks at how far the core is.
TICK_S = 0.05


def call_and_watch(
    call: Callable[[], Outcome],
    control: NDArray[np.intc],
    *,
    tell: Callable[[int], None] | None = None,
) -> Outcome:
    """Call the core in a thread of its own and wait.

    What interrupts the waiting (Ctrl-C, an exception from `tell`) stops the core and goes on to the
    caller once the core has come back.

    Parameters
    ----------
    call : callable
        The call of the core; it gives the interpreter free while it runs.
    control : (2,) array of C ints
        Shared with the core: [0] asks it to stop, [1] is what it has done.
    tell : callable, optional
        Told control[1] several times a second.

    Returns
    -------
    What `call` returns.
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
