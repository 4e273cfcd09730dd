"""Questions to the user about values outside the usual range of their key."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cache
from typing import TYPE_CHECKING, Any

from msgspec import Struct

from flankload.scene.catalogue import estimate_notes
from flankload.scene.form import fields_of
from flankload.scene.refusal import shown

if TYPE_CHECKING:
    from flankload.scene.scene import Scene
    from flankload.scene.table import Table

#: Factor between units of one quantity (um and mm, GPa and MPa), also squared (um and m).
THOUSAND = 1000.0
TABLES = ("body_1", "body_2", "pair", "load", "positions", "effects", "accuracy")


def questions(scene: Scene) -> dict[str, str]:
    """Value and question for each key of a scene with an unusual value, by path of the key."""
    return {
        path: f"{shown(value)}, {asked}"
        for name in TABLES
        for path, value, usual in _numbers(getattr(scene, name), name)
        if (asked := question(_largest(value), usual)) is not None
    }


def question_notes(scene: Scene) -> tuple[str, ...]:
    """Lines of text: questions about unusual values and notes about estimated ones."""
    asked = (f"{path} = {text}" for path, text in questions(scene).items())
    return (*asked, *estimate_notes(scene))


def question(value: float, usual: tuple[float, float]) -> str | None:
    """Question about a value whose magnitude is unusual; None for other values and for 0."""
    low, high = usual
    if value == 0.0 or low <= abs(value) <= high:
        return None
    for factor in (THOUSAND, 1.0 / THOUSAND, THOUSAND**2, THOUSAND**-2):
        if low <= abs(value) * factor <= high:
            return f"did you mean {value * factor:.12g}? (usual: {low:g} to {high:g})"
    return f"is that what you mean? (usual: {low:g} to {high:g})"


def _numbers(table: Any, key: str) -> Iterator[tuple[str, Any, tuple[float, float]]]:
    """Path, value and usual range of each key that has one."""
    if not isinstance(table, Struct):
        return
    usual = _usual_ranges(type(table))
    for name in table.__struct_fields__:
        value, path = getattr(table, name), f"{key}.{name}"
        if isinstance(value, Struct):
            yield from _numbers(value, path)
        elif value is not None and name in usual:
            yield path, value, usual[name]


@cache
def _usual_ranges(form: type[Table]) -> dict[str, tuple[float, float]]:
    """The usual ranges in the annotations of a table, by key."""
    return {
        name: (meta.extra_json_schema["usual"][0], meta.extra_json_schema["usual"][1])
        for name, field in fields_of(form).items()
        for meta in getattr(field.type, "__metadata__", ())
        if "usual" in (meta.extra_json_schema or {})
    }


def _largest(value: float | Sequence[float]) -> float:
    """The number, or the entry of a list with the largest magnitude."""
    if isinstance(value, Sequence):
        return max((float(part) for part in value), key=abs, default=0.0)
    return float(value)
