"""Reading of attributes of the components of a stage, with a list of what is not taken over."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import isfinite
from typing import TYPE_CHECKING, Any, NoReturn

from flankload.base.number_text import number_of
from flankload.exchange.rexs.attributes import (
    FACTORS,
    UNITS,
    converted,
    reason_for,
    reason_for_type,
)

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flankload.exchange.rexs.model import Component, Model


@dataclass
class Source:
    """A component from which attributes are read; remembers which."""

    model: Model
    component: Component
    read: set[str] = field(default_factory=set)

    def number(self, attribute: str, unit: str) -> float | None:
        """A number in the unit of a scene; None if the file has no such attribute.

        A value that is not a finite number, or has a unit of another quantity, is refused.
        """
        found = self.component.attributes.get(attribute)
        if found is None:
            return None
        value = None if isinstance(found.value, bool) else _float(found.value)
        if value is None:
            self.refuse(attribute, "a finite number", found.value)
        given = UNITS[attribute] if found.unit is None else found.unit
        number = converted(value, given, unit)
        if number is None:
            self.refuse(attribute, f"one of the units {', '.join(FACTORS[unit])}", given or "none")
        self.read.add(attribute)
        return number

    def text(self, attribute: str, *allowed: str) -> str | None:
        """One of the values that the database allows; None if the file has no such attribute."""
        found = self.component.attributes.get(attribute)
        if found is None:
            return None
        if found.value not in allowed:
            self.refuse(attribute, " or ".join(f"'{name}'" for name in allowed), found.value)
        self.read.add(attribute)
        return str(found.value)

    def vector(self, attribute: str) -> tuple[float, float, float] | None:
        """Three numbers in mm; None if the file has no such array of three numbers."""
        found = self.component.attributes.get(attribute)
        if found is None or not isinstance(found.value, tuple) or len(found.value) != 3:
            return None
        unit = UNITS[attribute] if found.unit is None else found.unit
        numbers = [_float(value) for value in found.value]
        in_mm = [None if x is None else converted(x, unit, "mm") for x in numbers]
        x, y, z = in_mm
        return None if x is None or y is None or z is None else (x, y, z)

    def refuse(self, attribute: str, expected: str, found: object) -> NoReturn:
        """Raise the error of an attribute."""
        shown = "a matrix or a coded array" if found is None else f"{found!r}"[:60]
        self.model.refuse(f"{self.component.label}: {attribute}", expected, shown)


def _float(value: object) -> float | None:
    """A finite number, of a number or its text."""
    if not isinstance(value, str | int | float):
        return None
    try:
        number = number_of(value) if isinstance(value, str) else float(value)
    except (ValueError, OverflowError):
        return None
    return number if isfinite(number) else None


@dataclass
class Stock:
    """The components that belong to a stage, and lines about what was not taken over.

    The model has the attributes of the load case; `settings` are keys of the scene that are given
    beside the file: what they replace is not required.
    """

    model: Model
    settings: Mapping[str, Any]
    sources: dict[int, Source] = field(default_factory=dict)
    lines: list[str] = field(default_factory=list)

    def source(self, component: Component) -> Source:
        """The component as a source, the same one each time."""
        return self.sources.setdefault(component.id, Source(self.model, component))

    def missing(self, source: Source, attribute: str, key: str) -> None:
        """Raise the error of a missing attribute, unless its key is given otherwise."""
        if key not in self.settings:
            expected = f"a value, or --set {key}=…"
            if attribute not in UNITS:
                expected = f"--set {key}=…, since the database of REXS has no such attribute"
            self.model.refuse(f"{source.component.label}: {attribute}", expected, "nothing")

    def assume(self, component: Component, what: str) -> None:
        """Report what the scene has although the file does not define it."""
        self.lines.append(f"assumed: {component.label}: {what}")

    def leave(self, component: Component, attribute: str, why: str) -> None:
        """Report an attribute that is not taken over."""
        self.source(component).read.add(attribute)
        self.lines.append(f"not taken: {component.label}: {attribute}: {why}")

    def leave_all(self, component: Component, why: str) -> None:
        """Report a component that is not taken over with any of its attributes."""
        self.source(component).read |= set(component.attributes)
        self.lines.append(f"not taken: {component.label}: {why}")

    def replace(self, path: str, own: object) -> None:
        """Report a value of the file that is replaced by another one."""
        value = self.settings[path]
        if own is not None and own != value:
            self.lines.append(f"not taken: {path} = {own} of the file: replaced by {value}")

    def rest(self) -> list[str]:
        """Lines of all attributes that nothing read, and of components of other parts."""
        lines = [
            f"not taken: {source.component.label}: {attribute}: {reason_for(attribute)}"
            for source in self.sources.values()
            for attribute in source.component.attributes
            if attribute not in source.read
        ]
        others: dict[str, list[int]] = {}
        for component in self.model.components.values():
            if component.id not in self.sources:
                others.setdefault(component.type, []).append(component.id)
        return lines + [
            f"not taken: {kind} {', '.join(map(str, ids))}: {reason_for_type(kind)}"
            for kind, ids in sorted(others.items())
        ]
