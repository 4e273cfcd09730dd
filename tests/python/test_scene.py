"""Scenes: what is understood, and the one line that each mistake gets."""

import datetime
import json
import tomllib
from collections.abc import Mapping
from copy import deepcopy
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from flankload.effects import effects_of
from flankload.errors import SceneError
from flankload.scene import Scene, read_scene, scene_schema
from flankload.scene.tables import EffectsAsked

EXAMPLES = Path(__file__).parents[2] / "examples" / "scenes"

GEAR = {"kind": "gear", "teeth": 16, "module_mm": 4.5, "tip_diameter_mm": 82.46}
SCENE: dict[str, Any] = {
    "name": "pair",
    "body_1": {**GEAR, "bore_diameter_mm": 30},
    "body_2": {**GEAR, "bore_diameter_mm": 30},
    "pair": {"center_distance_mm": 72.0, "face_width_mm": 14},
    "load": {"torque_Nm": 302},
}
PROFILE = {"module_mm": 4.5, "tip_diameter_mm": 82.46}
ROUNDED = {**PROFILE, "tip_radius_mm": 0.3}
MESH = {"kind": "mesh", "file": "a.msh", "teeth": 16, "profile": PROFILE}

RING = {
    **{"kind": "ring", "teeth": 60, "module_mm": 4.5, "tip_diameter_mm": 262},
    **{"root_diameter_mm": 281, "outer_diameter_mm": 320},
}

ABSENT = object()
#: Kinds of body 1, as a message names them.
KINDS_1 = (
    "'gear' or 'spline_shaft' or 'follower' or 'sprocket' or 'pulley' or 'mesh' or 'compliance'"
)

#: Keys of [effects], in their order.
EFFECT_KEYS = ("friction_coefficient", "root_stress", "contact", "coast_flank", "tip_contact")

#: What two rigid bodies are told.
UNDETERMINED = "where neither body yields, nothing says how the flanks share the torque"


def changed(**changes: Any) -> dict[str, Any]:
    """The valid scene with keys (dots written as two underscores) set, or taken away if ABSENT."""
    scene = deepcopy(SCENE)
    for path, value in changes.items():
        *tables, key = path.split("__")
        table = scene
        for name in tables:
            table = table.setdefault(name, {})
        if value is ABSENT:
            del table[key]
        else:
            table[key] = value
    return scene


def refusal(scene: Any) -> SceneError:
    with pytest.raises(SceneError) as caught:
        Scene.from_dict(scene, file="a.toml")
    return caught.value


# --- what is understood ---------------------------------------------------------------------------
def test_defaults_and_units_are_those_of_the_scene_format() -> None:
    scene = Scene.from_dict(SCENE)
    body = scene.body_1
    assert body.kind == "gear"
    assert (body.pressure_angle_deg, body.profile_shift) == (20.0, 0.0)
    assert (body.dedendum_factor, body.fillet_radius_factor) == (1.25, 0.38)
    assert (body.young_modulus_MPa, body.poisson_ratio, body.rigid) == (206000.0, 0.3, False)
    assert body.tip_relief_um is None
    assert body.tip_relief_shape == "linear"
    assert body.pitch_errors_um == ()
    assert (scene.positions.count, scene.positions.driver) == (32, "body_1")
    accuracy = scene.accuracy
    assert (accuracy.tolerance, accuracy.plane, accuracy.estimate) == (0.01, "strain", True)
    assert scene.file is None
    assert scene.name == "pair"


def test_integers_do_where_numbers_are_wanted() -> None:
    scene = Scene.from_dict(changed(load__torque_Nm=302))
    assert isinstance(scene.load.torque_Nm, float)
    assert not scene.has_torque_list


def test_list_of_torques() -> None:
    scene = Scene.from_dict(changed(load__torque_Nm=[0, 100, 302.5]))
    assert scene.load.torque_Nm == (0.0, 100.0, 302.5)
    assert scene.has_torque_list


