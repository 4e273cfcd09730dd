"""Plugin of pytest: while the core runs, invalid operations, division by zero and overflow stop.

``pytest -p tests.trapping`` with a core that was built with all checks of the compiler
(`./dev check`).
"""

from __future__ import annotations

import ctypes
import ctypes.util
from collections.abc import Callable
from functools import wraps
from typing import Any

from flankload import _core

#: FE_INVALID | FE_DIVBYZERO | FE_OVERFLOW of x86
_TRAPS = 0x01 | 0x04 | 0x08
_MATH = ctypes.CDLL(ctypes.util.find_library("m"))


def trapping(procedure: Callable[..., Any]) -> Callable[..., Any]:
    """The procedure, with traps from its start to its end, for the calling thread."""

    @wraps(procedure)
    def call(*arguments: Any, **named: Any) -> Any:
        _MATH.feclearexcept(_TRAPS)
        _MATH.feenableexcept(_TRAPS)
        try:
            return procedure(*arguments, **named)
        finally:
            _MATH.fedisableexcept(_TRAPS)

    return call


for _name in dir(_core):
    if _name.startswith("flankload_"):
        setattr(_core, _name, trapping(getattr(_core, _name)))
