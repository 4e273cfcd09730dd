"""What is asked: a scene, from a TOML file or a dictionary, checked once and frozen.

Here stands the form of the input (types, keys, ranges, combinations of keys). Whether the geometry
is possible is for the bodies and the pairing to say.
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise
from math import cos, pi, radians
from pathlib import Path
from typing import Any

from msgspec.structs import replace

from flankload.errors import SceneError
from flankload.scene.belt_rules import check_belt
from flankload.scene.cam_rules import check_cam, check_cam_pair, check_follower
from flankload.scene.drive_rules import check_drive
from flankload.scene.effect_rules import check_effects
from flankload.scene.form import json_schema, read_table, shown
from flankload.scene.mesh_rules import check_sets
from flankload.scene.tables import (
    LARGEST_COEFFICIENT,
    Accuracy,
    Belt,
    Cam,
    Chain,
    ComplianceBody,
    EffectsAsked,
    Follower,
    Gear,
    InvoluteKeys,
    Load,
    MeshBody,
    Pair,
    Positions,
    Profile,
    Pulley,
    Ring,
    RingKeys,
    SceneFile,
    SplineHub,
    SplineShaft,
    Sprocket,
)

__all__ = [
    "Belt",
    "BodySpec",
    "Cam",
    "Chain",
    "ComplianceBody",
    "Follower",
    "Gear",
    "Load",
    "MeshBody",
    "Profile",
    "Pulley",
    "Ring",
    "Scene",
    "SplineHub",
    "SplineShaft",
    "Sprocket",
    "read_scene",
    "scene_schema",
]

BodySpec = (
    Gear
    | Ring
    | SplineShaft
    | SplineHub
    | Cam
    | Follower
    | Sprocket
    | Chain
    | Pulley
    | Belt
    | MeshBody
    | ComplianceBody
)

#: What stands for [pair] where there is none: a chain or a belt.
NO_PAIR = Pair(face_width_mm=1.0)
#: Bore over tip diameter: a body that is held in a point turns about it without resistance.
LEAST_BORE = 1e-3
#: Pitch error over base pitch: beyond it the teeth of one space would change places.
LARGEST_PITCH_ERROR = 0.1
#: Fewer positions to begin with overlook pairs that carry on a part of a pitch only.
LEAST_START = 8


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
    """

    name: str
    body_1: Gear | SplineShaft | Follower | Sprocket | Pulley | MeshBody | ComplianceBody
    body_2: Gear | Ring | SplineHub | Cam | Chain | Belt | MeshBody | ComplianceBody
    pair: Pair
    load: Load
    positions: Positions
    effects: EffectsAsked
    accuracy: Accuracy
    file: Path | None = None
    named_effects: frozenset[str] = frozenset()

    @property
    def folder(self) -> Path:
        """Folder that the files of bodies are relative to."""
        return self.file.parent if self.file is not None else Path()

    @property
    def torques_Nm(self) -> tuple[float, ...]:
        """All torques on body 1, N m."""
        torque = self.load.torque_Nm
        return torque if isinstance(torque, tuple) else (float(torque),)

    @property
    def has_torque_list(self) -> bool:
        """Whether the scene has a list of torques, so that there is a result for each."""
        return isinstance(self.load.torque_Nm, tuple)

    @property
    def sectors(self) -> int | None:
        """Sectors of a body that yield, an odd number; None for all of them."""
        if self.effects.body == "whole":
            return None
        return 1 if self.effects.body == "tooth" else self.effects.segment_teeth

    @property
    def has_friction(self) -> bool:
        """Whether flanks rub anywhere: a coefficient that is not 0."""
        asked = self.effects.friction_coefficient
        if not isinstance(asked, tuple):
            return bool(asked)
        return any(row[1] if isinstance(row, tuple) else row for row in asked)

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
            pair=self.pair,
            load=self.load,
            positions=self.positions,
            effects=self.effects,
            accuracy=self.accuracy,
        )
        named = {key: getattr(self.effects, key) for key in self.named_effects}
        _check_whole(asked, {"effects": named})

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
            for key, body in (("body_1", d["body_1"]), ("body_2", d["body_2"])):
                _check_body(getattr(asked, key), body, key)
            _check_whole(asked, d)
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
        )


