"""The discretization of a run as keys of a scene."""

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

#: Largest number of strips that a scene can set, per half-width.
MOST_STRIPS = 200.0
#: Largest number of adaptive positions over their initial number.
MOST_POSITIONS_RATIO = 64
#: Keys of [effects] that `scene_at` resets: the contact model, and results without error estimate.
RESET_KEYS = ("contact", "near_field", "root_stress")


@dataclass(frozen=True)
class NamedDiscretization:
    """Parameters of the discretization of a run; None: the value of the scene.

    Attributes
    ----------
    level : {"pairs", "lumped", "nodes", "slices", "plane"}
        Contact model: contact pairs on strips; one unknown per place of contact; nodal forces;
        slices of three-dimensional bodies; contact pairs on their plane section.
    flank_element_mm : float or None
    modes : int or None
    strips_per_half_width : float or None
        The ratio to that at sharp corners is the default one.
    zone_half_widths : float or None
    axial_degree, load_degree_z, slices : int or None
        In three dimensions; `load_degree_z` is limited to `axial_degree` - 4.
    count : int or None
        Positions per tooth pitch (per turn of a cam); with `adaptive`, the initial ones.
    adaptive : float or None
        Tolerance of adaptive positions; None: equally spaced positions.
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
    def is_empty(self) -> bool:
        """Whether no parameter is named, so that the scene remains unchanged."""
        return self == NamedDiscretization()

    def as_dict(self) -> dict[str, Any]:
        """The named parameters."""
        return {key: value for key, value in asdict(self).items() if value is not None}

    @classmethod
    def from_dict(cls, tree: dict[str, Any]) -> NamedDiscretization:
        """The discretization from the mapping of `as_dict`."""
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
            "max_count": MOST_POSITIONS_RATIO * self.count,
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
        """The keys as text of a scene file."""
        return "\n".join(
            "\n".join([f"[{name}]", *(f"{key} = {_toml(value)}" for key, value in keys.items())])
            for name, keys in self.tables().items()
        )


def _toml(value: object) -> str:
    if isinstance(value, bool | str):
        return str(value).lower() if isinstance(value, bool) else f'"{value}"'
    return f"{value:g}" if isinstance(value, float) else str(value)


def scene_at(scene: Scene, discretization: NamedDiscretization) -> Scene:
    """The scene with another discretization, without error estimate and root stress."""
    if discretization.level == "plane":
        scene = plane_section(scene)
    plain = EffectsAsked()
    reset = {key: getattr(plain, key) for key in RESET_KEYS if hasattr(plain, key)}
    if discretization.level == "slices":
        reset.pop("contact")
    reset = {} if discretization.is_empty else reset
    return with_discretization(
        replace(
            scene,
            accuracy=structs.replace(scene.accuracy, estimate=False),
            effects=structs.replace(scene.effects, **reset),
        ),
        discretization,
    )


def with_discretization(scene: Scene, discretization: NamedDiscretization) -> Scene:
    """The scene with the parameters of a discretization; all other keys are unchanged."""
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
