# The extension that f2py makes of fortran/flat; its signatures stand in fortran/flat/_core.pyf.
from typing import Any

def __getattr__(name: str) -> Any: ...
