"""The commands that write a report: one line for a bad output, the page for a good one."""

from __future__ import annotations

import importlib
from pathlib import Path
from typing import Any

import pytest

from flankload.report import document
from tests.support.command_line import run
from tests.support.made_up_result import made_up_result
from tests.support.small_job import SCENE


@pytest.fixture
def scene(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A scene whose solution and plots cost nothing."""
    monkeypatch.setattr(
        importlib.import_module("flankload.api"), "solve", lambda *_, **__: made_up_result()
    )
    monkeypatch.setattr(document, "plots_of", lambda _: {})
    path = tmp_path / "pair.toml"
    path.write_text(SCENE, encoding="utf-8")
    return path


def test_page_is_written_and_named(
    scene: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    page = tmp_path / "report.html"
    assert run(capsys, "report", scene, "-o", page) == (0, f"wrote {page}\n", "")
    text = page.read_text(encoding="utf-8")
    assert f"flankload report {scene} -o {page}" in text
    page.unlink()
    code, out, err = run(capsys, "run", scene, "--report", page)
    assert (code, err) == (0, "")
    assert out.endswith(f"\n\nwrote {page}\n")
    assert page.read_text(encoding="utf-8").startswith("<!DOCTYPE html>")


def test_page_on_stdout_is_alone(scene: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for argv in (("report", scene, "-o", "-"), ("run", scene, "--report", "-")):
        code, out, err = run(capsys, *argv)
        assert (code, err) == (0, "")
        assert out.startswith("<!DOCTYPE html>")
        assert out.endswith("</html>\n")


@pytest.mark.parametrize("option", ["-o", "--report"])
@pytest.mark.parametrize(
    ("name", "line"),
    [
        ("", "expected a file, found the folder {folder}"),
        ("none/a.html", "expected a file in a folder that exists, found no folder {folder}/none"),
        ("pair.toml", "expected a file other than the scene, found {folder}/pair.toml"),
    ],
)
def test_output_that_cannot_be_written_is_refused_before_the_run(
    scene: Path,
    option: str,
    name: str,
    line: str,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def never(*_: Any, **__: Any) -> None:
        pytest.fail("solved")

    monkeypatch.setattr(importlib.import_module("flankload.api"), "solve", never)
    command = "report" if option == "-o" else "run"
    code, out, err = run(capsys, command, scene, option, scene.parent / name)
    assert (code, out) == (2, "")
    assert err == f"flankload: {option}: {line.format(folder=scene.parent)}\n"
    assert scene.read_text(encoding="utf-8") == SCENE


def test_two_outputs_on_stdout_and_a_missing_output_are_refused(
    scene: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    code, _, err = run(capsys, "run", scene, "--json", "-", "--report", "-")
    assert code == 2
    assert err == ("flankload: --report: expected a file, since --json uses stdout, found -\n")
    code, _, err = run(capsys, "report", scene)
    assert code == 2
    assert err.startswith("flankload: the following arguments are required: -o")
    assert err.count("\n") == 1
