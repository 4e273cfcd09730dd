"""State of the test process that every test relies on."""

from __future__ import annotations

import gc
import signal
import sys

import pytest

#: Checks that tests share say as much where they fail as those of the tests.
pytest.register_assert_rewrite("tests.support")


def pytest_configure() -> None:
    """Let Ctrl-C reach this process and the programs that the tests start; collect faster.

    A shell that starts the tests in the background ignores SIGINT, and programs inherit that.
    """
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    gc.disable()  # there is no garbage while modules are imported


def pytest_collection_finish() -> None:
    """Leave thousands of collected tests out of every later search for garbage: 5 % of the time.

    Fewer searches take half as long.
    """
    gc.enable()
    gc.freeze()
    gc.set_threshold(10_000, 20, 10)
    # Pictures are drawn as for users, with fewer pixels.
    style = sys.modules.get("flankload.plot.style")
    if style is not None:
        style.STYLE["savefig.dpi"] = 40
