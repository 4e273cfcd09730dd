"""Reading of whole files: limits of size, names that no file can have, numbers as text."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

import flankload as fl
from flankload.base.files import path_of, read_file, write_atomically
from flankload.base.number_text import number_of
from flankload.errors import InputError, SceneError, one_line
from tests.support.design_scene import TEXT, design_scene

ZERO = Path("/dev/zero")


def test_a_file_is_read_up_to_its_limit(tmp_path: Path) -> None:
    path = tmp_path / "a"
    path.write_bytes(b"0123456789")
    assert read_file(path, 10) == b"0123456789"
    with pytest.raises(OSError, match="a file larger than 9e-06 million bytes"):
        read_file(path, 9)


@pytest.mark.skipif(not ZERO.is_char_device(), reason="no /dev/zero here")
def test_a_device_without_an_end_is_no_scene() -> None:
    """Regression: the device was read until the memory was full."""
    with pytest.raises(SceneError) as refused:
        fl.read_scene(ZERO)
    expected = "a scene file to read, found a file larger than 64 million bytes"
    assert str(refused.value) == f"/dev/zero: file: expected {expected}"


def test_a_name_with_nul_is_no_traceback(tmp_path: Path) -> None:
    """Regression: the ValueError of `open` was reported as a number of thousands of digits."""
    with pytest.raises(SceneError) as refused:
        fl.read_scene("a\0b.toml")
    found = "a\\x00b.toml: file: expected a scene file to read, found a name that no file can have"
    assert str(refused.value) == found
    with pytest.raises(OSError, match="a name that no file can have"):
        write_atomically(tmp_path / "a\0b", "")
    with pytest.raises(InputError, match="store: expected a path"):
        fl.study(design_scene(), {}, store="a\0b")


def test_bytes_of_a_name_that_are_no_letters_are_written_and_named(tmp_path: Path) -> None:
    """Regression: the report of such a scene ended in UnicodeEncodeError."""
    name = os.fsdecode(b"\xfc.toml")
    (tmp_path / name).write_text(TEXT.replace('name = "small job"', ""), encoding="utf-8")
    scene = fl.read_scene(tmp_path / name)
    assert scene.name == "\ufffd"
    assert scene.replace({"load.torque_Nm": 1.0}).name == "\ufffd"
    write_atomically(tmp_path / "a", f"of {name}")
    assert (tmp_path / "a").read_text(encoding="utf-8") == "of \ufffd.toml"
    assert str(SceneError(file=name, key="k", expected="a", found="b")).startswith(
        "\ufffd.toml: k:"
    )


def test_letters_that_a_terminal_obeys_are_written_out() -> None:
    assert one_line("a\x1b[2J\n b \u202eü") == "a\\x1b[2J b \\u202eü"


def test_a_name_is_that_of_a_file_in_any_locale(monkeypatch: pytest.MonkeyPatch) -> None:
    def of_ascii(name: str) -> bytes:
        return name.encode("ascii", "surrogateescape")

    assert path_of("ü.toml") == Path("ü.toml")
    monkeypatch.setattr(os, "fsencode", of_ascii)
    monkeypatch.setattr(os, "fsdecode", lambda name: name.decode("ascii", "surrogateescape"))
    assert of_ascii(str(path_of("ü.toml"))) == "ü.toml".encode()


@pytest.mark.parametrize("text", ["5_0", "٣", "1e_3", "", "1,5"])
def test_numbers_have_plain_digits(text: str) -> None:
    with pytest.raises(ValueError, match=r"number|float"):
        number_of(text)
    assert number_of(" -1.5e3 ") == -1500.0
