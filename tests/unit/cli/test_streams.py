"""Streams that are closed, full or read by nobody: the work is done nevertheless."""

from __future__ import annotations

import errno
import io
import os
import subprocess
import sys
from pathlib import Path
from typing import NoReturn

import pytest

from flankload.cli import main
from flankload.cli.outputs import write_text
from tests.support.design_scene import TEXT


class Unread(io.StringIO):
    """A stream whose reader has closed the pipe, or whose disk is full."""

    def __init__(self, code: int) -> None:
        super().__init__()
        self.code = code

    def write(self, _: str) -> NoReturn:
        raise OSError(self.code, os.strerror(self.code))


@pytest.mark.parametrize("code", [errno.ENOSPC, errno.EPIPE])
def test_an_error_that_nobody_can_read_keeps_its_exit_code(
    code: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "stderr", Unread(code))
    assert main(["run", "none.toml"]) == 2


def test_a_reader_that_leaves_stops_no_other_output(monkeypatch: pytest.MonkeyPatch) -> None:
    """Regression: `run --json - --csv F | head` ended before F was written, with exit code 0."""
    monkeypatch.setattr(sys, "stdout", Unread(errno.EPIPE))
    write_text("-", "text")


def test_a_study_needs_no_open_streams_and_no_letters_of_the_locale(tmp_path: Path) -> None:
    """Regression: with closed stderr, `run`, `report` and `study` failed without a message.

    The next file that was opened got the number of the closed stream. In the locale C without
    UTF-8, a report or a study named ü ended in UnicodeEncodeError.
    """
    (tmp_path / "ü.toml").write_text(TEXT.replace('name = "small job"', ""), encoding="utf-8")
    study = """scene = "ü.toml"\nstore = "ß.sqlite"\nquantities = ["peak_pressure_MPa"]
[variables]\nload.torque_Nm = [100]\n"""
    (tmp_path / "ö.toml").write_text(study, encoding="utf-8")
    environment = {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}
    command = f"exec '{sys.executable}' -m flankload study ö.toml -o ä.csv 2>&- <&-"
    done = subprocess.run(
        ["sh", "-c", command],
        cwd=tmp_path, stdout=subprocess.PIPE, text=True, env={**os.environ, **environment},
    )  # fmt: skip
    assert done.returncode == 0
    assert done.stdout.startswith("\\xfc: 1 designs")
    assert sorted(os.listdir(tmp_path)) == sorted(["ü.toml", "ö.toml", "ß.sqlite", "ä.csv"])
