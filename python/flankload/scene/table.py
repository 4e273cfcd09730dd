"""What all tables of a scene file are made of: types of numbers, and what stands beside a key."""

from typing import Annotated

from msgspec import Meta, Struct

Positive = Annotated[float, Meta(gt=0)]
#: mm. The range is far wider than any pair; beyond it numbers overflow or meshes have no end.
Length = Annotated[float, Meta(ge=1e-3, le=1e5)]
NotNegative = Annotated[float, Meta(ge=0)]
Text = Annotated[str, Meta(min_length=1)]
# Beyond thousands of turns the place within a tooth pitch is lost to rounding.
Angle = Annotated[float, Meta(ge=-1e7, le=1e7)]
Angles = Annotated[tuple[Angle, ...], Meta(min_length=1)]
Torques = Annotated[tuple[NotNegative, ...], Meta(min_length=1)]
Shift = Annotated[float, Meta(ge=-5, le=5)]
Strips = Annotated[float, Meta(ge=2, le=200)]


def about(unit: str, meaning: str) -> Meta:
    """Meaning and unit of a key ("-" for a pure number, "" for words)."""
    return Meta(description=meaning, extra_json_schema={"unit": unit} if unit else None)


class Table(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What all tables have in common."""
