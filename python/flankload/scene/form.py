"""The form of the input: plain dictionaries against the tables, one refusal at a time.

Every refusal names the key by its dotted path, what was expected and what was found.
"""

from collections.abc import Mapping, Sequence
from difflib import get_close_matches
from functools import cache
from math import isfinite
from numbers import Integral, Real
from typing import Any, TypeVar

import msgspec
from msgspec import inspect

from flankload.errors import SceneError
from flankload.scene.refusal import shown
from flankload.scene.table import Table

T = TypeVar("T", bound=Table)

LEAD = "lead modifications, which are three-dimensional"
#: Keys that later versions know, and what this one does not do; where they stand, by table. A name
#: that ends in an underscore stands for all that begin so.
NOT_YET = {
    "body": {
        "helix_angle_deg": "helical gears",
        "hand": "helical gears",
        "axial_offset_mm": "axially displaced bodies",
        "face_width_mm": "bodies of different face widths",
        **dict.fromkeys(("lead_", "helix_slope_", "end_relief_", "profile_twist_"), LEAD),
    },
}


def read_table(form: type[T], table: object, key: str) -> T:
    """Read one table.

    Parameters
    ----------
    form : subclass of Table
    table : mapping
        As it comes from TOML or from a user's dictionary.
    key : str
        Dotted path of the table; "" for the file itself.

    Returns
    -------
    instance of `form`

    Raises
    ------
    SceneError
        At the first key that is unknown, missing, of a wrong type or out of range.
    """
    if not isinstance(table, Mapping):
        raise SceneError(key=key or "scene", expected="a table", found=shown(table))
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
        elif field.required:
            raise SceneError(key=path, expected=expected_of(field.type), found="nothing")
    return form(**values)


@cache
def fields_of(form: type[Table]) -> dict[str, inspect.Field]:
    """Fields of a table by their keys."""
    info = inspect.type_info(form)
    assert isinstance(info, inspect.StructType)
    return {field.encode_name: field for field in info.fields}


def _refuse_unknown(name: str, value: object, known: list[str], key: str) -> None:
    path = f"{key}.{name}" if key else name
    later = _later("body" if key.startswith("body_") else key, name)
    if later is not None:
        raise SceneError(
            key=path,
            expected=f"no such key, since this version does not simulate {later}",
            found=shown(value),
        )
    if not known:
        expected = "no such key: this table has none yet"
    elif near := get_close_matches(name, known, n=1, cutoff=0.6):
        expected = f"a known key (did you mean {near[0]}?)"
    else:
        expected = f"a known key ({', '.join(known)})"
    raise SceneError(key=path, expected=expected, found=f"the unknown key '{name}'")


def _later(table: str, name: str) -> str | None:
    """What later versions do with an unknown key; None where it is no key of theirs."""
    for known, does in NOT_YET.get(table, {}).items():
        if name == known or (known.endswith("_") and name.startswith(known)):
            return does
    return None


def _read(kind: inspect.Type, value: Any, key: str) -> Any:
    if hasattr(value, "tolist"):  # NumPy's arrays and scalars are welcome in dictionaries
        value = value.tolist()
    if isinstance(kind, inspect.Metadata):
        return _read(kind.type, value, key)
    if isinstance(kind, inspect.UnionType):
        return _read(_member(kind, value, key), value, key)
    if isinstance(kind, inspect.StructType):
        form: type[Table] = kind.cls  # type: ignore[assignment]
        return read_table(form, value, key)
    if isinstance(kind, inspect.VarTupleType | inspect.TupleType):
        return _read_list(kind, value, key)
    if not _fits(kind, value):
        raise SceneError(key=key, expected=expected_of(kind), found=shown(value))
    if isinstance(kind, inspect.FloatType):
        return float(value)
    return int(value) if isinstance(kind, inspect.IntType) else value


def _member(union: inspect.UnionType, value: Any, key: str) -> inspect.Type:
    """Member of a union that the value means to be: by `kind`, or a list against a single value."""
    members = [member for member in union.types if not isinstance(member, inspect.NoneType)]
    tagged = {
        member.tag: member
        for member in members
        if isinstance(member, inspect.StructType) and member.tag is not None
    }
    if tagged:
        if not isinstance(value, Mapping):
            raise SceneError(key=key, expected="a table", found=shown(value))
        found = value.get("kind")
        if not isinstance(found, str) or found not in tagged:
            raise SceneError(
                key=f"{key}.kind",
                expected=" or ".join(f"'{tag}'" for tag in tagged),
                found="nothing" if "kind" not in value else shown(found),
            )
        return tagged[found]
    if len(members) > 1:
        is_list = isinstance(value, Sequence) and not isinstance(value, str | bytes)
        single = [m for m in members if not isinstance(_bare(m), inspect.VarTupleType)]
        if is_list and len(single) < len(members):
            return next(member for member in members if member not in single)
        for member in single:
            if not is_list and _fits(_bare(member), value):
                return member
        raise SceneError(key=key, expected=expected_of(union), found=shown(value))
    return members[0]


def _bare(kind: inspect.Type) -> inspect.Type:
    """A type without what is said about it."""
    return kind.type if isinstance(kind, inspect.Metadata) else kind


