"""Exceptions of the package."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray


def readable(text: str) -> str:
    """A text that can be encoded.

    The bytes of a file name that the locale does not know are letters of UTF-8 if they can be.
    """
    try:
        data = text.encode("utf-8", "surrogateescape")
    except UnicodeEncodeError:  # halves of letters, which are no bytes
        data = text.encode("utf-8", "replace")
    return data.decode("utf-8", "replace")


def one_line(text: object) -> str:
    """A message in one line, in which letters that a terminal would obey are written out."""
    words = " ".join(readable(str(text)).split())
    if words.isprintable():
        return words
    return "".join(x if x.isprintable() else ascii(x)[1:-1] for x in words)


def reason_of(error: OSError) -> str:
    """Why a file cannot be read or written, in the words of the system."""
    return (error.strerror or str(error) or type(error).__name__).lower()


class FlankloadError(Exception):
    """Base class of all exceptions that flankload raises on purpose."""

    def __reduce__(self) -> tuple[Any, ...]:
        # the default would call the class with its args, but some arguments are keywords
        return _restored, (type(self), self.args, dict(vars(self)))


def _restored(
    kind: type[FlankloadError], args: tuple[Any, ...], values: dict[str, Any]
) -> FlankloadError:
    """An exception from a pickle or a copy."""
    error = kind.__new__(kind, *args)
    vars(error).update(values)
    return error


class SceneError(FlankloadError):
    """A scene that cannot be understood or built.

    Parameters
    ----------
    key : str
        Dotted path of the key in the scene, for example ``body_1.tip_diameter_mm``.
    expected, found : str
        Expected and actual value, each as the end of a sentence.
    file : str or Path, optional
        The file that contains the key; omitted for scenes from a dictionary.
    """

    def __init__(
        self, *, key: str, expected: str, found: object, file: str | Path | None = None
    ) -> None:
        self.file = None if file is None else str(file)
        self.key = key
        self.expected = expected
        self.found = str(found)
        super().__init__(self.file, key, expected, self.found)

    def __str__(self) -> str:
        places = [part for part in (self.file, self.key) if part]
        return one_line(": ".join([*places, f"expected {self.expected}, found {self.found}"]))

    def with_file(self, path: str | Path) -> Self:
        """Return the same exception with the file that contains the key."""
        return type(self)(key=self.key, expected=self.expected, found=self.found, file=path)


class PremiseError(SceneError):
    """A scene that violates a premise of the model (`docs/guide/limits.md`).

    `effects.beyond_limits = true` solves it nevertheless.
    """


class MeshError(SceneError):
    """A mesh file that cannot be read or does not describe a body."""


class ComplianceFileError(SceneError):
    """A compliance file that cannot be read or does not describe a body."""


class OtherProgramError(FlankloadError):
    """The external program of a verification is missing or found no solution.

    Attributes
    ----------
    folder : Path or None
        Folder of its files.
    """

    def __init__(self, message: str, *, folder: Path | None = None) -> None:
        super().__init__(message if folder is None else f"{message}; its files are in {folder}")
        self.folder = folder


class ContactError(FlankloadError):
    """A contact problem without a solution.

    Attributes
    ----------
    code : int
        The core's code: -1 … -7.
    place : tuple of int
        Indices of position and torque, if several problems are solved at once.
    states : tuple
        States of the other problems solved at once; None for those without a state.
    """

    code = 0
    place: tuple[int, ...] = ()
    states: tuple[object, ...] = ()


class NoContactState(ContactError):  # noqa: N818 - a public name
    """No state of contact is in equilibrium with the loads, or none was found (code -1).

    Attributes
    ----------
    proven : bool
        True: no state exists. False: none was found, but one may exist; this happens only for a
        matrix that is not positive definite.
    largest_torque : float
        The largest torque in equilibrium on the path from zero load [N mm].
    motion : ndarray of shape (q,)
        If no forces balance the loads: a motion that closes no gap while the loads do work;
        otherwise the motion at the end of the path from zero load. Zero if neither was found.
    """

    code = -1

    def __init__(
        self,
        message: str,
        *,
        proven: bool = False,
        largest_torque: float = 0.0,
        motion: NDArray[np.float64] | None = None,
    ) -> None:
        super().__init__(message)
        self.proven = proven
        self.largest_torque = largest_torque
        self.motion = np.empty(0) if motion is None else motion


class PivotLimit(ContactError):  # noqa: N818 - a public name
    """The loop reached its limit of pivots before it found a state (code -2)."""

    code = -2


class SingularContact(ContactError):  # noqa: N818 - a public name
    """No pair resists a motion, or the rows of the pairs in contact are dependent (code -3).

    Attributes
    ----------
    motion : ndarray of shape (q,)
        A motion on which no force does work, with largest component 1; zero if none was found.
    """

    code = -3

    def __init__(self, message: str, *, motion: NDArray[np.float64] | None = None) -> None:
        super().__init__(message)
        self.motion = np.empty(0) if motion is None else motion


class InputError(ContactError, ValueError):
    """Arguments that do not define a contact problem (code -4).

    Code -5 if a row scale is not positive or no lever arm could carry the torque, -7 if forces,
    gaps or motions in the given units exceed the range of double precision.
    """

    code = -4

    def __init__(self, message: str, *, code: int = -4) -> None:
        super().__init__(message)
        self.code = int(code)


class NegativeForce(ContactError):  # noqa: N818 - a public name
    """The final state of method ``paper`` requires tension (code -6).

    Attributes
    ----------
    state : ContactState
        That state, including negative forces.
    """

    code = -6

    def __init__(self, message: str, *, state: Any) -> None:
        super().__init__(message)
        self.state = state