def test_numpy_values_are_welcome() -> None:
    scene = Scene.from_dict(
        changed(load__torque_Nm=np.float32(302), body_1__teeth=np.int64(17), positions={"count": 4})
    )
    assert scene.body_1.teeth == 17
    angles = Scene.from_dict(changed(positions={"angles_deg": np.array([0.0, 1.5])}))
    assert angles.positions.angles_deg == (0.0, 1.5)


def test_mesh_body_with_and_without_profile() -> None:
    scene = Scene.from_dict(
        changed(body_1=MESH, body_2={**MESH, "profile": None, "reference_radius_mm": 33.8})
        | {
            "body_2": {k: v for k, v in MESH.items() if k != "profile"}
            | {"reference_radius_mm": 33}
        }
    )
    assert scene.body_1.kind == scene.body_2.kind == "mesh"
    assert scene.body_1.cut_sets == ("CUT_LEFT", "CUT_RIGHT")
    assert scene.body_1.profile.module_mm == 4.5
    assert scene.body_2.profile is None
    assert scene.body_2.reference_radius_mm == 33.0


def test_ring_is_body_2_with_its_own_keys() -> None:
    ring = Scene.from_dict(changed(body_2=RING)).body_2
    assert ring.kind == "ring"
    assert (ring.pressure_angle_deg, ring.profile_shift, ring.rigid) == (20.0, 0.0, False)
    assert (ring.root_fillet_radius_mm, ring.tip_relief_um) == (None, None)
    assert (ring.young_modulus_MPa, ring.poisson_ratio) == (206000.0, 0.3)
    assert (ring.root_diameter_mm, ring.outer_diameter_mm) == (281.0, 320.0)


def test_scene_does_not_change_its_dictionary() -> None:
    given = deepcopy(SCENE)
    Scene.from_dict(given)
    assert given == SCENE


def test_name_of_the_file_stands_in_for_a_missing_name() -> None:
    scene = Scene.from_dict(changed(name=ABSENT), file="folder/my_pair.toml")
    assert scene.name == "my_pair"
    assert scene.folder == Path("folder")


@pytest.mark.parametrize("path", sorted(EXAMPLES.glob("*.toml")), ids=lambda path: path.stem)
def test_example_scenes_are_valid(path: Path) -> None:
    assert read_scene(path).file == path


# --- effects --------------------------------------------------------------------------------------
def test_effects_of_a_plain_pair() -> None:
    effects = effects_of(Scene.from_dict(SCENE))
    assert effects.elastic_body_1
    assert effects.elastic_body_2
    assert not effects.flank_modifications
    assert not effects.pitch_errors
    assert not effects.several_torques
    assert not effects.friction


@pytest.mark.parametrize(
    ("changes", "effect", "value"),
    [
        ({"body_1__rigid": True}, "elastic_body_1", False),
        ({"body_2__rigid": True}, "elastic_body_2", False),
        ({"body_2__tip_radius_mm": 0.3}, "flank_modifications", True),
        ({"body_1__profile_crowning_um": 4}, "flank_modifications", True),
        ({"body_1__profile_crowning_um": 0}, "flank_modifications", False),
        (
            {"body_1": {**MESH, "profile": {**PROFILE, "tip_chamfer_mm": 0.2}}},
            "flank_modifications",
            True,
        ),
        ({"body_1__pitch_errors_um": [0] * 15 + [3]}, "pitch_errors", True),
        ({"body_1__pitch_errors_um": [0] * 16}, "pitch_errors", False),
        ({"load__torque_Nm": [302]}, "several_torques", True),
        ({"body_2": {**RING, "tip_radius_mm": 0.2}}, "flank_modifications", True),
        ({"body_2": {**RING, "rigid": True}}, "elastic_body_2", False),
    ],
)
def test_effect_is_called_for(changes: dict[str, Any], effect: str, value: bool) -> None:
    assert getattr(effects_of(Scene.from_dict(changed(**changes))), effect) is value


