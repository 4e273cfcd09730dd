"""Tables of all keys of a scene, for docs/reference/scene_keys.md."""

from __future__ import annotations

import inspect
from typing import Any, NamedTuple, get_args

import msgspec
from msgspec import inspect as kinds_of
from reference_markdown import table, unit_shown

from flankload.scene.expected import expected_of
from flankload.scene.form import fields_of, is_required, types_of
from flankload.scene.groups import group_of
from flankload.scene.scene import Body1, Body2, SceneFile
from flankload.scene.table import BY_NAME, Table
from flankload.scene.usual import usual_ranges

HEADS = ("key", "meaning", "unit", "value", "usual", "default")


class Key(NamedTuple):
    """A key of a table of the scene; name "shaft.lengths_mm" for a table in the table."""

    name: str
    unit: str
    expected: str
    usual: str
    default: str
    meaning: str


def body_tables() -> dict[str, tuple[type[Table], tuple[str, ...]]]:
    """Tables of all kinds of body by kind, with the bodies that can be of it."""
    found: dict[str, tuple[type[Table], tuple[str, ...]]] = {}
    inner = {
        name: tuple(
            part.cls
            for part in _members(types_of(SceneFile)[name])
            if isinstance(part, kinds_of.StructType)
        )
        for name in ("planet", "body_3")
    }
    for body, forms in (
        ("body_1", get_args(Body1)),
        ("body_2", get_args(Body2)),
        *inner.items(),
    ):
        for form in forms:
            kind = str(form.__struct_config__.tag)
            found[kind] = form, (*found.get(kind, (form, ()))[1], body)
    return found


#: Keys that follow from other tables, with their condition.
BY_OTHER_TABLES = {"face_width_mm": "both bodies have one"}


def keys_of(form: type[Table], before: str = "") -> list[Key]:
    """Keys of a table and of the tables in it, in their order."""
    found = []
    fields, usual = fields_of(form), usual_ranges(form)
    for name, whole in types_of(form).items():
        bare, extra = whole, {}
        if isinstance(bare, kinds_of.Metadata):
            extra, bare = bare.extra_json_schema or {}, bare.type
        members = bare.types if isinstance(bare, kinds_of.UnionType) else (bare,)
        inner = [part.cls for part in members if isinstance(part, kinds_of.StructType)]
        for part in inner:
            found += keys_of(part, f"{before}{name}.")
        if inner:
            continue
        field = fields[name]
        default = "required" if is_required(field) else shown(field.default)
        if others := form.instead_of.get(name, ()) if is_required(field) else ():
            default = f"required, or {' or '.join(f'`{other}`' for other in others)}"
        elif field.default is BY_NAME:
            default = f"required unless {BY_OTHER_TABLES.get(name, 'a name gives it')}"
        low_high = f"{usual[name].low:g} to {usual[name].high:g}" if name in usual else ""
        if name in usual and (per := usual[name].per) is not None:
            low_high += f", {per[1]:g} per mm of `{per[0]}`"
        meaning = str(extra.get("description", ""))
        unit = unit_shown(str(extra.get("unit", "")))
        found.append(Key(before + name, unit, expected_of(whole), low_high, default, meaning))
    return found


def shown(value: Any) -> str:
    """A default as in a scene file; absent for None."""
    if value is None or value is msgspec.NODEFAULT or value == ():
        return "absent"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, tuple):
        return f"[{', '.join(shown(part) for part in value)}]"
    return f'`"{value}"`' if isinstance(value, str) else f"{value:g}"


def scene_sections() -> list[tuple[str, str, list[Key]]]:
    """Title, introduction and keys of each section of the page."""
    found = []
    for kind, (form, bodies) in body_tables().items():
        partner = getattr(form, "partner", None)
        beside = f" The other body must be a `{partner}`." if partner else ""
        tables = " or ".join(f"`[{body}]`" for body in bodies)
        text = f'{tables} with `kind = "{kind}"`.{beside}'
        found.append((f"Body: {kind}", text, keys_of(form)))
    for name in ("stage", "train", "pair", "load", "positions", "effects", "accuracy"):
        (form,) = (
            part.cls
            for part in _members(types_of(SceneFile)[name])
            if isinstance(part, kinds_of.StructType)
        )
        found.append((f"[{name}]", f"{inspect.cleandoc(str(form.__doc__))}", keys_of(form)))
    return found


def _members(whole: Any) -> tuple[Any, ...]:
    bare = whole.type if isinstance(whole, kinds_of.Metadata) else whole
    return bare.types if isinstance(bare, kinds_of.UnionType) else (bare,)


def scene_keys() -> str:
    """Every key of a scene file, table by table."""
    parts = []
    for title, text, keys in scene_sections():
        rows: list[tuple[str, ...]] = []
        groups = [group_title(title, key) for key in keys]
        for before, group, key in zip([None, *groups], groups, keys, strict=False):
            if group != before and any(groups):
                rows.append((f"**{group}**", *[""] * (len(HEADS) - 1)))
            value = key.expected.replace("a number from ", "").replace("a number ", "")
            rows.append((f"`{key.name}`", key.meaning, key.unit, value, key.usual, key.default))
        parts.append(f"## {title}\n\n{text}\n\n{table(HEADS, rows)}")
    return "\n".join(parts)


def group_title(section: str, key: Key) -> str | None:
    """Group in which a key of a body is listed; None for the keys of other tables."""
    if not section.startswith("Body: "):
        return None
    if key.default.startswith("required") and "." not in key.name:
        return "Required"
    return group_of(key.name.partition(".")[0]) or "Keys of this kind"
