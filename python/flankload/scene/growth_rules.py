"""Which keys go with growth, by heat or by speed."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flankload.scene.cam_tables import Cam
from flankload.scene.mesh_tables import ComplianceBody
from flankload.scene.refusal import refuse

if TYPE_CHECKING:
    from flankload.scene.tables import SceneFile

#: Strain up to which growth is linear, far beyond what any machine bears.
LARGEST_STRAIN = 0.02


def check_growth(asked: SceneFile) -> None:
    """Refuse what stands beside a key that is absent, and growth of elements where there are none.

    Raises
    ------
    SceneError
    """
    effects = asked.effects
    for key, other in (
        ("thermal_expansion_per_K", "temperature_rise_K"),
        ("support_expansion_per_K", "temperature_rise_K"),
        ("density_kg_m3", "speed_rpm"),
    ):
        if getattr(effects, key) is not None and getattr(effects, other) is None:
            refuse(
                f"effects.{key}",
                f"nothing, unless there is an effects.{other}",
                getattr(effects, key),
            )
    for expansion in ("thermal_expansion_per_K", "support_expansion_per_K"):
        for rise, per_K in zip(
            _of_both(effects.temperature_rise_K), _of_both(getattr(effects, expansion)), strict=True
        ):
            if abs(rise * per_K) > LARGEST_STRAIN:
                refuse(
                    "effects.temperature_rise_K",
                    f"so few K that they stretch the bodies by {LARGEST_STRAIN:g} at most, with "
                    f"effects.{expansion} {per_K:g}",
                    rise,
                )
    if effects.speed_rpm and isinstance(asked.body_2, Cam):
        refuse(
            "effects.speed_rpm",
            "nothing, since body_2.kind is 'cam': its follower, body_1, swings and does not turn",
            effects.speed_rpm,
        )
    for key in ("speed_rpm", "support_expansion_per_K"):
        if getattr(effects, key) is not None:
            _check_elements(asked, key)


def _check_elements(asked: SceneFile, key: str) -> None:
    """Growth beside what holds a body, or by its speed, is a load of finite elements."""
    if asked.effects.body == "tooth" and not (asked.body_1.rigid and asked.body_2.rigid):
        why = "effects.body is 'tooth': how a body grows is a matter of all its sectors"
        refuse(f"effects.{key}", f"nothing, since {why}", getattr(asked.effects, key))
    for name, spec in (("body_1", asked.body_1), ("body_2", asked.body_2)):
        if isinstance(spec, ComplianceBody) and not spec.rigid:
            why = f"{name}.kind is 'compliance': its file does not say how it grows"
            refuse(f"effects.{key}", f"nothing, since {why}", getattr(asked.effects, key))


def _of_both(value: float | tuple[float, ...] | None) -> tuple[float, ...]:
    """A number for each body; 0 where there is none."""
    return value if isinstance(value, tuple) else (value or 0.0,) * 2
