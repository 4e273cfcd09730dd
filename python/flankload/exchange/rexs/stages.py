"""The cylindrical gear stages of a model, and the torque on body 1.

The torque is that of the stage itself, or of the only load on the shaft of a gear.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from flankload.exchange.rexs.attributes import GEARS, PLANETARY

if TYPE_CHECKING:
    from flankload.exchange.rexs.model import Component, Model
    from flankload.exchange.rexs.source import Source, Stock


@dataclass(frozen=True)
class Stage:
    """A stage with its two gears; a ring gear is the second one."""

    component: Component
    gears: tuple[Component, Component]

    @property
    def is_internal(self) -> bool:
        """Whether the second gear is a ring gear."""
        return self.gears[1].type == "ring_gear"


def chosen_stage(model: Model, number: int | None) -> Component:
    """A stage by its id, or the only one; a planetary stage counts as one with its own stages.

    Refused: an unknown id, several stages and no id.
    """
    every = _stages(model)
    if not every:
        model.refuse("cylindrical_stage", "at least one in the model", "none")
    inside = {part.id for stage in every for part in stages_within(model, stage)}
    alone = [part.id for part in every if part.id not in inside]
    if number is None and len(alone) == 1:
        number = alone[0]
    ids = [part.id for part in every]
    if number not in ids:
        kinds = " or ".join(dict.fromkeys(part.type for part in every))
        expected = f"the id of a {kinds}: {', '.join(map(str, ids))}"
        model.refuse("--stage", expected, "nothing" if number is None else number)
    return model.components[number]


def stages_within(model: Model, stage: Component) -> list[Component]:
    """Cylindrical stages of a planetary stage: one for each gear mesh."""
    if stage.type != PLANETARY:
        return []
    parts = model.partners("assembly", "assembly", stage.id, "part")
    return [part for part in parts if part.type == "cylindrical_stage"]


def stage_of(model: Model, component: Component) -> Stage:
    """A cylindrical stage with its gears; refused if its relation does not name two gears."""
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
        within = stages_within(model, part)
        meshes = [stage_of(model, one) for one in within or [part]]
        # a sun first, a ring last
        gears = list(dict.fromkeys(gear.id for stage in meshes for gear in stage.gears))
        gears.sort(key=lambda gear: model.components[gear].type == "ring_gear")
        kind = "internal" if meshes[0].is_internal else "external"
        rows.append(
            (
                f"{part.id}",
                ", ".join(map(str, gears)),
                ", ".join(_teeth(model.components[gear]) for gear in gears),
                "planetary" if within else kind,
                part.name,
            )
        )
    return rows


def _teeth(gear: Component) -> str:
    """Tooth number as in the file."""
    found = gear.attributes.get("number_of_teeth")
    return "?" if found is None else f"{found.value}".removesuffix(".0")


def _stages(model: Model) -> list[Component]:
    """Cylindrical stages, and planetary stages with cylindrical ones."""
    return [
        part
        for part in model.components.values()
        if part.type == "cylindrical_stage" or stages_within(model, part)
    ]


# --- load -----------------------------------------------------------------------------------------
def model_of_case(model: Model, number: int | None, *, needed: bool) -> tuple[Model, list[str]]:
    """The model with the attributes of a load case (None: the only one), lines about the others.

    An unknown load case is refused; several cases without a number, if the load is needed.
    """
    cases = list(model.load_cases)
    if number is None and len(cases) == 1:
        number = cases[0]
    if number is None and (not cases or not needed):
        rest = cases
    elif number in cases:
        model = model.with_load_case(number)
        rest = [case for case in cases if case != number]
    else:
        expected = f"the id of a load_case: {', '.join(map(str, cases)) or 'none in the file'}"
        model.refuse("--load-case", expected, "nothing" if number is None else number)
    lines = [f"not taken: load_case {', '.join(map(str, rest))}: another load"] if rest else []
    return model, lines


def torque_of(
    stock: Stock, stage: Stage, data: tuple[Source | None, Source | None]
) -> float | None:
    """Amount of the torque on gear 1, N m; None if the file defines none."""
    teeth = [abs(stock.source(gear).number("number_of_teeth", "") or 0.0) for gear in stage.gears]
    ratios = (1.0, teeth[0] / teeth[1] if teeth[1] else 0.0)
    for source, ratio in zip(data, ratios, strict=True):
        if source is not None and (value := source.number("torque", "N m")) and ratio:
            return float(f"{abs(value) * ratio:.12g}")
    for gear, ratio in zip(stage.gears, ratios, strict=True):
        if (value := torque_of_shaft(stock, gear)) and ratio:
            return float(f"{abs(value) * ratio:.12g}")
    return None


def torque_of_shaft(stock: Stock, gear: Component, most_stages: int = 1) -> float | None:
    """The only torque on the shaft of a gear that is the only one, and in few stages only."""
    model = stock.model
    shafts = model.partners("assembly", "part", gear.id, "assembly")
    roles = ("gear_1", "gear_2")
    stages = [part for role in roles for part in model.partners("stage", role, gear.id, "stage")]
    if len(shafts) != 1 or len(stages) > most_stages or _is_coupled(model, shafts[0]):
        return None
    parts = model.partners("assembly", "assembly", shafts[0].id, "part")
    loads = [
        stock.source(part)
        for part in parts
        if part.type == "external_load" and "torque_around_u_axis" in part.attributes
    ]
    if len(loads) != 1 or sum(part.type in GEARS for part in parts) != 1:
        return None
    return loads[0].number("torque_around_u_axis", "N m")


def _is_coupled(model: Model, shaft: Component) -> bool:
    """Whether anything but a bearing connects a shaft with another part."""
    return any(
        "bearing" not in part.type
        for role in ("inner_part", "outer_part")
        for part in model.partners("side", role, shaft.id, "assembly")
    )
