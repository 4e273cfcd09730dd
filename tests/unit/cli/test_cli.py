"""The command line as its users use it: exit codes, one-line errors, files whole or not at all."""

import csv
import errno
import importlib
import io
import json
import os
import re
import runpy
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

import flankload as fl
from flankload.cli import main
from flankload.errors import NoContactState, SceneError
from tests.support.command_line import run
from tests.support.made_up_result import made_up_result
from tests.support.paths import DOCS
from tests.support.small_job import SCENE

#: The console script.
PROGRAM = "import sys; from flankload.cli import main; sys.exit(main())"


def two_torques() -> fl.Result:
    return fl.Result.of_torques([made_up_result(torque_Nm=torque) for torque in (100.0, 302.0)])


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    path = tmp_path / "pair.toml"
    path.write_text(SCENE, encoding="utf-8")
    return path


@pytest.fixture
def solved(monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    """The conductor replaced by one that returns the items of the list."""
    answers: list[Any] = [made_up_result()]

    def solve(*_: object, **__: object) -> Any:
        if isinstance(answers[0], BaseException):
            raise answers[0]
        return answers[0]

    monkeypatch.setattr(importlib.import_module("flankload.api"), "solve", solve)
    return answers


@pytest.fixture
def empty_pictures(monkeypatch: pytest.MonkeyPatch) -> None:
    """Figures are made, but their files are empty: only their names are of interest."""
    import flankload.plot

    monkeypatch.setattr(flankload.plot, "file_of", lambda *_: b"")


def one_line(text: str) -> str:
    assert text.startswith("flankload: ")
    assert text.endswith("\n")
    assert text.count("\n") == 1
    return text[len("flankload: ") : -1]


# --- the real thing -------------------------------------------------------------------------------
def test_run_solves_and_writes_everything(
    scene: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    code, out, err = run(
        capsys, "run", scene, "--json", tmp_path / "a.json", "--csv", tmp_path / "a.csv",
        "--plot", tmp_path / "out",
    )  # fmt: skip
    assert (code, err) == (0, "")
    assert out.startswith("small job: 302 N m, 2 positions over one pitch of 22.5 deg\n")
    tree = json.loads((tmp_path / "a.json").read_text(encoding="utf-8"))
    assert len(tree["transmission_error_um"]) == 2
    assert tree["cost"]["fe_factorisations"] == 2
    rows = list(csv.DictReader(io.StringIO((tmp_path / "a.csv").read_text(encoding="utf-8"))))
    assert [float(row["transmission_error_um"]) for row in rows] == tree["transmission_error_um"]
    for name in sorted(os.listdir(tmp_path / "out")):
        assert f"\nwrote {tmp_path / 'out' / name}" in out


def test_installed_command_prints_no_progress_into_a_pipe(scene: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM, "run", str(scene), "--json", "-"],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0
    assert done.stderr == ""
    assert json.loads(done.stdout)["name"] == "small job"


def test_mesh_writes_both_bodies_with_their_sets(
    scene: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    code, out, _ = run(capsys, "mesh", scene, "-o", tmp_path / "meshes")
    assert code == 0
    assert sorted(os.listdir(tmp_path / "meshes")) == ["body_1.msh", "body_2.msh"]
    assert "one of 16 sectors" in out
    code, out, _ = run(capsys, "check", tmp_path / "meshes" / "body_1.msh")
    assert code == 0
    for name in ("FLANK", "BORE", "CUT_LEFT", "CUT_RIGHT"):
        assert name in out


def test_check_prints_natural_modes_of_stages_only(
    scene: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    stage = DOCS.parent / "examples/scenes/planetary_stage.toml"
    code, out, _ = run(capsys, "check", stage, "--modes", "--set", "load.torque_Nm=300")
    assert code == 0
    assert "natural modes at 300 N m, with the mean stiffness of a pitch" in out
    assert re.search(r"^ +\d+\.\d +rotational .* 4, 8, 12, 16, \.\.\.$", out, re.MULTILINE)
    code, out, err = run(capsys, "check", scene, "--modes")
    assert (code, out) == (2, "")
    assert "stage: expected a table, for natural modes, found nothing" in err
    mesh = DOCS.parent / "examples/meshes/own_pinion.msh"
    code, _, err = run(capsys, "check", mesh, "--modes")
    assert code == 2
    assert "--modes: expected the scene of a planetary stage, found the mesh" in err


def test_mesh_as_vtu(scene: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    code, _, _ = run(capsys, "mesh", scene, "-o", tmp_path / "m", "--format", "vtu")
    assert code == 0
    assert sorted(os.listdir(tmp_path / "m")) == ["body_1.vtu", "body_2.vtu"]


def test_check_says_what_was_understood(scene: Path, capsys: pytest.CaptureFixture[str]) -> None:
    code, out, err = run(capsys, "check", scene)
    assert (code, err) == (0, "")
    rows = dict(line.strip().split("  ", 1) for line in out.splitlines() if line.startswith("  "))
    words = {name: value.strip() for name, value in rows.items()}
    assert words["root diameter"] == "98.2890 mm"  # body 2, printed last
    assert words["tip diameter"] == "118.3600 mm"
    assert words["working pressure angle"].startswith("22.4")
    assert words["contact ratio"].startswith("1.4")
    assert words["elastic body 1"] == "yes (body_1.rigid absent)"
    assert words["friction"] == "no (effects.friction_coefficient absent)"


def test_rigid_body_has_no_mesh_file(
    scene: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    scene.write_text(SCENE.replace("[body_2]", "[body_2]\nrigid = true"), encoding="utf-8")
    code, out, _ = run(capsys, "mesh", scene, "-o", tmp_path / "m")
    assert code == 0
    assert os.listdir(tmp_path / "m") == ["body_1.msh"]
    assert "body_2: rigid, so it has no mesh" in out


@pytest.mark.parametrize(
    ("old", "new", "key"),
    [
        ("teeth = 16", "teeth = 2", "body_1.teeth"),
        ("torque_Nm = 302", "torque_Nm = -302", "load.torque_Nm"),
        ("torque_Nm = 302", "torqe_Nm = 302", "load.torqe_Nm"),
        ("torque_Nm = 302", "", "load.torque_Nm"),
        ("face_width_mm = 14", 'face_width_mm = "14"', "pair.face_width_mm"),
        ("center_distance_mm = 91.5", "center_distance_mm = 101", "pair.center_distance_mm"),
        ("center_distance_mm = 91.5", "center_distance_mm = 80", "pair.center_distance_mm"),
        ("tip_diameter_mm = 82.46", "tip_diameter_mm = 99", "body_1.tip_diameter_mm"),
        ("bore_diameter_mm = 30", "bore_diameter_mm = 70", "body_1.bore_diameter_mm"),
        ("teeth = 24\nmodule_mm = 4.5", "teeth = 24\nmodule_mm = 4.4", "body_2"),
    ],
)
@pytest.mark.parametrize("command", ["run", "check", "mesh"])
def test_bad_input_gets_exit_2_and_one_line(
    scene: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str],
    command: str, old: str, new: str, key: str,
) -> None:  # fmt: skip
    assert old in SCENE
    scene.write_text(SCENE.replace(old, new), encoding="utf-8")
    more = {"run": ["--json", tmp_path / "a.json"], "check": [], "mesh": ["-o", tmp_path / "m"]}
    code, out, err = run(capsys, command, scene, *more[command])
    assert (code, out) == (2, "")
    line = one_line(err)
    assert line.startswith(f"{scene}: {key}")
    assert ": expected " in line
    assert ", found " in line
    assert os.listdir(tmp_path) == ["pair.toml"]


# --- without a solution ---------------------------------------------------------------------------
def test_version_is_that_of_the_package(capsys: pytest.CaptureFixture[str]) -> None:
    import flankload

    assert run(capsys, "--version") == (0, f"flankload {flankload.__version__}\n", "")


def test_schema_is_json(capsys: pytest.CaptureFixture[str]) -> None:
    code, out, err = run(capsys, "schema")
    assert (code, err) == (0, "")
    assert json.loads(out)["title"] == "flankload scene"


def test_schema_lists_the_paths_of_keys(capsys: pytest.CaptureFixture[str]) -> None:
    code, out, err = run(capsys, "schema", "--paths")
    assert (code, err) == (0, "")
    line = next(line for line in out.splitlines() if line.startswith("load.torque_Nm"))
    assert line.startswith("load.torque_Nm [N m]: a number from 0 to 1e+12 or a non-empty list")


@pytest.mark.parametrize(
    "argv", [[], ["fly"], ["run"], ["mesh", "a.toml"], ["run", "a.toml", "--fast"]]
)
def test_wrong_arguments_get_one_line(argv: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    code, out, err = run(capsys, *argv)
    assert (code, out) == (2, "")
    one_line(err)


@pytest.mark.parametrize("command", [["run"], ["check"], ["mesh", "-o", "m"]])
def test_missing_scene_is_named(
    command: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "none.toml"
    code, _, err = run(capsys, *command, path)
    assert code == 2
    assert one_line(err).startswith(f"{path}: file: expected a scene file to read, found ")


def test_missing_mesh_is_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    code, _, err = run(capsys, "check", tmp_path / "none.msh")
    assert code == 2
    assert one_line(err) == f"{tmp_path / 'none.msh'}: expected a mesh file, found no such file"


def test_file_that_is_no_mesh_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "bad.msh"
    path.write_text("not a mesh\n", encoding="utf-8")
    code, _, err = run(capsys, "check", path)
    assert code == 2
    assert one_line(err).startswith(f"{path}: expected a readable mesh file, found ")


# --- outputs --------------------------------------------------------------------------------------
def test_table_goes_to_stdout(
    scene: Path, solved: list[Any], capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(capsys, "run", scene) == (0, solved[0].table() + "\n", "")


def test_quiet_prints_nothing(
    scene: Path, solved: list[Any], capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(capsys, "run", scene, "--quiet") == (0, "", "")


def test_a_long_run_says_so(
    scene: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    progress = importlib.import_module("flankload.cli.progress")
    assert run(capsys, "run", scene)[2] == ""  # less than 10 s
    monkeypatch.setattr(progress, "LONG_S", 0.0)
    monkeypatch.setattr(progress, "LEAST_S", 0.0)
    code, _, err = run(capsys, "run", scene)
    assert code == 0
    assert re.fullmatch(r"this takes about \d+ s or more \(now: [\w ]+\)", one_line(err))
    assert run(capsys, "run", scene, "--quiet") == (0, "", "")


def test_costs_follow_the_tables_once(
    scene: Path,
    solved: list[Any],
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(importlib.import_module("flankload.studies.plan"), "plan", lambda _: None)
    solved[0] = fl.Result.of_torques(
        [made_up_result(torque_Nm=torque) for torque in (100.0, 302.0)]
    )
    cost = solved[0].cost_table()
    expected = "\n\n".join([solved[0].table(), cost]) + "\n"
    assert run(capsys, "run", scene, "--cost") == (0, expected, "")
    assert run(capsys, "run", scene, "--cost", "--quiet") == (0, cost + "\n", "")
    assert "0.120  0.100" in cost
    code, out, _ = run(capsys, "run", scene, "--cost", "--csv", "-")
    assert code == 0
    assert cost not in out


def test_stiffness_of_all_torques_goes_to_one_file(
    scene: Path, tmp_path: Path, solved: list[Any], capsys: pytest.CaptureFixture[str]
) -> None:
    solved[0] = fl.Result.of_torques(
        [made_up_result(torque_Nm=torque) for torque in (100.0, 302.0)]
    )
    expected = solved[0].stiffness_table().to_csv()
    path = tmp_path / "stiffness.csv"
    assert run(capsys, "run", scene, "--stiffness-csv", path, "--quiet") == (0, "", "")
    assert path.read_text(encoding="utf-8") == expected
    assert run(capsys, "run", scene, "--stiffness-csv", "-") == (0, expected, "")


@pytest.mark.parametrize(("option", "method"), [("--json", "to_json"), ("--csv", "to_csv")])
def test_dash_sends_only_the_data_to_stdout(
    option: str, method: str, scene: Path, solved: list[Any], capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(capsys, "run", scene, option, "-") == (0, getattr(solved[0], method)(), "")


@pytest.mark.usefixtures("empty_pictures")
def test_list_of_torques_gives_a_list_of_everything(
    scene: Path, tmp_path: Path, solved: list[Any], capsys: pytest.CaptureFixture[str]
) -> None:
    solved[0] = fl.Result.of_torques(
        [made_up_result(torque_Nm=torque) for torque in (100.0, 302.0)]
    )
    code, out, _ = run(
        capsys, "run", scene, "--json", tmp_path / "a.json", "--plot", tmp_path / "out"
    )
    assert code == 0
    assert "made-up pair: 100 N m" in out
    assert "made-up pair: 302 N m" in out
    tree = json.loads((tmp_path / "a.json").read_text(encoding="utf-8"))
    assert tree["torques_Nm"] == [100.0, 302.0]
    names = os.listdir(tmp_path / "out")
    assert {"transmission_error.png", "loaded_pair.png", "torque_sweep.png"} < set(names)
    assert sorted(re.findall(r"wrote .*/(.*)", out)) == sorted(names)


def test_plots_have_the_formats_and_the_size_asked_for(
    scene: Path, tmp_path: Path, solved: list[Any], monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:  # fmt: skip
    import flankload.plot

    given: dict[str, Any] = {}
    monkeypatch.setattr(flankload.plot, "plot_all", lambda *_, **options: given.update(options))
    options = ("--format", "svg", "--format", "PDF,svg", "--size", "160x90", "--dpi", "300")
    assert run(capsys, "run", scene, "--quiet", "--plot", tmp_path / "out", *options)[0] == 0
    assert given == {"formats": ("svg", "pdf"), "dpi": 300.0, "size_mm": (160.0, 90.0)}


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        (["--json", "no/a"], "--json: expected a file in a folder that exists, found no folder no"),
        (["--csv", "no/a"], "--csv: expected a file in a folder that exists, found no folder no"),
        (["--json", "."], "--json: expected a file, found the folder ."),
        (["--plot", "pair.toml"], "--plot: expected a folder, found the file pair.toml"),
        (["--plot", "pair.toml/out"], "--plot: expected a folder, found the file pair.toml"),
        (["--plot", "p.pdf"],
         "--plot: expected a folder for PNG files, such as p, found p.pdf, the name of a file"),
        (["--plot", "p.svg", "--format", "svg"],
         "--plot: expected a folder for SVG files, such as p, found p.svg, the name of a file"),
        (["--format", "svg"], "--format: expected --plot DIR beside it, found no --plot"),
        (["--plot", "out", "--format", "svg,gif"],
         "--format: expected png, svg or pdf, or several with commas, found 'gif'"),
        (["--plot", "out", "--dpi", "5"], "--dpi: expected a number from 30 to 1200, found '5'"),
        (["--plot", "out", "--size", "160"],
         "--size: expected WxH, such as 160x100, each from 40 to 1000 mm, found '160'"),
        (["--plot", "out", "--size", "160x5"],
         "--size: expected WxH, such as 160x100, each from 40 to 1000 mm, found '160x5'"),
        (["--json", "pair.toml"], "--json: expected a file other than the scene, found pair.toml"),
        (["--csv", "./pair.toml"], "--csv: expected a file other than the scene, found pair.toml"),
        (["--json", "link.toml"], "--json: expected a file other than the scene, found link.toml"),
        (["--json", "hard.toml"], "--json: expected a file other than the scene, found hard.toml"),
        (["--json", "a", "--csv", "a"],
         "--csv: expected a file other than that of --json, found a"),
        (["--csv", "a", "--stiffness-csv", "b/../a"],
         "--stiffness-csv: expected a file other than that of --csv, found b/../a"),
        (["--json", "a", "--plot", "a"],
         "--plot: expected a file other than that of --json, found a"),
        (["--csv", "-", "--json", "-"],
         "--csv: expected a file, since --json uses stdout, found -"),
        (["--stiffness-csv", "-", "--csv", "-"],
         "--stiffness-csv: expected a file, since --csv uses stdout, found -"),
        (["--stiffness-csv", "no/a"],
         "--stiffness-csv: expected a file in a folder that exists, found no folder no"),
    ],
)  # fmt: skip
def test_impossible_output_is_refused_before_the_work(
    arguments: list[str], line: str, scene: Path, solved: list[Any],
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    solved[0] = AssertionError("the work was begun")
    monkeypatch.chdir(scene.parent)
    (scene.parent / "b").mkdir()
    (scene.parent / "link.toml").symlink_to(scene)
    (scene.parent / "hard.toml").hardlink_to(scene)
    code, out, err = run(capsys, "run", scene, *arguments)
    assert (code, out) == (2, "")
    assert one_line(err) == line
    assert scene.read_text(encoding="utf-8") == SCENE


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        (["run", "--json", "meshes/body_1.msh"],
         "--json: expected a file other than that of body_1.file, found meshes/body_1.msh"),
        (["mesh", "-o", "meshes"],
         "-o: expected a file other than that of body_1.file, found meshes/body_1.msh"),
        (["compliance", "-o", "meshes"],
         "-o: expected a file other than that of body_2.file, found meshes/body_2.npz"),
        (["verify", "-o", "."], "-o: expected a file other than the scene, found deck.inp"),
        (["accuracy", "--csv", "a", "--json", "a"],
         "--json: expected a file other than that of --csv, found a"),
        (["accuracy", "--resume", "deck.inp"],
         "--resume: expected a file other than the scene, found deck.inp"),
        (["run", "--vtu", "meshes/../links"],
         ("--vtu: expected a folder whose files do not replace meshes/body_1.msh (that of "
         "body_1.file), found meshes/../links")),
        (["run", "--plot", "links"],
         "--plot: expected a folder whose files do not replace deck.inp (the scene), found links"),
        (["mesh", "-o", "m.msh"],
         "-o: expected a folder for both meshes, such as m, found m.msh, the name of a file"),
        (["accuracy", "--plot", "p.svg"],
         "--plot: expected a folder for PNG files, such as p, found p.svg, the name of a file"),
    ],
    ids=lambda one: one[0] if isinstance(one, list) else "",
)  # fmt: skip
def test_output_does_not_replace_what_the_scene_reads(
    arguments: list[str], line: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:  # fmt: skip
    monkeypatch.chdir(tmp_path)
    Path("meshes").mkdir()
    for name in ("body_1.msh", "body_2.npz"):
        (Path("meshes") / name).write_text("mine", encoding="utf-8")
    Path("links").mkdir()
    Path("links/transmission_error.png").symlink_to("../deck.inp")
    Path("links/body_1_0000.vtu").symlink_to("../meshes/body_1.msh")
    Path("deck.inp").write_text(
        """
[body_1]
kind = "mesh"
file = "meshes/body_1.msh"
teeth = 16
flank_set = "FLANK"
fixed_set = "BORE"
reference_radius_mm = 40.0
[body_2]
kind = "compliance"
file = "meshes/body_2.npz"
[pair]
center_distance_mm = 91.5
face_width_mm = 14.0
[load]
torque_Nm = 302.0
""",
        encoding="utf-8",
    )
    command, *options = arguments
    code, out, err = run(capsys, command, "deck.inp", *options)
    assert (code, out) == (2, "")
    assert one_line(err) == line
    assert sorted(os.listdir()) == ["deck.inp", "links", "meshes"]


def test_outputs_may_go_to_one_device(
    scene: Path, solved: list[Any], capsys: pytest.CaptureFixture[str]
) -> None:
    arguments = ("--json", "/dev/null", "--csv", "/dev/null", "--quiet")
    assert run(capsys, "run", scene, *arguments) == (0, "", "")


@pytest.mark.usefixtures("empty_pictures")
def test_picture_folder_may_be_called_like_a_file_if_it_is_there(
    scene: Path, solved: list[Any], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "p.pdf").mkdir()
    assert run(capsys, "run", scene, "--plot", tmp_path / "p.pdf", "--quiet") == (0, "", "")
    assert (tmp_path / "p.pdf" / "transmission_error.png").exists()


@pytest.mark.parametrize(
    ("error", "code", "line"),
    [
        (NoContactState("no state"), 1, "{file}: no state"),
        (SceneError(key="variables[0].start", expected="this", found="that"), 2,
         "{file}: variables[0].start: expected this, found that"),
        (KeyboardInterrupt(), 130, "interrupted"),
    ],
    ids=["not solved", "bad input", "interrupted"],
)  # fmt: skip
def test_failed_optimisation_leaves_no_output(
    error: BaseException, code: int, line: str, scene: Path, tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str],
) -> None:  # fmt: skip
    def optimise(*_: object, **__: object) -> None:
        raise error

    monkeypatch.setattr(
        importlib.import_module("flankload.studies.optimisation"), "optimise", optimise
    )
    file = tmp_path / "optimisation.toml"
    file.write_text(f"scene = '{scene.name}'\n", encoding="utf-8")
    found, out, err = run(capsys, "optimise", file, "-o", tmp_path / "best.toml")
    assert (found, out) == (code, "")
    assert one_line(err) == line.format(file=file)
    assert sorted(os.listdir(tmp_path)) == ["optimisation.toml", "pair.toml"]


@pytest.mark.parametrize(
    ("error", "code", "line"),
    [
        (NoContactState("no state at position 3"), 1,
         "{scene}: no state at position 3"),
        (SceneError(file="a.toml", key="pair.x", expected="this", found="that"), 2,
         "a.toml: pair.x: expected this, found that"),
        (KeyboardInterrupt(), 130, "interrupted"),
    ],
    ids=["not solved", "bad input", "interrupted"],
)  # fmt: skip
def test_failed_run_leaves_no_output(
    error: BaseException, code: int, line: str, scene: Path, tmp_path: Path,
    solved: list[Any], capsys: pytest.CaptureFixture[str],
) -> None:  # fmt: skip
    solved[0] = error
    found, out, err = run(
        capsys, "run", scene, "--json", tmp_path / "a.json", "--csv", tmp_path / "a.csv",
        "--plot", tmp_path / "out",
    )  # fmt: skip
    assert (found, out) == (code, "")
    assert one_line(err) == line.format(scene=scene)
    assert os.listdir(tmp_path) == ["pair.toml"]


@pytest.mark.usefixtures("empty_pictures")
def test_failed_picture_leaves_no_output(
    scene: Path, tmp_path: Path, solved: list[Any], monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:  # fmt: skip
    import flankload.plot.style

    def refuse(*_: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device", "out/picture.png")

    monkeypatch.setattr(flankload.plot.style, "write_atomically", refuse)
    code, out, err = run(
        capsys, "run", scene, "--json", tmp_path / "a.json", "--plot", tmp_path / "out"
    )
    assert (code, out) == (1, "")
    assert one_line(err) == "out/picture.png: no space left on device"
    assert not (tmp_path / "a.json").exists()
    assert os.listdir(tmp_path / "out") == []


def test_reader_that_leaves_early_gets_no_traceback() -> None:
    reading, writing = os.pipe()
    os.close(reading)
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM, "schema"],
        stdout=writing, stderr=subprocess.PIPE, text=True, check=False,
    )  # fmt: skip
    os.close(writing)
    assert done.stderr == ""
    assert done.returncode == 0


@pytest.mark.skipif(not Path("/dev/full").is_char_device(), reason="no /dev/full here")
def test_full_disk_behind_stdout_gets_one_line() -> None:
    with open("/dev/full", "w") as full:
        done = subprocess.run(
            [sys.executable, "-c", PROGRAM, "schema"],
            stdout=full, stderr=subprocess.PIPE, text=True, timeout=60,
        )  # fmt: skip
    assert done.returncode == 1
    assert one_line(done.stderr) == "stdout: no space left on device"


def test_closed_stdout_gets_no_traceback() -> None:
    command = f"exec '{sys.executable}' -c '{PROGRAM}' schema >&-"
    done = subprocess.run(["sh", "-c", command], capture_output=True, text=True, timeout=60)
    assert (done.returncode, done.stderr) == (0, "")


def test_scene_of_any_suffix_can_be_checked(
    scene: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    renamed = scene.rename(scene.with_suffix(".scene"))
    code, out, _ = run(capsys, "check", renamed)
    assert code == 0
    assert "small job: a valid scene" in out


def test_progress_shows_after_patience_on_a_terminal_only(
    scene: Path, solved: list[Any], monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:  # fmt: skip
    import time

    import flankload.cli.progress as room

    monkeypatch.setattr(room, "PATIENCE_S", 0.05)
    found = solved[0]

    def slow(_: object, progress: Any, **__: object) -> Any:
        progress("compliance body 1", 1, 5)
        time.sleep(0.2)
        # a busy machine draws late
        end = time.monotonic() + 60.0
        while sys.stderr.isatty() and time.monotonic() < end:
            if "compliance body 1" in sys.stderr.getvalue():  # type: ignore[attr-defined]
                break
            time.sleep(0.05)
        progress("sweep", 3, 5)
        return found

    monkeypatch.setattr(importlib.import_module("flankload.api"), "solve", slow)
    assert "compliance" not in run(capsys, "run", scene)[2]
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    monkeypatch.setenv("TERM", "xterm")
    assert "compliance body 1" in run(capsys, "run", scene)[2]


@pytest.mark.parametrize("kind", ["mesh", "compliance", "cam"])
def test_file_name_that_is_too_long_is_refused(
    kind: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    name = "a" * 5000 + (".csv" if kind == "cam" else ".npz")
    body = {
        "mesh": f'[body_1]\nkind = "mesh"\nfile = "{name}"\nteeth = 20\nreference_radius_mm = 40',
        "compliance": f'[body_1]\nkind = "compliance"\nfile = "{name}"',
        "cam": '[body_1]\nkind = "follower"\nbore_diameter_mm = 16\n'
        "arm_mm = 70\nroller_radius_mm = 10",
    }[kind]
    wheel = {
        "cam": f'[body_2]\nkind = "cam"\nbore_diameter_mm = 20\nprofile_file = "{name}"',
    }.get(kind, '[body_2]\nkind = "compliance"\nfile = "wheel.npz"')
    scene = tmp_path / "long.toml"
    tables = "[pair]\ncenter_distance_mm = 80\nface_width_mm = 10\n[load]\ntorque_Nm = 10"
    scene.write_text("\n".join([body, wheel, tables]), encoding="utf-8")
    for command in ("check", "run"):
        code, out, err = run(capsys, command, scene, *(["--json", "a"] if command == "run" else []))
        assert (code, out) == (2, "")
        assert one_line(err).endswith((", found no such file", f", found no file {name}"))


def test_letters_that_the_terminal_does_not_have_are_no_traceback(scene: Path) -> None:
    scene.write_text(SCENE.replace("small job", "小さな歯車"), encoding="utf-8")
    done = subprocess.run(
        [sys.executable, "-m", "flankload", "check", str(scene)],
        capture_output=True, text=True, check=False,
        env={**os.environ, "PYTHONIOENCODING": "ascii"},
    )  # fmt: skip
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.startswith("\\u5c0f\\u3055")


def test_manual_page_is_that_of_the_parser() -> None:
    """`python docs/make_manual.py` writes it anew."""
    docs = DOCS
    page = (docs / "flankload.1").read_text(encoding="ascii")
    assert page == runpy.run_path(str(docs / "make_manual.py"))["manual"]()
    for command in ("run", "plan", "check"):
        assert f".SS flankload {command} " in page


def test_manual_page_has_single_percent_signs() -> None:
    """Regression: the page had the doubled signs that argparse needs."""
    page = (DOCS / "flankload.1").read_text(encoding="ascii")
    assert "errors of 1 %, 0.1 % and 0.01 %" in page
    assert "%%" not in page


@pytest.mark.parametrize(
    ("command", "words"),
    [
        ("run", "Solve a scene and print"),
        ("check", "Validate a scene or a mesh file"),
        ("schema", "Print the JSON schema"),
        ("accuracy", "Print error and CPU time"),
    ],
)
def test_help_of_a_command_describes_it(
    command: str, words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """Regression: the help of a command listed its options without a word on its purpose."""
    with pytest.raises(SystemExit):
        main([command, "--help"])
    assert words in " ".join(capsys.readouterr().out.split())
