"""Valid scenes, the effects that they request, and the schema."""

import json
import tomllib
from copy import deepcopy
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from flankload.scene import Scene, read_scene, scene_schema
from flankload.scene.effects import effects_of
from tests.support.gear_scenes import ABSENT, MESH, PROFILE, RING, SCENE, changed
from tests.support.paths import SCENES


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


def test_name_of_the_file_replaces_a_missing_name() -> None:
    scene = Scene.from_dict(changed(name=ABSENT), file="folder/my_pair.toml")
    assert scene.name == "my_pair"
    assert scene.folder == Path("folder")


@pytest.mark.parametrize("path", sorted(SCENES.glob("*.toml")), ids=lambda path: path.stem)
def test_example_scenes_are_valid(path: Path) -> None:
    assert read_scene(path).file == path


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
        "usual": [0.002, 50.0],
        "type": "number",
        "minimum": 0.001,
        "maximum": 100000.0,
    }
    assert gear["additionalProperties"] is False
    assert '"null"' not in json.dumps(schema)
    assert schema["title"] == "flankload scene"


def test_schema_names_the_keys_of_the_example() -> None:
    defs = scene_schema()["$defs"]
    example = tomllib.loads((SCENES / "external_gear.toml").read_text(encoding="utf-8"))
    assert set(example["body_1"]) <= set(defs["Gear"]["properties"])
    assert set(defs["Gear"]["required"]) <= set(example["body_1"])
