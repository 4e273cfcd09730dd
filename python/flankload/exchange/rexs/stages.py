"""The cylindrical gear stages of a model."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from flankload.exchange.rexs.attributes import GEARS

if TYPE_CHECKING:
    from flankload.exchange.rexs.model import Component, Model


@dataclass(frozen=True)
class Stage:
    """A stage with its two gears; a ring gear is the second one."""

    component: Component
    gears: tuple[Component, Component]

    @property
    def is_internal(self) -> bool:
        """Whether the second gear is a ring gear."""
        return self.gears[1].type == "ring_gear"


def stage_of(model: Model, number: int | None) -> Stage:
    """A stage by its id, or the only stage.

    Refused: an unknown id, several stages and no id, a relation that does not name two gears.
    """
    ids = [part.id for part in _stages(model)]
    if not ids:
        model.refuse("cylindrical_stage", "at least one in the model", "none")
    if number is None and len(ids) == 1:
        number = ids[0]
    if number not in ids:
        expected = f"the id of a cylindrical_stage: {', '.join(map(str, ids))}"
        model.refuse("--stage", expected, "nothing" if number is None else number)
    return _stage(model, model.components[number])


def _stage(model: Model, component: Component) -> Stage:
    gears = {
        role: model.partners("stage", "stage", component.id, role) for role in ("gear_1", "gear_2")
    }
    for role, found in gears.items():
        if len(found) != 1 or found[0].type not in GEARS:
            names = ", ".join(part.label for part in found) or "none"
            model.refuse(
                component.label, f"one {' or '.join(GEARS)} as {role} in its relation", names
            )
    one, two = gears["gear_1"][0], gears["gear_2"][0]
    if one.type == "ring_gear":
        one, two = two, one
    if one.type == "ring_gear" or one.id == two.id:
        model.refuse(component.label, "a gear and another gear or a ring gear", two.label)
    return Stage(component, (one, two))


def stage_rows(model: Model) -> list[tuple[str, ...]]:
    """Table of the stages: id, ids and teeth of the gears, kind, name; the header first."""
    rows: list[tuple[str, ...]] = [("stage", "gears", "teeth", "kind", "name")]
    for part in _stages(model):
        stage = _stage(model, part)
        gears = [gear.attributes.get("number_of_teeth") for gear in stage.gears]
        teeth = ["?" if found is None else f"{found.value}" for found in gears]
        rows.append(
            (
                f"{part.id}",
                ", ".join(f"{gear.id}" for gear in stage.gears),
                ", ".join(count.removesuffix(".0") for count in teeth),
                "internal" if stage.is_internal else "external",
                part.name,
            )
        )
    return rows


def _stages(model: Model) -> list[Component]:
    return [part for part in model.components.values() if part.type == "cylindrical_stage"]
