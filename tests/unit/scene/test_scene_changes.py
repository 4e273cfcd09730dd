"""Scenes with other values of some keys, and scenes written as dictionaries and as text."""

import dataclasses
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest
from msgspec import structs

from flankload.errors import SceneError
from flankload.scene import Scene, read_scene, scene_paths, scene_schema
from tests.support.gear_scenes import SCENE, example
from tests.support.paths import SCENES

EXAMPLES = sorted(SCENES.glob("*.toml"))
PAIR = Scene.from_dict(SCENE, file="a.toml")


def without_defaults(given: Any, found: Any) -> bool:
    """Whether all keys found were given, with the same values."""
    if isinstance(found, dict):
        return all(key in given and without_defaults(given[key], found[key]) for key in found)
    return bool(given == found)


@pytest.mark.parametrize("file", EXAMPLES, ids=lambda file: file.stem)
def test_a_scene_is_written_with_the_keys_that_were_given_and_reads_as_equal(file: Path) -> None:
    scene = read_scene(file)
    tree = scene.to_dict()
    assert without_defaults({"name": scene.name, **example(file.stem)}, tree)
    for again in (tree, tomllib.loads(scene.to_toml())):
        read = Scene.from_dict(again, file=file)
        assert read == scene
        assert (read.named_effects, read.named_discretization_keys) == (
            scene.named_effects,
            scene.named_discretization_keys,
        )


@pytest.mark.parametrize(
    "keys",
    [
        {"effects": {"dimension": 3}},  # the reader derives effects.contact
        {"accuracy": {"tolerance": 0.01}, "positions": {"count": 32}},  # named, at the default
        {"effects": {"tooth_coupling": True, "friction_coefficient": [[-5.0, 0.05], [5.0, 0.1]]}},
        {"name": 'a "quoted" name\\ with\ttab, \x7f, µ and 𝛽'},
    ],
)
def test_derived_values_named_defaults_and_strange_words_are_written(keys: dict[str, Any]) -> None:
    scene = Scene.from_dict({**SCENE, **keys})
    again = Scene.from_dict(tomllib.loads(scene.to_toml()))
    assert again == scene
    for table in set(keys) & {"effects", "accuracy", "positions"}:
        assert set(scene.to_dict()[table]) == set(keys[table])


def test_a_scene_that_was_changed_in_the_program_is_written_as_it_is() -> None:
    accuracy = structs.replace(PAIR.accuracy, estimate=False)
    scene = dataclasses.replace(PAIR, accuracy=accuracy)
    assert Scene.from_dict(scene.to_dict()).accuracy == accuracy


def test_replaced_keys_are_those_of_a_file_with_other_values() -> None:
    scene = PAIR.replace(
        {
            "body_1.tip_relief_um": 25,
            "body_1.tip_relief_start_diameter_mm": 80,
            "load.torque_Nm": [100, 200],
            "effects.friction_coefficient": 0.1,
        }
    )
    body = {**SCENE["body_1"], "tip_relief_um": 25.0, "tip_relief_start_diameter_mm": 80.0}
    expected = {
        **{**SCENE, "body_1": body},
        **{"load": {"torque_Nm": [100.0, 200.0]}, "effects": {"friction_coefficient": 0.1}},
    }
    assert scene == Scene.from_dict(expected, file="a.toml")
    assert scene.named_effects == {"friction_coefficient"}
    assert Scene.from_dict(SCENE, file="a.toml") == PAIR  # the scene itself is unchanged


def test_whole_tables_entries_of_lists_and_absent_keys() -> None:
    errors = PAIR.replace({"body_1.pitch_errors_um": [0.0] * 16})
    one = errors.replace({"body_1.pitch_errors_um[3]": 4})
    assert one.body_1.pitch_errors_um == (0, 0, 0, 4, *[0] * 12)
    shaft = {
        **{"diameters_mm": [25.0], "lengths_mm": [100.0], "gear_position_mm": 50.0},
        **{"bearing_positions_mm": [0.0, 100.0], "radial_stiffness_N_per_um": [200.0, 200.0]},
    }
    held = PAIR.replace({"body_1.shaft": shaft, "effects.dimension": 3})
    moved = held.replace({"body_1.shaft.bearing_positions_mm[0]": 10.0})
    assert moved.body_1.shaft.bearing_positions_mm == (10.0, 100.0)
    assert moved.replace({"body_1.shaft": None, "effects": None}) == PAIR


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        (
            {"body_1.tip_releif_um": 3},
            (
                "a.toml: body_1.tip_releif_um: expected a known key (did you mean tip_relief_um?), "
                "found the unknown key 'tip_releif_um'"
            ),
        ),
        (
            {"laod.torque_Nm": 3},
            "a.toml: laod: expected a known key (did you mean load?), found the unknown key 'laod'",
        ),
        (
            {"body_1.module_mm.y": 3},
            "a.toml: body_1.module_mm: expected a table, found 4.5",
        ),
        (
            {"body_1.teeth": 2},
            "a.toml: body_1.teeth: expected an integer from 3 to 10000, found 2",
        ),
        (
            {"body_1.teeth": None},
            "a.toml: body_1.teeth: expected an integer from 3 to 10000, found nothing",
        ),
        (
            {"body_1.tip_relief_um": 25},
            (
                "a.toml: body_1.tip_relief_start_diameter_mm: expected a number > 0 (or "
                "tip_relief_start_roll_angle_deg, tip_relief_length_mm, tip_relief_length), since "
                "there is a body_1.tip_relief_um, found nothing"
            ),
        ),
        (
            {"load.torque_Nm": [1.0, 2.0], "load.torque_Nm[2]": 3.0},
            "a.toml: load.torque_Nm[2]: expected an entry up to load.torque_Nm[1], found nothing",
        ),
        (
            {"load.torque_Nm[0]": 3.0},
            "a.toml: load.torque_Nm[0]: expected an entry of a list, found 302.0",
        ),
        (
            {"body_1..teeth": 3},
            (
                "a.toml: body_1..teeth: expected a path such as body_1.tip_relief_um or "
                "body_1.pitch_errors_um[3], found 'body_1..teeth'"
            ),
        ),
        (
            {3: 4},
            (
                "a.toml: changes: expected a path such as body_1.tip_relief_um or "
                "body_1.pitch_errors_um[3], found 3"
            ),
        ),
        (3, "a.toml: changes: expected a mapping of paths to values, found 3"),
    ],
)
def test_impossible_changes_get_one_line(changes: Mapping[str, Any], message: str) -> None:
    with pytest.raises(SceneError) as caught:
        PAIR.replace(changes)
    assert str(caught.value) == message


def test_paths_are_those_of_all_keys() -> None:
    paths = scene_paths()
    defs = scene_schema()["$defs"]
    for table, prefix in (
        ("Gear", "body_1."),
        ("Shaft", "body_1.shaft."),
        ("Profile", "body_2.profile."),
    ):
        keys = {path.path.removeprefix(prefix) for path in paths if path.path.startswith(prefix)}
        nested = {"shaft", "profile"}
        assert set(defs[table]["properties"]) - nested <= keys
    by_path = {path.path: path for path in paths}
    relief = by_path["body_1.tip_relief_um"]
    assert (relief.unit, relief.expected) == ("um", "a number from 0 to 1e+06")
    assert relief.kinds == "gear, spline_shaft"
    assert by_path["body_2.kind"].expected.startswith("'gear' or 'ring'")
    assert len(paths) == len(set(paths))