def read_scene(path: str | Path) -> Scene:
    """Read a scene file.

    Parameters
    ----------
    path : path
        TOML file; mesh files in it are relative to its folder.

    Returns
    -------
    Scene

    Raises
    ------
    SceneError
        If the file cannot be read, is no TOML, or asks for something impossible.
    """
    path = Path(path)
    try:
        tables = tomllib.loads(path.read_bytes().decode("utf-8-sig"))
    except OSError as error:
        raise SceneError(
            file=path, key="file", expected="a scene file to read", found=_reason(error)
        ) from None
    except UnicodeDecodeError as error:
        raise SceneError(
            file=path,
            key="file",
            expected="text in UTF-8",
            found=_strange_byte(error),
        ) from None
    except tomllib.TOMLDecodeError as error:
        raise SceneError(
            file=path, key="file", expected="valid TOML", found=_syntax_error(str(error))
        ) from None
    except (RecursionError, ValueError) as error:
        # What tomllib hands on from Python itself.
        expected, found = (
            ("numbers of a few digits", "one of thousands of digits")
            if isinstance(error, ValueError)
            else ("lists of a few levels", "too many levels")
        )
        raise SceneError(file=path, key="file", expected=expected, found=found) from None
    return Scene.from_dict(tables, file=path)


def scene_schema() -> dict[str, Any]:
    """JSON schema of a scene file, with unit and meaning of each key.

    Returns
    -------
    dict
        JSON Schema, draft 2020-12; the keyword `unit` stands beside each number.
    """
    return {**json_schema(SceneFile), "title": "flankload scene"}


def _reason(error: OSError) -> str:
    return (error.strerror or type(error).__name__).lower()


def _strange_byte(error: UnicodeDecodeError) -> str:
    line = error.object.count(b"\n", 0, error.start) + 1
    return f"line {line}: byte 0x{error.object[error.start]:02x}"


def _syntax_error(message: str) -> str:
    """What tomllib says, with the place in front: "line 3, column 7: unclosed string"."""
    text, _, place = message.partition(" (at ")
    return f"{place.rstrip(')')}: {text.lower()}" if place else text.lower()


def _refuse(key: str, expected: str, found: object) -> None:
    raise SceneError(
        key=key, expected=expected, found=found if isinstance(found, str) else shown(found)
    )


def _check_body(body: BodySpec, given: Mapping[str, Any], key: str) -> None:
    if isinstance(body, ComplianceBody | Sprocket | Chain | Pulley | Belt):
        return  # teeth and all else stand in its file, or is for the rules of drives to say
    if isinstance(body, Cam):
        check_cam(body, key)
        return
    if isinstance(body, Follower):
        check_follower(body, key)
        return
    if isinstance(body, MeshBody):
        check_sets(body, given, key)
    teeth = body.number_of_teeth
    if body.pitch_errors_um and len(body.pitch_errors_um) != teeth:
        _refuse(
            f"{key}.pitch_errors_um",
            f"one entry per tooth: {teeth}, as in {key}.teeth",
            f"{len(body.pitch_errors_um)} entries",
        )
    _check_pitch_errors(body, key)
    if isinstance(body, Gear | SplineShaft):
        _check_geometry(body, given, key)
        if body.bore_diameter_mm < LEAST_BORE * body.tip_diameter_mm:
            _refuse(
                f"{key}.bore_diameter_mm",
                f"at least {LEAST_BORE:g} of {key}.tip_diameter_mm "
                f"({LEAST_BORE * body.tip_diameter_mm:g}), since the body is held there",
                body.bore_diameter_mm,
            )
        if body.bore_diameter_mm >= body.tip_diameter_mm:
            _refuse(
                f"{key}.bore_diameter_mm",
                f"less than {key}.tip_diameter_mm ({body.tip_diameter_mm:g})",
                body.bore_diameter_mm,
            )
        return
    if isinstance(body, RingKeys):
        _check_geometry(body, given, key)
        _check_ring(body, key)
        return
    if body.profile is None:
        if body.reference_radius_mm is None:
            _refuse(
                f"{key}.reference_radius_mm",
                f"a number > 0, since there is no {key}.profile to take it from",
                "nothing",
            )
        return
    _check_geometry(body.profile, given["profile"], f"{key}.profile")
    if body.profile.teeth not in (None, teeth):
        _refuse(
            f"{key}.profile.teeth",
            f"{teeth} as in {key}.teeth, or nothing",
            body.profile.teeth,
        )


