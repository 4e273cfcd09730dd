"""Switches of the effects that have no key in [effects]."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import TYPE_CHECKING, Any

from flankload.scene.axial import LEAD_KEYS, MISALIGNMENTS, AxialKeys, three_dimensional_key
from flankload.scene.belt import Pulley
from flankload.scene.effects.record import Switch, as_key
from flankload.scene.reliefs import ReliefKeys
from flankload.scene.table import has_several_meshes

if TYPE_CHECKING:
    from flankload.scene.scene import Scene

#: Keys of a body that modify its flank.
MODIFICATIONS = (
    *("tip_relief_um", "root_relief_um", "profile_crowning_um"),
    *("tip_radius_mm", "tip_chamfer_mm"),
)

#: Keys of the places of reliefs, of which every relief requires some.
RELIEF_PLACES = (
    *("tip_relief_knee_um", "tip_relief_knee_diameter_mm"),
    *(name for start, others in ReliefKeys.instead_of.items() for name in (start, *others)),
)

#: Reason why two bodies alone have no effect of a stage.
NO_STAGE = "stage absent"


def is_elastic(number: int) -> Callable[[Scene], Switch]:
    """Whether a body is elastic; bodies are elastic by default, except for pulleys."""

    def switch(scene: Scene) -> Switch:
        body = (scene.body_1, scene.body_2)[number - 1]
        if isinstance(body, Pulley):
            return Switch(not body.rigid, f"body_1.rigid = {as_key(body.rigid)}", not body.rigid)
        word = "= true" if body.rigid else "absent"
        return Switch(not body.rigid, f"body_{number}.rigid {word}", body.rigid)

    return switch


@lru_cache(maxsize=64)
def is_spatial(scene: Scene) -> Switch:
    """Whether the bodies are three-dimensional, and the first key that requires it."""
    key, named = three_dimensional_key(scene), scene.effects.dimension is not None
    return Switch(key is not None, key or "nothing varies along the axis", named)


def _bodies(scene: Scene) -> tuple[tuple[str, Any], ...]:
    """Bodies by the names of their tables."""
    planet = () if scene.planet is None else (("planet", scene.planet),)
    return ("body_1", scene.body_1), *planet, ("body_2", scene.body_2)


def is_modified(scene: Scene) -> Switch:
    """Whether a flank is modified, and the first key that modifies it."""
    for name, body in _bodies(scene):
        inside, table = body.flank_keys
        for key in MODIFICATIONS if table is not None else ():
            if value := getattr(table, key):
                return Switch(True, f"{name}.{inside}{key} = {as_key(value)}", True)
    return Switch(False, "no relief, crowning, tip radius or chamfer", False)


def has_lead(scene: Scene) -> Switch:
    """Whether a flank is modified along the axis, and the first key that modifies it."""
    return _first_of(scene, LEAD_KEYS, "no modification along the axis")


def has_shaft(scene: Scene) -> Switch:
    """Whether a body is on a shaft with bearings."""
    return _first_of(scene, ("shaft",), "body_*.shaft absent")


def is_misaligned(scene: Scene) -> Switch:
    """Whether the axes are not parallel."""
    for key in MISALIGNMENTS:
        if value := getattr(scene.pair, key):
            return Switch(True, f"pair.{key} = {as_key(value)}", True)
    return Switch(False, "axes are parallel", False)


def _first_of(scene: Scene, keys: tuple[str, ...], none: str) -> Switch:
    """Switch of the first of these keys along the axis that a body has."""
    for name, body in _bodies(scene):
        for key in keys if isinstance(body, AxialKeys) else ():
            value = getattr(body, key)
            if any(value) if isinstance(value, tuple) else value:
                shown = f" = {as_key(value)}" if isinstance(value, float | tuple) else ""
                return Switch(True, f"{name}.{key}{shown}", True)
    return Switch(False, none, False)


def is_misplaced(scene: Scene) -> Switch:
    """Whether a body has pitch errors."""
    for name, body in _bodies(scene):
        if any(body.pitch_errors_um):
            return Switch(True, f"{name}.pitch_errors_um", True)
    return Switch(False, "body_*.pitch_errors_um absent", False)


def has_elastic_planets(scene: Scene) -> Switch:
    """Whether a stage has elastic planets."""
    if scene.planet is None:
        return Switch(False, NO_STAGE, False)
    rigid = scene.planet.rigid
    return Switch(not rigid, f"planet.rigid {'= true' if rigid else 'absent'}", rigid)


def has_coupled_meshes(scene: Scene) -> Switch:
    """Whether forces in a mesh of a stage or a train deform the bodies in the others."""
    if not has_several_meshes(scene):
        return Switch(False, NO_STAGE, False)
    coupled, named = scene.effects.mesh_coupling, "mesh_coupling" in scene.named_effects
    found = f"= {as_key(coupled)}" if named else "absent"
    return Switch(coupled, f"effects.mesh_coupling {found}", named)


def has_floating_sun(scene: Scene) -> Switch:
    """Whether the sun of a stage floats."""
    if scene.stage is None:
        return Switch(False, NO_STAGE, False)
    member = scene.stage.floating
    return Switch(member == "sun", f'stage.floating = "{member}"', member != "none")


def has_bending_ring(scene: Scene) -> Switch:
    """Whether the outside of the ring of a stage moves."""
    if scene.stage is None:
        return Switch(False, NO_STAGE, False)
    support = scene.stage.ring_support
    return Switch(support != "clamped", f'stage.ring_support = "{support}"', support != "clamped")


def has_several_torques(scene: Scene) -> Switch:
    """Whether the scene has a list of torques."""
    torque = scene.load.torque_Nm
    return Switch(scene.has_torque_list, f"load.torque_Nm = {as_key(torque)}", True)
