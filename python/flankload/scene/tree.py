"""Scenes as plain dictionaries and as TOML text, and changes of keys by path."""

from __future__ import annotations

import copy
import json
import re
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from msgspec import NODEFAULT

from flankload.scene.catalogue import keys_of_names
from flankload.scene.form import fields_of
from flankload.scene.refusal import refuse, shown
from flankload.scene.table import BODIES, SEVERAL_MESHES, Table

if TYPE_CHECKING:
    from flankload.scene.scene import Scene

Tree = dict[str, Any]

#: Part of a path: a key with the indices of entries of its list.
PART = re.compile(r"([A-Za-z_]\w*)((?:\[\d+\])*)")


def tree_of(table: Table, named: frozenset[str] = frozenset()) -> Tree:
    """Keys of a table that differ from their defaults, and those in `named`.

    Tuples become lists; keys without a value are left out.
    """
    tag = table.__struct_config__.tag_field
    tree: Tree = {} if tag is None else {tag: table.__struct_config__.tag}
    for name, field in fields_of(type(table)).items():
        value = getattr(table, name)
        value = value.tolist() if hasattr(value, "tolist") else value  # an array in a typed table
        is_default = field.default is not NODEFAULT and value == field.default
        if value is not None and (not is_default or name in named):
            tree[name] = _plain(value)
    return tree


def scene_tree(scene: Scene, *, implied: bool) -> Tree:
    """Keys of a scene; tables without keys are left out.

    `implied`: includes keys of [positions] and [effects] that the scene does not set and that the
    reader derived from others.
    """
    from flankload.scene.scene import NO_PAIR

    tree: Tree = {"name": scene.name}
    for name in (*BODIES, *SEVERAL_MESHES):
        if (table := getattr(scene, name)) is not None:
            tree[name] = tree_of(table)
    for name, keys in keys_of_names(tree).items():
        tree[name] = _beside_catalogue(tree[name], getattr(scene, name), keys)
    if not (scene.is_drive and scene.pair == NO_PAIR):
        tree["pair"] = tree_of(scene.pair)
    tree["load"] = tree_of(scene.load)
    set_keys = scene.named_discretization_keys.union(
        f"effects.{key}" for key in scene.named_effects
    )
    for name in ("positions", "effects", "accuracy"):
        named = {key.partition(".")[2] for key in set_keys if key.startswith(f"{name}.")}
        found = tree_of(getattr(scene, name), frozenset(named))
        tree[name] = {key: x for key, x in found.items() if implied or key in named}
    for path in scene.derived:
        place, _, key = path.rpartition(".")
        table = tree
        for part in place.split("."):
            table = table.get(part, {})
        table.pop(key, None)
    return {name: part for name, part in tree.items() if part != {}}


def _beside_catalogue(tree: Tree, table: Table, keys: Mapping[str, Any]) -> Tree:
    """Keys of a body without those that follow from its names with the same value."""
    own = {key: getattr(table, key) for key in keys if key in fields_of(type(table))}
    rest = {key: value for key, value in tree.items() if key not in own}
    return rest | {key: _plain(value) for key, value in own.items() if value != keys[key]}


def with_changes(tree: Tree, changes: Mapping[str, Any]) -> Tree:
    """A copy of the keys of a scene with changes of single keys.

    Parameters
    ----------
    tree : dict
        As in a scene file.
    changes : mapping of str to object
        By path, as "body_1.tip_relief_um" or "body_1.pitch_errors_um[3]": the new value, a whole
        table or list included; None removes the key. An absent list with an entry per planet has
        zeros.

    Returns
    -------
    dict
        Unknown keys are not refused here, but by the reader.

    Raises
    ------
    SceneError
        If a path is malformed or leads to an entry that does not exist.
    """
    if not isinstance(changes, Mapping):
        refuse("changes", "a mapping of paths to values", shown(changes))
    tree = copy.deepcopy(tree)
    for path, value in changes.items():
        _change(tree, _steps_of(path), path, value)
    return tree


