"""Conversion of plain dictionaries to tables by msgspec; the first faulty key is refused."""

from collections.abc import Mapping, Sequence
from difflib import get_close_matches
from fractions import Fraction
from functools import cache
from math import inf
from types import UnionType
from typing import Annotated, Any, NoReturn, TypeVar, Union, get_args, get_origin

import msgspec
from msgspec import inspect, structs
from msgspec.structs import FieldInfo

from flankload.scene.groups import in_groups
from flankload.scene.refusal import refuse, shown
from flankload.scene.table import BY_NAME, Table

T = TypeVar("T", bound=Table)

LEAD = "lead modifications, which are three-dimensional"
#: Keys of some kinds of body, with the feature that the others lack. A name that ends in an
#: underscore matches all keys that begin with it.
OF_SOME_BODIES = {
    "helix_angle_deg": "helical gears",
    "hand": "helical gears",
    "axial_offset_mm": "axially displaced bodies",
    "face_width_mm": "bodies of different face widths",
    **dict.fromkeys(("lead_", "helix_slope_", "tooth_helix_slope_", "end_relief_"), LEAD),
    "profile_twist_": "profile twist, which varies with height and width of the flank",
    "topography_": "measured topographies",
    "shaft": "shafts of these bodies",
    **dict.fromkeys(("web_", "rim_thickness_", "hub_"), "webs and hubs of these bodies"),
    "region_": "regions of other width in these bodies",
}


def read_table(form: type[T], table: object, key: str) -> T:
    """Convert one table, a mapping from TOML or from a user's dictionary.

    `key` is the dotted path of the table; "" for the whole file.

    Raises
    ------
    SceneError
        At the first key that is unknown, missing (with all other missing keys of the table), of a
        wrong type or out of range.
    """
    if not isinstance(table, Mapping):
        refuse(key or "scene", "a table", shown(table))
    fields = fields_of(form)
    tag = form.__struct_config__.tag_field
    for name in table:
        if name not in fields and name != tag:
            _refuse_unknown(str(name), table[name], [*fields, *([tag] if tag else [])], key)
    values = {}
    for name, field in fields.items():
        path = f"{key}.{name}" if key else name
        if name in table:
            values[name] = _read(field.type, table[name], path)
        elif is_required(field):
            more = [
                other for other in required_of(form) if key and other not in table and other != name
            ]
            expected = expected_of(inspect.type_info(field.type))
            also = f" (also missing: {', '.join(more)})" if more else ""
            refuse(path, expected + also, "nothing")
    return form(**values)


@cache
def fields_of(form: type[Table]) -> dict[str, FieldInfo]:
    """Fields of a table with their annotations, by key; those of a body group by group."""
    fields = {field.encode_name: field for field in structs.fields(form)}
    return in_groups(fields) if form.grouped else fields


def is_required(field: FieldInfo) -> bool:
    """Whether a key is required, in the file or from a name (module `catalogue`)."""
    return field.required or field.default is BY_NAME


def check_key(form: type[Table], name: str, value: object, path: str) -> None:
    """Refuse a value of a wrong type or out of the range of its key."""
    _read(fields_of(form)[name].type, value, path)


@cache
def required_of(form: type[Table]) -> tuple[str, ...]:
    """Keys of a table that have no default."""
    return tuple(name for name, field in fields_of(form).items() if is_required(field))


@cache
def types_of(form: type[Table]) -> dict[str, inspect.Type]:
    """Types of the fields with all tables below them, by key; slow, for texts only."""
    info = inspect.type_info(form)
    assert isinstance(info, inspect.StructType)
    types = {field.encode_name: field.type for field in info.fields}
    return {name: types[name] for name in fields_of(form)}


def _refuse_unknown(name: str, value: object, known: list[str], key: str) -> NoReturn:
    path = f"{key}.{name}" if key else name
    for begin, feature in OF_SOME_BODIES.items() if key.startswith("body_") else ():
        if any(other.startswith(begin) for other in known):
            continue  # this kind of body has the feature
        if name == begin or (begin.endswith("_") and name.startswith(begin)):
            expected = f"no such key, since this version does not simulate {feature}"
            refuse(path, expected, shown(value))
    near = get_close_matches(name, known, n=1, cutoff=0.6)
    expected = f"did you mean {near[0]}?" if near else ", ".join(known)
    refuse(path, f"a known key ({expected})", f"the unknown key '{name}'")


def _read(kind: Any, value: Any, key: str) -> Any:
    """Convert a value or a table to its annotated type."""
    value = _plain(value)
    forms = [form for form in _members(kind) if isinstance(form, type) and issubclass(form, Table)]
    if forms:
        return read_table(_form_of(forms, value, key), value, key)
    if not _fits(kind, value):
        _refuse_value(kind, value, key)
    return msgspec.convert(value, kind)