def _check_ring(ring: RingKeys, key: str) -> None:
    """Tip circle, root circle and outside of the rim follow each other outwards."""
    circles = ("tip_diameter_mm", "root_diameter_mm", "outer_diameter_mm")
    for inner, outer in pairwise(circles):
        if getattr(ring, outer) <= getattr(ring, inner):
            _refuse(
                f"{key}.{outer}",
                f"more than {key}.{inner} ({getattr(ring, inner):g}), since the teeth of a "
                f"{'hub' if isinstance(ring, SplineHub) else 'ring'} stand inwards",
                getattr(ring, outer),
            )


def _check_pitch_errors(body: Gear | RingKeys | SplineShaft | MeshBody, key: str) -> None:
    """A tooth cannot stand beside its place by more than a part of the pitch."""
    profile = body.profile if isinstance(body, MeshBody) else body
    if profile is not None:
        base_pitch = pi * profile.module_mm * cos(radians(profile.pressure_angle_deg))
    else:
        assert isinstance(body, MeshBody)
        base_pitch = 2 * pi * (body.reference_radius_mm or 0.0) / body.number_of_teeth
    for i, error in enumerate(body.pitch_errors_um):
        if base_pitch and abs(error) > LARGEST_PITCH_ERROR * 1000 * base_pitch:
            _refuse(
                f"{key}.pitch_errors_um[{i}]",
                f"at most {LARGEST_PITCH_ERROR:g} of the base pitch, "
                f"{LARGEST_PITCH_ERROR * 1000 * base_pitch:.0f} um",
                error,
            )


def _check_geometry(body: InvoluteKeys, given: Mapping[str, Any], key: str) -> None:
    if body.tip_radius_mm is not None and body.tip_chamfer_mm is not None:
        _refuse(
            f"{key}.tip_radius_mm",
            f"nothing beside {key}.tip_chamfer_mm: a tip has one or the other",
            f"{body.tip_radius_mm:g} and {body.tip_chamfer_mm:g}",
        )
    start = body.tip_relief_start_diameter_mm
    if body.tip_relief_um is None:
        for name in ("tip_relief_start_diameter_mm", "tip_relief_shape"):
            if name in given:
                _refuse(
                    f"{key}.tip_relief_um",
                    f"a number >= 0, since there is a {key}.{name}",
                    "nothing",
                )
    elif start is None:
        _refuse(
            f"{key}.tip_relief_start_diameter_mm",
            f"a number > 0, since there is a {key}.tip_relief_um",
            "nothing",
        )
    elif (
        start <= body.tip_diameter_mm
        if isinstance(body, RingKeys)
        else start >= body.tip_diameter_mm
    ):
        side = "more" if isinstance(body, RingKeys) else "less"
        _refuse(
            f"{key}.tip_relief_start_diameter_mm",
            f"{side} than {key}.tip_diameter_mm ({body.tip_diameter_mm:g})",
            start,
        )


def _check_whole(asked: SceneFile, given: Mapping[str, Any]) -> None:
    check_drive(asked, given)
    check_belt(asked, given)
    if asked.pair is not None:
        _check_kinds(asked, asked.pair)
    _check_friction(asked)
    _check_lumped(asked)
    check_effects(asked, given)
    _check_positions(asked.positions, given.get("positions", {}))
    torque = asked.load.torque_Nm
    loaded = any(torque) if isinstance(torque, tuple) else torque > 0
    if loaded and asked.body_1.rigid and asked.body_2.rigid:
        _refuse(
            "body_2.rigid",
            "false, since body_1.rigid is true: where neither body yields, nothing says how the "
            "flanks share the torque",
            True,
        )


