"""Data of a gear in its stage, and its loaded flank."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flankload.exchange.rexs.modifications import modifications_of

if TYPE_CHECKING:
    from flankload.exchange.rexs.model import Component, Model
    from flankload.exchange.rexs.source import Source, Stock
    from flankload.exchange.rexs.stages import Stage


def data_of(stock: Stock, stage: Stage, index: int) -> Source | None:
    """The data of a gear in this stage: torque and loaded flank."""
    of_stage = stock.model.partners(
        "stage_gear_data", "stage", stage.component.id, "stage_gear_data"
    )
    gear = stage.gears[index]
    of_gear = stock.model.partners("stage_gear_data", "gear", gear.id, "stage_gear_data")
    found = [part for part in of_stage if part in of_gear]
    return stock.source(found[0]) if found else None


def flank_of(
    stock: Stock, gear: Component, data: Source | None, chosen: str | None
) -> Component | None:
    """The loaded flank of a gear; either one if both are alike."""
    model = stock.model
    flanks = {
        side: found[0]
        for side in ("left", "right")
        if (found := model.partners("flank", "gear", gear.id, side))
    }
    if not flanks:
        return None
    side = (data and data.text("loaded_tooth_flank", "left", "right")) or chosen
    if side is None:
        side = next(iter(flanks))
        if len({content_of(model, flank) for flank in flanks.values()}) > 1:
            expected = "left or right in its stage_gear_data, or --flank, since its flanks differ"
            model.refuse(f"{gear.label}: loaded_tooth_flank", expected, "nothing")
    if side not in flanks:
        model.refuse(f"{gear.label}: flank", f"a {side} flank in its relation", "none")
    for other, flank in flanks.items():
        if other != side:
            stock.leave_all(flank, "the flank that is not loaded")
            for part in modifications_of(model, flank):
                if part not in modifications_of(model, flanks[side]):
                    stock.leave_all(part, "of the flank that is not loaded")
    return flanks[side]


def content_of(model: Model, flank: Component) -> str:
    """Attributes of a flank and of its modifications, without ids and names."""
    parts = [flank, *modifications_of(model, flank)]
    return repr(sorted((part.type, sorted(part.attributes.items(), key=str)) for part in parts))
