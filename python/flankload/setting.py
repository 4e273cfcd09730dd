"""Settings: the knobs of accuracy as one thing, and how a scene looks at them."""

from __future__ import annotations

from dataclasses import asdict, dataclass, fields, replace
from typing import TYPE_CHECKING, Any

from msgspec import structs

from flankload.scene.effects.keys import EffectsAsked

if TYPE_CHECKING:
    from flankload.scene import Scene

#: Cells on the half-width at sharp corners, over those elsewhere.
CORNER_STRIPS = 3.0
MOST_STRIPS = 200.0
#: Adaptive positions may grow to so many times those they begin with.
ADAPTIVE_GROWTH = 64
#: Keys of [effects] that a setting decides on, and what no error is asked of.
LEVELS_AND_EXTRAS = ("contact", "near_field", "root_stress")


@dataclass(frozen=True)
class Setting:
    """Knobs of a run; None is left as the scene has it.

    Attributes
    ----------
    level : {"pairs", "lumped", "nodes"}
        Contact pairs on strips; one unknown for each place of contact; plain nodal loads.
    flank_element_mm : float or None
    modes : int or None
    strips_per_half_width : float or None
        At sharp corners three times as many.
    zone_half_widths : float or None
    count : int or None
        Positions per tooth pitch (per turn of a cam); adaptive ones begin with them.
    adaptive : float or None
        Tolerance of adaptive positions; None where they are even.
    """

    level: str = "pairs"
    flank_element_mm: float | None = None
    modes: int | None = None
    strips_per_half_width: float | None = None
    zone_half_widths: float | None = None
    count: int | None = None
    adaptive: float | None = None

    @property
    def as_it_stands(self) -> bool:
        """Whether nothing of the scene is changed."""
        return self == Setting()

    def as_dict(self) -> dict[str, Any]:
        """Knobs by name, without those that are left."""
        return {key: value for key, value in asdict(self).items() if value is not None}

    @classmethod
    def from_dict(cls, tree: dict[str, Any]) -> Setting:
        """The setting that `as_dict` shows."""
        return cls(**{field.name: tree[field.name] for field in fields(cls) if field.name in tree})

    @property
    def accuracy_keys(self) -> dict[str, Any]:
        """Keys of [accuracy]."""
        strips = self.strips_per_half_width
        keys = {
            "flank_element_mm": self.flank_element_mm,
            "modes": self.modes,
            "strips_per_half_width": strips,
            "corner_strips_per_half_width": strips and min(MOST_STRIPS, CORNER_STRIPS * strips),
            "zone_half_widths": self.zone_half_widths,
        }
        return {key: value for key, value in keys.items() if value is not None}

    @property
    def position_keys(self) -> dict[str, Any]:
        """Keys of [positions]."""
        if self.count is None:
            return {}
        if self.adaptive is None:
            return {"count": self.count}
        return {
            "count": self.count,
            "adaptive": True,
            "tolerance": self.adaptive,
            "max_count": ADAPTIVE_GROWTH * self.count,
        }

    @property
    def effect_keys(self) -> dict[str, Any]:
        """Keys of [effects]."""
        return {"pairs": {}, "lumped": {"contact": "lumped"}, "nodes": {"near_field": "nodes"}}[
            self.level
        ]

    def tables(self) -> dict[str, dict[str, Any]]:
        """The keys by table, without empty ones."""
        tables = {
            "effects": self.effect_keys,
            "accuracy": self.accuracy_keys,
            "positions": self.position_keys,
        }
        return {name: keys for name, keys in tables.items() if keys}

    def lines(self) -> str:
        """What a user puts into the scene file."""
        return "\n".join(
            "\n".join([f"[{name}]", *(f"{key} = {_toml(value)}" for key, value in keys.items())])
            for name, keys in self.tables().items()
        )


def _toml(value: object) -> str:
    if isinstance(value, bool | str):
        return str(value).lower() if isinstance(value, bool) else f'"{value}"'
    return f"{value:g}" if isinstance(value, float) else str(value)


def scene_at(scene: Scene, setting: Setting) -> Scene:
    """The scene with other knobs, without error estimate and stress in the roots.

    Parameters
    ----------
    scene : Scene
    setting : Setting

    Returns
    -------
    Scene
    """
    plain = EffectsAsked()
    reset = {key: getattr(plain, key) for key in LEVELS_AND_EXTRAS if hasattr(plain, key)}
    quiet = {} if setting.as_it_stands else reset
    return with_setting(
        replace(
            scene,
            accuracy=structs.replace(scene.accuracy, estimate=False),
            effects=structs.replace(scene.effects, **quiet),
        ),
        setting,
    )


def with_setting(scene: Scene, setting: Setting) -> Scene:
    """The scene with the knobs of a setting named, all else as it stands.

    Parameters
    ----------
    scene : Scene
    setting : Setting

    Returns
    -------
    Scene
    """
    accuracy = structs.replace(scene.accuracy, **setting.accuracy_keys)
    if setting.level == "lumped":
        accuracy = structs.replace(
            accuracy,
            strips_per_half_width=None,
            corner_strips_per_half_width=None,
            zone_half_widths=None,
        )
    even = {"adaptive": False, "tolerance": None, "max_count": None} if setting.count else {}
    return replace(
        scene,
        accuracy=accuracy,
        positions=structs.replace(scene.positions, **(even | setting.position_keys)),
        effects=structs.replace(scene.effects, **setting.effect_keys),
        named_effects=scene.named_effects.union(setting.effect_keys),
        named_knobs=scene.named_knobs.union(
            {f"accuracy.{key}" for key in setting.accuracy_keys},
            {f"positions.{key}" for key in setting.position_keys},
        ),
    )
