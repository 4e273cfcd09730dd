"""A scene: what is asked, checked once and frozen."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from msgspec.structs import replace

from flankload.errors import SceneError
from flankload.scene.accuracy import Accuracy
from flankload.scene.belt import Belt
from flankload.scene.effects.keys import EffectsAsked
from flankload.scene.form import read_table
from flankload.scene.pair import Load, Pair, Positions
from flankload.scene.scene_file import Body1, Body2, SceneFile

#: N mm in a N m.
N_MM_PER_N_M = 1000.0
#: What stands for [pair] where there is none: a chain or a belt.
NO_PAIR = Pair(face_width_mm=1.0)


@dataclass(frozen=True)
class Scene:
    """Two bodies, how they stand, what they carry and what is wanted.

    Attributes
    ----------
    name : str
    body_1 : Gear, SplineShaft, Follower, Sprocket, Pulley, MeshBody or ComplianceBody
        Free to turn; carries the torque.
    body_2 : Gear, Ring, SplineHub, Cam, Chain, Belt, MeshBody or ComplianceBody
    pair : Pair
        Centre distance, or offset of a spline, and face width, mm.
    load : Load
        Torque on body 1, N m: a number, or a tuple (one result per torque).
    positions : Positions
    effects : EffectsAsked
    accuracy : Accuracy
    file : Path or None
        The scene's file.
    named_effects : frozenset of str
        Keys of [effects] that are named, not left to their defaults.
    named_knobs : frozenset of str
        The same of [accuracy] and of [positions], as "accuracy.modes".
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
    named_effects: frozenset[str] = frozenset()
    named_knobs: frozenset[str] = frozenset()

    @property
    def steers(self) -> bool:
        """Whether the scene names a tolerance, which then decides on the knobs that it leaves."""
        return "accuracy.tolerance" in self.named_knobs

    @property
    def folder(self) -> Path:
        """Folder that the files of bodies are relative to."""
        return self.file.parent if self.file is not None else Path()

    @property
    def files(self) -> dict[str, Path]:
        """Files that bodies name, by their keys."""
        named = {
            f"{name}.{key}": getattr(body, key, None)
            for name, body in (("body_1", self.body_1), ("body_2", self.body_2))
            for key in ("file", "profile_file")
        }
        return {key: self.folder / file for key, file in named.items() if file is not None}

    @property
    def torques_Nm(self) -> tuple[float, ...]:
        """All torques on body 1, N m."""
        return self.load.torques_Nm

    @property
    def torques_Nmm(self) -> tuple[float, ...]:
        """All torques on body 1, N mm: the one place where N m becomes N mm."""
        return tuple(N_MM_PER_N_M * torque for torque in self.torques_Nm)

    @property
    def has_torque_list(self) -> bool:
        """Whether the scene has a list of torques, so that there is a result for each."""
        return isinstance(self.load.torque_Nm, tuple)

    @property
    def is_drive(self) -> bool:
        """Whether a chain or a belt lies around body 1."""
        return self.body_2.is_drive

    @property
    def is_concentric(self) -> bool:
        """Whether the axes of a spline are one, so that all positions are alike."""
        return self.body_1.conforms and self.pair.axes_apart_mm == 0.0

    @property
    def sectors(self) -> int | None:
        """Sectors of a body that yield, an odd number; None for all of them."""
        if self.effects.body == "whole":
            return None
        return 1 if self.effects.body == "tooth" else self.effects.segment_teeth

    @property
    def is_loaded(self) -> bool:
        """By a torque, by flanks that may press on each other across the teeth, or by a belt."""
        return any(self.torques_Nm) or self.effects.coast_flank or isinstance(self.body_2, Belt)

    @property
    def has_friction(self) -> bool:
        """Whether flanks rub anywhere: a coefficient that is not 0."""
        return self.effects.has_friction

    def check(self) -> None:
        """Refuse what no scene file may have, of a scene whose keys were changed.

        Raises
        ------
        SceneError
            At the first key that contradicts another one; names key, expected and found.
        """
        asked = SceneFile(
            name=self.name,
            body_1=self.body_1,
            body_2=self.body_2,
            pair=None if self.body_2.is_drive and self.pair == NO_PAIR else self.pair,
            load=self.load,
            positions=self.positions,
            effects=self.effects,
            accuracy=self.accuracy,
        )
        named = {key: getattr(self.effects, key) for key in self.named_effects}
        asked.check({"effects": named})

    @classmethod
    def from_dict(cls, d: Mapping[str, Any], *, file: str | Path | None = None) -> Scene:
        """Make a scene from a dictionary with the keys of a scene file.

        Parameters
        ----------
        d : mapping
            Tables as mappings; every number in the unit its key names.
        file : path, optional
            Where the scene comes from: for messages and relative mesh paths.

        Returns
        -------
        Scene

        Raises
        ------
        SceneError
            At the first key that is unknown, missing, of a wrong type, out of range, or that
            contradicts another one; names file, key, expected and found.
        """
        path = Path(file) if file is not None else None
        try:
            asked = read_table(SceneFile, d, "")
            asked.body_1.check(d["body_1"], "body_1")
            asked.body_2.check(d["body_2"], "body_2")
            asked.check(d)
            asked = _without_repetition(asked, d)
        except SceneError as error:
            raise (error if path is None else error.with_file(path)) from None
        return cls(
            name=asked.name or (path.stem if path is not None else "scene"),
            body_1=asked.body_1,
            body_2=asked.body_2,
            pair=asked.pair or NO_PAIR,
            load=asked.load,
            positions=asked.positions,
            effects=asked.effects,
            accuracy=asked.accuracy,
            file=path,
            named_effects=frozenset(d.get("effects", {})),
            named_knobs=frozenset(
                f"{table}.{key}" for table in ("accuracy", "positions") for key in d.get(table, {})
            ),
        )


def _without_repetition(asked: SceneFile, given: Mapping[str, Any]) -> SceneFile:
    """Concentric splines and belts have one position, unless more are asked for."""
    concentric = asked.pair is not None and asked.body_1.conforms and not asked.pair.axes_apart_mm
    if not concentric and not isinstance(asked.body_2, Belt):
        return asked
    if {"count", "angles_deg"} & set(given.get("positions", {})):
        return asked
    return replace(asked, positions=replace(asked.positions, count=1))