def number_at(scene: Scene, path: str) -> float:
    """Number at a path, defaults included; an absent deviation in um is 0.

    Raises
    ------
    SceneError
        If the path is malformed, or leads to no number.
    """
    place: Any = scene
    inside = False
    for step in _steps_of(path):
        if isinstance(step, int):
            if place == () and path.startswith("stage.") and scene.stage is not None:
                place = (0.0,) * scene.stage.count
            inside = isinstance(place, tuple) and step < len(place)
            place = place[step] if inside else None
        else:
            inside = isinstance(place, Table | type(scene)) and hasattr(place, step)
            place = getattr(place, step) if inside else None
    if place is None and inside and path.endswith("_um"):
        return 0.0
    if isinstance(place, bool) or not isinstance(place, int | float):
        refuse(path, "a key with a number", None if place is None else shown(place))
    return float(place)


def toml_of(tree: Tree) -> str:
    """Text of a scene file; each number has the digits that identify it."""
    return "\n".join(_lines_of(tree, "")) + "\n"


def _lines_of(tree: Tree, path: str) -> list[str]:
    """Lines of a table: its keys, then the tables in it."""
    own = {key: value for key, value in tree.items() if not isinstance(value, dict)}
    lines = [f"[{path}]"] if path and (own or not tree) else []
    lines += [f"{key} = {_toml_value(value)}" for key, value in own.items()]
    for key, value in tree.items():
        if isinstance(value, dict):
            inner = _lines_of(value, f"{path}.{key}" if path else key)
            lines += ["", *inner] if lines else inner
    return lines


def _toml_value(value: Any) -> str:
    """A value in TOML, whose strings are those of JSON except for DEL."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, list):
        return f"[{', '.join(_toml_value(part) for part in value)}]"
    return repr(value)


def _steps_of(path: object) -> list[str | int]:
    """Keys and indices of a path, in their order."""
    parts = path.split(".") if isinstance(path, str) else []
    found = [PART.fullmatch(part) for part in parts]
    steps: list[str | int] = []
    for match in found:
        if match is None:
            break
        steps += [match[1], *(int(index) for index in re.findall(r"\d+", match[2]))]
    if not found or None in found:
        expected = "a path such as body_1.tip_relief_um or body_1.pitch_errors_um[3]"
        refuse(path if isinstance(path, str) else "changes", expected, shown(path))
    return steps


def _change(tree: Tree, steps: list[str | int], path: str, value: Any) -> None:
    """Set or remove the key at a path."""
    place: Any = tree
    for n, step in enumerate(steps):
        here = _text_of(steps[:n])
        if isinstance(step, int):
            if not isinstance(place, list) or not place:
                refuse(path, "an entry of a list", shown(place) if place else None)
            if step >= len(place):
                refuse(path, f"an entry up to {here}[{len(place) - 1}]", None)
        elif not isinstance(place, dict):
            refuse(here, "a table", shown(place))
        if n + 1 < len(steps):
            if isinstance(step, str) and step not in place:
                place[step] = _zeros(place) if isinstance(steps[n + 1], int) else {}
            place = place[step]
        elif value is None:
            if isinstance(step, int) or step in place:
                del place[step]
        else:
            place[step] = copy.deepcopy(value)


def _zeros(stage: Tree) -> list[float]:
    """A list with an entry per planet of a stage; empty for other tables."""
    angles, planets = stage.get("angles_deg"), stage.get("planets")
    count = len(angles) if isinstance(angles, list) else planets
    return [0.0] * count if isinstance(count, int) else []


def _text_of(steps: list[str | int]) -> str:
    """Path of keys and indices."""
    text = "".join(f"[{step}]" if isinstance(step, int) else f".{step}" for step in steps)
    return text.lstrip(".")


def _plain(value: Any) -> Any:
    """Tables as dictionaries, tuples as lists."""
    if isinstance(value, Table):
        return tree_of(value)
    if isinstance(value, tuple):
        return [_plain(part) for part in value]
    return value
