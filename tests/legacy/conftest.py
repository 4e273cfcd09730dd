"""The library as it is installed, without Python; what is built against it knows nothing else."""

from __future__ import annotations

import fcntl
import os
import shutil
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from decimal import Decimal
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PROGRAMS = Path(__file__).parent / "programs"
LINKING = [pytest.param(False, id="shared"), pytest.param(True, id="static")]
#: Kept from run to run: nothing new to compile takes two seconds.
BUILD = ROOT / "build-core"
#: As they are installed.
EXAMPLES = BUILD / "prefix" / "share" / "doc" / "flankload" / "examples"


@contextmanager
def alone() -> Iterator[None]:
    """Keep other processes of the same test run from building here at the same time."""
    BUILD.mkdir(exist_ok=True)
    with (BUILD / "tests.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield


@pytest.fixture(scope="session")
def prefix() -> Path:
    """Where the library is installed."""
    target = BUILD / "prefix"
    with alone():
        subprocess.run([ROOT / "dev", "install", target], check=True, capture_output=True)
    return target


@pytest.fixture(scope="session")
def environment(prefix: Path) -> dict[str, str]:
    """What a caller sets: where pkg-config finds the library, and one thread."""
    return {
        **os.environ,
        "PKG_CONFIG_PATH": str(prefix / "lib" / "pkgconfig"),
        "OPENBLAS_NUM_THREADS": "1",
        "OMP_NUM_THREADS": "1",
    }


@pytest.fixture(scope="session")
def workshop(prefix: Path) -> Path:
    """A folder outside the sources; programs are built there when the library is newer."""
    folder = BUILD / "programs"
    folder.mkdir(exist_ok=True)
    newest = max(path.stat().st_mtime for path in prefix.rglob("*") if path.is_file())
    with alone():
        for program in folder.glob("*/*"):
            old = program.is_file() and program.stat().st_mtime < newest
            if old and os.access(program, os.X_OK):
                program.unlink()
    return folder


def written(path: Path, text: str) -> Path:
    """A file that other processes of the same test run may be reading already."""
    with alone():
        if not path.exists() or path.read_text(encoding="ascii") != text:
            path.write_text(text, encoding="ascii")
    return path


def built(source: Path, folder: Path, environment: dict[str, str], *, static: bool) -> Path:
    """Copy a folder with a Makefile out of the tree and make it there."""
    command = ["make", "-C", str(folder), *(["LINK=link_static"] if static else [])]
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
    """What a program prints; it must end well and complain of nothing."""
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
    """A printed number is the number, rounded to its last printed digit."""
    found = Decimal(token)
    last_digit = Decimal(1).scaleb(int(found.as_tuple().exponent))
    assert abs(found - Decimal(float(number))) <= last_digit / 2, f"{token} for {number!r}"
