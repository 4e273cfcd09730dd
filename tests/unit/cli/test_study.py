"""The command study: files, exit codes, errors in one line, interrupts."""

from __future__ import annotations

import csv
import io
import re
import shutil
import signal
import subprocess
import sys
import time
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest

from flankload.cli import main
from tests.support.design_scene import TEXT
from tests.support.paths import EXAMPLES

STUDY = """
scene = "pair.toml"
design = "factorial"
quantities = ["peak_pressure_MPa"]
[variables]
load.torque_Nm = [100, 200]
[changes]
body_1.profile_shift = 0.18
"""
PROGRAM = "import sys; from flankload.__main__ import command; sys.exit(command())"


@pytest.fixture
def study(tmp_path: Path) -> Path:
    (tmp_path / "pair.toml").write_text(TEXT, encoding="utf-8")
    path = tmp_path / "study.toml"
    path.write_text(STUDY, encoding="utf-8")
    return path


def run(capsys: pytest.CaptureFixture[str], *argv: str | Path) -> tuple[int, str, str]:
    """Exit code, stdout and stderr of the command."""
    code = main(["study", *map(str, argv)])
    out, err = capsys.readouterr()
    return code, out, err


def edit(path: Path, old: str, new: str) -> None:
    text = path.read_text(encoding="utf-8")
    assert old in text
    path.write_text(text.replace(old, new), encoding="utf-8")


