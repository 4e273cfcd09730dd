"""Packages that flankload uses but does not require."""

from __future__ import annotations

from importlib import import_module
from typing import Any


def optional(package: str, user: str, *, extra: str | None = None) -> Any:
    """Import a package that may be missing.

    Parameters
    ----------
    package : str
        Module to import; its first part is the name of the package.
    user : str
        Function that needs it.
    extra : str, optional
        Extra of flankload that installs it; by default the name of the package.

    Raises
    ------
    ImportError
        If the package is not installed.
    """
    try:
        return import_module(package)
    except ImportError:
        name = package.partition(".")[0]
        raise ImportError(
            f"{user} needs the package {name}: pip install 'flankload[{extra or name}]'"
        ) from None
