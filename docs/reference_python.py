"""Public names of the package with their documentation, for docs/reference/python_api.md."""

from __future__ import annotations

import inspect
import re
import textwrap
from collections.abc import Iterator
from typing import Any

from msgspec import UNSET
from reference_markdown import table

import flankload as fl
from flankload.scene.table import BodyTable, Table
from flankload.scene.typed_pairs import AsScene

#: Sections of a docstring whose entries are names; the others are text.
OF_ENTRIES = ("Parameters", "Attributes", "Returns", "Yields", "Raises")
#: Longest line of a signature.
LINE = 88
SECTION = re.compile(r"^(\w[\w ]*)\n-{3,}\n", re.MULTILINE)
#: Tables of a scene that a class describes under another name.
SECTION_OF_TABLE = {"Positions": "positions", "Effects": "effects", "Accuracy": "accuracy"}


def public_names() -> dict[str, list[str]]:
    """Public names of the package by their kind."""
    found: dict[str, list[str]] = {"Functions": [], "Classes": [], "Exceptions": []}
    for name in fl.__all__:
        value = getattr(fl, name)
        if inspect.isclass(value):
            found["Exceptions" if issubclass(value, BaseException) else "Classes"].append(name)
        elif callable(value):
            found["Functions"].append(name)
    return found


def python_api() -> str:
    """Every public name with its documentation."""
    parts = []
    for title, names in public_names().items():
        parts.append(f"## {title}\n")
        for name in names:
            value = getattr(fl, name)
            text = class_text(name, value) if inspect.isclass(value) else function_text(value)
            parts.append(f"### {name}\n\n{text}")
    return "\n".join(parts)


def function_text(function: Any) -> str:
    """Signature and documentation of a function."""
    return f"```python\n{signature(function)}\n```\n\n{markdown_of(function.__doc__)}"


def class_text(name: str, form: type) -> str:
    """Documentation of a class, of its properties and of its methods."""
    parts = []
    if issubclass(form, AsScene):
        parts.append(f"```python\n{signature(form)}\n```\n")
    if issubclass(form, BaseException):
        bases = ", ".join(f"`{base.__name__}`" for base in form.__bases__)
        parts.append(f"Base class: {bases}.\n")
    parts.append(markdown_of(form.__doc__))
    if issubclass(form, Table) and not issubclass(form, AsScene):
        return "\n".join([*parts, keys_text(name, form)])
    members = dict(members_of(form))
    rows = [
        (f"`{key}`", " ".join(SECTION.split(inspect.cleandoc(str(doc)))[0].split()))
        for key, value in members.items()
        if (doc := documentation_of_property(value))
    ]
    parts += [table(("property", "meaning"), rows)] if rows else []
    for key, value in members.items():
        if documentation_of_property(value) is None:
            function = getattr(value, "__func__", value)
            parts.append(f"#### {name}.{key}\n\n{function_text(function)}")
    return "\n".join(parts)


def keys_text(name: str, form: type[Table]) -> str:
    """Where the keys of a table are described."""
    if issubclass(form, BodyTable):
        kind = str(form.__struct_config__.tag)
        place = f"[Body: {kind}](scene_keys.md#body-{kind})"
    elif name in SECTION_OF_TABLE:
        section = SECTION_OF_TABLE[name]
        place = f"[\\[{section}\\]](scene_keys.md#{section})"
    else:
        place = f"`{name.lower()}` of a body, in [scene keys](scene_keys.md)"
    return f"Keyword arguments: the keys of {place}.\n"


def members_of(form: type) -> Iterator[tuple[str, Any]]:
    """Documented public methods and properties of a class and of its bases in the package."""
    seen = set()
    for base in form.__mro__:
        if not base.__module__.startswith("flankload") or issubclass(base, Table):
            continue
        for name, value in vars(base).items():
            if name.startswith("_") or name in seen:
                continue
            function = getattr(value, "__func__", value)
            is_method = inspect.isfunction(function) and function.__doc__
            if is_method or documentation_of_property(value):
                seen.add(name)
                yield name, value


def documentation_of_property(value: Any) -> str | None:
    """Documentation of a property; None for a method."""
    function = getattr(value, "fget", getattr(value, "func", None))
    return getattr(function, "__doc__", None)


def signature(function: Any) -> str:
    """Name and arguments with their defaults; types are in the documentation."""
    found = inspect.signature(function)
    bare = [
        argument.replace(
            annotation=inspect.Parameter.empty,
            # of a key that follows from others; None is the same
            default=None if argument.default is UNSET else argument.default,
        )
        for argument in found.parameters.values()
        if argument.name not in ("self", "cls")
    ]
    text = f"{function.__name__}{inspect.Signature(bare)}"
    if len(text) <= LINE:
        return text
    return "\n".join(textwrap.wrap(text, LINE, subsequent_indent="    "))


def markdown_of(docstring: str | None) -> str:
    """A docstring in Markdown: sections in bold, their entries as a list."""
    assert docstring, "a public name without documentation"
    first, *rest = SECTION.split(inspect.cleandoc(docstring))
    parts = [first.strip() + "\n"]
    for title, text in zip(rest[::2], rest[1::2], strict=True):
        body = entries_of(text) if title in OF_ENTRIES else examples_of(text)
        parts.append(f"**{title}**\n\n{body}")
    return "\n".join(parts)


def entries_of(text: str) -> str:
    """Entries "name : type", each with indented text below, as a list."""
    lines = []
    for entry in filter(str.strip, re.split(r"^(?=\S)", text, flags=re.MULTILINE)):
        head, *body = entry.strip().splitlines()
        names, _, kind = head.partition(" : ")
        shown = ", ".join(f"`{name}`" for name in names.split(", "))
        said = " ".join(" ".join(body).split())
        kind = f" ({kind})" if kind else ""
        lines.append(f"* {shown}{kind}{': ' if said else ''}{said}")
    return "\n".join(lines) + "\n"


def examples_of(text: str) -> str:
    """Text, with interactive sessions as code."""
    text = text.strip() + "\n"
    return f"```pycon\n{text}```\n" if text.startswith(">>>") else text
