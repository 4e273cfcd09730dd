"""Keys from the names of belt profiles, chains and materials; keys of the scene have precedence."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from flankload.scene.belt import Pulley
from flankload.scene.belt_profiles import BELT_PROFILES, Estimate
from flankload.scene.chain import Chain
from flankload.scene.chain_sizes import CHAIN_SIZES
from flankload.scene.form import check_key
from flankload.scene.materials import EFFECT_KEYS, ELASTIC_KEYS, MATERIALS, NamedMaterial
from flankload.scene.table import BODIES

if TYPE_CHECKING:
    from flankload.scene.scene import Scene
    from flankload.scene.table import Table

    Tree = Mapping[str, Any]
    Keys = dict[str, dict[str, Any]]

#: Body, its table and the key with the name of a profile or a chain.
NAMES_OF_DRIVES: tuple[tuple[str, type[Table], str], ...] = (
    ("body_1", Pulley, "profile"),
    ("body_2", Chain, "chain"),
)


def with_catalogue(tree: Any) -> Any:
    """Complete a scene with the keys that follow from its names and that it does not set.

    The tree is that of a scene file; without such a name, the same object is returned. Entries that
    should be tables but are not are left to the reader.

    Raises
    ------
    SceneError
        If a profile or a chain is unknown.
    """
    for name, form, key in NAMES_OF_DRIVES:
        body = _table(tree, name)
        if key in body and body.get("kind") == form.__struct_config__.tag:
            check_key(form, key, body[key], f"{name}.{key}")
    added = catalogue_keys(tree)
    if not added:
        return tree
    return {**tree, **{name: {**keys, **tree.get(name, {})} for name, keys in added.items()}}


def catalogue_keys(tree: Any) -> Keys:
    """Keys that follow from the names of a scene, by table, also those that the scene sets."""
    bodies = [_table(tree, name) for name in ("body_1", "body_2")]
    found: Keys = {name: {} for name in BODIES}
    for name in found:
        body = _table(tree, name)
        material = _entry(MATERIALS, body, "material")
        if material is not None:
            found[name] = {key: getattr(material, key) for key in ELASTIC_KEYS}
    for name, keys in _drive_keys(bodies).items():
        found[name] |= keys
    effects = _effect_keys(bodies, _table(tree, "effects"))
    return {name: keys for name, keys in {**found, "effects": effects}.items() if keys}


def keys_of_names(tree: Tree) -> Keys:
    """Keys of the bodies that follow from the names alone, without other keys, by body."""
    names = ("kind", "profile", "chain", "material")
    return catalogue_keys(
        {
            body: {key: _table(tree, body)[key] for key in names if key in _table(tree, body)}
            for body in BODIES
        }
    )


def _drive_keys(bodies: list[Tree]) -> Keys:
    """Keys of pulley and belt, or of sprocket and chain."""
    wheel, around = bodies
    kinds = (wheel.get("kind"), around.get("kind"))
    profile = _entry(BELT_PROFILES, wheel, "profile")
    if kinds == ("pulley", "belt") and profile is not None:
        values = {key: estimate.value for key, estimate in profile.estimates.items()}
        pitch = {"pitch_mm": profile.pitch_mm}
        return {"body_1": pitch, "body_2": {**pitch, **profile.belt, **values}}
    size = _entry(CHAIN_SIZES, around, "chain")
    if kinds == ("sprocket", "chain") and size is not None:
        common = {"pitch_mm": size.pitch_mm, "roller_diameter_mm": size.roller_diameter_mm}
        # a key set for one body applies to the other, since chain and sprocket must agree
        common = {key: wheel.get(key, around.get(key, common[key])) for key in common}
        values = {key: estimate.value for key, estimate in size.estimates.items()}
        return {"body_1": common, "body_2": {**common, **values}}
    return {}


def _effect_keys(bodies: list[Tree], effects: Tree) -> dict[str, Any]:
    """Thermal expansion and density, if an effect uses them and a body names its material."""
    named: list[NamedMaterial | None] = [_entry(MATERIALS, body, "material") for body in bodies]
    if not any(named):
        return {}
    both = [material or MATERIALS["steel"] for material in named]
    return {
        key: [getattr(material, key) for material in both]
        for key, user in EFFECT_KEYS.items()
        if user in effects
    }


def estimate_notes(scene: Scene) -> tuple[str, ...]:
    """Notes about the estimated keys of a scene."""
    estimates: dict[str, Estimate] = {}
    around = scene.body_2
    if scene.is_drive:
        profile = BELT_PROFILES.get(getattr(scene.body_1, "profile", ""))
        size = CHAIN_SIZES.get(getattr(around, "chain", None) or "")
        named = profile or size
        estimates = named.estimates if named is not None else {}
    return tuple(
        f"body_2.{key} = {estimate.value:g} is an estimate: {estimate.reason}"
        for key, estimate in estimates.items()
        if getattr(around, key) == estimate.value
    )


def _table(tree: Any, name: str) -> Tree:
    table = tree.get(name) if isinstance(tree, Mapping) else None
    return table if isinstance(table, Mapping) else {}


def _entry(entries: Mapping[str, Any], body: Tree, key: str) -> Any:
    name = body.get(key)
    return entries.get(name) if isinstance(name, str) else None
