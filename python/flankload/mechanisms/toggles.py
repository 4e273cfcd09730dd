"""Scenes with one effect switched, from which the size and cost of an effect are determined."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from msgspec import structs

from flankload.errors import SceneError
from flankload.scene.effects import MODIFICATIONS, switches_of
from flankload.scene.effects.keys import EffectsAsked

if TYPE_CHECKING:
    from collections.abc import Iterable

    from flankload.scene import Scene

#: Assumed values of an effect that is off in a scene and has no value there.
ASSUMED: dict[str, dict[str, Any]] = {
    "friction": {"friction_coefficient": 0.1},
    "thermal_growth": {"temperature_rise_K": 50.0},
    "centrifugal_growth": {"speed_rpm": 3000.0},
    "segment": {"segment_teeth": 5},
    "land_friction": {"land_friction": 0.1},
}
_WHOLE = {"body": "whole", "segment_teeth": None}
#: Values of [effects] that switch an effect on and off, for effects with one key.
LEVELS: dict[str, tuple[dict[str, Any], dict[str, Any]]] = {
    "segment": ({"body": "segment"}, _WHOLE),
    "single_tooth": ({"body": "tooth", "segment_teeth": None}, _WHOLE),
    "tooth_coupling": ({"tooth_coupling": True}, {"tooth_coupling": False}),
    "nodal_near_field": ({"near_field": "nodes"}, {"near_field": "analytic"}),
    "finite_influence": ({"influence": "finite"}, {"influence": "small"}),
    "lumped_contact": ({"contact": "lumped"}, {"contact": "pairs"}),
    "tip_contact": ({"tip_contact": True}, {"tip_contact": False}),
    "coast_flanks": ({"coast_flank": True}, {"coast_flank": False}),
    "root_stress": ({"root_stress": True}, {"root_stress": False}),
    "large_displacement": ({"large_displacement": True}, {"large_displacement": False}),
    "land_lift": ({"land_lift": True}, {"land_lift": False}),
}
#: Keys of [effects] that set a quantity; without them the effect is off.
QUANTITIES: dict[str, tuple[str, ...]] = {
    "friction": ("friction_coefficient",),
    "land_friction": ("land_friction",),
    "thermal_growth": (
        "temperature_rise_K",
        "thermal_expansion_per_K",
        "support_expansion_per_K",
    ),
    "centrifugal_growth": ("speed_rpm", "density_kg_m3"),
}
#: Bodies that can be rigid.
RIGID = {"elastic_body_1": "body_1", "elastic_body_2": "body_2"}
#: Keys of a body that switch an effect off, with their values for that.
REMOVED: dict[str, dict[str, Any]] = {
    "pitch_errors": {"pitch_errors_um": ()},
    "flank_modifications": dict.fromkeys((*MODIFICATIONS, "tip_relief_start_diameter_mm")),
}


@dataclass(frozen=True)
class Toggle:
    """A scene with one effect switched.

    Attributes
    ----------
    scene : Scene or None
        None if the scene cannot have the effect switched.
    assumed : str or None
        Value that the scene does not set and that was assumed, as key and value.
    impossible : str or None
        Reason why the effect cannot be switched.
    """

    scene: Scene | None
    assumed: str | None = None
    impossible: str | None = None


def toggles(scene: Scene, names: Iterable[str]) -> dict[str, Toggle]:
    """Scenes with each of some effects switched, except effects that no key switches.

    Parameters
    ----------
    scene : Scene
    names : iterable of str
        Rows of the table of effects.

    Returns
    -------
    dict of str to Toggle
    """
    switches, found = switches_of(scene), {}
    for name in names:
        try:
            toggle = toggled(scene, name, on=switches[name].on)
        except SceneError as error:
            toggle = Toggle(None, impossible=str(error))
        if toggle is not None:
            found[name] = toggle
    return found


def toggled(scene: Scene, name: str, *, on: bool) -> Toggle | None:
    """A scene with one effect switched.

    Parameters
    ----------
    scene : Scene
    name : str
        Row of the table of effects.
    on : bool
        Whether the scene has the effect.

    Returns
    -------
    Toggle or None
        None if the switched scene is undefined.

    Raises
    ------
    SceneError
        If the switched scene is impossible.
    """
    taken = {} if on else ASSUMED.get(name, {})
    assumed = next((f"effects.{key} = {value:g}" for key, value in taken.items()), None)
    if name in QUANTITIES and on:
        return Toggle(without_keys(scene, *QUANTITIES[name]))
    if name in LEVELS or name in QUANTITIES:
        level = LEVELS[name][1 if on else 0] if name in LEVELS else {}
        found = with_keys(scene, **level, **taken)
    elif name in RIGID:
        other = scene.body_2 if name == "elastic_body_1" else scene.body_1
        # the load sharing of flanks between two rigid bodies is undefined
        if not any(scene.torques_Nm) or (on and getattr(other, "rigid", False)):
            return None
        found = with_rigid(scene, RIGID[name], rigid=on)
    elif name in REMOVED and on:
        return Toggle(
            replace(
                scene,
                body_1=_without(scene.body_1, REMOVED[name]),
                body_2=_without(scene.body_2, REMOVED[name]),
            )
        )
    elif name == "several_torques":
        most = max(scene.torques_Nm)
        load = structs.replace(scene.load, torque_Nm=most if on else (most, most))
        return Toggle(replace(scene, load=load))
    else:
        return None
    found.check()
    return Toggle(found, assumed)


def with_keys(scene: Scene, **keys: Any) -> Scene:
    """A scene with these keys of [effects] set explicitly."""
    effects = structs.replace(scene.effects, **keys)
    return replace(scene, effects=effects, named_effects=scene.named_effects | set(keys))


def without_keys(scene: Scene, *keys: str) -> Scene:
    """A scene with these keys of [effects] removed."""
    plain = EffectsAsked()
    effects = structs.replace(scene.effects, **{key: getattr(plain, key) for key in keys})
    return replace(scene, effects=effects, named_effects=scene.named_effects - set(keys))


def with_rigid(scene: Scene, key: str, *, rigid: bool) -> Scene:
    """A scene with a rigid or an elastic body."""
    return replace(scene, **{key: structs.replace(getattr(scene, key), rigid=rigid)})


def _without(body: Any, keys: dict[str, Any]) -> Any:
    """A body, or the profile of a mesh, with some keys removed."""
    here = {key: value for key, value in keys.items() if key in body.__struct_fields__}
    profile = getattr(body, "profile", None)
    if not here and hasattr(profile, "__struct_fields__"):
        here["profile"] = _without(profile, keys)
    return structs.replace(body, **here) if here else body
