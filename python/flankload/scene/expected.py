"""The value that a key expects, in words, from its annotation."""

from msgspec import inspect


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
