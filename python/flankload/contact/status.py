"""Status codes of the core, their exceptions, and the largest possible torque of a position."""

from __future__ import annotations

from enum import IntEnum
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from flankload import _core
from flankload.base.torque import in_newton_metres
from flankload.errors import ContactError, InputError, NoContactState, PivotLimit, SingularContact

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from flankload.base.arrays import Floats

    Corners = NDArray[np.int64]


class Status(IntEnum):
    """Status of a contact problem or of a position (`fortran/base/status.f90`)."""

    SOLVED = 0
    ILL_CONDITIONED = 1
    DEGENERATE = 2
    NOT_UNIQUE = 3
    # contact problems without a solution
    NO_CONTACT_STATE = -1
    PIVOT_LIMIT = -2
    SINGULAR_CONTACT = -3
    INVALID_INPUT = -4
    INVALID_SCALE = -5
    NEGATIVE_FORCE = -6
    OUT_OF_RANGE = -7
    # positions without a solution
    NO_ZONE = -11
    TOO_MANY_ZONES = -12
    UNSETTLED_CELLS = -13
    CIRCLE_MISSES = -14
    NO_ROOM = -15  # the position is repeated with a larger workspace
    STOPPED = -16
    CONFORMS = -17
    UNSETTLED_WIDTHS = -18
    UNSTEADY_POINTS = -19
    FORCES_MOVE = -20
    ONLY_ENDS = -21
    NOT_IN_SLICES = -22
    ONE_MESH_ONLY = -23


class SiteCorner(IntEnum):
    """Contact of a site on a sharp corner of a body, or off corners (`fortran/base/status.f90`)."""

    OFF_CORNERS = 0
    CORNER_1 = 1
    CORNER_2 = 2
    # off corners
    TOUCHES = -1  # the site that touches without torque
    NOT_PARABOLIC = -2  # a lumped contact that no parabola approximates
    END_WOULD_TOUCH = -3  # a cut end of a flank would touch

    @classmethod
    def of_body(cls, z: int) -> SiteCorner:
        """Contact on a sharp corner of body z (0 or 1)."""
        return (cls.CORNER_1, cls.CORNER_2)[z]


def on_corner(corners: Corners) -> NDArray[np.bool_]:
    """Whether each site has contact on a sharp corner of a body."""
    return np.asarray(corners >= SiteCorner.CORNER_1)


def with_sharp_ends(
    corners: Corners, force_N: Floats, sharp_ends: tuple[int, int]
) -> NDArray[np.int64]:
    """Corners (P, S, J) of slices, with contact on sharp ends (`Slices`) that carry load."""
    marked = corners.copy()
    for j, body in ((0, sharp_ends[0]), (-1, sharp_ends[1])):
        if body:
            carries = (force_N[..., j] > 0) & ~on_corner(corners[..., j])
            marked[..., j][carries] = SiteCorner.of_body(body - 1)
    return marked


def worst_corner(corners: Corners) -> NDArray[np.int64]:
    """Corner (P, S) of each site from those of its slices (P, S, J): contact on one comes first."""
    return np.where(on_corner(corners).any(axis=2), corners.max(axis=2), corners.min(axis=2))


def is_marked(corners: Corners) -> NDArray[np.bool_]:
    """Whether each site has contact on a corner, or one that is marked for another reason."""
    unmarked = (SiteCorner.OFF_CORNERS, SiteCorner.END_WOULD_TOUCH)
    return np.asarray(~np.isin(corners, unmarked))


#: Exception for each status of a position without a state.
EXCEPTIONS: dict[int, type[ContactError]] = {
    Status.NO_CONTACT_STATE: NoContactState,
    Status.PIVOT_LIMIT: PivotLimit,
    Status.SINGULAR_CONTACT: SingularContact,
    Status.INVALID_INPUT: InputError,
    Status.INVALID_SCALE: InputError,
    Status.OUT_OF_RANGE: InputError,
    Status.NO_ZONE: NoContactState,
    Status.TOO_MANY_ZONES: PivotLimit,
    Status.UNSETTLED_CELLS: PivotLimit,
    Status.CIRCLE_MISSES: PivotLimit,
    Status.STOPPED: ContactError,
    Status.CONFORMS: InputError,
    Status.UNSETTLED_WIDTHS: PivotLimit,
    Status.FORCES_MOVE: PivotLimit,
    Status.ONLY_ENDS: NoContactState,
    Status.NOT_IN_SLICES: InputError,
    Status.ONE_MESH_ONLY: InputError,
}