# --- what is refused ------------------------------------------------------------------------------
@pytest.mark.parametrize(
    ("changes", "key", "expected", "found"),
    [
        # unknown keys
        (
            {"body_1__modul_mm": 4},
            "body_1.modul_mm",
            "a known key (did you mean module_mm?)",
            "the unknown key 'modul_mm'",
        ),
        (
            {"laod": {}},
            "laod",
            "a known key (did you mean load?)",
            "the unknown key 'laod'",
        ),
        (
            {"pair__x": 1},
            "pair.x",
            "a known key (center_distance_mm, center_offset_mm, face_width_mm)",
            "the unknown key 'x'",
        ),
        (
            {"effects__near_field": "nodes", "accuracy__modes": 5},
            "accuracy.modes",
            "nothing with effects.near_field 'nodes': forces at nodes stand in place of modes",
            "5",
        ),
        (
            {"effects__near_field": "nodes", "body_1": {**MESH, "profile": ROUNDED}},
            "effects.near_field",
            (
                "'analytic' with body_1.profile.tip_radius_mm: the edges of a file's flank set "
                "that carry end where the tip turns"
            ),
            "'nodes'",
        ),
        (
            {"effects__near_field": "nodes", "effects__contact": "lumped"},
            "effects.contact",
            "'pairs' with effects.near_field 'nodes': forces there have places",
            "'lumped'",
        ),
        (
            {"effects__influence": "finite", "effects__contact": "lumped"},
            "effects.contact",
            "'pairs' with effects.influence 'finite': forces there have places",
            "'lumped'",
        ),
        (
            {"effects__wind": 1},
            "effects.wind",
            f"a known key ({', '.join(EffectsAsked.__struct_fields__)})",
            "the unknown key 'wind'",
        ),
        (
            {"body_1__helix_angle_deg": 10},
            "body_1.helix_angle_deg",
            "no such key, since this version does not simulate helical gears",
            "10",
        ),
        # missing keys and tables
        (
            {"body_1__teeth": ABSENT},
            "body_1.teeth",
            "an integer >= 3",
            "nothing",
        ),
        (
            {"body_1__bore_diameter_mm": ABSENT},
            "body_1.bore_diameter_mm",
            "a number from 0.001 to 100000",
            "nothing",
        ),
        (
            {"body_1__kind": ABSENT},
            "body_1.kind",
            KINDS_1,
            "nothing",
        ),
        (
            {"body_2": ABSENT},
            "body_2",
            "a table",
            "nothing",
        ),
        (
            {"pair": ABSENT},
            "pair",
            "a table",
            "nothing",
        ),
        (
            {"load__torque_Nm": ABSENT},
            "load.torque_Nm",
            "a number >= 0 or a non-empty list of numbers >= 0",
            "nothing",
        ),
        # wrong types
        (
            {"body_1": 3},
            "body_1",
            "a table",
            "3",
        ),
        (
            {"body_1__kind": "ring"},
            "body_1.kind",
            KINDS_1,
            "'ring'",
        ),
        (
            {"body_1__kind": ["gear"]},
            "body_1.kind",
            KINDS_1,
            "['gear']",
        ),
        (
            {"body_1__teeth": "16"},
            "body_1.teeth",
            "an integer >= 3",
            "'16'",
        ),
        (
            {"body_1__teeth": 16.5},
            "body_1.teeth",
            "an integer >= 3",
            "16.5",
        ),
        (
            {"body_1__teeth": True},
            "body_1.teeth",
            "an integer >= 3",
            "true",
        ),
        (
            {"body_1__module_mm": False},
            "body_1.module_mm",
            "a number from 0.001 to 100000",
            "false",
        ),
        (
            {"body_1__rigid": 1},
            "body_1.rigid",
            "true or false",
            "1",
        ),
        (
            {"name": 7},
            "name",
            "a non-empty string",
            "7",
        ),
        (
            {"name": " "},
            "name",
            "a non-empty string",
            "' '",
        ),
        (
            {"positions__angles_deg": 3.0},
            "positions.angles_deg",
            "a non-empty list of numbers from -1e+07 to 1e+07",
            "3.0",
        ),
        (
            {"positions__angles_deg": []},
            "positions.angles_deg",
            "a non-empty list of numbers from -1e+07 to 1e+07",
            "[]",
        ),
        (
            {"positions__angles_deg": [0, "a"]},
            "positions.angles_deg[1]",
            "a number from -1e+07 to 1e+07",
            "'a'",
        ),
        (
            {"load__torque_Nm": "302"},
            "load.torque_Nm",
            "a number >= 0 or a non-empty list of numbers >= 0",
            "'302'",
        ),
        # out of range
        (
            {"body_1__teeth": 2},
            "body_1.teeth",
            "an integer >= 3",
            "2",
        ),
        (
            {"body_1__module_mm": 0},
            "body_1.module_mm",
            "a number from 0.001 to 100000",
            "0",
        ),
        (
            {"body_1__poisson_ratio": 0.5},
            "body_1.poisson_ratio",
            "a number >= 0 and < 0.5",
            "0.5",
        ),
        (
            {"body_1__profile_shift": float("nan")},
            "body_1.profile_shift",
            "a number from -5 to 5",
            "nan",
        ),
        (
            {"body_1__young_modulus_MPa": float("inf")},
            "body_1.young_modulus_MPa",
            "a number from 0.001 to 1e+09",
            "inf",
        ),
        (
            {"pair__face_width_mm": -14},
            "pair.face_width_mm",
            "a number from 0.001 to 100000",
            "-14",
        ),
        (
            {"pair__face_width_mm": 10**400},
            "pair.face_width_mm",
            "a number from 0.001 to 100000",
            "1" + 76 * "0" + "...",
        ),
        (
            {"load__torque_Nm": -1},
            "load.torque_Nm",
            "a number >= 0 or a non-empty list of numbers >= 0",
            "-1",
        ),
        (
            {"load__torque_Nm": []},
            "load.torque_Nm",
            "a non-empty list of numbers >= 0",
            "[]",
        ),
        (
            {"load__torque_Nm": [1, -2]},
            "load.torque_Nm[1]",
            "a number >= 0",
            "-2",
        ),
        (
            {"positions__count": 0},
            "positions.count",
            "an integer from 1 to 100000",
            "0",
        ),
        (
            {"positions__driver": "body_3"},
            "positions.driver",
            "'body_1' or 'body_2'",
            "'body_3'",
        ),
        (
            {"accuracy__tolerance": 0.5},
            "accuracy.tolerance",
            "a number from 0.0001 to 0.1",
            "0.5",
        ),
        (
            {"accuracy__modes": 2},
            "accuracy.modes",
            "an integer from 3 to 12",
            "2",
        ),
        (
            {"accuracy__plane": "shell"},
            "accuracy.plane",
            "'strain' or 'stress'",
            "'shell'",
        ),
        # impossible combinations name both keys
        (
            {"positions": {"adaptive": True, "angles_deg": [0.0, 3.0]}},
            "positions.angles_deg",
            "nothing beside positions.adaptive: one of the two",
            "[0.0, 3.0]",
        ),
        (
            {"positions": {"pitches": "hunting", "angles_deg": [0.0]}},
            "positions.angles_deg",
            "nothing beside positions.pitches: one of the two",
            "[0.0]",
        ),
        (
            {"positions__pitches": "all"},
            "positions.pitches",
            "an integer from 1 to 10000 or 'hunting'",
            "'all'",
        ),
        (
            {"positions__pitches": 0},
            "positions.pitches",
            "an integer from 1 to 10000 or 'hunting'",
            "0",
        ),
        (
            {"positions__pitches": [2, 3]},
            "positions.pitches",
            "an integer from 1 to 10000 or 'hunting'",
            "[2, 3]",
        ),
        ({"positions__adaptive": 1}, "positions.adaptive", "true or false", "1"),
        (
            {"positions__tolerance": 0.01},
            "positions.tolerance",
            "nothing, unless positions.adaptive is true",
            "0.01",
        ),
        (
            {"positions": {"adaptive": True, "tolerance": 0}},
            "positions.tolerance",
            "a number from 1e-05 to 0.1",
            "0",
        ),
        (
            {"positions__max_count": 100},
            "positions.max_count",
            "nothing, unless positions.adaptive is true",
            "100",
        ),
        (
            {"positions": {"adaptive": True, "max_count": 31}},
            "positions.max_count",
            "at least positions.count (32)",
            "31",
        ),
        (
            {"positions": {"adaptive": True, "count": 7}},
            "positions.count",
            "at least 8 to begin adaptive positions with",
            "7",
        ),
        (
            {"positions": {"count": 4, "angles_deg": [0.0]}},
            "positions.angles_deg",
            "nothing beside positions.count: one of the two",
            "[0.0]",
        ),
        (
            {"body_1__rigid": True, "body_2__rigid": True},
            "body_2.rigid",
            f"false, since body_1.rigid is true: {UNDETERMINED}",
            "true",
        ),
        (
            {"body_1__tip_radius_mm": 0.2, "body_1__tip_chamfer_mm": 0.3},
            "body_1.tip_radius_mm",
            "nothing beside body_1.tip_chamfer_mm: a tip has one or the other",
            "0.2 and 0.3",
        ),
        (
            {"body_1__tip_relief_um": 20},
            "body_1.tip_relief_start_diameter_mm",
            "a number > 0, since there is a body_1.tip_relief_um",
            "nothing",
        ),
        (
            {"body_1__tip_relief_start_diameter_mm": 80},
            "body_1.tip_relief_um",
            "a number >= 0, since there is a body_1.tip_relief_start_diameter_mm",
            "nothing",
        ),
        (
            {"body_1__tip_relief_shape": "linear"},
            "body_1.tip_relief_um",
            "a number >= 0, since there is a body_1.tip_relief_shape",
            "nothing",
        ),
        (
            {"body_1__tip_relief_um": 20, "body_1__tip_relief_start_diameter_mm": 90},
            "body_1.tip_relief_start_diameter_mm",
            "less than body_1.tip_diameter_mm (82.46)",
            "90.0",
        ),
        (
            {"body_1__bore_diameter_mm": 90},
            "body_1.bore_diameter_mm",
            "less than body_1.tip_diameter_mm (82.46)",
            "90.0",
        ),
        (
            {"body_1__pitch_errors_um": [1, 2]},
            "body_1.pitch_errors_um",
            "one entry per tooth: 16, as in body_1.teeth",
            "2 entries",
        ),
        # bodies from meshes
        (
            {"body_1": {"kind": "mesh", "teeth": 16}},
            "body_1.file",
            "a non-empty string",
            "nothing",
        ),
        (
            {"body_1": {**MESH, "cut_sets": ["A"]}},
            "body_1.cut_sets",
            "a list of 2 non-empty strings",
            "['A']",
        ),
        (
            {"body_1": {**MESH, "cut_sets": ["A", "A"]}},
            "body_1.cut_sets",
            "two different names",
            "['A', 'A']",
        ),
        (
            {"body_1": {k: v for k, v in MESH.items() if k != "profile"}},
            "body_1.reference_radius_mm",
            "a number > 0, since there is no body_1.profile to take it from",
            "nothing",
        ),
        (
            {"body_1": {**MESH, "profile": {**PROFILE, "teeth": 17}}},
            "body_1.profile.teeth",
            "16 as in body_1.teeth, or nothing",
            "17",
        ),
        (
            {"body_1": {**MESH, "profile": {**PROFILE, "bore_diameter_mm": 17}}},
            "body_1.profile.bore_diameter_mm",
            "a known key (did you mean tip_diameter_mm?)",
            "the unknown key 'bore_diameter_mm'",
        ),
        (
            {"body_1": {**MESH, "flank_sets": ["A", "B"], "cut_sets": ["L", "R"]}},
            "body_1.cut_sets",
            "nothing beside body_1.flank_sets: those are of a whole body",
            "['L', 'R']",
        ),
        (
            {"body_1": {**MESH, "flank_sets": ["A", "B"], "flank_set": "C"}},
            "body_1.flank_set",
            "nothing beside body_1.flank_sets: those are of a whole body",
            "'C'",
        ),
        (
            {"body_1": {**MESH, "flank_sets": ["A", "B", "A"]}},
            "body_1.flank_sets[2]",
            "each set once",
            "'A'",
        ),
        (
            {"body_1": {**MESH, "teeth": 3, "flank_sets": ["A", "B", "C", "D"]}},
            "body_1.teeth",
            "at least 4, as many as in body_1.flank_sets",
            "3",
        ),
        (
            {"body_1": {k: v for k, v in MESH.items() if k != "teeth"}},
            "body_1.teeth",
            "an integer >= 3, since there is no body_1.flank_sets to count",
            "nothing",
        ),
        (
            {"body_2": {**RING, "root_diameter_mm": 260}},
            "body_2.root_diameter_mm",
            "more than body_2.tip_diameter_mm (262), since the teeth of a ring stand inwards",
            "260.0",
        ),
        (
            {"body_2": {**RING, "outer_diameter_mm": 281}},
            "body_2.outer_diameter_mm",
            "more than body_2.root_diameter_mm (281), since the teeth of a ring stand inwards",
            "281.0",
        ),
        (
            {
                "body_2": {
                    **RING,
                    **{"tip_relief_um": 9, "tip_relief_start_diameter_mm": 261},
                }
            },
            "body_2.tip_relief_start_diameter_mm",
            "more than body_2.tip_diameter_mm (262)",
            "261.0",
        ),
        (
            {"body_2": {k: v for k, v in RING.items() if k != "outer_diameter_mm"}},
            "body_2.outer_diameter_mm",
            "a number from 0.001 to 100000",
            "nothing",
        ),
        (
            {"body_2": {**RING, "bore_diameter_mm": 30}},
            "body_2.bore_diameter_mm",
            "a known key (did you mean outer_diameter_mm?)",
            "the unknown key 'bore_diameter_mm'",
        ),
        (
            {"body_2": {**RING, "pitch_errors_um": [1]}},
            "body_2.pitch_errors_um",
            "one entry per tooth: 60, as in body_2.teeth",
            "1 entries",
        ),
        (
            {"body_1": {**MESH, "profile": {**PROFILE, "tip_relief_um": 3}}},
            "body_1.profile.tip_relief_start_diameter_mm",
            "a number > 0, since there is a body_1.profile.tip_relief_um",
            "nothing",
        ),
    ],
    ids=lambda value: next(iter(value), "") if isinstance(value, Mapping) else "",
)
def test_bad_input_gets_one_line(
    changes: dict[str, Any], key: str, expected: str, found: str
) -> None:
    error = refusal(changed(**changes))
    assert str(error) == f"a.toml: {key}: expected {expected}, found {found}"
    assert (error.key, error.expected, error.found) == (key, expected, found)
    assert "\n" not in str(error)


