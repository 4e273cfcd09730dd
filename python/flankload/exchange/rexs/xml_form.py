"""A REXS model in XML: element `model` with `relations`, `components` and `load_spectrum`."""

from __future__ import annotations

from typing import TYPE_CHECKING, NoReturn
from xml.etree.ElementTree import Element, TreeBuilder

from flankload.errors import SceneError
from flankload.exchange.rexs.form import Form
from flankload.exchange.rexs.model import Attribute, Component, Model, Relation

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path


class Builder(TreeBuilder):
    """Builder of elements that refuses a document type: no entity is ever expanded."""

    def __init__(self, file: Path) -> None:
        super().__init__()
        self.file = file

    def doctype(self, name: str, pubid: str | None, system: str | None) -> NoReturn:
        """Refuse a document type before its entities are read.

        Raises
        ------
        SceneError
        """
        raise SceneError(
            file=self.file,
            key="file",
            expected="XML without a document type",
            found=f"<!DOCTYPE {name}>",
        )


def xml_model(path: Path, root: Element) -> Model:
    """The model of a root element.

    Raises
    ------
    SceneError
        If the root is no model; at the first part without its type or with an id that is no
        integer; if ids are used twice or refer to nothing.
    """
    form = Form(path)
    if _name(root) != "model":
        form.refuse("root", "element 'model'", f"'{_name(root)}'")
    cases = [
        (
            form.id(case.get("id"), "load_case"),
            [_component(form, part) for part in _children(case, "component")],
        )
        for spectrum in _children(root, "load_spectrum")
        for case in _children(spectrum, "load_case")
    ]
    return form.model(
        version=root.get("version"),
        components=[
            _component(form, part)
            for group in _children(root, "components")
            for part in _children(group, "component")
        ],
        relations=[
            _relation(form, part)
            for group in _children(root, "relations")
            for part in _children(group, "relation")
        ],
        cases=cases,
    )


def _component(form: Form, part: Element) -> Component:
    number = form.id(part.get("id"), "component")
    attributes = [
        (item.get("id"), Attribute(item.get("unit"), _value(item)))
        for item in _children(part, "attribute")
    ]
    return form.component(number, part.get("type"), part.get("name"), attributes)


def _relation(form: Form, part: Element) -> Relation:
    number = form.id(part.get("id"), "relation")
    refs = [(ref.get("role"), ref.get("id")) for ref in _children(part, "ref")]
    return form.relation(number, part.get("type"), refs)


def _value(item: Element) -> str | tuple[object, ...] | None:
    """Text of a scalar, texts of a plain array; None for anything else."""
    if not len(item):
        return (item.text or "").strip()
    first = item[0]
    if _name(first) == "array" and first.get("code") is None:
        return tuple((cell.text or "").strip() for cell in _children(first, "c"))
    return None


def _children(element: Element, name: str) -> Iterator[Element]:
    return (child for child in element if _name(child) == name)


def _name(element: Element) -> str:
    """Name without the namespace, which a file may or may not have."""
    return element.tag.rpartition("}")[2]