#: Texts in terms of a scene that replace those of the core.
SCENE_TEXTS: dict[int, str] = {
    Status.NO_CONTACT_STATE: "no contact state was found for this torque",
    Status.SINGULAR_CONTACT: (
        "no pair restrains the rotation, or the pairs in contact are linearly dependent"
    ),
    Status.INVALID_SCALE: "no pair could carry the torque",
    Status.OUT_OF_RANGE: "forces, gaps or rotation exceed the range of double precision",
    Status.CONFORMS: (
        'effects.contact = "lumped" has one point per contact, but here the flanks conform and '
        'touch over a length (contact = "pairs" resolves it)'
    ),
    Status.ONLY_ENDS: (
        "only tips or fillets can touch here, which effects.tip_contact = false excludes"
    ),
    Status.NOT_IN_SLICES: "slices along the face width do not support finite forces",
}
#: Search for the largest torque that a jammed pair can hold: first torque over the requested one,
#: steps per round, and rounds; accurate to 3e-4.
LEAST_HELD, HELD_STEPS, HELD_ROUNDS = 1e-4, 40, 3


def status_text(code: int) -> str:
    """Message of a status (`fortran/base/status.f90`)."""

    return _core.flankload_status_text(code).decode("ascii").strip()


def checked(info: int) -> int:
    """`info` of a procedure of the core called in this thread, unless an argument is invalid.

    Raises
    ------
    InputError
        With the words of the core: procedure, argument, expected, found.
    """
    if info < 0:
        raise InputError(status_text(info))
    return int(info)


def raise_first_failure(
    status: NDArray[np.int64],
    position_rad: NDArray[np.float64],
    torques: NDArray[np.float64],
    certificate: NDArray[np.float64],
    *,
    has_friction: bool,
    holds: Callable[[int, NDArray[np.float64]], NDArray[np.bool_]] | None = None,
) -> None:
    """Raise the exception of the first state without a solution, if there is one.

    `status` (P, T) is negative if no state was found; `certificate` (3, P, T) then has the part of
    the torque that can be held, and 1 if this is proven. `holds(k, torques)`: whether position k
    can hold each torque; `NoContactState` contains the largest one.
    """
    failed = np.argwhere(status < 0)
    if failed.size == 0:
        return
    k, t = (int(number) for number in failed[0])
    torque_Nm = in_newton_metres(float(torques[t]))
    where = f"position {k} ({np.degrees(position_rad[k]):.4f} deg), torque {torque_Nm:g} N m"
    more = f" ({len(failed)} of {status.size} states failed)" if len(failed) > 1 else ""
    code = int(status[k, t])
    kind, reason = EXCEPTIONS[code], SCENE_TEXTS.get(code) or status_text(code)
    if code != Status.NO_CONTACT_STATE:
        raise kind(f"{where}: {reason}{more}")
    part, proven = certificate[:2, k, t]
    held = float(torques[t] * part)
    if held > 0.0 and holds is not None:
        held = _largest_held(held, float(torques[t]), partial(holds, k))
    jams = "the pair jams by friction, " if has_friction else ""
    raise NoContactState(
        f"{where}: {jams}{reason}; about {in_newton_metres(held):.4g} N m can be held there{more}",
        proven=bool(proven),
        largest_torque=held,
    )


def _largest_held(
    guess: float, torque: float, holds: Callable[[NDArray[np.float64]], NDArray[np.bool_]]
) -> float:
    """Largest torque that can be held, N mm; the guess if none of the tried torques can be held.

    The guess is based on the cells of the requested torque; each tried torque has its own cells.
    """
    found = guess
    tried = np.geomspace(LEAST_HELD * torque, torque, HELD_STEPS)
    for _ in range(HELD_ROUNDS):
        held = np.flatnonzero(holds(tried))
        if held.size == 0:
            return found
        last = int(held[-1])
        found = float(tried[last])
        if last + 1 == tried.size:
            return found
        tried = np.linspace(found, tried[last + 1], HELD_STEPS)
    return found
