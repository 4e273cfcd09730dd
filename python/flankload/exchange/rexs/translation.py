"""A stage of a REXS model as a scene, with a line for each thing that is not taken over."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from flankload.errors import SceneError
from flankload.exchange.rexs.body import body_of
from flankload.exchange.rexs.modifications import modifications_of
from flankload.exchange.rexs.pair import pair_of
from flankload.exchange.rexs.source import Source, Stock
from flankload.exchange.rexs.stages import Stage, model_of_case, stage_of, torque_of
from flankload.scene import Scene
from flankload.scene.tree import with_changes

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from flankload.exchange.rexs.model import Component, Model


@dataclass(frozen=True)
class Choices:
    """What the user determines beside the file: ids of stage and load case (None: the only one).

    `flank`, "left" or "right", is the loaded flank of the gears for which the file does not define
    it; `settings` are keys of the scene by path, which replace those of the file.
    """

    stage: int | None = None
    load_case: int | None = None
    flank: str | None = None
    settings: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Translation:
    """A scene, the label of its stage, and lines about what was assumed or not taken over."""

    scene: Scene
    stage: str
    lines: tuple[str, ...]


def scene_of_stage(
    model: Model, choices: Choices | None = None, *, file: Path | None = None
) -> Translation:
    """Make a scene of a cylindrical gear stage; its name is that of `file` if the stage has none.

    Raises SceneError if the stage does not exist or is ambiguous, a value is missing or invalid, or
    the scene contradicts the rules of scenes.
    """
    choices = choices or Choices()
    given = "load.torque_Nm" in choices.settings
    model, other_cases = model_of_case(model, choices.load_case, needed=not given)
    stage = stage_of(model, choices.stage)
    stock = Stock(model, choices.settings, lines=other_cases)
    stock.source(stage.component)
    data = (_data_of(stock, stage, 0), _data_of(stock, stage, 1))
    bodies = [
        body_of(stock, gear, f"body_{k}", _flank_of(stock, gear, data[k - 1], choices.flank))
        for k, gear in enumerate(stage.gears, start=1)
    ]
    pair = pair_of(stock, stage, bodies)
    torque = torque_of(stock, stage, data)
    if torque is None and not given:
        model.refuse(stage.component.label, "--torque-Nm, since the file has none of it", "nothing")
    tree: dict[str, Any] = {
        "name": stage.component.name or stage.component.label,
        "body_1": bodies[0].keys,
        "body_2": bodies[1].keys,
        "pair": pair,
        "load": {} if torque is None else {"torque_Nm": torque},
    }
    for path in choices.settings:
        table, _, key = path.partition(".")
        own = tree.get(table)
        stock.replace(path, own.get(key) if isinstance(own, dict) else None)
    try:
        scene = Scene.from_dict(with_changes(tree, choices.settings), file=file)
    except SceneError as error:
        raise error.with_file(model.file) from None
    return Translation(scene, stage.component.label, (*stock.lines, *stock.rest()))


def _data_of(stock: Stock, stage: Stage, index: int) -> Source | None:
    """The data of a gear in this stage: torque and loaded flank."""
    of_stage = stock.model.partners(
        "stage_gear_data", "stage", stage.component.id, "stage_gear_data"
    )
    gear = stage.gears[index]
    of_gear = stock.model.partners("stage_gear_data", "gear", gear.id, "stage_gear_data")
    found = [part for part in of_stage if part in of_gear]
    return stock.source(found[0]) if found else None


# --- flanks ---------------------------------------------------------------------------------------
def _flank_of(
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
        if len({_content(model, flank) for flank in flanks.values()}) > 1:
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


def _content(model: Model, flank: Component) -> str:
    """Attributes of a flank and of its modifications, without ids and names."""
    parts = [flank, *modifications_of(model, flank)]
    return repr(sorted((part.type, sorted(part.attributes.items(), key=str)) for part in parts))
