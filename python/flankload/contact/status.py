"""Status codes of the core and their exceptions; the messages come from the core."""

from __future__ import annotations

from flankload import _core
from flankload.errors import (
    ContactError,
    InputError,
    NoContactState,
    PivotLimit,
    SingularContact,
)

#: Status codes: the state exceeds the range of double precision; the workspace was too small for
#: the pairs of a position, which is repeated with a larger one; a position was not started.
OUT_OF_RANGE, NO_ROOM, STOPPED = -7, -15, -16
#: Exception for each status of a position without a state.
EXCEPTIONS: dict[int, type[ContactError]] = {
    NoContactState.code: NoContactState,
    PivotLimit.code: PivotLimit,
    SingularContact.code: SingularContact,
    InputError.code: InputError,
    -5: InputError,
    OUT_OF_RANGE: InputError,
    -11: NoContactState,
    -12: PivotLimit,
    -13: PivotLimit,
    -14: PivotLimit,
    STOPPED: ContactError,
    -17: InputError,
    -18: PivotLimit,
    -20: PivotLimit,
    -21: NoContactState,
    -22: InputError,
}


def words(code: int) -> str:
    """Message of a status (`fortran/base/status.f90`)."""

    return _core.flankload_status_text(code).decode("ascii").strip()
