"""`effects.choose = "auto"`: the significant effects of a scene, written out as keys.

What a scene names stays: levels, questions, geometry. Numbers of physics that it names (a
coefficient of friction, a rise of temperature, a speed) are candidates: they are left out where
they change next to nothing. So are bodies that hardly yield, and the levels that it leaves open.
"""

from __future__ import annotations

from dataclasses import astuple
from typing import TYPE_CHECKING

from flankload.effects import EFFECTS, Effect, switches_of
from flankload.errors import SceneError
from flankload.plan.planned import Chosen
from flankload.plan.planning import sizes
from flankload.plan.screening import screening_of
from flankload.plan.significance import against_threshold, is_significant, threshold_text
from flankload.plan.toggles import LEVELS, QUANTITIES, RIGID, with_keys, with_rigid, without_keys

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flankload.effects import Switch
    from flankload.plan.planning import Measured
    from flankload.scene import Scene


def asks_for_choice(scene: Scene) -> bool:
    """Whether a scene leaves the effects to the plan."""
    return scene.effects.choose == "auto"


def without_choice(scene: Scene) -> Scene:
    """The scene as its other keys have it."""
    return without_keys(scene, "choose") if asks_for_choice(scene) else scene


def choose_effects(scene: Scene) -> tuple[Scene, tuple[Chosen, ...]]:
    """A scene with the effects that are significant at its tolerance, and no others.

    Parameters
    ----------
    scene : Scene

    Returns
    -------
    scene : Scene
        The same with the keys written out; itself where it does not leave them to the plan.
    choice : tuple of Chosen
        Each key that was decided on, and why.
    """
    if not asks_for_choice(scene):
        return scene, ()
    plain = without_choice(scene)
    if not any(plain.torques_Nm):
        return plain, ()
    screening = screening_of(plain, levels=True)
    return chosen_scene(plain, screening.rows, sizes(screening, plain))


def chosen_scene(
    scene: Scene, rows: tuple[str, ...], measured: Mapping[str, Measured]
) -> tuple[Scene, tuple[Chosen, ...]]:
    """What sizes say of a scene without `choose`; see `choose_effects`."""
    choice: list[Chosen] = []
    switches, tolerance = switches_of(scene), scene.accuracy.tolerance
    for effect in (effect for effect in EFFECTS if effect.name in rows):
        size = measured[effect.name].size
        if size is None or not _is_open(scene, effect, switches):
            continue
        wanted = is_significant(size.largest, tolerance) != effect.coarser
        switched, key, value = _switched(scene, effect, on=wanted)
        try:
            switched.check()
        except SceneError:  # it does not go with what was chosen before
            continue
        scene = switched
        why = against_threshold(size.largest, tolerance)
        choice.append(Chosen(effect.name, key, value, wanted, why))
    return scene, tuple(choice)


def _is_open(scene: Scene, effect: Effect, switches: Mapping[str, Switch]) -> bool:
    """Whether a scene leaves an effect to the choice."""
    switch = switches[effect.name]
    if effect.name in QUANTITIES:
        return switch.on  # without a number nothing says what it would be
    if effect.name in RIGID:
        return switch.on and not scene.effects.root_stress
    if effect.name not in LEVELS:
        return False
    keys = {key.removeprefix("effects.") for key in effect.keys}
    saves = any(number < 0 for number in astuple(effect.work))
    if keys & scene.named_effects or (effect.coarser and not saves):
        return False
    return switch.on or not any(switches[other].on for other in effect.excludes)


def said_of(choice: tuple[Chosen, ...], tolerance: float) -> str:
    """The choice as one sentence."""
    threshold = f"{threshold_text(tolerance)}, a quarter of accuracy.tolerance"
    return f"effects chosen by what changes more than {threshold}: " + "; ".join(map(str, choice))


def _switched(scene: Scene, effect: Effect, *, on: bool) -> tuple[Scene, str, bool | str | None]:
    """The scene with an effect on or off; key and value that say so."""
    if effect.name in QUANTITIES:
        keys = QUANTITIES[effect.name]
        return (scene if on else without_keys(scene, *keys)), f"effects.{keys[0]}", None
    if effect.name in LEVELS:
        ((key, value),) = LEVELS[effect.name][0 if on else 1].items()
        return with_keys(scene, **{key: value}), f"effects.{key}", value
    body = RIGID[effect.name]
    return with_rigid(scene, body, rigid=not on), f"{body}.rigid", not on
