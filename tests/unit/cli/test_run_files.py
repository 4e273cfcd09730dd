"""The files of `flankload run` for other programs."""

from __future__ import annotations

import importlib
from pathlib import Path

import numpy as np
import pytest

from flankload.cli import main
from flankload.result import Result, results_to_csv, stiffness_table
from tests.support.made_up_result import made_up_result
from tests.support.small_job import SCENE


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    path = tmp_path / "pair.toml"
    path.write_text(SCENE, encoding="utf-8")
    return path


@pytest.fixture
def solved(monkeypatch: pytest.MonkeyPatch) -> Result:
    """The result that takes the place of a solution."""
    result = made_up_result(count=8)
    api = importlib.import_module("flankload.api")
    monkeypatch.setattr(api, "solve", lambda *_, **__: result)
    return result


def run(capsys: pytest.CaptureFixture[str], *argv: str | Path) -> tuple[int, str, str]:
    code = main(["run", *map(str, argv)])
    out, err = capsys.readouterr()
    return code, out, err


def test_one_run_writes_all_files(
    scene: Path, solved: Result, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = scene.parent
    names = {"--csv": "a.csv", "--xlsx": "a.xlsx", "--modelica": "a.txt", "--fmu": "a.fmu"}
    files = [str(word) for key, name in names.items() for word in (key, folder / name)]
    code, out, err = run(capsys, scene, *files, "--csv-format", "tab,degrees")
    assert (code, err) == (0, "")
    assert f"{folder / 'a.fmu'}: C sources and " in out
    assert (folder / "a.csv").read_text() == solved.to_csv(separator="\t", degrees=True)
    assert (folder / "a.txt").read_text() == stiffness_table((solved,)).to_modelica()
    assert (folder / "a.xlsx").read_bytes()[:2] == (folder / "a.fmu").read_bytes()[:2] == b"PK"


def test_tables_for_modelica_can_be_printed(
    scene: Path, solved: Result, capsys: pytest.CaptureFixture[str]
) -> None:
    code, out, _ = run(capsys, scene, "--modelica", "-")
    assert (code, out) == (0, stiffness_table((solved,)).to_modelica())
    code, out, _ = run(capsys, scene, "--csv", "-", "--csv-format", "decimal-comma")
    assert (code, out) == (0, solved.to_csv(decimal_comma=True))
    code, out, _ = run(capsys, scene, "--csv", "-")
    assert (code, out) == (0, results_to_csv(solved))


def test_positions_of_fields_are_chosen(scene: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = scene.parent / "fields"
    code, out, err = run(capsys, scene, "--vtu", folder, "--vtu-positions", "0, 1")
    assert (code, err) == (0, "")
    assert "body_1: " in out
    assert " nodes at 2 positions" in out
    names = sorted(path.name for path in folder.iterdir())
    parts = ("body_1", "body_2", "contacts")
    assert names == sorted(
        [*(f"{part}_000{p}.vtu" for part in parts for p in (0, 1)), "loaded_pair.pvd"]
    )


@pytest.mark.parametrize(
    ("options", "line"),
    [
        (
            ["--csv-format", "comma,point"],
            ("--csv-format: expected words among semicolon, tab, decimal-comma, degrees, with one "
            "separator, found comma,point"),
        ),
        (
            ["--csv-format", "tab,semicolon"],
            ("--csv-format: expected words among semicolon, tab, decimal-comma, degrees, with one "
            "separator, found tab,semicolon"),
        ),
        (
            ["--csv-format", "degrees"],
            "--csv-format: expected --csv FILE or --stiffness-csv FILE beside it, found neither",
        ),
        (["--vtu-positions", "1"], "--vtu-positions: expected --vtu DIR beside it, found 1"),
        (
            ["--vtu", "fields", "--vtu-positions", "1,-2"],
            "--vtu-positions: expected indices such as 0,8,16, found '1,-2'",
        ),
        (["--fmu", "-"], "--fmu: expected a file, since it is no text, found -"),
        (
            ["--modelica", "-", "--csv", "-"],
            "--modelica: expected a file, since --csv uses stdout, found -",
        ),
        (
            ["--vtu", "a.vtu"],
            "--vtu: expected a folder for VTU files, such as a, found a.vtu, the name of a file",
        ),
    ],
)  # fmt: skip
def test_options_that_cannot_be_met_are_refused_before_the_run(
    scene: Path, capsys: pytest.CaptureFixture[str], options: list[str], line: str
) -> None:
    assert run(capsys, scene, *options) == (2, "", f"flankload: {line}\n")


@pytest.mark.parametrize("option", ["--modelica", "--fmu"])
def test_tables_without_stiffness_are_refused_before_the_run(
    scene: Path, capsys: pytest.CaptureFixture[str], option: str
) -> None:
    """Regression: all other files were written before the refusal."""
    text = scene.read_text(encoding="utf-8")
    scene.write_text(text.replace("torque_Nm = 302", "torque_Nm = [0, 302]"), encoding="utf-8")
    path = scene.parent / "a"
    line = f"{scene}: load.torque_Nm: expected torques > 0, since {option} needs stiffness, found 0"
    assert run(capsys, scene, option, path) == (2, "", f"flankload: {line}\n")
    text = text.replace("[accuracy]", "[accuracy]\ntangents = false")
    scene.write_text(text.replace("tangents = false\ntangents", "tangents"), encoding="utf-8")
    line = f"{scene}: accuracy.tangents: expected true, since {option} needs tangent stiffness"
    assert run(capsys, scene, option, path) == (2, "", f"flankload: {line}, found false\n")


def test_a_workbook_without_its_package_is_refused(
    scene: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    module = importlib.import_module("flankload.cli.result_files")
    monkeypatch.setattr(module, "find_spec", lambda _: None)
    code, _, err = run(capsys, scene, "--xlsx", scene.parent / "a.xlsx")
    wanted = "--xlsx: expected the package openpyxl: pip install 'flankload[xlsx]', found none"
    assert (code, err) == (2, f"flankload: {wanted}\n")


def test_a_table_that_does_not_repeat_names_the_scene(
    scene: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    part = made_up_result(count=8, closed=False, position_rad=np.linspace(0.0, 0.1, 8))
    monkeypatch.setattr(importlib.import_module("flankload.api"), "solve", lambda *_, **__: part)
    code, _, err = run(capsys, scene, "--fmu", scene.parent / "a.fmu")
    assert code == 2
    assert err.startswith(f"flankload: {scene}: positions: expected angles over a whole period")
