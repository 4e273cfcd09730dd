"""A scene with one effect the other way: what the size of an effect is taken from."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from msgspec import structs

from flankload.scene import MeshBody, Scene
from flankload.scene.effects import EFFECTS, MODIFICATIONS, Effect
from flankload.scene.effects.keys import EffectsAsked

if TYPE_CHECKING:
    from collections.abc import Callable

#: Effects that keys of [effects] decide on, and that change states.
RECORDS = {row.name: row for row in EFFECTS if row.on and row.size_by != "nothing"}
#: What is taken of an effect that a scene does not call for and has no number of.
ASSUMED: dict[str, dict[str, Any]] = {name: row.numbers for name, row in RECORDS.items()}
#: Values of [effects] by which an effect is on and off, where a level is chosen by one key.
LEVELS: dict[str, tuple[dict[str, Any], dict[str, Any]]] = {
    name: ({key: value for key, value in row.on.items() if key not in row.numbers}, row.off)
    for name, row in RECORDS.items()
    if not row.is_quantity
}
#: Keys of a quantity of [effects]: without them the effect is off.
QUANTITIES: dict[str, tuple[str, ...]] = {
    name: tuple(row.off) for name, row in RECORDS.items() if row.is_quantity
}


@dataclass(frozen=True)
class Variant:
    """A scene with one effect the other way.

    Attributes
    ----------
    scene : Scene
    assumed : str or None
        What the scene does not say and was taken all the same, as key and value.
    """

    scene: Scene
    assumed: str | None = None


def is_readable(effect: Effect) -> bool:
    """Whether scenes have the keys of an effect."""
    keys = [key.removeprefix("effects.") for key in effect.keys if key.startswith("effects.")]
    return not keys or any(key in EffectsAsked.__struct_fields__ for key in keys)


def other_way(scene: Scene, name: str, *, on: bool) -> Variant | None:
    """A scene with one effect switched.

    Parameters
    ----------
    scene : Scene
    name : str
        Row of the table of effects.
    on : bool
        Whether the scene has it.

    Returns
    -------
    Variant or None
        None where the effect changes no state, or where nothing says what it would be.

    Raises
    ------
    SceneError
        If there is no such scene.
    """
    taken = {} if on else ASSUMED.get(name, {})
    assumed = next((f"effects.{key} = {value:g}" for key, value in taken.items()), None)
    if name in LEVELS:
        return _allowed(with_keys(scene, **LEVELS[name][1 if on else 0], **taken), assumed)
    if name in QUANTITIES:
        if on:
            return Variant(without_keys(scene, *QUANTITIES[name]))
        return _allowed(with_keys(scene, **taken), assumed)
    if name in ("elastic_body_1", "elastic_body_2"):
        return _other_rigid(scene, name[-6:], on=on)
    if name in REMOVED and on:
        remove = REMOVED[name]
        return Variant(replace(scene, body_1=remove(scene.body_1), body_2=remove(scene.body_2)))
    return None


def _allowed(scene: Scene, assumed: str | None = None) -> Variant:
    """A scene that a file could have, too."""
    scene.check()
    return Variant(scene, assumed)


def with_keys(scene: Scene, **keys: Any) -> Scene:
    """A scene with these keys of [effects] written out."""
    effects = structs.replace(scene.effects, **keys)
    return replace(scene, effects=effects, named_effects=scene.named_effects | set(keys))


def without_keys(scene: Scene, *keys: str) -> Scene:
    """A scene without these keys of [effects]."""
    plain = EffectsAsked()
    known = [key for key in keys if key in EffectsAsked.__struct_fields__]
    effects = structs.replace(scene.effects, **{key: getattr(plain, key) for key in known})
    return replace(scene, effects=effects, named_effects=scene.named_effects - set(keys))


def with_rigid(scene: Scene, key: str, *, rigid: bool) -> Scene:
    """A scene with a body that does not yield, or does."""
    return replace(scene, **{key: structs.replace(getattr(scene, key), rigid=rigid)})


def _other_rigid(scene: Scene, key: str, *, on: bool) -> Variant | None:
    """Not where the other body does not yield either: nothing would say how flanks share."""
    other = scene.body_2 if key == "body_1" else scene.body_1
    if not any(scene.torques_Nm) or (on and other.rigid):
        return None
    return _allowed(with_rigid(scene, key, rigid=on))


def _placed(body: Any) -> Any:
    """Every tooth at its place."""
    if "pitch_errors_um" not in type(body).__struct_fields__:
        return body
    return structs.replace(body, pitch_errors_um=())


def _unmodified(body: Any) -> Any:
    """The involute up to the tip circle."""
    if isinstance(body, MeshBody):
        if body.profile is None:
            return body
        return structs.replace(body, profile=_without_modifications(body.profile))
    if hasattr(body, MODIFICATIONS[0]):
        return _without_modifications(body)
    return body


def _without_modifications(table: Any) -> Any:
    keys = (*MODIFICATIONS, "tip_relief_start_diameter_mm")
    return structs.replace(table, **dict.fromkeys(keys))


#: What takes an effect off the bodies of a scene.
REMOVED: dict[str, Callable[[Any], Any]] = {
    "pitch_errors": _placed,
    "flank_modifications": _unmodified,
}
