"""Scenes as files: unreadable content, and its place in the error line."""

from pathlib import Path

import pytest

from flankload.errors import SceneError
from flankload.scene import read_scene
from tests.support.paths import SCENES


def test_syntax_error_names_the_line(tmp_path: Path) -> None:
    path = tmp_path / "bad.toml"
    path.write_text("name = 'a'\n[body_1\n", encoding="utf-8")
    with pytest.raises(SceneError) as caught:
        read_scene(path)
    line = str(caught.value)
    assert line.startswith(f"{path}: file: expected valid TOML, found line 2, column 8: ")
    assert "\n" not in line


def test_missing_file_is_named(tmp_path: Path) -> None:
    path = tmp_path / "none.toml"
    with pytest.raises(SceneError) as caught:
        read_scene(path)
    assert (
        str(caught.value)
        == f"{path}: file: expected a scene file to read, found no such file or directory"
    )


def test_file_that_is_no_text_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "binary.toml"
    path.write_bytes(b"# a scene\nname = '\xff'")
    with pytest.raises(SceneError, match="expected text in UTF-8, found line 2: byte 0xff"):
        read_scene(path)


def test_byte_order_mark_of_windows_editors_is_welcome(tmp_path: Path) -> None:
    path = tmp_path / "pair.toml"
    path.write_bytes(b"\xef\xbb\xbf" + (SCENES / "external_gear.toml").read_bytes())
    assert read_scene(path).name == "FZG type C"


@pytest.mark.parametrize(
    ("value", "line"),
    [
        ("[" * 5000 + "]" * 5000, "expected lists of a few levels, found too many levels"),
        ("9" * 5000, "expected numbers of a few digits, found one of thousands of digits"),
    ],
    ids=["deep list", "long number"],
)
def test_toml_that_python_itself_refuses_gets_one_line(
    tmp_path: Path, value: str, line: str
) -> None:
    path = tmp_path / "pair.toml"
    path.write_text(f"name = {value}\n", encoding="utf-8")
    with pytest.raises(SceneError) as caught:
        read_scene(path)
    assert str(caught.value) == f"{path}: file: {line}"


def test_errors_from_a_file_name_it(tmp_path: Path) -> None:
    path = tmp_path / "pair.toml"
    path.write_text("name = 'a'\n", encoding="utf-8")
    with pytest.raises(SceneError) as caught:
        read_scene(path)
    assert str(caught.value).startswith(f"{path}: body_1.kind: expected 'gear' or ")
