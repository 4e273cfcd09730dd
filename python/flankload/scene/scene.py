"""The tables of a scene file, the rules between them, and the scene, the complete input of a run.

The tables define every key once, with its type, range, unit and meaning, for the reader (`form`)
and the JSON schema.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from copy import deepcopy
from dataclasses import dataclass, fields
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any, get_args

from msgspec.structs import replace

from flankload.base.arguments import require_path
from flankload.base.card import Card
from flankload.base.files import path_of
from flankload.base.torque import N_MM_PER_N_M
from flankload.errors import SceneError, readable
from flankload.scene.accuracy import Accuracy
from flankload.scene.axial import AxialKeys, check_dimension, three_dimensional_key
from flankload.scene.belt import Belt, Pulley
from flankload.scene.cam import Cam, Follower
from flankload.scene.catalogue import with_catalogue
from flankload.scene.chain import Chain, Sprocket
from flankload.scene.derived import (
    WIDTH,
    derived_keys,
    with_common_width,
    with_pair_geometry,
    with_tip_diameters,
)
from flankload.scene.drive import check_drive
from flankload.scene.effects.keys import EffectsAsked
from flankload.scene.effects.rules import check_effects
from flankload.scene.form import read_table
from flankload.scene.former_keys import without_former_keys
from flankload.scene.gear import Gear, Ring
from flankload.scene.mates import check_base_pitches
from flankload.scene.mesh import ComplianceBody, MeshBody
from flankload.scene.pair import Load, Pair, Positions, check_partners
from flankload.scene.refusal import refuse, shown
from flankload.scene.spline import SplineHub, SplineShaft
from flankload.scene.stage import Stage, check_stage
from flankload.scene.table import BODIES, Table, Text, about, has_several_meshes
from flankload.scene.train import Train, check_train
from flankload.scene.tree import scene_tree, toml_of, with_changes
from flankload.scene.usual import with_questions

#: N mm per N m.
#: Keys of bodies that name a file.
FILE_KEYS = ("file", "profile_file", "topography_file", "compliance_file")
#: The table [pair] of chains and belts, whose scenes have none.
NO_PAIR = Pair(face_width_mm=1.0)


Body1 = Gear | SplineShaft | Follower | Sprocket | Pulley | MeshBody | ComplianceBody
Body2 = Gear | Ring | SplineHub | Cam | Chain | Belt | MeshBody | ComplianceBody
BodySpec = Body1 | Body2


class SceneFile(Table, frozen=True, kw_only=True):
    """A scene file."""

    name: Annotated[Text | None, about("name of the scene; absent = name of the file")] = None
    body_1: Annotated[Body1, about("the body that carries the torque; free to rotate")]
    body_2: Annotated[Body2, about("the body that is fixed at its kinematic angle")]
    planet: Annotated[
        Gear | None,
        about("the planets of a stage, which are equal, between the sun, body 1, and the ring"),
    ] = None
    stage: Annotated[Stage | None, about("planetary stage: body 1 is its sun, body 2 its ring")] = (
        None
    )
    body_3: Annotated[
        Gear | None, about("the third gear of a train: its idler, or the second pinion")
    ] = None
    train: Annotated[
        Train | None,
        about("external gears in two meshes: an idler, two pinions, or double helical gears"),
    ] = None
    pair: Annotated[
        Pair | None, about("required, except for chains and belts, which do not have this table")
    ] = None
    load: Load
    positions: Positions = Positions()
    effects: EffectsAsked = EffectsAsked()
    accuracy: Accuracy = Accuracy()

    @classmethod
    def also_required(cls, given: Mapping[str, Any]) -> tuple[str, ...]:
        """The table [pair], except for chains and belts."""
        for name, forms in (("body_1", Body1), ("body_2", Body2)):
            body = given.get(name)
            kind = body.get("kind") if isinstance(body, Mapping) else None
            known = [form.__struct_config__.tag for form in get_args(forms) if not form.is_drive]
            if kind not in known:
                return ()
        return ("pair",)

    @classmethod
    def given_by_others(cls, given: Mapping[str, Any]) -> Mapping[str, tuple[str, ...]]:
        """The common face width, by those of both bodies."""
        missing = []
        for name, forms in (("body_1", Body1), ("body_2", Body2)):
            body = given.get(name)
            with_width = [form for form in get_args(forms) if issubclass(form, AxialKeys)]
            kinds = [form.__struct_config__.tag for form in with_width]
            if not isinstance(body, Mapping) or body.get("kind") not in kinds:
                return {}
            missing += [] if "face_width_mm" in body else [f"{name}.face_width_mm"]
        return {} if len(missing) > 1 else {WIDTH: tuple(missing)}

    def check(self, given: Mapping[str, Any]) -> None:
        """Check the rules between the tables; `given` is the scene as in the file.

        Raises
        ------
        SceneError
            At the first key that contradicts another one; names key, expected and found.
        """
        check_partners(self.body_1, self.body_2)
        check_drive(self, given)
        if self.pair is not None:
            self.pair.check(self.body_1, self.body_2)
        check_base_pitches(self.body_1, self.body_2)
        check_stage(self, given)
        check_train(self, given)
        check_dimension(self, given)
        check_effects(self, given)
        self.positions.check(given.get("positions", {}))
        if (
            any(self.load.torques_Nm)
            and self.body_1.rigid
            and self.body_2.rigid
            and not has_several_meshes(self)
        ):
            expected = "false, since body_1.rigid is true: the load sharing of two rigid bodies "
            expected += "is undetermined"
            refuse("body_2.rigid", expected, True)


@dataclass(frozen=True, repr=False)
class Scene(Card):
    """Two bodies, their relative position, the load on them and the requested options.

    Attributes
    ----------
    name : str
    body_1 : Gear, SplineShaft, Follower, Sprocket, Pulley, MeshBody or ComplianceBody
        Driven by the torque and free to turn.
    body_2 : Gear, Ring, SplineHub, Cam, Chain, Belt, MeshBody or ComplianceBody
    pair : Pair
        Centre distance, or offset of a spline, and face width, mm.
    load : Load
        Torque on body 1, N m: one number, or a tuple with one result per torque.
    positions : Positions
    effects : EffectsAsked
    accuracy : Accuracy
    file : Path or None
        File from which the scene was read.
    planet : Gear or None
        Planets of a stage.
    stage : Stage or None
        The stage; None for two bodies.
    body_3 : Gear or None
        Third gear of a train.
    train : Train or None
        The train; None for two bodies.
    derived : frozenset of str
        Paths of the keys that follow from others (module `derived`) and are not in the file.
    named_effects : frozenset of str
        Keys of [effects] that the scene sets explicitly.
    named_discretization_keys : frozenset of str
        Keys of [accuracy] and [positions] that the scene sets explicitly, as "accuracy.modes".
    """

    name: str
    body_1: Body1
    body_2: Body2
    pair: Pair
    load: Load
    positions: Positions
    effects: EffectsAsked
    accuracy: Accuracy
    file: Path | None = None
    planet: Gear | None = None
    stage: Stage | None = None
    body_3: Gear | None = None
    train: Train | None = None
    derived: frozenset[str] = frozenset()
    named_effects: frozenset[str] = frozenset()
    named_discretization_keys: frozenset[str] = frozenset()

    @property
    def names_tolerance(self) -> bool:
        """Whether the scene sets a tolerance, which determines the rest of the discretization."""
        return "accuracy.tolerance" in self.named_discretization_keys

    @property
    def folder(self) -> Path:
        """Folder to which the paths of the bodies' files are relative."""
        return self.file.parent if self.file is not None else Path()

    @property
    def tables(self) -> tuple[Any, ...]:
        """All tables, without the name: what identifies a scene beside its files."""
        return tuple(
            getattr(self, field.name)
            for field in fields(self)
            if field.name in SceneFile.__struct_fields__ and field.name != "name"
        )

    @property
    def files(self) -> dict[str, Path]:
        """Paths of the files that the bodies name, by the dotted path of the key."""
        named = {
            f"{name}.{key}": getattr(body, key, None)
            for name, body in (
                *((name, getattr(self, name)) for name in BODIES),
                ("stage.carrier", None if self.stage is None else self.stage.carrier),
            )
            for key in FILE_KEYS
        }
        return {key: self.folder / path_of(name) for key, name in named.items() if name is not None}

    @property
    def torques_Nm(self) -> tuple[float, ...]:
        """All torques on body 1, N m."""
        return self.load.torques_Nm

    @property
    def torques_Nmm(self) -> tuple[float, ...]:
        """All torques on body 1, N mm; the only place where N m is converted to N mm."""
        return tuple(N_MM_PER_N_M * torque for torque in self.torques_Nm)

    @property
    def has_torque_list(self) -> bool:
        """Whether the scene has a list of torques, with one result for each."""
        return isinstance(self.load.torque_Nm, tuple)

    @property
    def is_drive(self) -> bool:
        """Whether body 2 is a chain or a belt around body 1."""
        return self.body_2.is_drive

    @property
    def is_concentric(self) -> bool:
        """Whether the two axes of a spline coincide, so that all positions are equivalent."""
        return self.body_1.conforms and self.pair.axes_coincide

    @property
    def sectors(self) -> int | None:
        """Number of elastic sectors of a body, an odd number; None if all sectors are elastic."""
        if self.effects.body == "whole":
            return None
        return 1 if self.effects.body == "tooth" else self.effects.segment_teeth

    @property
    def is_loaded(self) -> bool:
        """Whether the scene has a load: a torque, coast flanks (press fit), or a belt."""
        return any(self.torques_Nm) or self.effects.coast_flank or isinstance(self.body_2, Belt)

    @property
    def has_friction(self) -> bool:
        """Whether any friction coefficient of the flanks is not 0."""
        return self.effects.has_friction

    def _card_title(self) -> str:
        return f"Scene {self.name!r}"

    def _card_lines(self) -> Iterator[tuple[str, str]]:
        """Name and keys of each table."""
        if self.file is not None:
            yield "file", str(self.file)
        for name, table in scene_tree(self, implied=False).items():
            if isinstance(table, dict):
                yield name, ", ".join(f"{key} = {shown(value)}" for key, value in table.items())

    def check(self) -> None:
        """Check a scene whose keys were changed, with the same rules as for a scene file.

        Raises
        ------
        SceneError
            At the first key that contradicts another one; names key, expected and found.
        """
        asked = SceneFile(
            name=self.name,
            body_1=self.body_1,
            body_2=self.body_2,
            planet=self.planet,
            stage=self.stage,
            body_3=self.body_3,
            train=self.train,
            pair=None if self.body_2.is_drive and self.pair == NO_PAIR else self.pair,
            load=self.load,
            positions=self.positions,
            effects=self.effects,
            accuracy=self.accuracy,
        )
        named = {key: getattr(self.effects, key) for key in self.named_effects}
        asked.check({"effects": named})

    def replace(self, changes: Mapping[str, Any]) -> Scene:
        """Return the scene with other values of some keys, checked like a scene file.

        Parameters
        ----------
        changes : mapping of str to object
            By path, as "body_1.tip_relief_um", "load.torque_Nm" or "body_1.pitch_errors_um[3]":
            the new value, or None for a key that is absent. `flankload schema --paths` lists all
            paths. A path may lead to a whole table.

        Returns
        -------
        Scene

        Raises
        ------
        SceneError
            As `from_dict`; at a path that is malformed or leads to no entry of a list.

        Examples
        --------
        >>> scene.replace({"body_1.tip_relief_um": 25, "load.torque_Nm": [100, 200]})
        """
        try:
            tree = with_changes(self._tree, changes)
        except SceneError as error:
            raise (error if self.file is None else error.with_file(self.file)) from None
        return type(self).from_dict(tree, file=self.file)

    def to_dict(self) -> dict[str, Any]:
        """Keys of the scene as in its file, without those at their defaults.

        Returns
        -------
        dict
            `from_dict` makes an equal scene of it, with the same `file`. The name is included.
        """
        return deepcopy(self._tree)

    @cached_property
    def _tree(self) -> dict[str, Any]:
        """Keys of the scene, cached for many changes of one scene."""
        tree = scene_tree(self, implied=False)
        try:
            again = type(self).from_dict(tree, file=self.file)
        except SceneError:
            return scene_tree(self, implied=True)
        return tree if again == self else scene_tree(self, implied=True)

    def to_toml(self) -> str:
        """Text of a scene file with the keys of `to_dict`.

        Returns
        -------
        str
            In the folder of the scene's file it reads as an equal scene, apart from `file`: paths
            of other files remain relative to that folder.
        """
        return toml_of(self.to_dict())

    @classmethod
    def from_dict(cls, d: Mapping[str, Any], *, file: str | Path | None = None) -> Scene:
        """Make a scene from a dictionary with the keys of a scene file.

        Parameters
        ----------
        d : mapping
            Tables as mappings; each number in the unit that its key names.
        file : path, optional
            File of the scene, for messages and for relative paths of mesh files.

        Returns
        -------
        Scene

        Raises
        ------
        SceneError
            At the first key that is unknown, missing, of a wrong type, out of range, or that
            contradicts another one; names file, key, expected and found.
        """
        require_path("file", file)
        path = Path(file) if file is not None else None
        d = without_former_keys(d, path)
        try:
            asked = read_table(SceneFile, with_catalogue(d), "")
            asked = with_common_width(with_tip_diameters(asked))
            _check_all(asked, d)
            asked = with_pair_geometry(asked)
            asked = _with_slices(_without_repetition(asked, d), d)
        except SceneError as error:
            raise (error if path is None else error.with_file(path)) from None
        return cls(
            name=asked.name or (readable(path.stem) if path is not None else "scene"),
            body_1=asked.body_1,
            body_2=asked.body_2,
            pair=asked.pair or NO_PAIR,
            load=asked.load,
            positions=asked.positions,
            effects=asked.effects,
            accuracy=asked.accuracy,
            file=path,
            planet=asked.planet,
            stage=asked.stage,
            body_3=asked.body_3,
            train=asked.train,
            derived=derived_keys(asked, d),
            named_effects=frozenset(d.get("effects", {})),
            named_discretization_keys=frozenset(
                f"{table}.{key}" for table in ("accuracy", "positions") for key in d.get(table, {})
            ),
        )


