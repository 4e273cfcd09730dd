"""Scenes from Python objects are those of files, and every form of a scene is accepted."""

import tomllib
from pathlib import Path
from typing import Any, get_args

import numpy as np
import pytest

import flankload as fl
from flankload.scene import scene_of
from flankload.scene.axial import MISALIGNMENTS
from flankload.scene.form import fields_of
from flankload.scene.scene import SceneFile
from flankload.scene.train import WITHOUT_IN_KIND
from flankload.scene.typed_pairs import (
    DoubleHelicalPair,
    Drive,
    FlankPair,
    IdlerTrain,
    StageKeys,
    TwoPinions,
)
from tests.support.paths import SCENES

TABLES: dict[str, Any] = {
    "gear": fl.Gear,
    "ring": fl.Ring,
    "spline_shaft": fl.SplineShaft,
    "spline_hub": fl.SplineHub,
    "cam": fl.Cam,
    "follower": fl.Follower,
    "chain": fl.Chain,
    "sprocket": fl.Sprocket,
    "belt": fl.Belt,
    "pulley": fl.Pulley,
    "mesh": fl.MeshBody,
    "compliance": fl.ComplianceBody,
}
PAIRS = {
    "spline_shaft": fl.Spline,
    "follower": fl.CamAndFollower,
    "sprocket": fl.ChainAndSprocket,
    "pulley": fl.BeltAndPulley,
}
INNER = {"profile": fl.Profile, "shaft": fl.Shaft}
PINION = {"teeth": 16, "module_mm": 4.5, "tip_diameter_mm": 82.46, "bore_diameter_mm": 30}
WHEEL = {"teeth": 24, "module_mm": 4.5, "tip_diameter_mm": 118.36, "bore_diameter_mm": 40}
PAIR = {"center_distance_mm": 91.5, "face_width_mm": 14, "torque_Nm": 302}


def body(tree: dict[str, Any]) -> Any:
    """Table of a body from its keys."""
    keys = {k: INNER[k](**x) if isinstance(x, dict) else x for k, x in tree.items() if k != "kind"}
    return TABLES[tree["kind"]](**keys)


def gear_pair(**changes: Any) -> fl.GearPair:
    return fl.GearPair(fl.Gear(**PINION), fl.Gear(**WHEEL), **{**PAIR, **changes})


TRAINS = {
    "idler": IdlerTrain,
    "two_pinions": TwoPinions,
    "double_helical": DoubleHelicalPair,
}


@pytest.mark.parametrize("path", sorted(SCENES.glob("*.toml")), ids=lambda path: path.stem)
def test_objects_make_the_scene_of_the_file(path: Path) -> None:
    tree = tomllib.loads(path.read_text(encoding="utf-8"))
    kind = PAIRS.get(tree["body_1"]["kind"], fl.GearPair)
    tables = {"positions": fl.Positions, "effects": fl.Effects, "accuracy": fl.Accuracy}
    whole = {name: table(**tree[name]) for name, table in tables.items() if name in tree}
    kind = fl.PlanetaryStage if "stage" in tree else kind
    names = [name for name in ("body_1", "planet", "body_2") if name in tree]
    train = dict(tree.get("train", {}))
    if train:
        kind = TRAINS[train.pop("kind")]
        if "body_3" in tree:
            names.insert(1 if kind is IdlerTrain else 2, "body_3")
    pair = kind(
        *(body(tree[name]) for name in names),
        name=tree.get("name"),
        **tree.get("stage", {}),
        **train,
        **tree.get("pair", {}),
        **tree["load"],
        **whole,
    )
    found, expected = pair.to_scene(), fl.Scene.from_dict(tree)
    for name in (
        *names,
        "name",
        "stage",
        "train",
        "pair",
        "load",
        "positions",
        "effects",
        "accuracy",
    ):
        assert getattr(found, name) == getattr(expected, name), name
    assert fl.Scene.from_dict(tomllib.loads(pair.to_toml())).to_dict() == found.to_dict()


def test_tables_of_a_stage() -> None:
    gears = [fl.Gear(teeth=z, module_mm=3, tip_diameter_mm=d, bore_diameter_mm=20) for z, d in TWO]
    ring = {"root_diameter_mm": 184.5, "outer_diameter_mm": 201}
    stage = fl.PlanetaryStage(
        *gears,
        fl.Ring(teeth=59, module_mm=3, tip_diameter_mm=172.8, **ring),
        planets=4,
        carrier=fl.Carrier(plate_distance_mm=40, pin_diameter_mm=20),
        planet_ring_flank=fl.PlanetFlank(helix_slope_um=5),
        face_width_mm=20,
        torque_Nm=600,
    )
    scene = stage.to_scene()
    assert scene.stage is not None
    assert scene.stage.carrier == fl.Carrier(plate_distance_mm=40, pin_diameter_mm=20)
    assert fl.Scene.from_dict(tomllib.loads(stage.to_toml())) == scene


TWO = ((25, 80.7), (17, 56.7))


