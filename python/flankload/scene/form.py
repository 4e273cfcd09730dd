"""Conversion of plain dictionaries to tables by msgspec; the first faulty key is refused."""

from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from functools import cache
from math import inf
from types import MappingProxyType, UnionType
from typing import Annotated, Any, NamedTuple, NoReturn, TypeVar, Union, get_args, get_origin

import msgspec
from msgspec import inspect, structs
from msgspec.structs import FieldInfo

from flankload.scene.expected import expected_of
from flankload.scene.groups import in_groups
from flankload.scene.refusal import refuse, shown
from flankload.scene.table import BODIES, BY_NAME, Table

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
    """Convert one table with the tables in it, a mapping from TOML or from a user's dictionary.

    `key` is the dotted path of the table; "" for the whole file.

    Raises
    ------
    SceneError
        At the first unknown key; without one, at the first missing key, with all other missing
        ones; without one, at the first key of a wrong type or out of range.
    """
    members = list(_members_of(form, table, key))
    for member in members:
        _check_known(member)
        _check_alternatives(member)
    missing = {path: kind for member in members for path, kind in _missing(member)}
    for path, kind in missing.items():
        place = path.rpartition(".")[0]
        more = [other.removeprefix(f"{place}.") for other in missing if other != path]
        also = f" (also missing: {', '.join(more)})" if more else ""
        refuse(path, kind + also, None)
    return _converted(form, table, key)


def _converted(form: type[T], table: object, key: str) -> T:
    """Convert a table whose keys are known and complete."""
    if not isinstance(table, Mapping):
        refuse(key or "scene", "a table", shown(table))
    fields = fields_of(form)
    return form(**{x: _read(fields[x].type, table[x], _path(key, x)) for x in fields if x in table})


def _path(key: str, name: str) -> str:
    return f"{key}.{name}" if key else name


class _Member(NamedTuple):
    """A table of a file.

    Attributes
    ----------
    forms : tuple of Table types
        Those between which the key `kind` chooses, or the only one.
    form : Table type or None
        None if there is no known kind.
    by_others : mapping of str to tuple of str
        Its keys that follow from other tables, with the missing keys of these.
    """

    forms: tuple[type[Table], ...]
    form: type[Table] | None
    given: Mapping[str, Any]
    key: str
    by_others: Mapping[str, tuple[str, ...]] = MappingProxyType({})


def _members_of(form: type[Table], table: object, key: str) -> Iterator[_Member]:
    """A table and all tables in it; required ones that are absent are empty."""
    if not isinstance(table, Mapping):
        return
    yield _Member((form,), form, table, key)
    by_others = form.given_by_others(table)
    for name, forms in _tables_in(form).items():
        absent: dict[str, Any] | None = {} if name in _required_in(form, table) else None
        value = table.get(name, absent)
        if not isinstance(value, Mapping):
            continue
        chosen = [one for one in forms if one.__struct_config__.tag in (None, value.get("kind"))]
        if chosen:
            inner = list(_members_of(chosen[0], value, _path(key, name)))
            own = {path.removeprefix(f"{name}."): keys for path, keys in by_others.items()}
            yield inner[0]._replace(forms=forms, by_others=own)
            yield from inner[1:]
        else:
            yield _Member(forms, None, value, _path(key, name))


def _check_known(member: _Member) -> None:
    """Refuse the first unknown key of a table; if another kind fits all keys, refuse the kind."""
    if member.form is None:
        return
    known, given = _known(member.form), member.given
    for name, value in given.items():
        if name in known:
            continue
        for other in member.forms if not _is_complete(member.form, given) else ():
            if _is_complete(other, given) and set(given) <= set(_known(other)):
                expected = f"'{other.__struct_config__.tag}', which has all keys of this table"
                kind = member.form.__struct_config__.tag
                refuse(f"{member.key}.kind", expected, f"'{kind}', which has no {name}")
        _refuse_unknown(str(name), value, known, member.key)


def _is_complete(form: type[Table], given: Mapping[str, Any]) -> bool:
    return set(_required_in(form, given)) <= set(given)


