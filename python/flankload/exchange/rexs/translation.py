"""A stage of a REXS model as a scene, with a line for each thing that is not taken over."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from flankload.errors import SceneError
from flankload.exchange.rexs.body import body_of
from flankload.exchange.rexs.flanks import data_of, flank_of
from flankload.exchange.rexs.pair import pair_of
from flankload.exchange.rexs.planetary import tables_of_planets
from flankload.exchange.rexs.source import Stock
from flankload.exchange.rexs.stages import (
    PLANETARY,
    chosen_stage,
    model_of_case,
    stage_of,
    torque_of,
)
from flankload.scene import Scene
from flankload.scene.tree import with_changes

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from flankload.exchange.rexs.model import Component, Model


@dataclass(frozen=True)
class Choices:
    """Choices of the user beside the file: ids of stage and load case (None: the only one).

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
    """Make a scene of a cylindrical or planetary gear stage.

    Its name is that of `file` if the stage has none.

    Raises SceneError if the stage does not exist or is ambiguous, a value is missing or invalid, or
    the scene contradicts the rules of scenes.
    """
    choices = choices or Choices()
    given = "load.torque_Nm" in choices.settings
    model, other_cases = model_of_case(model, choices.load_case, needed=not given)
    component = chosen_stage(model, choices.stage)
    stock = Stock(model, choices.settings, lines=other_cases)
    stock.source(component)
    tables = tables_of_planets if component.type == PLANETARY else _tables_of_pair
    tree, torque = tables(stock, component, choices.flank)
    if torque is None and not given:
        model.refuse(component.label, "--torque-Nm, since the file has none of it", "nothing")
    tree = {
        "name": component.name or component.label,
        **tree,
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
    lines = tuple(dict.fromkeys((*stock.lines, *stock.rest())))
    return Translation(scene, component.label, lines)


def _tables_of_pair(
    stock: Stock, component: Component, flank: str | None
) -> tuple[dict[str, Any], float | None]:
    """Tables of a cylindrical stage, and the torque on body 1."""
    stage = stage_of(stock.model, component)
    data = data_of(stock, stage, 0), data_of(stock, stage, 1)
    bodies = [
        body_of(stock, gear, f"body_{k}", flank_of(stock, gear, data[k - 1], flank))
        for k, gear in enumerate(stage.gears, start=1)
    ]
    pair = pair_of(stock, stage, bodies)
    tree = {"body_1": bodies[0].keys, "body_2": bodies[1].keys, "pair": pair}
    return tree, torque_of(stock, stage, data)
