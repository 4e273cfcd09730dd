"""REXS files: XML (.rexs), JSON (.rexsj), or one of them in a ZIP archive (.rexsz, .rexs.zip).

An XML document is first brought into the form that a JSON document has: `model` with `relations`,
`components`, `load_spectrum`. Ids are integers and unique, types and roles are texts.
"""

from __future__ import annotations

import json
import re
import zipfile
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn, TypeVar
from xml.etree.ElementTree import Element, ParseError, TreeBuilder, XMLParser

from flankload.base.files import LARGEST, read_file
from flankload.errors import SceneError, reason_of
from flankload.exchange.rexs.model import RENAMED, Attribute, Component, Model, Relation, Value

if TYPE_CHECKING:
    from collections.abc import Iterable

XML, JSON, ZIP = (".rexs", ".xml"), (".rexsj", ".json"), (".rexsz", ".zip")
#: Names under which an attribute has a value that a scene may need.
SCALARS = ("floating_point", "integer", "boolean", "enum", "string", "reference_component")
ARRAYS = ("floating_point_array", "integer_array")
Tree = dict[str, Any]
Item = TypeVar("Item")


def read_model(path: str | Path) -> Model:
    """Read a REXS file: .rexs (XML), .rexsj (JSON), .rexsz or .rexs.zip (ZIP with one of these).

    Raises SceneError if the file cannot be read, is too large, is not well-formed, or is no REXS
    model of version 1; if an id is used twice or a relation refers to a component that is missing.
    """
    path = Path(path)
    suffix = path.suffix.lower()
    if suffix not in XML + JSON + ZIP:
        _refuse(path, "a REXS file (.rexs, .rexsj, .rexsz)", path.name)
    try:
        data = read_file(path, LARGEST)
    except OSError as error:
        _refuse(path, "a REXS file to read", reason_of(error))
    if suffix in ZIP:
        suffix, data = _unpacked(path, data)
    return _json(path, data) if suffix in JSON else _xml(path, data)


def _unpacked(path: Path, data: bytes) -> tuple[str, bytes]:
    """Suffix and content of the only model in an archive."""
    try:
        with zipfile.ZipFile(BytesIO(data)) as archive:
            models = [
                info
                for info in archive.infolist()
                if info.filename.lower().endswith((".rexs", ".rexsj"))
            ]
            if len(models) != 1:
                _refuse(path, "one file .rexs or .rexsj in the archive", f"{len(models)}")
            with archive.open(models[0]) as member:
                # the header of a member may understate its size
                content = member.read(LARGEST + 1)
    except SceneError:
        raise
    except (RuntimeError, NotImplementedError) as error:
        _refuse(path, "a ZIP archive without encryption, compressed by deflate", str(error))
    except Exception as error:  # damaged archives raise many kinds, among them those of LZMA
        _refuse(path, "a ZIP archive", str(error).lower() or type(error).__name__)
    if len(content) > LARGEST:
        expected = f"a model of at most {LARGEST / 1e6:g} million bytes"
        _refuse(path, expected, "a larger one in the archive")
    return Path(models[0].filename).suffix.lower(), content


def _xml(path: Path, data: bytes) -> Model:
    parser = XMLParser(target=Builder(path))
    try:
        parser.feed(data)
        root = parser.close()
    except ParseError as error:
        _refuse(path, "well-formed XML", str(error))
    except (LookupError, ValueError) as error:  # an unknown encoding
        _refuse(path, "XML in UTF-8", str(error))
    return xml_model(path, root)


