"""A REXS model: components with attributes, relations between components, load cases."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, NoReturn

from flankload.errors import SceneError

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

#: Types of components up to REXS 1.2 with their name since REXS 1.3.
RENAMED = {
    "flank_geometry": "cylindrical_gear_flank",
    "stage_gear_data": "cylindrical_stage_gear_data",
}
#: Value of an attribute: text as in XML; in JSON also numbers, booleans and lists.
Value = str | float | bool | tuple[object, ...] | None


@dataclass(frozen=True)
class Attribute:
    """An attribute of a component, with its unit as in the file, which may name none.

    The value is None for a matrix, a coded array or another value that no scene needs.
    """

    unit: str | None
    value: Value


@dataclass(frozen=True)
class Component:
    """A machine element or a part of one."""

    id: int
    type: str
    name: str
    attributes: Mapping[str, Attribute]

    @property
    def label(self) -> str:
        """Type and id."""
        return f"{self.type} {self.id}"


@dataclass(frozen=True)
class Relation:
    """A relation between components: its type, and the role of each of them."""

    id: int
    type: str
    refs: tuple[tuple[str, int], ...]

    def ids(self, role: str) -> list[int]:
        """Components with a role."""
        return [number for name, number in self.refs if name == role]


@dataclass(frozen=True)
class Model:
    """A gearbox model: components by id, relations, load cases by id.

    A load case has components by id, with the attributes that differ between cases.
    """

    file: Path
    version: str
    components: Mapping[int, Component]
    relations: tuple[Relation, ...]
    load_cases: Mapping[int, Mapping[int, Component]] = field(default_factory=dict)

    def refuse(self, key: str, expected: str, found: object) -> NoReturn:
        """Raise the error of this file."""
        raise SceneError(file=self.file, key=key, expected=expected, found=found)

    def partners(self, kind: str, role: str, number: int, wanted: str) -> list[Component]:
        """Components of role `wanted` in the relations in which a component has another role.

        `kind` is the type of the relations, `number` the id of the given component.
        """
        return [
            self.components[other]
            for relation in self.relations
            if relation.type == kind and number in relation.ids(role)
            for other in relation.ids(wanted)
        ]

    def with_load_case(self, number: int) -> Model:
        """The model with the attributes of a load case in place of or beside its own."""
        changed = dict(self.components)
        for key, extra in self.load_cases[number].items():
            own = changed[key]
            changed[key] = replace(own, attributes={**own.attributes, **extra.attributes})
        return replace(self, components=changed)
