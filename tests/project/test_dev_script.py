"""`./dev` where something is missing: one line that says so, and one to paste."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tests.support.paths import ROOT


@pytest.fixture
def checkout(tmp_path: Path) -> Path:
    for name in ("dev", "pyproject.toml", "meson.build"):
        shutil.copy2(ROOT / name, tmp_path)
    return tmp_path


def script(path: Path, text: str) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(f"#!/bin/sh\n{text}\n", encoding="utf-8")
    path.chmod(0o755)


def said_by(checkout: Path, *arguments: str, **environment: str) -> str:
    done = subprocess.run(
        [shutil.which("bash"), checkout / "dev", *arguments],
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 1, done.stderr
    return done.stderr


def few_tools(folder: Path) -> str:
    """A PATH without compilers, for a user who is not root."""
    folder.mkdir()
    for name in ("dirname", "realpath", "grep", "cut", "sed"):
        (folder / name).symlink_to(shutil.which(name))
    (folder / "python3").symlink_to(sys.executable)
    script(folder / "id", "echo 1000")
    script(folder / "apt-get", "exit 100")
    return str(folder)


def test_without_root_there_is_a_line_for_the_administrator(checkout) -> None:
    said = said_by(checkout, "install", str(checkout / "to"), PATH=few_tools(checkout / "tools"))
    [line] = [line for line in said.splitlines() if "apt-get install" in line]
    assert line.startswith("  apt-get update && apt-get install -y gfortran gcc pkg-config make")


def test_other_systems_see_their_own_packages(checkout) -> None:
    path = few_tools(checkout / "tools")
    (checkout / "tools" / "apt-get").unlink()
    script(checkout / "tools" / "pacman", "exit 100")
    said = said_by(checkout, "install", str(checkout / "to"), PATH=path)
    assert "  pacman -S gcc-fortran gcc pkgconf make openblas python\n" in said


def test_without_network_apt_says_one_line(checkout) -> None:
    path = few_tools(checkout / "tools")
    script(checkout / "tools" / "id", "echo 0")
    (checkout / "tools" / "env").symlink_to(shutil.which("env"))
    failed = "echo 'W: Failed to fetch x  Temporary failure resolving y' >&2; exit 100"
    script(checkout / "tools" / "apt-get", failed)
    said = said_by(checkout, "install", str(checkout / "to"), PATH=path)
    assert [line for line in said.splitlines() if "network" in line] == [
        "dev: no network: apt-get cannot fetch what is missing"
    ]
    assert "Temporary failure" not in said


def test_without_network_pip_says_one_line(checkout) -> None:
    path = few_tools(checkout / "tools")
    for name in ("gfortran", "gcc", "make", "pkg-config"):
        script(checkout / "tools" / name, "exit 0")
    (checkout / "tools" / "apt-get").unlink()
    script(
        checkout / ".venv" / "bin" / "python",
        "echo 'NewConnectionError: [Errno 111] Connection refused' >&2; exit 1",
    )
    said = said_by(checkout, "install", str(checkout / "to"), PATH=path)
    assert said.splitlines()[-1].startswith("dev: no network: pip cannot fetch Python packages")
    assert "NewConnectionError" not in said


def test_every_command_is_in_its_help_and_in_the_guide_for_contributors() -> None:
    text = (ROOT / "dev").read_text(encoding="utf-8")
    guide = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    commands = re.findall(r"^    (\w+)\) (?:setup|run_)", text, re.M)
    assert {"docs", "measure"} <= set(commands)
    done = subprocess.run([ROOT / "dev", "help"], capture_output=True, text=True, check=True)
    for command in commands:
        assert re.search(rf"^  {command} ", done.stdout, re.M), command
        assert re.search(rf"^\| `\./dev {command}\b", guide, re.M), command