def _check_alternatives(member: _Member) -> None:
    """Refuse a key beside another one that gives the same."""
    for name, others in member.form.instead_of.items() if member.form else ():
        named = [other for other in (name, *others) if other in member.given]
        if len(named) > 1:
            path = _path(member.key, named[1])
            expected = f"nothing beside {_path(member.key, named[0])}: one of the two"
            refuse(path, expected, shown(member.given[named[1]]))


def _known(form: type[Table]) -> list[str]:
    """Keys of a table, `kind` included."""
    tag = form.__struct_config__.tag_field
    return [*fields_of(form), *([tag] if tag else [])]


def _missing(member: _Member) -> Iterator[tuple[str, str]]:
    """Path and expected value of the missing keys of a table, but for tables of one form in it."""
    form, given, key = member.form, member.given, member.key
    if form is None:
        tags = [str(other.__struct_config__.tag) for other in member.forms]
        if "kind" not in given:
            yield f"{key}.kind", " or ".join(f"'{tag}'" for tag in tags)
        return
    for name in _required_in(form, given):
        kind = fields_of(form)[name].type
        others = member.by_others.get(name)
        if name not in given and name not in _tables_in(form) and others != ():
            expected = expected_of(inspect.type_info(kind))
            also = (*form.instead_of.get(name, ()), *(others or ()))
            yield _path(key, name), " or ".join((expected, *also))


def _required_in(form: type[Table], given: Mapping[str, Any]) -> tuple[str, ...]:
    """Required keys of a table that has the given ones."""
    required = required_of(form)
    if form.instead_of:
        others = form.instead_of
        required = tuple(x for x in required if not any(y in given for y in others.get(x, ())))
    return required + form.also_required(given)


@cache
def _tables_in(form: type[Table]) -> dict[str, tuple[type[Table], ...]]:
    """Forms of the tables that the values of some keys of a table can be, by key."""
    forms = {name: _tables_of(field.type) for name, field in fields_of(form).items()}
    return {name: some for name, some in forms.items() if some}


def _tables_of(kind: Any) -> tuple[type[Table], ...]:
    """Forms of the tables that a value can be."""
    members = _members(kind)
    return tuple(part for part in members if isinstance(part, type) and issubclass(part, Table))


@cache
def fields_of(form: type[Table]) -> dict[str, FieldInfo]:
    """Fields of a table with their annotations, by key; those of a body group by group."""
    fields = {field.encode_name: field for field in structs.fields(form)}
    return in_groups(fields) if form.grouped else fields


def is_required(field: FieldInfo) -> bool:
    """Whether a key is required, in the file, from a name (module `catalogue`) or from others."""
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
    for begin, feature in OF_SOME_BODIES.items() if key.startswith(BODIES) else ():
        if any(other.startswith(begin) for other in known):
            continue  # this kind of body has the feature
        if name == begin or (begin.endswith("_") and name.startswith(begin)):
            expected = f"no such key, since this version does not simulate {feature}"
            refuse(path, expected, shown(value))
    from difflib import get_close_matches

    near = get_close_matches(name, known, n=1, cutoff=0.6)
    expected = f"did you mean {near[0]}?" if near else ", ".join(known)
    refuse(path, f"a known key ({expected})", f"the unknown key '{name}'")


def _read(kind: Any, value: Any, key: str) -> Any:
    """Convert a value or a table to its annotated type."""
    value = _plain(value)
    if forms := _tables_of(kind):
        return _converted(_form_of(forms, value, key), value, key)
    if not _fits(kind, value):
        _refuse_value(kind, value, key)
    return msgspec.convert(value, kind)


def _members(kind: Any) -> list[Any]:
    """Members of a union, or the type itself; without None and without metadata."""
    while get_origin(kind) is Annotated:
        kind = get_args(kind)[0]
    members = get_args(kind) if get_origin(kind) in (Union, UnionType) else (kind,)
    return [member for member in members if member is not type(None)]


def _form_of(forms: tuple[type[Table], ...], value: Any, key: str) -> type[Table]:
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
