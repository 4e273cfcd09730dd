"""Programs in other languages, built against the installed library."""

from __future__ import annotations

import fcntl
import shutil
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from decimal import Decimal
from pathlib import Path

import pytest

from tests.support.paths import ROOT

PROGRAMS = ROOT / "tests" / "legacy" / "programs"
LINKING = [pytest.param(False, id="shared"), pytest.param(True, id="static")]
#: Kept between runs: a build without changes takes two seconds.
BUILD = ROOT / "build-core"
#: Names as installed.
EXAMPLES = BUILD / "prefix" / "share" / "doc" / "flankload" / "examples"


@contextmanager
def alone() -> Iterator[None]:
    """Keep other processes of the same test run from building here at the same time."""
    BUILD.mkdir(exist_ok=True)
    with (BUILD / "tests.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield


def written(path: Path, text: str) -> Path:
    """A file that other processes of the same test run may already be reading."""
    with alone():
        if not path.exists() or path.read_text(encoding="ascii") != text:
            path.write_text(text, encoding="ascii")
    return path


def built(
    source: Path, folder: Path, environment: dict[str, str], *, static: bool, program: str = "all"
) -> Path:
    """Copy a folder with a Makefile out of the tree and build it there, or one of its programs.

    A program with all of the library in it takes a second to link.
    """
    command = ["make", "-C", str(folder), program, *(["LINK=link_static"] if static else [])]
    with alone():
        folder.mkdir(exist_ok=True)
        for path in source.iterdir():
            copy = folder / path.name
            if path.is_file() and (
                not copy.exists() or copy.stat().st_mtime < path.stat().st_mtime
            ):
                shutil.copy2(path, copy)
        made = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    assert made.returncode == 0, made.stdout + made.stderr
    assert "warning" not in made.stderr, made.stderr
    return folder


def run(program: Path, data: Path | None, environment: dict[str, str], *arguments: str) -> str:
    """Output of a program; it must succeed and print no error."""
    text = data.read_text(encoding="ascii") if data else ""
    done = subprocess.run(
        [program, *arguments],
        input=text,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
        timeout=120,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stderr == ""
    return done.stdout


def expect_printed(token: str, number: float) -> None:
    """Check that a printed number is the number rounded to its last printed digit."""
    found = Decimal(token)
    last_digit = Decimal(1).scaleb(int(found.as_tuple().exponent))
    assert abs(found - Decimal(float(number))) <= last_digit / 2, f"{token} for {number!r}"
