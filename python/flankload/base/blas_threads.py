"""Limit BLAS to one thread for all Python threads of the process."""

from __future__ import annotations

import sys
from contextlib import contextmanager
from functools import lru_cache
from threading import Lock
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Iterator

_lock = Lock()
_inside = 0
_limits: Any = None


@contextmanager
def one_blas_thread() -> Iterator[None]:
    """Limit BLAS to one thread until all Python threads have left this block.

    The number of BLAS threads is a property of the process, except with OpenMP. If each Python
    thread saved and restored it separately, one could save the 1 set by another and restore that.
    """
    global _inside, _limits
    found = _blas(len(sys.modules))
    by_thread = found.select(threading_layer="openmp")
    own = {library.filepath for library in by_thread.lib_controllers}
    shared = [lib.filepath for lib in found.lib_controllers if lib.filepath not in own]
    with _lock:
        _inside += 1
        if _inside == 1:
            _limits = found.select(filepath=shared).limit(limits=1)
    try:
        with by_thread.limit(limits=1):
            yield
    finally:
        with _lock:
            _inside -= 1
            if _inside == 0:
                _restore(_limits)


@lru_cache(maxsize=1)
def _blas(_modules: int) -> Any:
    """Loaded BLAS libraries; the search takes milliseconds and is repeated after each import."""
    from threadpoolctl import ThreadpoolController

    return ThreadpoolController().select(user_api="blas")


def _restore(limits: Any) -> None:
    """Restore the numbers of BLAS threads, also if another Python thread has set them."""
    from threadpoolctl import OpenBLASController

    # since version 3.7 only the thread that set the number can restore it
    forget = getattr(OpenBLASController, "clear_controlling_thread", lambda **_: None)
    forget(force=True)
    limits.restore_original_limits()
    forget(force=True)