def _members(kind: Any) -> list[Any]:
    """Members of a union, or the type itself; without None and without metadata."""
    while get_origin(kind) is Annotated:
        kind = get_args(kind)[0]
    members = get_args(kind) if get_origin(kind) in (Union, UnionType) else (kind,)
    return [member for member in members if member is not type(None)]


def _form_of(forms: list[type[Table]], value: Any, key: str) -> type[Table]:
    """The type of table for the `kind` of a value."""
    tagged = {form.__struct_config__.tag: form for form in forms if form.__struct_config__.tag}
    if not tagged:
        return forms[0]
    if not isinstance(value, Mapping):
        refuse(key, "a table", shown(value))
    kind = value.get("kind")
    if not isinstance(kind, str) or kind not in tagged:
        found = "nothing" if "kind" not in value else shown(kind)
        refuse(f"{key}.kind", " or ".join(f"'{tag}'" for tag in tagged), found)
    return tagged[kind]


def _plain(value: Any) -> Any:
    """Plain Python values for msgspec; NumPy arrays and numbers are accepted in dictionaries."""
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, str | bytes):
        return value
    if isinstance(value, Sequence):
        return [_plain(part) for part in value]
    return float(value) if isinstance(value, Fraction) else value


def _fits(kind: Any, value: Any) -> bool:
    if _is_invalid(value):
        return False
    try:
        msgspec.convert(value, kind)
    except msgspec.ValidationError:
        return False
    return True


def _is_invalid(value: Any) -> bool:
    """Whether a value has another type, is NaN, infinite or blank, or has a letter of no text."""
    if isinstance(value, list):
        return any(_is_invalid(part) for part in value)
    if isinstance(value, str):
        return not value.strip() or any(map(_is_no_letter, value))
    return not isinstance(value, int | float) or value != value or value in (inf, -inf)


def _is_no_letter(letter: str) -> bool:
    """Whether a letter is NUL, which ends names of files, or half of a letter."""
    return letter == "\0" or "\ud800" <= letter <= "\udfff"


def _refuse_value(kind: Any, value: Any, key: str) -> NoReturn:
    """Refuse a value, or the first invalid entry of a list."""
    for member in _members(kind) if isinstance(value, list) else ():
        (bare,) = _members(member)
        if get_origin(bare) is tuple:
            kind, items = member, get_args(bare)
            items = items[:1] * len(value) if items[-1] is Ellipsis else items
            count = getattr(inspect.type_info(member), "max_length", None)  # of a fixed length
            for i, (item, part) in enumerate(zip(items, value, strict=False)):
                if len(value) == (count or len(items)) and not _fits(item, part):
                    _refuse_value(item, part, f"{key}[{i}]")
    found = shown(value)
    if isinstance(value, str) and (no_letter := next(filter(_is_no_letter, value), None)):
        found = f"one with the letter U+{ord(no_letter):04X}"
    refuse(key, expected_of(inspect.type_info(kind)), found)


def expected_of(kind: inspect.Type, *, several: bool = False) -> str:
    """Expected value of a key in words; several: in the plural, for entries of a list."""
    if isinstance(kind, inspect.Metadata):
        return expected_of(kind.type, several=several)
    if isinstance(kind, inspect.UnionType):
        members = [member for member in kind.types if not isinstance(member, inspect.NoneType)]
        return " or ".join(dict.fromkeys(expected_of(m, several=several) for m in members))
    if isinstance(kind, inspect.LiteralType):
        return " or ".join(f"'{value}'" for value in kind.values)
    if isinstance(kind, inspect.BoolType):
        return "true or false"
    if isinstance(kind, inspect.TupleType):
        count, entries = len(kind.item_types), expected_of(kind.item_types[0], several=True)
        return f"lists of {count} numbers" if several else f"a list of {count} {entries}"
    if isinstance(kind, inspect.VarTupleType):
        entries = expected_of(kind.item_type, several=True)
        if kind.max_length is not None:  # of a fixed length
            entries, some = f"{kind.min_length} {entries}", ""
        else:
            some = "non-empty " if kind.min_length else ""
        return f"lists of {entries}" if several else f"a {some}list of {entries}"
    if isinstance(kind, inspect.IntType | inspect.FloatType):
        noun, bounds = "number" if isinstance(kind, inspect.FloatType) else "integer", _range(kind)
    elif isinstance(kind, inspect.StrType):
        noun, bounds = "non-empty string", ""
    else:
        return "a table"
    article = "an" if noun == "integer" else "a"
    return f"{noun}s{bounds}" if several else f"{article} {noun}{bounds}"


def _range(kind: inspect.IntType | inspect.FloatType) -> str:
    if kind.ge is not None and kind.le is not None:
        return f" from {kind.ge:g} to {kind.le:g}"
    signs = {">=": kind.ge, ">": kind.gt, "<=": kind.le, "<": kind.lt}
    parts = [f"{sign} {bound:g}" for sign, bound in signs.items() if bound is not None]
    return " " + " and ".join(parts) if parts else ""
