"""Bodies without modifications of their profile, whose flanks the finite elements follow."""

from __future__ import annotations

from typing import Any, TypeVar

from msgspec import Struct, structs

from flankload.scene.effects.switches import RELIEF_PLACES

T = TypeVar("T", bound=Struct)

#: Keys that remove micrometres from a profile, and those of their places and shapes, with the
#: values of an unmodified one. Tip roundings and chamfers are millimetres and remain; modifications
#: along the axis do not change the section.
UNMODIFIED: dict[str, Any] = {
    **dict.fromkeys(("tip_relief_um", "root_relief_um", "profile_crowning_um", *RELIEF_PLACES)),
    **dict.fromkeys(("tip_relief_shape", "root_relief_shape"), "linear"),
}


def unmodified(table: T) -> T:
    """The table of a body, or the profile of a mesh, without modifications of the profile."""
    keys = {name: UNMODIFIED[name] for name in table.__struct_fields__ if name in UNMODIFIED}
    return structs.replace(table, **keys)