def test_a_study_is_solved_written_and_not_solved_again(
    study: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    names = [study.parent / name for name in ("a.csv", "a.parquet")]
    code, out, err = run(capsys, study, "-o", names[0], "-o", names[1])
    assert (code, err) == (0, "flankload: 1 of 2 designs finished\n")
    head, columns, *lines = out.splitlines()
    assert head == "small job: 2 designs"
    assert columns.split("  ")[-1] == "largest"
    assert [line.split()[0] for line in lines] == ["peak_pressure_MPa", "least"]
    files = {"pair.toml", "study.toml", "study.sqlite", "a.csv", "a.parquet"}
    assert {path.name for path in study.parent.iterdir()} == files
    monkeypatch.delattr(import_module("flankload.studies.design.run"), "solve_scene")
    code, out, err = run(capsys, study, "-o", "-")
    assert (code, err) == (0, "")
    assert out == names[0].read_text(encoding="utf-8")
    rows = list(csv.DictReader(io.StringIO(out)))
    assert [row["load.torque_Nm"] for row in rows] == ["100", "200"]
    assert run(capsys, study, "--quiet") == (0, "", "")


def test_plots_are_written_and_named(study: Path, capsys: pytest.CaptureFixture[str]) -> None:
    edit(study, "[100, 200]", "[100, 200, -1]")
    folder = study.parent / "out"
    code, out, err = run(capsys, study, "--plot", folder)
    assert (code, err) == (0, "flankload: 1 of 3 designs finished\n")
    assert out.splitlines()[0].startswith("small job: 3 designs, 1 of them failed")
    assert out.splitlines()[-1] == f"plots in {folder}: curve_peak_pressure_MPa.png"
    assert [path.name for path in folder.iterdir()] == ["curve_peak_pressure_MPa.png"]
    edit(study, "[100, 200, -1]", "[100]")
    code, out, _ = run(capsys, study, "--plot", folder)
    assert out.splitlines()[-1] == f"plots in {folder}: none suits this study"


def test_processes_and_a_scheduler_are_workers(
    study: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    done: list[Any] = []
    module = import_module("flankload.studies.design.run")
    monkeypatch.setattr(module, "solve_scene", lambda *a: done.append(a))
    assert run(capsys, study, "--processes", "--workers", "1", "--quiet") == (0, "", "")
    assert not done  # not in this process
    monkeypatch.setattr(import_module("flankload.cli.designing"), "PATIENCE_S", 0.5)
    code, _, err = run(capsys, study, "--scheduler", "tcp://127.0.0.1:1")
    assert code == 1
    line = f"flankload: {study}: --scheduler tcp://127.0.0.1:1: no connection: "
    assert err.startswith(line)
    assert err.count("\n") == 1


@pytest.mark.parametrize(
    ("old", "new", "line"),
    [
        ('"pair.toml"', '"none.toml"', "{folder}/none.toml: file: expected a scene file to read"),
        ("design", "desing", "{study}: desing: expected a known key (did you mean design?)"),
        ("[variables]", "[variable]", "{study}: variables: expected a table of paths with values"),
        ("torque_Nm", "torqe_Nm", "{study}: variables.load.torqe_Nm: expected a known key (did"),
        (
            "[100",
            "[-100",
            "{study}: variables.load.torque_Nm: expected a number from 0 to 1e+12 or",
        ),
        ("profile_shift", "shift", "{study}: changes.body_1.shift: expected a known key"),
        ("[changes]\nbody_1.profile_shift", "[variables.changes]\na", "{study}: variables.changes"),
        ("peak_pressure_MPa", "peak_MPa", "{study}: quantities: expected names in Result.summary"),
        ("[variables]", "n = 3\n[variables]", "{study}: n: expected no such key, since the"),
        ('"factorial"', "1", "{study}: design: expected a non-empty string"),
        (
            "[variables]",
            "store = 'pair.toml'\n[variables]",
            "{study}: store: expected a file other than the scene",
        ),
        (
            "[variables]",
            "store = 'no/a'\n[variables]",
            "{study}: store: expected a file in a folder that",
        ),
    ],
)
def test_a_wrong_study_gets_exit_2_and_one_line(
    study: Path, capsys: pytest.CaptureFixture[str], old: str, new: str, line: str
) -> None:
    edit(study, old, new)
    code, out, err = run(capsys, study)
    assert (code, out) == (2, "")
    assert err.startswith("flankload: " + line.format(study=study, folder=study.parent))
    assert err.count("\n") == 1


@pytest.mark.parametrize(
    ("options", "line"),
    [
        (["-o", "a.txt"], "-o: expected a file ending in .csv or .parquet, found a.txt"),
        (["-o", "none/a.csv"], "-o: expected a file in a folder that exists, found no folder none"),
        (["--plot", "study.toml"], "--plot: expected a folder, found the file study.toml"),
        (["--workers", "0"], "--workers: expected an integer > 0, found 0"),
        (
            ["--workers", "2", "--processes", "--scheduler", "a"],
            "argument --scheduler: not allowed",
        ),
    ],
)
def test_wrong_options_get_exit_2_and_one_line(
    study: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    options: list[str],
    line: str,
) -> None:
    monkeypatch.chdir(study.parent)
    try:
        code = main(["study", str(study), *options])
    except SystemExit as leaving:
        code = int(leaving.code or 0)
    assert code == 2
    assert capsys.readouterr().err.startswith(f"flankload: {line}")
    assert not study.with_suffix(".sqlite").exists()


def test_packages_that_are_missing_are_named(
    study: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    module = import_module("flankload.cli.designing")
    monkeypatch.setattr(module, "find_spec", lambda _: None)
    for options, extra in ((["-o", "a.parquet"], "parquet"), (["--scheduler", "a"], "dask")):
        code, _, err = run(capsys, study, *options)
        assert code == 2
        assert f"pip install 'flankload[{extra}]'" in err


def test_failed_designs_are_said_and_a_study_of_nothing_else_is_not_solved(
    study: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    edit(study, "load.torque_Nm = [100, 200]", "body_1.bore_diameter_mm = [30, 70]")
    code, out, _ = run(capsys, study)
    assert code == 0
    assert out.startswith("small job: 2 designs, 1 of them failed; first: ")
    edit(study, "[30, 70]", "[70, 72]")
    code, _, err = run(capsys, study)
    assert code == 1
    assert err.splitlines()[-1].startswith(f"flankload: {study}: no design has a solution: ")


def test_an_interrupt_names_what_is_finished_and_the_command_that_resumes(study: Path) -> None:
    edit(study, "[100, 200]", str(list(range(100, 400))))
    arguments = ["study", str(study), "--workers", "1"]
    with subprocess.Popen(
        [sys.executable, "-c", PROGRAM, *arguments], stderr=subprocess.PIPE, text=True
    ) as process:
        store, limit = study.with_suffix(".sqlite-wal"), time.monotonic() + 60
        while time.monotonic() < limit and not (store.exists() and store.stat().st_size > 50_000):
            time.sleep(0.01)
        process.send_signal(signal.SIGINT)
        _, err = process.communicate(timeout=60)
    assert process.returncode == 130
    found = re.fullmatch(
        r"flankload: 1 of 300 designs finished\n"
        r"(?:flankload: this takes about .*\n)?"
        r"flankload: interrupted: (\d+) of 300 designs are finished; flankload study \S+ "
        r"--workers 1 resumes\n",
        err,
    )
    assert found is not None, err
    assert 0 < int(found[1]) < 300


def test_the_example_is_a_study(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for name in ("scenes", "studies"):
        shutil.copytree(EXAMPLES / name, tmp_path / name)
    (path,) = (tmp_path / "studies").glob("*.toml")
    edit(path, "[changes]", "[changes]\npositions.count = 4\naccuracy.flank_element_mm = 3")
    code, out, _ = run(capsys, path, "-o", "-")
    assert code == 0
    rows = list(csv.DictReader(io.StringIO(out)))
    assert [row["status"] for row in rows] == ["solved"] * 10


def test_progress_has_rate_and_time_left() -> None:
    """Stored designs and the slow first one are excluded from the rate."""
    rate_of = import_module("flankload.cli.designing")._Rate
    told: list[tuple[str, int, int, float | None]] = []
    said: list[str] = []

    class Told:
        def tell(self, *arguments: Any) -> None:
            told.append(arguments)

        def say(self, line: str) -> None:
            said.append(line)

    now = [0.0]
    rate = rate_of(Told(), said=True, now=lambda: now[0])
    for seconds, stage, done in (
        *((0.0, "store", 49), (0.0, "store", 50), (9.0, "designs", 51)),
        *((9.5, "designs", 52), (49.0, "designs", 53)),
    ):
        now[0] = seconds
        rate.tell(stage, done, 60)
    assert said == ["flankload: 51 of 60 designs (2 from the store) finished"]
    assert told == [
        ("49 of 60 designs (1 from the store)", 49, 60, None),
        ("50 of 60 designs (2 from the store)", 50, 60, None),
        ("51 of 60 designs (2 from the store)", 51, 60, None),
        ("52 of 60 designs (2 from the store), 2.0/s", 52, 60, 4.0),
        ("53 of 60 designs (2 from the store), 3.0/min", 53, 60, 140.0),
    ]


#: Starts a worker, prints its process id, and waits to be killed.
PARENT = """
import os, sys, time
from argparse import Namespace
from flankload.cli.designing import _executor
if __name__ == "__main__":
    with _executor(Namespace(scheduler=None, workers=1, processes=True)) as pool:
        print(pool.submit(os.getpid).result(), flush=True)
        time.sleep(60)
"""


def test_workers_end_with_a_parent_that_is_killed(tmp_path: Path) -> None:
    """Regression: they waited for tasks forever."""
    program = tmp_path / "parent.py"
    program.write_text(PARENT, encoding="utf-8")
    parent = subprocess.Popen(
        [sys.executable, str(program)], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL
    )
    assert parent.stdout is not None
    worker = int(parent.stdout.readline())
    parent.kill()
    # the worker holds this pipe as long as it lives
    assert parent.stdout.read() == b""
    parent.wait()
    parent.stdout.close()
    end = time.monotonic() + 10.0
    while Path(f"/proc/{worker}").exists() and time.monotonic() < end:
        time.sleep(0.02)
    assert not Path(f"/proc/{worker}").exists() or "Z" in state_of(worker)


def state_of(process: int) -> str:
    return Path(f"/proc/{process}/stat").read_text(encoding="utf-8").split()[2]


def test_an_output_does_not_replace_a_file_of_a_design(
    study: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(study.parent)
    edit(study, "body_1.profile_shift = 0.18", 'body_1.topography_file = "grid.csv"')
    code, _, err = run(capsys, study, "-o", "grid.csv")
    line = "-o: expected a file other than grid.csv of body_1.topography_file, found grid.csv"
    assert (code, err) == (2, f"flankload: {line}\n")
