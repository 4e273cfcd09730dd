"""Scenes with one effect switched, from which the size and cost of an effect are determined."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from msgspec import structs

from flankload.errors import SceneError
from flankload.scene.axial import LEAD_KEYS, MISALIGNMENTS
from flankload.scene.effects import EFFECTS, MODIFICATIONS, RELIEF_PLACES, is_spatial, switches_of
from flankload.scene.effects.keys import EffectsAsked
from flankload.scene.plane_section import in_three_dimensions, plane_section
from flankload.scene.refusal import refuse

if TYPE_CHECKING:
    from collections.abc import Iterable

    from flankload.scene import Scene

#: Effects that keys of [effects] decide on; power loss comes with friction and changes no state.
RECORDS = {row.name: row for row in EFFECTS if row.on and row.name != "power_loss"}
#: Values of [effects] with which an effect is on and off, where the deciding key is a choice.
LEVELS: dict[str, tuple[dict[str, Any], dict[str, Any]]] = {
    name: ({key: value for key, value in row.on.items() if key not in row.numbers}, row.off)
    for name, row in RECORDS.items()
    if not row.is_quantity
}
#: Keys of [effects] that set a quantity; without them the effect is off.
QUANTITIES: dict[str, tuple[str, ...]] = {
    name: tuple(row.off) for name, row in RECORDS.items() if row.is_quantity
}
#: Bodies that can be rigid.
RIGID = {"elastic_body_1": "body_1", "elastic_body_2": "body_2", "elastic_planet": "planet"}
#: Keys of a stage with which an effect is on and off; other keys that belong to it are removed.
OF_STAGE: dict[str, tuple[dict[str, Any], dict[str, Any]]] = {
    "floating_sun": (
        {"floating": "sun"},
        {"floating": "none", "sun_stiffness_N_per_um": None, "sun_weight_N": 0.0},
    ),
    "ring_support": (
        {"ring_support": "free"},
        {"ring_support": "clamped", "bolts": None, "bolt_stiffness_N_per_um": None},
    ),
}
#: Keys of a body or of the pair that switch an effect off, with their values for that.
REMOVED: dict[str, dict[str, Any]] = {
    "pitch_errors": {"pitch_errors_um": ()},
    "flank_modifications": dict.fromkeys((*MODIFICATIONS, *RELIEF_PLACES)),
    "lead_modifications": {
        **dict.fromkeys((*LEAD_KEYS, "end_relief_length_mm")),
        "tooth_helix_slope_um": (),
    },
    "misalignment": dict.fromkeys(MISALIGNMENTS, 0.0),
    "shafts": {"shaft": None},
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
    skipped : str or None
        Reason why it is not tried.
    """

    scene: Scene | None
    assumed: str | None = None
    impossible: str | None = None
    skipped: str | None = None


def toggles(scene: Scene, names: Iterable[str]) -> dict[str, Toggle]:
    """Return a scene for each effect, with that effect switched; none for effects without a key."""
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
    """Return the scene with one effect switched off if it is `on`, otherwise switched on.

    None if the switched scene is undefined.

    Raises SceneError if the switched scene is impossible.
    """
    # numbers that are assumed for an effect whose number the scene does not set
    taken = RECORDS[name].numbers if name in RECORDS and not on else {}
    assumed = next((f"effects.{key} = {value:g}" for key, value in taken.items()), None)
    if name in QUANTITIES and on:
        return Toggle(without_keys(scene, *QUANTITIES[name]))
    if name in LEVELS or name in QUANTITIES:
        level = LEVELS[name][1 if on else 0] if name in LEVELS else {}
        found = with_keys(scene, **level, **taken)
    elif name in RIGID:
        # the load sharing of flanks between two rigid bodies is undefined
        if not any(scene.torques_Nm) or (on and _rigid_beside(scene, RIGID[name])):
            return None
        found = with_rigid(scene, RIGID[name], rigid=on)
    elif name in OF_STAGE and scene.stage is not None:
        stage = structs.replace(scene.stage, **OF_STAGE[name][1 if on else 0])
        found = replace(scene, stage=stage)
    elif name in REMOVED and on:
        return Toggle(_without_tables(scene, REMOVED[name]))
    elif name == "three_dimensions":
        for table in ("body_1", "body_2"):
            if getattr(scene, table).brings_compliance:
                expected = "a body with finite elements: its file is that of a plane body or of a "
                expected += "three-dimensional one"
                refuse(f"{table}.kind", expected, "'compliance'", scene.file)
        found = plane_section(scene) if on else in_three_dimensions(scene)
    elif name == "several_torques":
        most = max(scene.torques_Nm)
        load = structs.replace(scene.load, torque_Nm=most if on else (most, most))
        return Toggle(replace(scene, load=load))
    else:
        return None
    found.check()
    return Toggle(found, assumed)


def _rigid_beside(scene: Scene, name: str) -> bool:
    """Whether a body in mesh with this one is rigid."""
    if scene.planet is None:
        mates = [scene.body_2 if name == "body_1" else scene.body_1]
    else:
        mates = [scene.body_1, scene.body_2] if name == "planet" else [scene.planet]
    return any(getattr(body, "rigid", False) for body in mates)


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


def _without_tables(scene: Scene, keys: dict[str, Any]) -> Scene:
    """A scene without some keys of its bodies and its pair, of the same dimension."""
    if is_spatial(scene).on:
        scene = with_keys(scene, dimension=3)
    tables = ("body_1", "body_2", "pair", *["planet"] * (scene.planet is not None))
    return replace(scene, **{name: _without(getattr(scene, name), keys) for name in tables})


def _without(body: Any, keys: dict[str, Any]) -> Any:
    """A table, or the profile of a mesh, with some keys removed."""
    here = {key: value for key, value in keys.items() if key in body.__struct_fields__}
    profile = getattr(body, "profile", None)
    if not here and hasattr(profile, "__struct_fields__"):
        here["profile"] = _without(profile, keys)
    return structs.replace(body, **here) if here else body