def test_scene_must_be_a_table() -> None:
    assert str(refusal([1])) == "a.toml: scene: expected a table, found [1]"


def test_long_values_are_cut_in_the_message() -> None:
    error = refusal(changed(body_1__teeth="x" * 500))
    assert len(error.found) <= 80


# --- files ----------------------------------------------------------------------------------------
def test_syntax_error_names_the_line(tmp_path: Path) -> None:
    path = tmp_path / "bad.toml"
    path.write_text("name = 'a'\n[body_1\n", encoding="utf-8")
    with pytest.raises(SceneError) as caught:
        read_scene(path)
    line = str(caught.value)
    assert line.startswith(f"{path}: file: expected valid TOML, found line 2, column 8: ")
    assert "\n" not in line


def test_missing_file_is_named(tmp_path: Path) -> None:
    path = tmp_path / "none.toml"
    with pytest.raises(SceneError) as caught:
        read_scene(path)
    assert (
        str(caught.value)
        == f"{path}: file: expected a scene file to read, found no such file or directory"
    )


def test_file_that_is_no_text_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "binary.toml"
    path.write_bytes(b"# a scene\nname = '\xff'")
    with pytest.raises(SceneError, match="expected text in UTF-8, found line 2: byte 0xff"):
        read_scene(path)


