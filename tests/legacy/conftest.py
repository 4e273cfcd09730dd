"""The installed library without Python, against which the programs are built."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

import pytest

from tests.support.programs import BUILD, ROOT, alone


@pytest.fixture(scope="session")
def prefix() -> Path:
    """Folder of the installed library."""
    target = BUILD / "prefix"
    with alone():
        subprocess.run([ROOT / "dev", "install", target], check=True, capture_output=True)
    return target


@pytest.fixture(scope="session")
def environment(prefix: Path) -> dict[str, str]:
    """Environment of a caller: the folder of pkg-config, and one thread."""
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
