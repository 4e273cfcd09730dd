"""JSON schema of a scene file, with unit and meaning of each key."""

from __future__ import annotations

from typing import Any

import msgspec

from flankload.scene.scene_file import SceneFile


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


def _without_null(node: Any) -> Any:
    """Remove null from a schema, since TOML has no null."""
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