def test_byte_order_mark_of_windows_editors_is_welcome(tmp_path: Path) -> None:
    path = tmp_path / "pair.toml"
    path.write_bytes(b"\xef\xbb\xbf" + (EXAMPLES / "external_gear.toml").read_bytes())
    assert read_scene(path).name == "FZG type C"


@pytest.mark.parametrize(
    ("value", "line"),
    [
        ("[" * 5000 + "]" * 5000, "expected lists of a few levels, found too many levels"),
        ("9" * 5000, "expected numbers of a few digits, found one of thousands of digits"),
    ],
    ids=["deep list", "long number"],
)
def test_toml_that_python_itself_refuses_gets_one_line(
    tmp_path: Path, value: str, line: str
) -> None:
    path = tmp_path / "pair.toml"
    path.write_text(f"name = {value}\n", encoding="utf-8")
    with pytest.raises(SceneError) as caught:
        read_scene(path)
    assert str(caught.value) == f"{path}: file: {line}"


@pytest.mark.parametrize(
    ("changes", "line"),
    [
        (
            {"body_1__bore_diameter_mm": 0.08},
            (
                "body_1.bore_diameter_mm: expected at least 0.001 of body_1.tip_diameter_mm "
                "(0.08246), since the body is held there, found 0.08"
            ),
        ),
        (
            {"body_1__pitch_errors_um": [0.0, -1e4, *14 * [0.0]]},
            (
                "body_1.pitch_errors_um[1]: expected at most 0.1 of the base pitch, 1328 um, "
                "found -10000.0"
            ),
        ),
        (
            {"load__torque_Nm": datetime.date(2026, 1, 31)},
            (
                "load.torque_Nm: expected a number >= 0 or a non-empty list of numbers >= 0, "
                "found 2026-01-31"
            ),
        ),
    ],
)
def test_nonsense_of_the_right_type_is_refused(changes: dict[str, Any], line: str) -> None:
    assert str(refusal(changed(**changes))) == f"a.toml: {line}"


