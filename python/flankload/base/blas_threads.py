"""One thread for BLAS, in all threads of the process at once."""

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
    """Limit BLAS to one thread until all threads of Python have left this block.

    The number of threads belongs to the process, except with OpenMP: if each thread of Python set
    and restored it by itself, one would restore what another has set, and it would remain 1.
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
    """Libraries of BLAS, sought again after another module is loaded: that takes milliseconds."""
    from threadpoolctl import ThreadpoolController

    return ThreadpoolController().select(user_api="blas")


def _restore(limits: Any) -> None:
    """Restore numbers of threads that another thread of Python may have set."""
    from threadpoolctl import OpenBLASController

    # from version 3.7 on, a thread that has not set the number cannot restore it
    forget = getattr(OpenBLASController, "clear_controlling_thread", lambda **_: None)
    forget(force=True)
    limits.restore_original_limits()
    forget(force=True)
