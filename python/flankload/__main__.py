"""The command `flankload` as a process, also `python -m flankload`; handles Ctrl-C."""

from __future__ import annotations

import _thread
import os
import signal
import sys
import time
from io import TextIOWrapper
from types import FrameType
from typing import NoReturn

INTERRUPTED = 130
MESSAGE = b"flankload: interrupted\n"
#: Restores the cursor of the terminal that a progress bar has hidden.
SHOW_CURSOR = b"\x1b[?25h"
#: Read when libraries are loaded. The seconds of `accuracy` are those of one thread by default, and
#: each worker of `study` has one.
THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS")
#: After this time the finalizer in which an interrupt came has ended, s.
REPEAT_S = 1e-3


def command() -> int:
    """Run the command line of this process.

    Returns
    -------
    int
        Exit code.
    """
    _open_closed_streams()
    # a shell that starts this in the background ignores Ctrl-C for it, and that is preserved
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, _on_interrupt)
        sys.unraisablehook = _on_ignored
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")  # letters that the terminal lacks
    if sys.argv[1:2] in (["accuracy"], ["study"]):
        for name in THREADS:
            os.environ.setdefault(name, "1")
    try:
        from flankload.cli import main

        code = main()
        signal.signal(signal.SIGINT, signal.SIG_IGN)  # everything is done
    except KeyboardInterrupt:
        os.write(2, MESSAGE)
        return INTERRUPTED
    return code


def _open_closed_streams() -> None:
    """Open streams that the caller closed (`2>&-`), for reading and writing nothing.

    Otherwise the next file that is opened gets the number of the stream, and messages of libraries
    end in it.
    """
    for number, name in enumerate(("stdin", "stdout", "stderr")):
        try:
            os.fstat(number)
        except OSError:
            # the lowest free number is this one
            os.set_inheritable(os.open(os.devnull, os.O_RDWR), True)
            setattr(sys, name, os.fdopen(number, "w" if number else "r", closefd=False))


def _on_interrupt(_: int, frame: FrameType | None) -> NoReturn:
    """Raise KeyboardInterrupt, except during imports: end the process there.

    Modules in C swallow or print an exception that is raised during their import. Nothing is being
    written at that time, so the process can end immediately.
    """
    while frame is not None:
        if "importlib" in frame.f_code.co_filename:
            os.write(2, (SHOW_CURSOR if os.isatty(2) else b"") + MESSAGE)
            os._exit(INTERRUPTED)
        frame = frame.f_back
    raise KeyboardInterrupt


def _on_ignored(ignored: sys.UnraisableHookArgs) -> None:
    """Repeat an interrupt that came in a finalizer or a callback of a weak reference.

    Python prints an exception that is raised there, and the program continues.
    """
    if issubclass(ignored.exc_type, KeyboardInterrupt):
        _thread.start_new_thread(_interrupt_again, ())
    else:
        sys.__unraisablehook__(ignored)


def _interrupt_again() -> None:
    time.sleep(REPEAT_S)
    os.kill(os.getpid(), signal.SIGINT)  # unlike interrupt_main, it also ends a wait


if __name__ == "__main__":
    sys.exit(command())