def test_errors_from_a_file_name_it(tmp_path: Path) -> None:
    path = tmp_path / "pair.toml"
    path.write_text("name = 'a'\n", encoding="utf-8")
    with pytest.raises(SceneError) as caught:
        read_scene(path)
    assert str(caught.value) == f"{path}: body_1: expected a table, found nothing"


# --- schema ---------------------------------------------------------------------------------------
def test_schema_has_a_meaning_for_every_key_and_units_for_numbers() -> None:
    schema = scene_schema()
    assert json.loads(json.dumps(schema, allow_nan=False)) == schema
    bodies = ("Gear", "MeshBody", "Profile", "Pair", "Load", "Positions", "Accuracy")
    for name in bodies:
        for key, entry in schema["$defs"][name]["properties"].items():
            if key == "kind":
                continue
            assert entry["description"], (name, key)
            if "number" in json.dumps(entry) or "integer" in json.dumps(entry):
                assert entry["unit"], (name, key)


def test_schema_knows_ranges_defaults_and_no_null() -> None:
    schema = scene_schema()
    gear = schema["$defs"]["Gear"]
    assert gear["properties"]["teeth"]["minimum"] == 3
    assert gear["properties"]["poisson_ratio"]["default"] == 0.3
    assert gear["properties"]["tip_radius_mm"] == {
        "description": "radius of the arc between flank and tip circle",
        "unit": "mm",
        "type": "number",
        "minimum": 0.001,
        "maximum": 100000.0,
    }
    assert gear["additionalProperties"] is False
    assert '"null"' not in json.dumps(schema)
    assert schema["title"] == "flankload scene"


def test_schema_names_the_keys_of_the_example() -> None:
    defs = scene_schema()["$defs"]
    example = tomllib.loads((EXAMPLES / "external_gear.toml").read_text(encoding="utf-8"))
    assert set(example["body_1"]) <= set(defs["Gear"]["properties"])
    assert set(defs["Gear"]["required"]) <= set(example["body_1"])
