"""Rules that XML and JSON share: ids are integers, types and roles are texts, ids are unique."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import TYPE_CHECKING, NoReturn

from flankload.errors import SceneError
from flankload.exchange.rexs.model import (
    RENAMED,
    Attribute,
    Component,
    Model,
    Relation,
    by_id,
    checked,
)

if TYPE_CHECKING:
    from collections.abc import Iterable
    from pathlib import Path


@dataclass(frozen=True)
class Form:
    """Checks of the parts of one file."""

    file: Path

    def refuse(self, key: str, expected: str, found: object) -> NoReturn:
        """Raise the error of this file.

        Raises
        ------
        SceneError
        """
        raise SceneError(file=self.file, key=key, expected=expected, found=found)

    def id(self, value: object, what: str) -> int:
        """An id; refused if it is no integer."""
        number = value if isinstance(value, int) and not isinstance(value, bool) else None
        if isinstance(value, str) and re.fullmatch(r"\s*[+-]?[0-9]{1,18}\s*", value):
            number = int(value)
        if number is None:
            self.refuse(what, "an integer as id", "nothing" if value is None else repr(value)[:40])
        return number

    def text(self, value: object, what: str, key: str) -> str:
        """A text that is required; `key` has its article."""
        if not isinstance(value, str) or not value.strip():
            self.refuse(what, key, "nothing" if value is None else repr(value)[:40])
        return value.strip()

    def component(
        self,
        number: int,
        kind: object,
        name: str | None,
        attributes: Iterable[tuple[object, Attribute]],
    ) -> Component:
        """A component; refused if an attribute has no id or occurs twice."""
        kind = self.text(kind, f"component {number}", "a type")
        kind = RENAMED.get(kind, kind)
        found: dict[str, Attribute] = {}
        for key, attribute in attributes:
            key = self.text(key, f"{kind} {number}: attribute", "an id")
            if key in found:
                self.refuse(f"{kind} {number}: {key}", "one attribute with this id", "two")
            found[key] = attribute
        return Component(number, kind, " ".join((name or "").split()), found)

    def relation(
        self, number: int, kind: object, refs: Iterable[tuple[object, object]]
    ) -> Relation:
        """A relation with its type, and roles and ids of its components."""
        what = f"relation {number}"
        pairs = tuple((self.text(role, what, "a role"), self.id(ref, what)) for role, ref in refs)
        return Relation(number, self.text(kind, what, "a type"), pairs)

    def model(
        self,
        *,
        version: object,
        components: Iterable[Component],
        relations: Iterable[Relation],
        cases: Iterable[tuple[int, Iterable[Component]]],
    ) -> Model:
        """The checked model.

        Raises
        ------
        SceneError
            If the version is not 1, an id is used twice, or an id refers to no component.
        """
        version = self.text(version, "model", "a version")
        if not re.fullmatch(r"1\.[0-9]+", version):
            self.refuse("model: version", "version 1 of REXS, such as 1.5", f"'{version[:40]}'")
        return checked(
            Model(
                file=self.file,
                version=version,
                components=by_id(components, "component", self.file),
                relations=tuple(by_id(relations, "relation", self.file).values()),
                load_cases=self._cases(cases),
            )
        )

    def _cases(
        self, cases: Iterable[tuple[int, Iterable[Component]]]
    ) -> dict[int, dict[int, Component]]:
        found: dict[int, dict[int, Component]] = {}
        for number, parts in cases:
            if number in found:
                self.refuse(f"load_case {number}", "an id that is unique", "two of them")
            found[number] = by_id(parts, f"load_case {number}: component", self.file)
        return found
