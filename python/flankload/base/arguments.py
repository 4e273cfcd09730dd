"""Checks of argument types; an error line names the argument, the expected and the found value."""

from __future__ import annotations

from collections.abc import Sequence
from numbers import Integral, Real
from os import PathLike
from typing import Any, NoReturn

from flankload.errors import InputError


def require(name: str, value: object, expected: str, *, fits: bool) -> None:
    """Refuse an argument unless it fits.

    Raises
    ------
    InputError
    """
    if not fits:
        refuse_argument(name, value, expected)


def refuse_argument(name: str, value: object, expected: str) -> NoReturn:
    """Refuse an argument.

    Raises
    ------
    InputError
    """
    text = " ".join(repr(value).split())
    text = text if len(text) <= 80 else text[:77] + "..."
    raise InputError(f"{name}: expected {expected}, found {text}")


def require_names(name: str, value: Any) -> None:
    """Refuse anything but a sequence of names; a single string is refused."""
    fits = isinstance(value, Sequence) and not isinstance(value, str)
    fits = fits and all(isinstance(item, str) for item in value)
    require(name, value, "a sequence of names", fits=fits)


def require_path(name: str, value: object) -> None:
    """Refuse anything but a path or None."""
    fits = value is None or isinstance(value, str | PathLike)
    require(name, value, "a path", fits=fits and "\0" not in str(value))


def require_number(name: str, value: object) -> None:
    """Refuse anything but a real number."""
    require(name, value, "a number", fits=is_number(value))


def is_number(value: object) -> bool:
    """Whether a value is a real number of Python or NumPy; Booleans do not count."""
    return isinstance(value, Real) and not isinstance(value, bool)


def is_index(value: object) -> bool:
    """Whether a value is an integer of Python or NumPy; Booleans do not count."""
    return isinstance(value, Integral) and not isinstance(value, bool)
