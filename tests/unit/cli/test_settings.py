"""Keys of a scene set on the command line: --set KEY=VALUE."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

import flankload as fl
from flankload.cli import main, parser
from tests.support.paths import SCENES

SCENE = SCENES / "external_gear.toml"
COARSE = ("accuracy.flank_element_mm=2", "accuracy.estimate=false", "positions.count=2")


def settings(*texts: str) -> list[str]:
    return [word for text in texts for word in ("--set", text)]


def refused(capsys: pytest.CaptureFixture[str], file: Path, *texts: str) -> str:
    assert main(["check", str(file), *settings(*texts)]) == 2
    out, err = capsys.readouterr()
    assert (out, err.count("\n")) == ("", 1)
    return err.removeprefix("flankload: ").rstrip("\n")


def test_run_solves_the_scene_with_other_keys(capsys: pytest.CaptureFixture[str]) -> None:
    more = settings(*COARSE, "load.torque_Nm=[100, 200]", "body_2.tip_radius_mm=0.3")
    assert main(["run", str(SCENE), *more, "--json", "-"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["torques_Nm"] == [100.0, 200.0]
    changes = {"body_2.tip_radius_mm": 0.3, "load.torque_Nm": [100, 200], "positions.count": 2}
    changes |= {"accuracy.flank_element_mm": 2.0, "accuracy.estimate": False}
    (one, _) = fl.solve(fl.read_scene(SCENE, changes=changes)).by_torque
    assert found["results"][0]["transmission_error_um"] == pytest.approx(
        list(one.transmission_error_um), rel=1e-9
    )


def test_a_file_may_lack_what_is_set(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = SCENE.read_text("utf-8").replace("torque_Nm = 302", "")
    (tmp_path / "pair.toml").write_text(text, "utf-8")
    assert "load.torque_Nm: expected" in refused(capsys, tmp_path / "pair.toml")
    assert main(["check", str(tmp_path / "pair.toml"), *settings("load.torque_Nm = 9")]) == 0
    assert "load.torque_Nm = 9" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("text", "line"),
    [
        (
            "load.torqe_Nm=3",
            (
                "FILE: load.torqe_Nm: expected a known key (did you mean torque_Nm?), found the "
                "unknown key 'torqe_Nm'"
            ),
        ),
        (
            "body_1.teeth=six",
            "FILE: body_1.teeth: expected an integer from 3 to 10000, found 'six'",
        ),
        ("body_1.teeth=", "FILE: body_1.teeth: expected an integer from 3 to 10000, found nothing"),
        ("name.x=3", "FILE: name: expected a table, found 'external gears'"),
        ("body_1.teeth", "--set: expected KEY=VALUE, found body_1.teeth"),
    ],
)
def test_wrong_settings_get_the_line_of_a_wrong_file(
    text: str, line: str, capsys: pytest.CaptureFixture[str]
) -> None:
    found = refused(capsys, SCENE, text)
    assert found.replace(str(SCENE), "FILE").split("found '")[0] == line.split("found '")[0]


def test_every_command_that_reads_a_scene_has_settings() -> None:
    for command in ("run", "plan", "check", "mesh", "compliance", "accuracy", "verify", "report"):
        argv = [command, "a.toml", "--set", "load.torque_Nm=3"]
        argv += ["-o", "out"] if command in ("mesh", "compliance", "report") else []
        assert parser().parse_args(argv).settings == ["load.torque_Nm=3"]


def test_a_mesh_has_no_settings(capsys: pytest.CaptureFixture[str]) -> None:
    found = refused(capsys, Path("a.msh"), "load.torque_Nm=3")
    assert found == "--set: expected a scene, whose keys it sets, found the mesh a.msh"