def _read_list(kind: inspect.VarTupleType | inspect.TupleType, value: Any, key: str) -> Any:
    if isinstance(value, str | bytes | Mapping) or not isinstance(value, Sequence):
        raise SceneError(key=key, expected=expected_of(kind), found=shown(value))
    if isinstance(kind, inspect.TupleType):
        items: Sequence[inspect.Type] = kind.item_types
        fits = len(value) == len(items)
    else:
        items = [kind.item_type] * len(value)
        fits = (kind.min_length or 0) <= len(value) <= (kind.max_length or len(value))
    if not fits:
        raise SceneError(key=key, expected=expected_of(kind), found=shown(value))
    return tuple(
        _read(item, part, f"{key}[{i}]")
        for i, (item, part) in enumerate(zip(items, value, strict=True))
    )


def _fits(kind: inspect.Type, value: Any) -> bool:
    if isinstance(kind, inspect.LiteralType):
        return value in kind.values
    if isinstance(kind, inspect.StrType):
        return (
            isinstance(value, str)
            and len(value.strip()) >= (kind.min_length or 0)
            and not any("\ud800" <= letter <= "\udfff" for letter in value)  # halves of letters
        )
    if isinstance(kind, inspect.BoolType):
        return isinstance(value, bool)
    # TOML has true and false for that: bool is no number here, though Python says it is.
    number = Integral if isinstance(kind, inspect.IntType) else Real
    if isinstance(value, bool) or not isinstance(value, number) or not _is_finite(value):
        return False
    assert isinstance(kind, inspect.IntType | inspect.FloatType)
    value = float(value)
    return (
        (kind.ge is None or value >= kind.ge)
        and (kind.gt is None or value > kind.gt)
        and (kind.le is None or value <= kind.le)
        and (kind.lt is None or value < kind.lt)
    )


def _is_finite(value: Any) -> bool:
    try:
        return isfinite(value)
    except OverflowError:  # an integer beyond the range of floats
        return False


def expected_of(kind: inspect.Type) -> str:
    """What a key takes, in words."""
    if isinstance(kind, inspect.Metadata):
        return expected_of(kind.type)
    if isinstance(kind, inspect.UnionType):
        members = [member for member in kind.types if not isinstance(member, inspect.NoneType)]
        return " or ".join(dict.fromkeys(expected_of(member) for member in members))
    if isinstance(kind, inspect.LiteralType):
        return " or ".join(f"'{value}'" for value in kind.values)
    if isinstance(kind, inspect.BoolType):
        return "true or false"
    if isinstance(kind, inspect.TupleType):
        return f"a list of {len(kind.item_types)} {_plural(kind.item_types[0])}"
    if isinstance(kind, inspect.VarTupleType):
        item = kind.item_type
        if kind.max_length is not None and kind.max_length == kind.min_length:
            return f"a list of {kind.min_length} {_plural(item)}"
        of = (
            f"lists of {len(item.item_types)} numbers"
            if isinstance(item, inspect.TupleType)
            else _plural(item)
        )
        return f"a {'non-empty ' if kind.min_length else ''}list of {of}"
    if isinstance(kind, inspect.StrType | inspect.IntType | inspect.FloatType):
        noun, bounds = _noun(kind)
        return ("an " if noun[0] in "aeiou" else "a ") + noun + bounds
    return "a table"


def _noun(kind: inspect.Type) -> tuple[str, str]:
    """Name of a plain type, and its range."""
    if isinstance(kind, inspect.Metadata):
        return _noun(kind.type)
    if isinstance(kind, inspect.IntType | inspect.FloatType):
        return "integer" if isinstance(kind, inspect.IntType) else "number", _range_of(kind)
    assert isinstance(kind, inspect.StrType)
    return "non-empty string" if kind.min_length else "string", ""


def _plural(kind: inspect.Type) -> str:
    if isinstance(kind, inspect.UnionType):
        return " or ".join(_plural(member) for member in kind.types)
    if isinstance(kind, inspect.VarTupleType):
        return f"lists of {kind.min_length} {_plural(kind.item_type)}"
    noun, bounds = _noun(kind)
    return f"{noun}s{bounds}"


def _range_of(kind: inspect.IntType | inspect.FloatType) -> str:
    if kind.ge is not None and kind.le is not None:
        return f" from {kind.ge:g} to {kind.le:g}"
    parts = [
        f"{sign} {bound:g}"
        for sign, bound in ((">=", kind.ge), (">", kind.gt), ("<=", kind.le), ("<", kind.lt))
        if bound is not None
    ]
    return " " + " and ".join(parts) if parts else ""


def json_schema(form: type[Table]) -> dict[str, Any]:
    """JSON schema of a table; what TOML cannot write (null) is left out."""
    schema = msgspec.json.schema(form)
    cleaned = _without_null(schema)
    assert isinstance(cleaned, dict)
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **cleaned}


def _without_null(node: Any) -> Any:
    if isinstance(node, list | tuple):
        return [_without_null(item) for item in node]
    if not isinstance(node, dict):
        return node
    node = {key: _without_null(value) for key, value in node.items()}
    if isinstance(node.get("anyOf"), list):
        options = [option for option in node.pop("anyOf") if option != {"type": "null"}]
        node |= options[0] if len(options) == 1 else {"anyOf": options}
    if isinstance(node.get("default"), dict):
        node["default"] = {k: v for k, v in node["default"].items() if v is not None}
    return {k: v for k, v in node.items() if not (k == "default" and v is None)}
