"""A REXS model in JSON: an object `model` with `relations`, `components` and `load_spectrum`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from flankload.exchange.rexs.form import Form
from flankload.exchange.rexs.model import Attribute, Component, Model, Relation, Value

if TYPE_CHECKING:
    from pathlib import Path

#: Names under which an attribute has a value that a scene may need.
SCALARS = ("floating_point", "integer", "boolean", "enum", "string", "reference_component")
ARRAYS = ("floating_point_array", "integer_array")


def json_model(path: Path, tree: object) -> Model:
    """The model of a JSON document.

    Raises
    ------
    SceneError
        As `xml_form.xml_model`, and for parts of a wrong kind.
    """
    form = Form(path)
    if not isinstance(tree, dict) or not isinstance(tree.get("model"), dict):
        form.refuse("root", "an object with the object 'model'", _kind(tree))
    root: dict[str, Any] = tree["model"]
    spectrum = root.get("load_spectrum") or []
    cases = [
        (
            form.id(case.get("id"), "load_case"),
            [_component(form, part) for part in _objects(form, case, "components")],
        )
        for one in (spectrum if isinstance(spectrum, list) else [spectrum])
        for case in _objects(form, one, "load_cases")
    ]
    return form.model(
        version=root.get("version"),
        components=[_component(form, part) for part in _objects(form, root, "components")],
        relations=[_relation(form, part) for part in _objects(form, root, "relations")],
        cases=cases,
    )


def _component(form: Form, part: dict[str, Any]) -> Component:
    number = form.id(part.get("id"), "component")
    attributes = [
        (item.get("id"), Attribute(_text(item.get("unit")), _value(item)))
        for item in _objects(form, part, "attributes")
    ]
    return form.component(number, part.get("type"), _text(part.get("name")), attributes)


def _relation(form: Form, part: dict[str, Any]) -> Relation:
    number = form.id(part.get("id"), "relation")
    refs = [(ref.get("role"), ref.get("id")) for ref in _objects(form, part, "refs")]
    return form.relation(number, part.get("type"), refs)


def _value(item: dict[str, Any]) -> Value:
    for name in SCALARS:
        value = item.get(name)
        if isinstance(value, str | int | float):
            return value
    for name in ARRAYS:
        if isinstance(item.get(name), list):
            return tuple(item[name])
    return None


def _objects(form: Form, owner: object, key: str) -> list[dict[str, Any]]:
    """The objects of a list; an absent list is empty."""
    found = owner.get(key, []) if isinstance(owner, dict) else owner
    if not isinstance(found, list) or not all(isinstance(item, dict) for item in found):
        form.refuse(key, "a list of objects", _kind(found))
    return found


def _text(value: object) -> str | None:
    return value if isinstance(value, str) else None


def _kind(value: object) -> str:
    kinds = {dict: "an object", list: "a list", str: "a text", type(None): "nothing"}
    return kinds.get(type(value), "a number")
