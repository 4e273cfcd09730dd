"""How finely a run is discretized, as keys of a scene."""

from __future__ import annotations

from dataclasses import asdict, dataclass, fields, replace
from typing import TYPE_CHECKING, Any

from msgspec import structs

from flankload.scene.axial import DEGREES_ABOVE_LOAD
from flankload.scene.discretization import DEFAULT, IN_SLICES
from flankload.scene.effects.keys import EffectsAsked
from flankload.scene.plane_section import plane_section

if TYPE_CHECKING:
    from flankload.scene import Scene

MOST_STRIPS = 200.0
#: Adaptive positions may grow to so many times those they begin with.
ADAPTIVE_GROWTH = 64
#: Keys of [effects] that a discretization decides on, and what no error is asked of.
LEVELS_AND_EXTRAS = ("contact", "near_field", "root_stress")


@dataclass(frozen=True)
class NamedDiscretization:
    """What a run is discretized with; None is left as the scene has it.

    Attributes
    ----------
    level : {"pairs", "lumped", "nodes", "slices", "plane"}
        Contact pairs on strips; one unknown for each place of contact; plain nodal loads; slices of
        three-dimensional bodies; contact pairs on the plane section of such.
    flank_element_mm : float or None
    modes : int or None
    strips_per_half_width : float or None
        At sharp corners as many more as by default.
    zone_half_widths : float or None
    axial_degree, load_degree_z, slices : int or None
        In three dimensions; the second is lowered to the first less four.
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
    axial_degree: int | None = None
    load_degree_z: int | None = None
    slices: int | None = None

    def __post_init__(self) -> None:
        if self.axial_degree is not None and self.load_degree_z is not None:
            resolved = min(self.load_degree_z, self.axial_degree - DEGREES_ABOVE_LOAD)
            object.__setattr__(self, "load_degree_z", resolved)

    @property
    def as_it_stands(self) -> bool:
        """Whether nothing of the scene is changed."""
        return self == NamedDiscretization()

    def as_dict(self) -> dict[str, Any]:
        """What is named, by name."""
        return {key: value for key, value in asdict(self).items() if value is not None}

    @classmethod
    def from_dict(cls, tree: dict[str, Any]) -> NamedDiscretization:
        """The discretization that `as_dict` shows."""
        return cls(**{field.name: tree[field.name] for field in fields(cls) if field.name in tree})

    @property
    def accuracy_keys(self) -> dict[str, Any]:
        """Keys of [accuracy]."""
        strips = self.strips_per_half_width
        grid = IN_SLICES if self.level == "slices" else DEFAULT.grid
        at_corners = grid.corner_strips_per_half_width / grid.strips_per_half_width
        keys = {
            "flank_element_mm": self.flank_element_mm,
            "modes": self.modes,
            "strips_per_half_width": strips,
            "corner_strips_per_half_width": strips and min(MOST_STRIPS, at_corners * strips),
            "zone_half_widths": self.zone_half_widths,
            "axial_degree": self.axial_degree,
            "load_degree_z": self.load_degree_z,
            "slices": self.slices,
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
        return {"lumped": {"contact": "lumped"}, "nodes": {"near_field": "nodes"}}.get(
            self.level, {}
        )

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


def scene_at(scene: Scene, discretization: NamedDiscretization) -> Scene:
    """The scene with another discretization, without error estimate and stress in the roots."""
    if discretization.level == "plane":
        scene = plane_section(scene)
    plain = EffectsAsked()
    reset = {key: getattr(plain, key) for key in LEVELS_AND_EXTRAS if hasattr(plain, key)}
    if discretization.level == "slices":
        reset.pop("contact")
    quiet = {} if discretization.as_it_stands else reset
    return with_discretization(
        replace(
            scene,
            accuracy=structs.replace(scene.accuracy, estimate=False),
            effects=structs.replace(scene.effects, **quiet),
        ),
        discretization,
    )


def with_discretization(scene: Scene, discretization: NamedDiscretization) -> Scene:
    """The scene with all keys of a discretization named, everything else unchanged."""
    accuracy = structs.replace(scene.accuracy, **discretization.accuracy_keys)
    if discretization.level == "lumped":
        accuracy = structs.replace(
            accuracy,
            strips_per_half_width=None,
            corner_strips_per_half_width=None,
            zone_half_widths=None,
        )
    even = {"adaptive": False, "tolerance": None, "max_count": None} if discretization.count else {}
    return replace(
        scene,
        accuracy=accuracy,
        positions=structs.replace(scene.positions, **(even | discretization.position_keys)),
        effects=structs.replace(scene.effects, **discretization.effect_keys),
        named_effects=scene.named_effects.union(discretization.effect_keys),
        named_discretization_keys=scene.named_discretization_keys.union(
            {f"accuracy.{key}" for key in discretization.accuracy_keys},
            {f"positions.{key}" for key in discretization.position_keys},
        ),
    )
