"""Scenes from Python objects: two bodies (`Gear`, `Ring`, …) with the keys of [pair] and [load].

Each is converted to the tree of a scene file, which the reader of scene files checks.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

from flankload.scene.accuracy import Accuracy
from flankload.scene.belt import Belt, Pulley
from flankload.scene.cam import Cam, Follower
from flankload.scene.chain import Chain, Sprocket
from flankload.scene.effects.keys import EffectsAsked
from flankload.scene.form import fields_of
from flankload.scene.gear import Gear, Ring
from flankload.scene.mesh import ComplianceBody, MeshBody
from flankload.scene.pair import Load, Pair, Positions, SlackTension, TorqueOrTorques
from flankload.scene.scene import Scene
from flankload.scene.spline import SplineHub, SplineShaft
from flankload.scene.stage import Stage
from flankload.scene.table import Table
from flankload.scene.train import Train
from flankload.scene.tree import Tree, tree_of

#: Tables of a scene that a typed pair has as attributes.
WHOLE = ("positions", "effects", "accuracy")


class AsScene:
    """Conversion of bodies with the keys of their tables to a scene.

    Attributes
    ----------
    bodies : tuple of str
        Tables of the scene that are bodies.
    tables : tuple of (str, Table type)
        Tables of the scene whose keys are keyword arguments.
    """

    bodies: ClassVar[tuple[str, ...]] = ("body_1", "body_2")
    tables: ClassVar[tuple[tuple[str, type[Table]], ...]] = (("pair", Pair), ("load", Load))

    def to_dict(self) -> dict[str, Any]:
        """Return the keys as in a scene file; keys at their defaults are left out.

        Returns
        -------
        dict
            `Scene.from_dict` reads it.
        """
        keys = self._keys()
        tree: Tree = {} if keys["name"] is None else {"name": keys["name"]}
        tree |= {body: _tree(keys[body]) for body in self.bodies}
        for name, table in self.tables:
            defaults = {key: field.default for key, field in fields_of(table).items()}
            own = {key: keys[key] for key in defaults if key in keys}
            own = {k: x for k, x in own.items() if x is not None and (x == defaults[k]) is not True}
            tree |= {name: {key: _tree(value) for key, value in own.items()}} if own else {}
        for name in WHOLE:
            tree |= {name: _tree(keys[name])} if keys[name] is not None else {}
        return tree

    def _keys(self) -> dict[str, Any]:
        """Bodies, tables and keys of tables by the name in the scene."""
        return {name: getattr(self, name) for name in self.__struct_fields__}  # type: ignore[attr-defined]

    def to_scene(self) -> Scene:
        """Return the scene.

        Raises
        ------
        SceneError
            As `Scene.from_dict`.
        """
        return Scene.from_dict(self.to_dict())

    def to_toml(self) -> str:
        """Return the text of the scene file; the keys are checked.

        Raises
        ------
        SceneError
            As `Scene.from_dict`.
        """
        return self.to_scene().to_toml()


def _tree(table: Any) -> Any:
    """Keys of a table; those of explicit positions include the count, even if it is the default."""
    if not isinstance(table, Table):
        return table
    counted = isinstance(table, Positions) and table.angles_deg is None
    return tree_of(table, frozenset({"count"} if counted else ()))


class FlankPair(AsScene, Pair, frozen=True, kw_only=True):
    """Two bodies with flanks in contact and the keys of [pair]."""

    torque_Nm: TorqueOrTorques
    name: str | None = None
    positions: Positions | Mapping[str, Any] | None = None
    effects: EffectsAsked | Mapping[str, Any] | None = None
    accuracy: Accuracy | Mapping[str, Any] | None = None


class Drive(AsScene, Table, frozen=True, kw_only=True):
    """A chain or a belt on its wheel."""

    torque_Nm: TorqueOrTorques
    slack_tension_N: SlackTension = None
    name: str | None = None
    positions: Positions | Mapping[str, Any] | None = None
    effects: EffectsAsked | Mapping[str, Any] | None = None
    accuracy: Accuracy | Mapping[str, Any] | None = None


class GearPair(FlankPair, frozen=True):
    """Two gears, or a gear in a ring; both may be imported bodies.

    `torque_Nm` is required, and `face_width_mm` unless both bodies have their own; without
    `center_distance_mm` the gears have no backlash, or `normal_backlash_um`. A key at its default
    counts as absent.

    Examples
    --------
    >>> pinion = fl.Gear(teeth=16, module_mm=4.5, tip_diameter_mm=82.46, bore_diameter_mm=30)
    >>> wheel = fl.Gear(teeth=24, module_mm=4.5, tip_diameter_mm=118.36, bore_diameter_mm=40)
    >>> pair = fl.GearPair(pinion, wheel, center_distance_mm=91.5, face_width_mm=14, torque_Nm=302)
    >>> result = fl.solve(pair)
    """

    body_1: Gear | MeshBody | ComplianceBody
    body_2: Gear | Ring | MeshBody | ComplianceBody


class Spline(FlankPair, frozen=True):
    """A splined shaft in its hub; keys as for `GearPair`."""

    body_1: SplineShaft
    body_2: SplineHub


class CamAndFollower(FlankPair, frozen=True):
    """A follower, which carries the torque, on its cam; keys as for `GearPair`."""

    body_1: Follower
    body_2: Cam


class StageKeys(AsScene, Stage, frozen=True, kw_only=True):
    """The keys of [stage], [pair] and [load] of a planetary stage."""

    bodies: ClassVar[tuple[str, ...]] = ("body_1", "planet", "body_2")
    tables: ClassVar[tuple[tuple[str, type[Table]], ...]] = (
        *(("stage", Stage), ("pair", Pair), ("load", Load)),
    )

    torque_Nm: TorqueOrTorques
    center_distance_mm: float | None = None
    normal_backlash_um: float | None = None
    face_width_mm: float | None = None
    name: str | None = None
    positions: Positions | Mapping[str, Any] | None = None
    effects: EffectsAsked | Mapping[str, Any] | None = None
    accuracy: Accuracy | Mapping[str, Any] | None = None


class PlanetaryStage(StageKeys, frozen=True):
    """A sun, which carries the torque, equal planets, and a ring, with the keys of [stage].

    `torque_Nm` is required, and `planets` or `angles_deg`, and `face_width_mm` unless all bodies
    have their own; without `center_distance_mm` sun and planets have no backlash, or
    `normal_backlash_um`. A key at its default counts as absent.

    Examples
    --------
    >>> sun = fl.Gear(teeth=25, module_mm=3, tip_diameter_mm=80.7, bore_diameter_mm=30)
    >>> planet = fl.Gear(teeth=17, module_mm=3, tip_diameter_mm=56.7, bore_diameter_mm=24)
    >>> ring = fl.Ring(
    ...     teeth=59,
    ...     module_mm=3,
    ...     tip_diameter_mm=172.8,
    ...     root_diameter_mm=184.5,
    ...     outer_diameter_mm=201,
    ... )
    >>> stage = fl.PlanetaryStage(
    ...     sun,
    ...     planet,
    ...     ring,
    ...     planets=4,
    ...     floating="sun",
    ...     center_distance_mm=63,
    ...     face_width_mm=20,
    ...     torque_Nm=600,
    ... )
    >>> result = fl.solve(stage)
    """

    sun: Gear
    planet: Gear
    ring: Ring

    def _keys(self) -> dict[str, Any]:
        return {**super()._keys(), "body_1": self.sun, "body_2": self.ring}


class TrainKeys(AsScene, Table, frozen=True, kw_only=True):
    """The keys of [train], [pair] and [load] of a gear train but its kind."""

    bodies: ClassVar[tuple[str, ...]] = ("body_1", "body_3", "body_2")
    tables: ClassVar[tuple[tuple[str, type[Table]], ...]] = (
        *(("train", Train), ("pair", Pair), ("load", Load)),
    )

    torque_Nm: TorqueOrTorques
    center_distance_mm: float | None = None
    normal_backlash_um: float | None = None
    bearing_stiffness_N_per_um: float | None = None
    bearing_tilt_stiffness_Nm_per_mrad: float | None = None
    face_width_mm: float | None = None
    name: str | None = None
    positions: Positions | Mapping[str, Any] | None = None
    effects: EffectsAsked | Mapping[str, Any] | None = None
    accuracy: Accuracy | Mapping[str, Any] | None = None


class IdlerTrain(TrainKeys, frozen=True):
    """A driver, which carries the torque, an idler, and a driven gear, with the keys of [train].

    Examples
    --------
    >>> driver = fl.Gear(teeth=20, module_mm=3, tip_diameter_mm=66, bore_diameter_mm=25)
    >>> idler = fl.Gear(teeth=27, module_mm=3, tip_diameter_mm=87, bore_diameter_mm=35)
    >>> driven = fl.Gear(teeth=33, module_mm=3, tip_diameter_mm=105, bore_diameter_mm=40)
    >>> train = fl.IdlerTrain(driver, idler, driven, face_width_mm=20, torque_Nm=200)
    >>> result = fl.solve(train)
    """

    driver: Gear
    idler: Gear
    driven: Gear
    angle_deg: float = 180.0
    center_distance_2_mm: float | None = None

    def _keys(self) -> dict[str, Any]:
        bodies = {"body_1": self.driver, "body_3": self.idler, "body_2": self.driven}
        return {**super()._keys(), "kind": "idler", **bodies}


class TwoPinions(TrainKeys, frozen=True):
    """A wheel, which carries the torque, and two pinions, with the keys of [train].

    Examples
    --------
    >>> pinion = fl.Gear(teeth=20, module_mm=3, tip_diameter_mm=66, bore_diameter_mm=25)
    >>> wheel = fl.Gear(teeth=60, module_mm=3, tip_diameter_mm=186, bore_diameter_mm=80)
    >>> train = fl.TwoPinions(wheel, pinion, pinion, face_width_mm=20, torque_Nm=1200)
    >>> result = fl.solve(train)
    """

    wheel: Gear
    pinion: Gear
    second_pinion: Gear
    floating: bool = False
    timing_error_um: float = 0.0
    angle_deg: float = 180.0
    center_distance_2_mm: float | None = None

    def _keys(self) -> dict[str, Any]:
        bodies = {"body_1": self.wheel, "body_2": self.pinion, "body_3": self.second_pinion}
        return {**super()._keys(), "kind": "two_pinions", **bodies}


class DoubleHelicalPair(TrainKeys, frozen=True):
    """A double helical pinion, which carries the torque, on its wheel, with the keys of [train].

    Bodies are those of the halves of larger z; the others are their mirror images.

    Examples
    --------
    >>> helix = {"module_mm": 3, "helix_angle_deg": 25}
    >>> pinion = fl.Gear(teeth=25, hand="right", tip_diameter_mm=88.1, bore_diameter_mm=35, **helix)
    >>> wheel = fl.Gear(teeth=50, hand="left", tip_diameter_mm=170.9, bore_diameter_mm=70, **helix)
    >>> pair = fl.DoubleHelicalPair(
    ...     pinion,
    ...     wheel,
    ...     groove_width_mm=15,
    ...     face_width_mm=12,
    ...     torque_Nm=500,
    ... )
    >>> result = fl.solve(pair)
    """

    bodies: ClassVar[tuple[str, ...]] = ("body_1", "body_2")

    pinion: Gear
    wheel: Gear
    groove_width_mm: float
    axial_stiffness_N_per_um: float | None = None
    timing_error_um: float = 0.0
    inclination_um_per_mm: float = 0.0
    deviation_um_per_mm: float = 0.0
    groove_diameter_mm: float | None = None

    def _keys(self) -> dict[str, Any]:
        bodies = {"body_1": self.pinion, "body_2": self.wheel}
        return {**super()._keys(), "kind": "double_helical", **bodies}


class ChainAndSprocket(Drive, frozen=True):
    """A sprocket, which carries the torque, in its chain; `torque_Nm` is required."""

    body_1: Sprocket
    body_2: Chain


class BeltAndPulley(Drive, frozen=True):
    """A pulley, which carries the torque, in its timing belt; `torque_Nm` is required."""

    body_1: Pulley
    body_2: Belt