def _check_all(asked: SceneFile, given: Mapping[str, Any]) -> None:
    """Check the rules of the bodies and between the tables; `given` is the scene as in the file."""
    try:
        asked.body_1.check(given["body_1"], "body_1")
        asked.body_2.check(given["body_2"], "body_2")
        for name in ("planet", "body_3"):
            if (body := getattr(asked, name)) is not None:
                body.check(given[name], name)
        asked.check(given)
    except SceneError as error:
        raise with_questions(error, asked) from None


def _without_repetition(asked: SceneFile, given: Mapping[str, Any]) -> SceneFile:
    """Use one position for concentric splines and belts, unless the scene sets positions."""
    concentric = asked.pair is not None and asked.body_1.conforms and asked.pair.axes_coincide
    if not concentric and not isinstance(asked.body_2, Belt):
        return asked
    if {"count", "angles_deg"} & set(given.get("positions", {})):
        return asked
    return replace(asked, positions=replace(asked.positions, count=1))


def _with_slices(asked: SceneFile, given: Mapping[str, Any]) -> SceneFile:
    """Use lumped contact in slices of three-dimensional bodies, unless the scene sets `contact`."""
    if "contact" in given.get("effects", {}):
        return asked
    if three_dimensional_key(asked) is None:
        return asked
    return replace(asked, effects=replace(asked.effects, contact="lumped"))