def _json(path: Path, data: bytes) -> Model:
    try:
        tree = json.loads(data.decode("utf-8-sig"))
    except UnicodeDecodeError as error:
        _refuse(path, "text in UTF-8", f"byte 0x{error.object[error.start]:02x}")
    except json.JSONDecodeError as error:
        place = f"line {error.lineno}, column {error.colno}"
        _refuse(path, "valid JSON", f"{place}: {error.msg.lower()}")
    except RecursionError:
        _refuse(path, "JSON of a few levels", "too many levels")
    except ValueError as error:  # an integer of thousands of digits
        _refuse(path, "valid JSON", re.sub(r";.*", "", str(error)).lower())
    form = Form(path)
    if not isinstance(tree, dict) or not isinstance(tree.get("model"), dict):
        form.refuse("root", "an object with the object 'model'", _kind(tree))
    return form.model(tree["model"])


def _refuse(path: Path, expected: str, found: str) -> NoReturn:
    raise SceneError(file=path, key="file", expected=expected, found=found)


# --- parts ----------------------------------------------------------------------------------------
class Builder(TreeBuilder):
    """Builder of elements that refuses a document type: no entity is ever expanded."""

    def __init__(self, file: Path) -> None:
        super().__init__()
        self.file = file

    def doctype(self, name: str, pubid: str | None, system: str | None) -> NoReturn:
        """Refuse a document type before its entities are read."""
        Form(self.file).refuse("file", "XML without a document type", f"<!DOCTYPE {name}>")


def xml_model(path: Path, root: Element) -> Model:
    """The model of the root element of an XML document, checked as by `Form.model`."""
    form = Form(path)
    if _name(root) != "model":
        form.refuse("root", "element 'model'", f"'{_name(root)}'")
    return form.model(
        {
            "version": root.get("version"),
            "components": _xml_components(_within([root], "components")),
            "relations": [
                _xml_part(part, "refs", [dict(ref.attrib) for ref in _within([part], "ref")])
                for part in _within(_within([root], "relations"), "relation")
            ],
            "load_spectrum": {
                "load_cases": [
                    _xml_part(case, "components", _xml_components([case]))
                    for case in _within(_within([root], "load_spectrum"), "load_case")
                ]
            },
        }
    )


