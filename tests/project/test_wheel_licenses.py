"""A wheel that carries libraries carries their licences, too."""

from __future__ import annotations

import base64
import hashlib
import re
import runpy
import shutil
import tomllib
from pathlib import Path
from zipfile import ZipFile

import pytest

from tests.support.paths import ROOT

LICENSES = runpy.run_path(str(ROOT / ".ci" / "bundled_licenses.py"))
INFO = "flankload-0.dist-info"


def wheel_with(path: Path, *libraries: str) -> Path:
    with ZipFile(path, "w") as wheel:
        for library in libraries:
            wheel.writestr(f"flankload.libs/{library}", "")
        wheel.writestr(f"{INFO}/METADATA", "Name: flankload\nLicense-File: LICENSE\n\ntext\n")
        wheel.writestr(f"{INFO}/RECORD", f"{INFO}/METADATA,sha256=old,1\n{INFO}/RECORD,,\n")
    return path


@pytest.mark.skipif(shutil.which("dpkg-query") is None, reason="no packages of Debian")
def test_licences_of_bundled_libraries_are_in_the_wheel(tmp_path) -> None:
    libraries = ("libgfortran-59811b6f.so.5.0.0", "libgomp-f9a9ad78.so.1.0.0")
    path = wheel_with(tmp_path / "flankload-0-py3-none-any.whl", *libraries)
    LICENSES["add"](path)
    with ZipFile(path) as wheel:
        text = wheel.read(f"{INFO}/licenses/LICENSES_bundled.txt")
        metadata = wheel.read(f"{INFO}/METADATA").decode()
        record = wheel.read(f"{INFO}/RECORD").decode()
    for library in libraries:
        assert library in text.decode()
    assert "GCC RUNTIME LIBRARY EXCEPTION" in text.decode()
    assert "TERMS AND CONDITIONS" in text.decode()
    assert "License-File: LICENSE\nLicense-File: LICENSES_bundled.txt\n\ntext" in metadata
    digest = base64.urlsafe_b64encode(hashlib.sha256(text).digest()).rstrip(b"=").decode()
    assert f"LICENSES_bundled.txt,sha256={digest},{len(text)}" in record
    assert "sha256=old" not in record
    assert f"{INFO}/RECORD,,\n" in record


@pytest.mark.skipif(shutil.which("dpkg-query") is None, reason="no packages of Debian")
def test_library_without_a_known_licence_is_refused(tmp_path) -> None:
    path = wheel_with(tmp_path / "flankload-0-py3-none-any.whl", "libnobodyknows-0.so.1")
    with pytest.raises(SystemExit, match=r"libnobodyknows-0\.so\.1"):
        LICENSES["add"](path)


def test_package_says_that_it_is_typed() -> None:
    assert (ROOT / "python" / "flankload" / "py.typed").is_file()
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert "Typing :: Typed" in project["classifiers"]


def test_changelog_knows_the_version_of_the_build() -> None:
    """The built version is the next one, or the one tagged last."""
    build = (ROOT / "meson.build").read_text(encoding="utf-8")
    version = re.search(r"^    version: '([\d.]+)'", build, re.MULTILINE)[1]
    changes = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    announced = re.search(r"^The next version is ([\d.]+)\.$", changes, re.MULTILINE)
    tagged = re.findall(r"^## \[([\d.]+)\]", changes, re.MULTILINE)
    assert version in [*([announced[1]] if announced else []), *tagged[:1]]
