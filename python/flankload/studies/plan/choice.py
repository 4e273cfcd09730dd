"""`effects.choose = "auto"`: the significant effects of a scene, written out as keys.

Keys that a scene names are kept: contact model, requested quantities, geometry. Named physical
values (a coefficient of friction, a temperature rise, a speed) are candidates: they are omitted if
their effect is negligible. The same applies to almost rigid bodies and to the contact model if it
is open.
"""

from __future__ import annotations

from dataclasses import astuple
from typing import TYPE_CHECKING

from flankload.errors import SceneError
from flankload.mechanisms.toggles import (
    LEVELS,
    QUANTITIES,
    RIGID,
    with_keys,
    with_rigid,
    without_keys,
)
from flankload.scene.effects import EFFECTS, Effect, excluded_by, switches_of
from flankload.studies.plan.coarse_runs import CoarseRuns
from flankload.studies.plan.planned import Chosen
from flankload.studies.plan.text import against_threshold, is_significant, threshold_text

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flankload.scene import Scene
    from flankload.scene.effects import Switch
    from flankload.studies.plan.coarse_runs import Measured


def asks_for_choice(scene: Scene) -> bool:
    """Whether a scene leaves the choice of effects to the plan."""
    return scene.effects.choose == "auto"


def without_choice(scene: Scene) -> Scene:
    """The scene with its other keys only."""
    return without_keys(scene, "choose") if asks_for_choice(scene) else scene


def choose_effects(scene: Scene) -> tuple[Scene, tuple[Chosen, ...]]:
    """A scene with exactly the effects that are significant at its tolerance.

    Parameters
    ----------
    scene : Scene

    Returns
    -------
    scene : Scene
        The scene with explicit keys; unchanged if it does not leave the choice to the plan.
    choice : tuple of Chosen
        Each chosen key, with the reason.
    """
    if not asks_for_choice(scene):
        return scene, ()
    plain = without_choice(scene)
    if not any(plain.torques_Nm):
        return plain, ()
    runs = CoarseRuns(plain, levels=True)
    return chosen_scene(plain, runs.effects, runs.measured(wanted_sizes(plain)))


def wanted_sizes(scene: Scene) -> tuple[str, ...]:
    """Names of the effects whose size decides on a choice."""
    switches = switches_of(scene)
    return tuple(effect.name for effect in EFFECTS if _is_open(scene, effect, switches))


def chosen_scene(
    scene: Scene, effects: tuple[Effect, ...], measured: Mapping[str, Measured]
) -> tuple[Scene, tuple[Chosen, ...]]:
    """Choice for a scene without `choose`, from sizes; see `choose_effects`."""
    choice: list[Chosen] = []
    switches, tolerance = switches_of(scene), scene.accuracy.tolerance
    for effect in effects:
        size = measured[effect.name].size
        if size is None or not _is_open(scene, effect, switches):
            continue
        wanted = is_significant(size.largest, tolerance) != effect.coarser
        switched, key, value = _switched(scene, effect, on=wanted)
        try:
            switched.check()
        except SceneError:  # incompatible with previous choices
            continue
        scene = switched
        why = against_threshold(size.largest, tolerance)
        choice.append(Chosen(effect.name, key, value, wanted, why))
    return scene, tuple(choice)


def _is_open(scene: Scene, effect: Effect, switches: Mapping[str, Switch]) -> bool:
    """Whether a scene leaves an effect to the choice."""
    switch = switches[effect.name]
    if effect.name in QUANTITIES:
        return switch.on  # without a value it cannot be switched on
    if effect.name in RIGID:
        return switch.on and not scene.effects.root_stress
    if effect.name not in LEVELS:
        return False
    keys = {key.removeprefix("effects.") for key in effect.keys}
    saves = any(number < 0 for number in astuple(effect.work))
    if keys & scene.named_effects or (effect.coarser and not saves):
        return False
    return switch.on or not any(switches[other].on for other in excluded_by(effect))


def said_of(choice: tuple[Chosen, ...], tolerance: float) -> str:
    """The choice in one sentence."""
    threshold = f"{threshold_text(tolerance)}, a quarter of accuracy.tolerance"
    return f"effects chosen by a change of more than {threshold}: " + "; ".join(map(str, choice))


def _switched(scene: Scene, effect: Effect, *, on: bool) -> tuple[Scene, str, bool | str | None]:
    """The scene with an effect on or off; key and value for that."""
    if effect.name in QUANTITIES:
        keys = QUANTITIES[effect.name]
        return (scene if on else without_keys(scene, *keys)), f"effects.{keys[0]}", None
    if effect.name in LEVELS:
        ((key, value),) = LEVELS[effect.name][0 if on else 1].items()
        return with_keys(scene, **{key: value}), f"effects.{key}", value
    body = RIGID[effect.name]
    return with_rigid(scene, body, rigid=not on), f"{body}.rigid", not on
