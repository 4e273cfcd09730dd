"""Values far from the usual: solved, with a question that names the value probably meant."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest
from msgspec import Struct, inspect

import flankload as fl
from flankload.cli import main
from flankload.mechanisms.flank_pair.assembly import build_bodies
from flankload.scene import read_scene, scene_schema
from flankload.scene.form import types_of
from flankload.scene.table import Table
from flankload.scene.usual import Usual, question, question_notes, questions
from tests.support.gear_scenes import MESH, SCENE, changed
from tests.support.paths import ROOT, SCENES
from tests.support.random_scenes import scenes

RELIEF = {"body_1__tip_relief_um": 20.0, "body_1__tip_relief_start_diameter_mm": 80.0}


def asked(**changes: Any) -> dict[str, str]:
    return questions(fl.Scene.from_dict(changed(**changes)))


@pytest.mark.parametrize(
    ("changes", "key", "meant"),
    [
        ({**RELIEF, "body_1__tip_relief_um": 0.02}, "body_1.tip_relief_um", "20"),
        ({"body_2__young_modulus_MPa": 210}, "body_2.young_modulus_MPa", "210000"),
        ({"body_2__young_modulus_MPa": 2.1e8}, "body_2.young_modulus_MPa", "210000"),
        ({"body_1__profile_crowning_um": 0.005}, "body_1.profile_crowning_um", "5"),
        ({"body_1__pitch_errors_um": [0.0, -0.004] * 8}, "body_1.pitch_errors_um", "-4"),
        ({"pair__face_width_mm": 0.014}, "pair.face_width_mm", "14"),
        ({"pair__face_width_mm": 14000}, "pair.face_width_mm", "14"),
        ({"pair__deviation_um_per_mm": 0.0004}, "pair.deviation_um_per_mm", "0.4"),
        ({"pair__inclination_um_per_mm": 12}, "pair.inclination_um_per_mm", "0.012"),
        ({"load__torque_Nm": 0.2}, "load.torque_Nm", "200"),
        (
            {"effects": {"speed_rpm": 100, "density_kg_m3": [7.85, 7850]}},
            "effects.density_kg_m3",
            "",
        ),
        (
            {"effects": {"temperature_rise_K": 9, "thermal_expansion_per_K": 1.2e-8}},
            "effects.thermal_expansion_per_K",
            "1.2e-05",
        ),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_a_thousand_times_beyond_the_usual_is_asked_about(
    changes: dict[str, Any], key: str, meant: str
) -> None:
    found = asked(**changes)
    if not meant:  # of a list the largest amount counts
        assert found == {}
        return
    assert list(found) == [key]
    assert f"did you mean {meant}? (usual: " in found[key]


@pytest.mark.parametrize(
    ("changes", "key", "limit"),
    [
        (
            {**RELIEF, "body_1__tip_relief_um": 200},
            "tip_relief_um",
            "180 um, up to 40 um per mm of",
        ),
        ({"body_1__lead_crowning_um": 500}, "lead_crowning_um", "70 um, up to 5 um per mm of"),
        ({"body_1__helix_slope_um": -500}, "helix_slope_um", "70 um, up to 5 um per mm of"),
    ],
)
def test_a_modification_too_large_for_module_or_width_is_asked_about(
    changes: dict[str, Any], key: str, limit: str
) -> None:
    """Module 4.5 and a face width of 14 mm; on larger gears the same amounts are usual."""
    found = asked(**changes)
    assert list(found) == [f"body_1.{key}"]
    assert "is that what you mean? (usual: " in found[f"body_1.{key}"]
    assert f" to {limit} " in found[f"body_1.{key}"]
    larger = {f"body_{z}__module_mm": 9.0 for z in (1, 2)} | {"pair__face_width_mm": 140}
    larger |= {f"body_{z}__tip_diameter_mm": 165 for z in (1, 2)}
    assert asked(**changes, **larger, load__torque_Nm=1e4) == {}


def test_questions_name_the_unit_that_was_probably_meant() -> None:
    assert asked(pair__deviation_um_per_mm=0.0004)["pair.deviation_um_per_mm"] == (
        "0.0004, did you mean 0.4? (usual: 0.001 to 5 um/mm; 0.0004 rad are 0.4 um/mm)"
    )
    assert asked(load__torque_Nm=0.2)["load.torque_Nm"].endswith("; 0.2 kN m are 200 N m)")


def test_the_largest_torque_counts_and_none_is_not_asked_about() -> None:
    assert asked(load__torque_Nm=[0.2, 302]) == asked(load__torque_Nm=0) == {}


def test_a_centre_distance_with_much_backlash_is_asked_about() -> None:
    """Regression: a centre distance 2 mm too large raised no question."""
    scene = fl.Scene.from_dict(changed(pair__center_distance_mm=74.0, effects__beyond_limits=True))
    (note,) = (note for note in build_bodies(scene).notes if "backlash" in note)
    assert note.startswith("pair.center_distance_mm = 74, is that what you mean? (backlash 1.64 mm")
    assert note.endswith(" mm, usual: up to 0.76 mm; none at 72.0000 mm)")
    usual = fl.Scene.from_dict(changed(pair__center_distance_mm=72.5))
    assert build_bodies(usual).notes == ()


def test_a_topography_in_mm_is_asked_about(tmp_path: Path) -> None:
    rows = ["d,0,14", *(f"{d},0.004,-0.02" for d in (60, 70, 90))]
    (tmp_path / "flank.csv").write_text("\n".join(rows), "utf-8")
    body = {**SCENE["body_1"], "rigid": True, "topography_file": "flank.csv"}
    scene = fl.Scene.from_dict(changed(body_1=body), file=tmp_path / "a.toml")
    (note,) = build_bodies(scene).notes
    assert note.startswith("body_1: topography_file: at most 0.02 um, did you mean 20? (usual: ")
    assert note.endswith("; 0.02 mm are 20 um)")


def test_usual_and_absent_values_raise_no_question() -> None:
    assert asked() == asked(**RELIEF) == {}
    assert asked(**{**RELIEF, "body_1__tip_relief_um": 0.0}) == {}
    for path in (*SCENES.glob("*.toml"), *ROOT.glob("benchmarks/*/scene.toml")):
        assert questions(read_scene(path)) == {}
    for _, tree in scenes(6):
        assert questions(fl.Scene.from_dict(tree)) == {}


def test_a_profile_inside_a_body_is_asked_about() -> None:
    body = {**MESH, "profile": {**MESH["profile"], "profile_crowning_um": 0.004}}
    assert list(asked(body_1=body)) == ["body_1.profile.profile_crowning_um"]


@pytest.mark.parametrize(
    ("value", "words"),
    [
        (0.4, None),
        (-0.4, None),
        (0.0, None),
        (2e-4, "did you mean 0.2?"),
        (-2e-4, "did you mean -0.2?"),
        (3e5, "did you mean 0.3?"),  # um in place of m
        (1e12, "is that what you mean?"),
    ],
)
def test_a_question_has_the_next_unit_in_which_a_value_is_usual(
    value: float, words: str | None
) -> None:
    found = question(value, Usual(0.1, 1.0))
    if words is None:
        assert found is None
    else:
        assert found == f"{words} (usual: 0.1 to 1)"


def test_usual_ranges_are_in_the_schema_within_the_permitted_ones() -> None:
    """No default lies outside its usual range."""
    keys = 0
    for name, form in scene_schema()["$defs"].items():
        for key, said in form.get("properties", {}).items():
            if "usual" not in said:
                continue
            keys += 1
            low, high = said["usual"]
            assert said.get("minimum", 0.0) <= low < high <= said.get("maximum", high), (name, key)
            default = said.get("default")
            assert default in (None, 0.0, []) or low <= default <= high, (name, key)
    assert keys > 40


def test_every_length_of_a_gear_has_a_usual_range() -> None:
    form = fl.scene.Gear
    assert issubclass(form, Table)
    assert issubclass(form, Struct)
    for key, kind in types_of(form).items():
        if key.endswith(("_mm", "_um", "_MPa")):
            assert isinstance(kind, inspect.Metadata)
            assert "usual" in (kind.extra_json_schema or {}), key


def test_questions_are_in_notes_of_bodies() -> None:
    scene = fl.Scene.from_dict(changed(**{**RELIEF, "body_1__tip_relief_um": 0.02}))
    (note,) = question_notes(scene)
    assert note == (
        "body_1.tip_relief_um = 0.02, did you mean 20? (usual: 0.3 to 180 um; 0.02 mm are 20 um)"
    )
    assert build_bodies(scene).notes[0] == note


@pytest.mark.parametrize(
    ("name", "key", "value", "meant"),
    [
        ("external_gear", "face_width_mm", "14000", "14"),
        ("belt", "young_modulus_MPa", "0.05", "50"),
    ],
)
def test_check_prints_questions(
    name: str, key: str, value: str, meant: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / f"{name}.toml"
    text = (SCENES / path.name).read_text("utf-8")
    path.write_text(re.sub(rf"{key} = [\d.]+", f"{key} = {value}", text), "utf-8")
    assert main(["check", str(path)]) == 0
    (said,) = [line for line in capsys.readouterr().out.splitlines() if "did you mean" in line]
    assert said.startswith("warning: ")
    assert f"{key} = {float(value)}, did you mean {meant}? (usual: " in said


@pytest.mark.parametrize(
    "key",
    [
        "lead_crowning_um",
        "lead_slope_um",
        "helix_slope_um",
        "tooth_helix_slope_um",
    ],
)
def test_lead_modifications_of_a_cam_suggest_no_profile_crowning(key: str) -> None:
    with pytest.raises(fl.SceneError) as caught:
        fl.Scene.from_dict(changed(body_2={"kind": "cam", key: 5}))
    assert caught.value.key == f"body_2.{key}"
    assert caught.value.expected == (
        "no such key, since this version does not simulate lead modifications, which are "
        "three-dimensional"
    )


def test_unknown_lead_modification_of_a_gear_is_no_later_feature() -> None:
    with pytest.raises(fl.SceneError, match="a known key") as caught:
        fl.Scene.from_dict(changed(body_1__lead_crowning=5))
    assert caught.value.expected == "a known key (did you mean lead_crowning_um?)"
