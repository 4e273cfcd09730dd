"""The coarse discretization of a scene: a run with it is the model of the run itself."""

from __future__ import annotations

from dataclasses import replace
from math import inf
from typing import TYPE_CHECKING, Any

from msgspec import structs

from flankload.mechanisms.registry import mechanism_of
from flankload.scene.effects import effects_of
from flankload.scene.named_discretization import NamedDiscretization, with_discretization
from flankload.scene.steps import ELEMENTS, STEPS

if TYPE_CHECKING:
    from flankload.mechanisms.reuse import Parts
    from flankload.scene import Scene
    from flankload.scene.pair import Positions

#: Largest number of positions, evenly spaced over those of the scene.
POSITIONS = 32
#: Distance of nodes with forces, relative to the scene: their error is proportional to it.
NODES_APART = 1.5


def coarse(scene: Scene, parts: Parts | None = None) -> Scene:
    """The scene with the coarsest step of each parameter, at few positions.

    A parameter that the scene has at a coarser value keeps it, as does one that files determine.
    Bodies from files are reused from `parts`.
    """
    wanted = mechanism_of(scene).parameters(scene, parts)
    values: dict[str, Any] = {
        name: _coarser(name, value, wanted.element_mm)
        for name, value in wanted.values.items()
        if name not in wanted.fixed or getattr(scene.accuracy, name) is not None
    }
    if scene.effects.near_field == "nodes":
        spacing = scene.accuracy.flank_element_mm or wanted.nodes_mm
        values = {} if spacing is None else {ELEMENTS: NODES_APART * spacing}
    level = "slices" if effects_of(scene).three_dimensions else "pairs"
    scene = with_discretization(scene, NamedDiscretization(level, **values))
    return replace(scene, positions=few_positions(scene.positions))


def _coarser(name: str, value: float, element_mm: float | None) -> float:
    """The coarse value of a parameter, or its own if that is coarser."""
    if name == ELEMENTS:
        return max(value, STEPS[name].coarse * (element_mm or inf))
    return min(value, STEPS[name].coarse)


def few_positions(positions: Positions, most: int = POSITIONS) -> Positions:
    """A limited number of evenly spaced positions, including the first; none adaptive."""
    if positions.angles_deg is not None:
        every = max(1, -(-len(positions.angles_deg) // most))
        return structs.replace(positions, angles_deg=positions.angles_deg[::every])
    pitches = 1 if positions.pitches == "hunting" else positions.pitches
    count = max(1, min(positions.count, most // pitches))
    return structs.replace(positions, count=count, adaptive=False, tolerance=None, max_count=None)
