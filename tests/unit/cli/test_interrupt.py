"""Ctrl-C, sent to a process: one line, exit code 130, nothing left behind, and soon."""

from __future__ import annotations

import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tests.support.paths import SCENES

SCENE = SCENES / "external_gear.toml"
#: Uninterrupted it would end after some ten seconds, and well.
COUNT = 20_000
#: A generous bound for work of milliseconds.
SOON_S = 60.0

#: The command as it is installed, which says when it begins …
BEGIN = """
import sys
from flankload.__main__ import command
print("begun", flush=True)
sys.exit(command())
"""
#: … or when its sweep does.
SWEEP = """
import sys
import flankload.contact.core_call as room
original = room.call_and_watch
def told(*arguments, **options):
    print("begun", flush=True)
    return original(*arguments, **options)
room.call_and_watch = told
from flankload.__main__ import command
sys.exit(command())
"""


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    path = tmp_path / "scene.toml"
    text = SCENE.read_text(encoding="utf-8")
    for key, value in (("count = 32", f"count = {COUNT}"), ("_Nm = 302", "_Nm = [100, 200, 302]")):
        assert key in text
        text = text.replace(key, value)
    path.write_text(text, encoding="utf-8")
    return path


@pytest.mark.parametrize("program", [BEGIN, SWEEP], ids=["imports", "sweep"])
def test_interrupted_process_ends_with_one_line_and_no_files(
    program: str, scene: Path, tmp_path: Path
) -> None:
    """Regression: an interrupt among the imports was a traceback, or was swallowed."""
    arguments = ["run", str(scene), "--json", str(tmp_path / "a.json"), "--quiet"]
    with subprocess.Popen(
        [sys.executable, "-c", program, *arguments],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "begun\n"
        time.sleep(0.1)
        process.send_signal(signal.SIGINT)
        _, err = process.communicate(timeout=SOON_S)
    assert process.returncode == 130
    assert err == "flankload: interrupted\n"
    assert sorted(tmp_path.iterdir()) == [scene]


def test_interrupt_of_a_finalizer_ends_the_process() -> None:
    """Regression: Python printed it with its traceback, and the run continued to exit code 0."""
    program = """
import signal, sys, time, weakref
import flankload.cli
from flankload.__main__ import command
def run():
    finalized = set()
    reference = weakref.ref(finalized, lambda _: signal.raise_signal(signal.SIGINT))
    del finalized
    time.sleep(10)
    return 0
flankload.cli.main = run
sys.exit(command())
"""
    ended = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert (ended.returncode, ended.stderr) == (130, "flankload: interrupted\n")


def test_interrupted_solve_raises_and_solves_again(scene: Path) -> None:
    """In Python it is an exception like any other: the core has stopped, the next call works."""
    program = f"""
import flankload as fl
scene = fl.read_scene({str(scene)!r})
try:
    fl.solve(scene, progress=lambda stage, done, total: print(stage, done, flush=True))
except KeyboardInterrupt:
    print("again", len(fl.solve(fl.read_scene({str(SCENE)!r})).status), flush=True)
"""
    with subprocess.Popen(
        [sys.executable, "-c", program], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout is not None
        seen = iter(process.stdout.readline, "")
        first = next(line for line in seen if line.startswith("sweep"))
        later = next(line for line in seen if line != first)
        assert later.startswith("sweep")
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=SOON_S)
    assert process.returncode == 0, err
    assert out.splitlines()[-1] == "again 32"