@dataclass(frozen=True)
class Form:
    """Checks of the parts of one file."""

    file: Path

    def refuse(self, key: str, expected: str, found: object) -> NoReturn:
        """Raise the error of this file."""
        raise SceneError(file=self.file, key=key, expected=expected, found=found)

    def model(self, root: Tree) -> Model:
        """The checked model.

        Refused: a part without its type or with an id that is not an integer, a version other
        than 1, an id that is used twice or refers to no component.
        """
        spectrum = root.get("load_spectrum") or []
        cases = [
            (self._id(case.get("id"), "load_case"), self._components(case))
            for one in (spectrum if isinstance(spectrum, list) else [spectrum])
            for case in self._objects(one, "load_cases")
        ]
        components = self._components(root)
        relations = [self._relation(part) for part in self._objects(root, "relations")]
        version = self._text(root.get("version"), "model", "a version")
        if not re.fullmatch(r"1\.[0-9]+", version):
            self.refuse("model: version", "version 1 of REXS, such as 1.5", f"'{version[:40]}'")
        model = Model(
            file=self.file,
            version=version,
            components=self._by_id(components, "component"),
            relations=tuple(self._by_id(relations, "relation").values()),
            load_cases={
                number: self._by_id(parts, f"load_case {number}: component")
                for number, parts in self._by_id(cases, "load_case").items()
            },
        )
        self._check_references(model)
        return model

    def _id(self, value: object, what: str) -> int:
        """An id; refused if it is not an integer."""
        number = value if isinstance(value, int) and not isinstance(value, bool) else None
        if isinstance(value, str) and re.fullmatch(r"\s*[+-]?[0-9]{1,18}\s*", value):
            number = int(value)
        if number is None:
            self.refuse(what, "an integer as id", "nothing" if value is None else repr(value)[:40])
        return number

    def _text(self, value: object, what: str, key: str) -> str:
        """A text that is required; `key` has its article."""
        if not isinstance(value, str) or not value.strip():
            self.refuse(what, key, "nothing" if value is None else repr(value)[:40])
        return value.strip()

    def _objects(self, owner: object, key: str) -> list[Tree]:
        """The objects of a list; an absent list is empty."""
        found = owner.get(key, []) if isinstance(owner, dict) else owner
        if not isinstance(found, list) or not all(isinstance(item, dict) for item in found):
            self.refuse(key, "a list of objects", _kind(found))
        return found

    def _components(self, owner: Tree) -> list[tuple[int, Component]]:
        """Components by their ids; refused if an attribute has no id or occurs twice."""
        components = []
        for part in self._objects(owner, "components"):
            number = self._id(part.get("id"), "component")
            attributes = self._objects(part, "attributes")
            kind = self._text(part.get("type"), f"component {number}", "a type")
            kind = RENAMED.get(kind, kind)
            found: dict[str, Attribute] = {}
            for item in attributes:
                key = self._text(item.get("id"), f"{kind} {number}: attribute", "an id")
                if key in found:
                    self.refuse(f"{kind} {number}: {key}", "one attribute with this id", "two")
                found[key] = Attribute(_text_of(item.get("unit")), _value(item))
            name = " ".join((_text_of(part.get("name")) or "").split())
            components.append((number, Component(number, kind, name, found)))
        return components

    def _relation(self, part: Tree) -> tuple[int, Relation]:
        number = self._id(part.get("id"), "relation")
        what, refs = f"relation {number}", self._objects(part, "refs")
        pairs = tuple(
            (self._text(ref.get("role"), what, "a role"), self._id(ref.get("id"), what))
            for ref in refs
        )
        return number, Relation(number, self._text(part.get("type"), what, "a type"), pairs)

    def _by_id(self, items: Iterable[tuple[int, Item]], what: str) -> dict[int, Item]:
        found: dict[int, Item] = {}
        for number, item in items:
            if number in found:
                self.refuse(f"{what} {number}", "an id that is unique", "two of them")
            found[number] = item
        return found

    def _check_references(self, model: Model) -> None:
        """Check that relations and load cases refer to components of the model."""
        for relation in model.relations:
            for role, number in relation.refs:
                if number not in model.components:
                    what = f"a component of the model as {role}"
                    self.refuse(f"relation {relation.id}", what, number)
        for case, components in model.load_cases.items():
            for number in components:
                if number not in model.components:
                    self.refuse(f"load_case {case}", "components of the model", number)


def _value(item: Tree) -> Value:
    scalars = (item[name] for name in SCALARS if isinstance(item.get(name), str | int | float))
    arrays = (tuple(item[name]) for name in ARRAYS if isinstance(item.get(name), list))
    return next(scalars, next(arrays, None))


def _text_of(value: object) -> str | None:
    return value if isinstance(value, str) else None


def _kind(value: object) -> str:
    kinds = {dict: "an object", list: "a list", str: "a text", type(None): "nothing"}
    return kinds.get(type(value), "a number")


def _xml_components(owners: list[Element]) -> list[Tree]:
    return [
        _xml_part(part, "attributes", [_xml_attribute(x) for x in _within([part], "attribute")])
        for part in _within(owners, "component")
    ]


def _xml_part(part: Element, key: str, members: list[Tree]) -> Tree:
    return {**part.attrib, key: members}


def _xml_attribute(item: Element) -> Tree:
    """Text of a scalar, texts of a plain array; no value for anything else."""
    tree: Tree = {"id": item.get("id"), "unit": item.get("unit")}
    if not len(item):
        tree["string"] = (item.text or "").strip()
    elif _name(item[0]) == "array" and item[0].get("code") is None:
        tree["floating_point_array"] = [(c.text or "").strip() for c in _within([item[0]], "c")]
    return tree


def _within(owners: list[Element], name: str) -> list[Element]:
    return [child for owner in owners for child in owner if _name(child) == name]


def _name(element: Element) -> str:
    """Name without the namespace, which a file may or may not have."""
    return element.tag.rpartition("}")[2]