def test_typed_pairs_have_each_key_of_the_tables() -> None:
    """A new key of [pair], [load], [stage] or of a whole scene must reach the typed pairs."""
    bodies = {"body_1", "planet", "body_3", "body_2"}
    tables = set(fields_of(SceneFile)) - {"pair", "load", "stage", "train", *bodies}
    load = set(fields_of(SceneFile)["load"].type.__struct_fields__)
    assert set(FlankPair.__struct_fields__) >= tables | (load - {"slack_tension_N"})
    assert set(Drive.__struct_fields__) == tables | load
    distance = {"center_distance_mm", "normal_backlash_um", "face_width_mm", "torque_Nm"}
    for typed, name, bodies in (
        (StageKeys, "stage", set()),
        (IdlerTrain, "train", {"driver", "idler", "driven"}),
        (TwoPinions, "train", {"wheel", "pinion", "second_pinion"}),
        (DoubleHelicalPair, "train", {"pinion", "wheel", *MISALIGNMENTS[:2]}),
    ):
        table = fields_of(SceneFile)[name].type
        (part,) = (part for part in get_args(get_args(table)[0]) if part is not type(None))
        own = set(part.__struct_fields__) - {"kind"}
        kind = next((name for name, one in TRAINS.items() if one is typed), None)
        own -= {*WITHOUT_IN_KIND.get(kind, ())}  # which it refuses
        assert set(typed.__struct_fields__) == tables | own | distance | bodies


def test_arrays_and_dictionaries_are_accepted() -> None:
    errors = np.linspace(0, 3, 16)
    pinion = fl.Gear(**PINION, pitch_errors_um=errors)
    pair = fl.GearPair(
        pinion, WHEEL | {"kind": "gear"}, **PAIR, positions={"count": 4}, name="pair"
    )
    scene = pair.to_scene()
    assert scene.body_1.pitch_errors_um == tuple(errors)
    assert scene.body_2 == fl.Gear(**{key: type(x)(x) for key, x in WHEEL.items()})
    assert (scene.name, scene.positions.count) == ("pair", 4)
    assert scene.named_discretization_keys == {"positions.count"}
    several = gear_pair(torque_Nm=np.array([1.0, 2.0])).to_scene()
    assert several.torques_Nm == (1.0, 2.0)
    assert several.has_torque_list


@pytest.mark.parametrize(
    ("changes", "line"),
    [
        ({"center_distance_mm": "far"}, "pair.center_distance_mm: expected a number from 0.001 to"),
        ({"torque_Nm": -1}, "load.torque_Nm: expected"),
        ({"body_1": fl.Gear(**PINION | {"teeth": "six"})}, "body_1.teeth: expected an integer"),
        ({"body_2": 5}, "body_2: expected a table, found 5"),
        ({"effects": {"frction": 1}}, "effects.frction: expected a known key (did you mean"),
        ({"body_2": fl.Ring}, "body_2: expected a table, found"),
    ],
)
def test_errors_of_typed_pairs_name_the_key(changes: dict[str, Any], line: str) -> None:
    keys = {"body_1": fl.Gear(**PINION), "body_2": fl.Gear(**WHEEL), **PAIR, **changes}
    with pytest.raises(fl.SceneError) as caught:
        fl.GearPair(**keys).to_scene()
    assert str(caught.value).startswith(line)
    assert "\n" not in str(caught.value)


def test_a_misspelt_keyword_is_refused_by_name() -> None:
    with pytest.raises(TypeError) as caught:
        fl.Gear(teth=3)
    meant = "Gear: expected a known key (did you mean teeth?), found the unknown key 'teth'"
    assert str(caught.value) == meant
    with pytest.raises(TypeError, match=r"GearPair: .* \(did you mean torque_Nm\?\)"):
        fl.GearPair(fl.Gear(**PINION), fl.Gear(**WHEEL), torque=3)


def test_all_missing_keywords_are_named() -> None:
    with pytest.raises(TypeError) as caught:
        fl.Gear(teeth=3)
    missing = "module_mm, bore_diameter_mm"
    assert str(caught.value) == f"Gear: expected {missing}, found nothing"
    with pytest.raises(TypeError, match="GearPair: expected torque_Nm, found nothing"):
        fl.GearPair(fl.Gear(**PINION), fl.Gear(**WHEEL))


def test_the_number_of_positions_counts_as_set_even_at_its_default() -> None:
    tree = fl.read_scene(SCENES / "spline.toml").to_dict()
    spline = fl.Spline(
        body(tree["body_1"]),
        body(tree["body_2"]),
        face_width_mm=10,
        torque_Nm=100,
        positions=fl.Positions(count=32),
    )
    assert spline.to_scene().positions.count == 32  # concentric: one position by default


def test_every_form_of_a_scene_is_the_same_scene(tmp_path: Path) -> None:
    pair = gear_pair(name="pair")
    file = tmp_path / "pair.toml"
    file.write_text(pair.to_toml(), encoding="utf-8")
    scene = pair.to_scene()
    assert scene_of(scene) is scene
    for form in (pair, scene.to_dict(), file, str(file)):
        assert scene_of(form).to_dict() == scene.to_dict()
    assert scene_of(file).file == file
