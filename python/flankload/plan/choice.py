"""`effects.choose = "auto"`: the effects that matter at the tolerance, written out as keys.

What a scene names stays: levels, questions, geometry. Numbers of physics that it names (a
coefficient of friction, a rise of temperature, a speed) are candidates: they are left out where
they change next to nothing. So are bodies that hardly yield, and the levels that it leaves open.
"""

from __future__ import annotations

from dataclasses import astuple
from typing import TYPE_CHECKING

from flankload.errors import SceneError
from flankload.plan.coarse import Coarse
from flankload.plan.measuring import Sizes, rows
from flankload.plan.planned import Chosen
from flankload.plan.quarter import against_quarter, matters, quarter_text
from flankload.plan.variants import LEVELS, QUANTITIES, with_keys, with_rigid, without_keys
from flankload.scene.effects import Effect, switches_of

if TYPE_CHECKING:
    from flankload.plan.measuring import Measured
    from flankload.scene import Scene
    from flankload.scene.effects import Switch


def asks_for_choice(scene: Scene) -> bool:
    """Whether a scene leaves the effects to the plan."""
    return getattr(scene.effects, "choose", None) == "auto"


def without_choice(scene: Scene) -> Scene:
    """The scene as its other keys have it."""
    return without_keys(scene, "choose")


def choose_effects(scene: Scene) -> tuple[Scene, tuple[Chosen, ...]]:
    """A scene with the effects that matter at its tolerance, and no others.

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
    sizes = Sizes(plain, Coarse(plain))
    switches = switches_of(plain)
    measured = {effect.name: sizes.of(effect, switches[effect.name]) for effect in rows(scene)}
    return chosen_scene(plain, switches, measured)


def chosen_scene(
    scene: Scene, switches: dict[str, Switch], measured: dict[str, Measured]
) -> tuple[Scene, tuple[Chosen, ...]]:
    """What sizes say of a scene without `choose`; see `choose_effects`."""
    choice: list[Chosen] = []
    for effect in rows(scene):
        size = measured[effect.name].size
        if size is None or not is_open(scene, effect, switches):
            continue
        large = matters(size.largest, scene.accuracy.tolerance)
        wanted = not large if effect.coarser else large
        switched, key, value = _switched(scene, effect, on=wanted)
        try:
            switched.check()
        except SceneError:  # it does not go with what was chosen before
            continue
        scene = switched
        reason = against_quarter(size.largest, scene.accuracy.tolerance)
        choice.append(Chosen(effect.name, key, value, wanted, reason))
    return scene, tuple(choice)


def is_open(scene: Scene, effect: Effect, switches: dict[str, Switch]) -> bool:
    """Whether a scene leaves an effect to the choice."""
    switch = switches[effect.name]
    if effect.name in QUANTITIES:
        return switch.on  # without a number nothing says what it would be
    if effect.name in ("elastic_body_1", "elastic_body_2"):
        return switch.on and not scene.effects.root_stress
    if effect.name in LEVELS:
        keys = {key.removeprefix("effects.") for key in effect.keys}
        if keys & scene.named_effects or (effect.coarser and not _saves(effect)):
            return False
        return switch.on or not any(switches[other].on for other in effect.excludes)
    return False


def _saves(effect: Effect) -> bool:
    return any(number < 0 for number in astuple(effect.work))


def said_of(choice: tuple[Chosen, ...], tolerance: float) -> str:
    """The choice as one sentence."""
    quarter = f"{quarter_text(tolerance)}, a quarter of accuracy.tolerance"
    return f"effects chosen by what changes more than {quarter}: " + "; ".join(map(str, choice))


def _switched(scene: Scene, effect: Effect, *, on: bool) -> tuple[Scene, str, bool | str | None]:
    """The scene with an effect on or off; key and value that say so."""
    if effect.name in QUANTITIES:
        keys = QUANTITIES[effect.name]
        return (scene if on else without_keys(scene, *keys)), f"effects.{keys[0]}", None
    if effect.name in LEVELS:
        ((key, value),) = LEVELS[effect.name][0 if on else 1].items()
        return with_keys(scene, **{key: value}), f"effects.{key}", value
    body = effect.name[-6:]
    return with_rigid(scene, body, rigid=not on), f"{body}.rigid", not on
