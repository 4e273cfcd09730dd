"""Whether a scene calls for an effect, and because of which key."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from flankload.scene import (
    Belt,
    BodySpec,
    Cam,
    Chain,
    ComplianceBody,
    Follower,
    MeshBody,
    Pulley,
    Scene,
    Sprocket,
)
from flankload.scene.effects.effect import Switch

#: Keys of a body by which its flank departs from the involute.
MODIFICATIONS = ("tip_relief_um", "profile_crowning_um", "tip_radius_mm", "tip_chamfer_mm")


def _is_loaded(scene: Scene) -> bool:
    """By a torque, by flanks that may press on each other across the teeth, or by a taut belt."""
    taut = isinstance(scene.body_2, Belt)
    return any(scene.torques_Nm) or scene.effects.coast_flank or taut


def yields(number: int) -> Callable[[Scene], Switch]:
    """A body yields unless it is rigid or nothing loads it."""

    def switch(scene: Scene) -> Switch:
        body = (scene.body_1, scene.body_2)[number - 1]
        if isinstance(body, Pulley):
            word = "true" if body.rigid else "false"
            return Switch(not body.rigid, f"body_{number}.rigid = {word}", not body.rigid)
        if body.rigid:
            return Switch(False, f"body_{number}.rigid = true", True)
        if not _is_loaded(scene):
            return Switch(False, "load.torque_Nm = 0", True)
        return Switch(True, f"body_{number}.rigid absent", False)

    return switch


def level(key: str, value: object, default: object) -> Callable[[Scene], Switch]:
    """A key of [effects] has this value."""

    def switch(scene: Scene) -> Switch:
        asked = getattr(scene.effects, key, default)
        if key in scene.named_effects:
            return Switch(asked == value, f"effects.{key} = {_shown(asked)}", True)
        return Switch(asked == value, f"effects.{key} absent", False)

    return switch


def quantity(key: str) -> Callable[[Scene], Switch]:
    """A key of [effects] has a number, or numbers, other than 0."""

    def switch(scene: Scene) -> Switch:
        asked = getattr(scene.effects, key, None)
        if asked is None or (not asked and key not in scene.named_effects):
            return Switch(False, f"effects.{key} absent", False)
        numbers = asked if isinstance(asked, tuple) else (asked,)
        return Switch(any(numbers), f"effects.{key} = {_shown(asked)}", True)

    return switch


def rubs(scene: Scene) -> Switch:
    """A coefficient of friction that is not 0 anywhere."""
    asked = scene.effects.friction_coefficient
    if asked is None:
        return Switch(False, "effects.friction_coefficient absent", False)
    return Switch(scene.has_friction, f"effects.friction_coefficient = {_shown(asked)}", True)


def stressed(scene: Scene) -> Switch:
    """Stress in the roots is asked for, and something loads them."""
    switch = level("root_stress", True, False)(scene)
    if switch.on and not _is_loaded(scene):
        return Switch(False, "load.torque_Nm = 0", True)
    return switch


def modified(scene: Scene) -> Switch:
    """The first key that says so."""
    for number, body in enumerate((scene.body_1, scene.body_2), start=1):
        key = _modification(body)
        if key is not None:
            return Switch(True, f"body_{number}.{key}", True)
    return Switch(False, "no relief, crowning, tip radius or chamfer", False)


def _modification(body: BodySpec) -> str | None:
    if isinstance(body, ComplianceBody | Cam | Follower | Sprocket | Chain | Pulley | Belt):
        return None
    inside = "profile." if isinstance(body, MeshBody) else ""
    profile = body.profile if isinstance(body, MeshBody) else body
    for key in MODIFICATIONS if profile is not None else ():
        value = getattr(profile, key)
        if value:
            return f"{inside}{key} = {_shown(value)}"
    return None


def misplaced(scene: Scene) -> Switch:
    """A tooth that stands beside its place."""
    for number, body in enumerate((scene.body_1, scene.body_2), start=1):
        if any(body.pitch_errors_um):
            return Switch(True, f"body_{number}.pitch_errors_um", True)
    return Switch(False, "body_*.pitch_errors_um absent", False)


def several(scene: Scene) -> Switch:
    """A list of torques."""
    torque = scene.load.torque_Nm
    return Switch(scene.has_torque_list, f"load.torque_Nm = {_shown(torque)}", True)


def _shown(value: Any) -> str:
    """A value as a scene file has it, of a list no more than its length."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, tuple):
        return f"[{len(value)} entries]"
    return f'"{value}"' if isinstance(value, str) else f"{value:g}"
