"""The command scene: from a gearbox model to a result, and its errors."""

import json
import tomllib
from pathlib import Path

import pytest

from flankload.scene import read_scene
from tests.support.command_line import run
from tests.support.paths import SCENES
from tests.support.rexs_files import EXAMPLE, TEXT, spur, without, written
from tests.support.solving import solve


def test_a_model_becomes_a_result(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The stage of the FZG pair gives the numbers of the example scene."""
    box, pair, numbers = written(tmp_path, spur()), tmp_path / "pair.toml", tmp_path / "a.json"
    few = ("--set", "positions.count=8", "--set", "accuracy.estimate=false")
    code, out, err = run(capsys, "scene", box, "--stage", "9", "-o", pair, *few)
    assert (code, err) == (0, "")
    lines = out.splitlines()
    assert lines[0] == f"{pair}: cylindrical_stage 9 of {box}"
    assert all(line.startswith(("assumed: ", "not taken: ")) for line in lines[1:])
    assert run(capsys, "check", pair)[0] == 0
    assert run(capsys, "run", pair, "--quiet", "--json", numbers)[0] == 0
    result = json.loads(numbers.read_text(encoding="utf-8"))
    changes = {"positions.count": 8, "accuracy.estimate": False}
    wanted = solve(read_scene(SCENES / "external_gear.toml").replace(changes))
    assert result["transmission_error_um"] == wanted.transmission_error_um.tolist()


def test_the_stages_are_listed(capsys: pytest.CaptureFixture[str]) -> None:
    code, out, err = run(capsys, "scene", EXAMPLE)
    assert (code, err) == (0, "")
    assert out.splitlines() == [
        "stage  gears   teeth   kind      name",
        "21     11, 12  25, 60  external  helical stage",
        "22     13, 14  24, 60  internal  planet and ring",
    ]


def test_the_only_stage_is_taken(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    box, pair = written(tmp_path, spur()), tmp_path / "pair.toml"
    assert run(capsys, "scene", box, "-o", pair)[0] == 0
    assert pair.exists()


def test_missing_data_can_be_given_beside_the_file(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    box = written(tmp_path, without("torque_around_u_axis", 81, without("inner_diameter", 12)))
    pair = tmp_path / "pair.toml"
    argv = ["scene", box, "--stage", "21", "-o", pair]
    code, out, err = run(capsys, *argv)
    assert (code, out) == (2, "")
    assert err == (
        f"flankload: {box}: cylindrical_gear 12: inner_diameter: expected a value, or "
        "--set body_2.bore_diameter_mm=…, found nothing\n"
    )
    argv += ["--set", "body_2.bore_diameter_mm=60"]
    code, out, err = run(capsys, *argv)
    assert (code, out) == (2, "")
    assert err == (
        f"flankload: {box}: cylindrical_stage 21: expected --torque-Nm, since the file has none "
        "of it, found nothing\n"
    )
    assert not pair.exists()
    assert run(capsys, *argv, "--torque-Nm", "250", "--set", "name=my pair")[0] == 0
    text = pair.read_text(encoding="utf-8")
    assert 'name = "my pair"' in text
    assert "torque_Nm = 250" in text


@pytest.mark.parametrize(
    ("more", "line"),
    [
        (["--stage", "21"], "-o: expected a file for the scene of the stage, found nothing"),
        (["-o", "BOX"], "-o: expected a file other than the model, found "),
        (["-o", "none/a.toml"], "-o: expected a file in a folder that exists"),
        (["-o", "PAIR", "--set", "teeth"], "--set: expected KEY=VALUE, found teeth"),
        (["-o", "PAIR"], "BOX: --stage: expected the id of a cylindrical_stage: 21, 22, found"),
        (["-o", "PAIR", "--stage", "21", "--set", "body_1.tooth=1"], "BOX: body_1.tooth: expected"),
        # a rule between bodies, which only building them shows
        (["-o", "PAIR", "--stage", "21", "--set", "pair.center_distance_mm=125"],
         "BOX: pair.center_distance_mm: expected "),
    ],
)  # fmt: skip
def test_bad_arguments_get_one_line_and_write_nothing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], more: list[str], line: str
) -> None:
    box, pair = written(tmp_path, TEXT), tmp_path / "pair.toml"
    pair.write_text("kept", encoding="utf-8")
    names = {"BOX": str(box), "PAIR": str(pair)}
    code, out, err = run(capsys, "scene", box, *(names.get(word, word) for word in more))
    assert (code, out) == (2, "")
    assert err.count("\n") == 1
    assert err.startswith(f"flankload: {line.replace('BOX', str(box))}")
    assert pair.read_text(encoding="utf-8") == "kept"
    assert box.read_text(encoding="utf-8") == TEXT


def test_the_scene_is_printed_and_its_notes_are_apart(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    box, pair = written(tmp_path, spur()), tmp_path / "pair.toml"
    assert run(capsys, "scene", box, "-o", pair)[0] == 0
    code, out, err = run(capsys, "scene", box, "-o", "-")
    assert code == 0
    assert out == pair.read_text(encoding="utf-8")
    assert all(line.startswith(("assumed: ", "not taken: ")) for line in err.splitlines())
    assert not (tmp_path / "-").exists()


def test_a_wrong_setting_is_named_as_it_was_given(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    box, pair = written(tmp_path, spur()), tmp_path / "pair.toml"
    code, _, err = run(capsys, "scene", box, "-o", pair, "--set", "body_1.teeth=-5")
    assert (code, pair.exists()) == (2, False)
    assert err == f"flankload: {box}: body_1.teeth: expected a number > 0, found -5\n"


def test_a_chosen_stage_goes_to_stdout(capsys: pytest.CaptureFixture[str]) -> None:
    code, out, err = run(capsys, "scene", EXAMPLE, "--stage", "21", "-o", "-")
    assert (code, tomllib.loads(out)["body_1"]["teeth"]) == (0, 25)
    assert all(
        line.startswith(("assumed: ", "not taken: ", "warning: ")) for line in err.splitlines()
    )
