"""JSON schema of a scene file, and paths of its keys with their units and meanings."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from typing import Any, NamedTuple

import msgspec
from msgspec import inspect

from flankload.scene.expected import expected_of
from flankload.scene.form import types_of
from flankload.scene.scene import SceneFile
from flankload.scene.table import Table


def scene_schema() -> dict[str, Any]:
    """JSON schema of a scene file, with unit and meaning of each key.

    Returns
    -------
    dict
        JSON Schema, draft 2020-12; each number has the keyword `unit`.
    """
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        **_without_null(msgspec.json.schema(SceneFile)),
        "title": "flankload scene",
    }


class KeyPath(NamedTuple):
    """A key of a scene by its path, as `Scene.replace` takes it.

    Attributes
    ----------
    path : str
        "body_1.tip_relief_um".
    unit : str
        "" for words.
    expected : str
        Type and range.
    meaning : str
    kinds : str
        Kinds of body that have the key; "" outside the tables of bodies.
    """

    path: str
    unit: str
    expected: str
    meaning: str
    kinds: str


@cache
def scene_paths() -> tuple[KeyPath, ...]:
    """Paths of all keys of a scene.

    Returns
    -------
    tuple of KeyPath
        A key whose range or meaning differs between kinds of body has an entry for each.
    """
    kinds: dict[KeyPath, list[str]] = {}
    for found in _paths_of(SceneFile, "", ""):
        kinds.setdefault(found._replace(kinds=""), []).append(found.kinds)
    return tuple(path._replace(kinds=", ".join(filter(None, of))) for path, of in kinds.items())


def _paths_of(form: type[Table], before: str, kind: str) -> Iterator[KeyPath]:
    """Paths of the keys of a table and of the tables in it."""
    for name, whole in types_of(form).items():
        bare = whole
        extra: dict[str, Any] = {}
        if isinstance(bare, inspect.Metadata):
            extra, bare = bare.extra_json_schema or {}, bare.type
        members = bare.types if isinstance(bare, inspect.UnionType) else (bare,)
        tables = [part for part in members if isinstance(part, inspect.StructType)]
        path = f"{before}{name}"
        if tags := [f"'{table.tag}'" for table in tables if table.tag]:
            meaning = f"kind of body: {extra.get('description', '')}"
            yield KeyPath(f"{path}.kind", "", " or ".join(tags), meaning, kind)
        for table in tables:
            assert issubclass(table.cls, Table)
            yield from _paths_of(table.cls, f"{path}.", str(table.tag or kind))
        if not tables:
            meaning = str(extra.get("description", ""))
            unit = str(extra.get("unit", ""))
            yield KeyPath(path, unit, expected_of(whole), meaning, kind)


def _without_null(node: Any) -> Any:
    """Remove null, which TOML lacks, from a schema."""
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
