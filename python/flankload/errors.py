"""What can go wrong, one class per kind; each says what was expected and what was found."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray


class FlankloadError(Exception):
    """Base of every error that flankload raises on purpose."""

    def __reduce__(self) -> tuple[Any, ...]:
        # the default calls the class with its args, but these classes are made with keywords
        return _restored, (type(self), self.args, dict(vars(self)))


def _restored(
    kind: type[FlankloadError], args: tuple[Any, ...], values: dict[str, Any]
) -> FlankloadError:
    """An error out of a pickle or a copy."""
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
        What was expected and what was found, each the end of a sentence.
    file : str or Path, optional
        The file in which the key stands; left out for scenes that come from a dictionary.
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
        line = ": ".join([*places, f"expected {self.expected}, found {self.found}"])
        return " ".join(line.split())

    def with_file(self, path: str | Path) -> Self:
        """Return the same error, naming the file in which the key stands."""
        return type(self)(key=self.key, expected=self.expected, found=self.found, file=path)


class PremiseError(SceneError):
    """A scene that breaks a premise of the model (`docs/guide/limits.md`).

    `effects.beyond_limits = true` solves it all the same.
    """


class MeshError(SceneError):
    """A mesh file that cannot be read or does not make a body."""


class ComplianceFileError(SceneError):
    """A compliance file that cannot be read or does not make a body."""


class OtherProgramError(FlankloadError):
    """The program that a verification asks is missing or has no answer.

    Attributes
    ----------
    folder : Path or None
        Where its files are.
    """

    def __init__(self, message: str, *, folder: Path | None = None) -> None:
        super().__init__(message if folder is None else f"{message}; its files are in {folder}")
        self.folder = folder


class ContactError(FlankloadError):
    """A contact problem without an answer.

    Attributes
    ----------
    code : int
        The core's code: -1 … -7.
    place : tuple of int
        Of many problems solved at once: numbers of the position and of the torque.
    states : tuple
        Of many problems solved at once: the states of the others, None where there is none.
    """

    code = 0
    place: tuple[int, ...] = ()
    states: tuple[object, ...] = ()


class NoContactState(ContactError):  # noqa: N818 - a public name
    """No state of contact holds the loads, or none was found (code -1).

    Attributes
    ----------
    proven : bool
        No state exists. False: none was found, but one may exist; so it can be only where the
        matrix is not positive definite.
    largest_torque : float
        The largest torque that was held on the way from no load [N mm].
    motion : ndarray of shape (q,)
        Where no forces hold the loads: a motion that opens or keeps all gaps while the loads do
        work; else the motion in which the way from no load ends. Zero where neither was met.
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
    """The loop used up its pivots without reaching a state (code -2)."""

    code = -2


class SingularContact(ContactError):  # noqa: N818 - a public name
    """No pair holds a motion, or the rows of the pairs in contact depend on each other (code -3).

    Attributes
    ----------
    motion : ndarray of shape (q,)
        A motion on which no force works, its largest part 1; zero where none was met.
    """

    code = -3

    def __init__(self, message: str, *, motion: NDArray[np.float64] | None = None) -> None:
        super().__init__(message)
        self.motion = np.empty(0) if motion is None else motion


class InputError(ContactError, ValueError):
    """Arguments that do not make a contact problem (code -4).

    Code -5 where a row scale is not positive or no lever arm could carry the torque, -7 where a
    double cannot hold forces, gaps or motions in the given units.
    """

    code = -4

    def __init__(self, message: str, *, code: int = -4) -> None:
        super().__init__(message)
        self.code = code


class NegativeForce(ContactError):  # noqa: N818 - a public name
    """The final state of method ``paper`` needs tension (code -6).

    Attributes
    ----------
    state : ContactState
        That state, negative forces included.
    """

    code = -6

    def __init__(self, message: str, *, state: Any) -> None:
        super().__init__(message)
        self.state = state