def _check_positions(positions: Positions, given: Mapping[str, Any]) -> None:
    """Angles stand alone; what steers adaptive positions stands with them."""
    if positions.angles_deg is not None:
        for key in ("count", "pitches", "adaptive", "tolerance", "max_count"):
            if key in given:
                _refuse(
                    "positions.angles_deg",
                    f"nothing beside positions.{key}: one of the two",
                    positions.angles_deg,
                )
    if not positions.adaptive:
        for key in ("tolerance", "max_count"):
            if key in given:
                _refuse(
                    f"positions.{key}", "nothing, unless positions.adaptive is true", given[key]
                )
        return
    if positions.count < LEAST_START:
        _refuse(
            "positions.count",
            f"at least {LEAST_START} to begin adaptive positions with",
            positions.count,
        )
    if positions.max_count is not None and positions.max_count < positions.count:
        _refuse(
            "positions.max_count",
            f"at least positions.count ({positions.count})",
            positions.max_count,
        )


def _check_friction(asked: SceneFile) -> None:
    """A list has one number per tooth, or rows of ascending roll position and coefficient."""
    given = asked.effects.friction_coefficient
    if not isinstance(given, tuple):
        return
    key = "effects.friction_coefficient"
    rows = [row for row in given if isinstance(row, tuple)]
    if rows and len(rows) < len(given):
        _refuse(key, "numbers, one per tooth, or rows of roll position and coefficient", "both")
    for i, (roll, coefficient) in enumerate(rows):
        if not 0.0 <= coefficient <= LARGEST_COEFFICIENT:
            _refuse(f"{key}[{i}][1]", f"a number from 0 to {LARGEST_COEFFICIENT:g}", coefficient)
        if i and roll <= rows[i - 1][0]:
            _refuse(
                f"{key}[{i}][0]",
                f"more than the roll position of the row before, {rows[i - 1][0]:g}",
                roll,
            )


def _check_lumped(asked: SceneFile) -> None:
    """Lumped contact has no strips, and conforming flanks have no place to lump it in."""
    if asked.effects.contact != "lumped":
        return
    key = "effects.contact"
    if isinstance(asked.body_1, SplineShaft):
        _refuse(
            key,
            "'pairs' with body_1.kind 'spline_shaft': its flanks conform, and touch over a length "
            "instead of at a place",
            "'lumped'",
        )
    for name in ("strips_per_half_width", "corner_strips_per_half_width", "zone_half_widths"):
        if getattr(asked.accuracy, name) is not None:
            _refuse(
                f"accuracy.{name}",
                f"nothing with {key} 'lumped', which lays no strips",
                getattr(asked.accuracy, name),
            )


def _check_kinds(asked: SceneFile, pair: Pair) -> None:
    """A shaft stands in a hub, on an offset; all other bodies stand on a centre distance."""
    check_cam_pair(asked)
    splines = isinstance(asked.body_1, SplineShaft), isinstance(asked.body_2, SplineHub)
    if any(splines) and not all(splines):
        _refuse(
            "body_2.kind",
            "'spline_hub' with body_1.kind 'spline_shaft': the two go together and with no other",
            f"'{asked.body_2.kind}' with body_1.kind '{asked.body_1.kind}'",
        )
    distance, offset = pair.center_distance_mm, pair.center_offset_mm
    if all(splines) and distance is not None:
        _refuse(
            "pair.center_distance_mm",
            "nothing: a spline's axes stand on pair.center_offset_mm (absent = 0)",
            distance,
        )
    if not any(splines) and offset is not None:
        _refuse(
            "pair.center_offset_mm",
            f"nothing: a {asked.body_1.kind} and a {asked.body_2.kind} stand on "
            "pair.center_distance_mm, only splines on an offset",
            offset,
        )
    if not any(splines) and distance is None:
        _refuse("pair.center_distance_mm", "a number from 0.001 to 100000", "nothing")


def _without_repetition(asked: SceneFile, given: Mapping[str, Any]) -> SceneFile:
    """Concentric splines have one position, unless more are asked for."""
    if asked.body_1.kind != "spline_shaft" or asked.pair is None or asked.pair.axes_apart_mm > 0:
        return asked
    if {"count", "angles_deg"} & set(given.get("positions", {})):
        return asked
    return replace(asked, positions=replace(asked.positions, count=1))
