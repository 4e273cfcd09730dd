"""Files are there whole or not at all, whoever writes beside, whatever interrupts."""

from __future__ import annotations

import os
import stat
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from flankload.base.files import would_replace, write_atomically
from flankload.meshes.io import write_mesh

TRIANGLE = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [0.5, 0.0], [0.5, 0.5], [0.0, 0.5]])


def test_failed_write_keeps_the_old_file_and_leaves_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "result.json"
    path.write_text("old", encoding="utf-8")

    def refuse(*_: object) -> None:
        raise OSError("no space left on device")

    monkeypatch.setattr(os, "replace", refuse)
    with pytest.raises(OSError, match="no space"):
        write_atomically(path, "new")
    assert path.read_text(encoding="utf-8") == "old"
    assert os.listdir(tmp_path) == ["result.json"]


def test_output_into_a_pipe_is_written_there_and_the_pipe_stays(tmp_path: Path) -> None:
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    reading = os.open(pipe, os.O_RDONLY | os.O_NONBLOCK)
    try:
        write_atomically(pipe, "numbers")
        assert os.read(reading, 100) == b"numbers"
    finally:
        os.close(reading)
    assert pipe.is_fifo()
    assert os.listdir(tmp_path) == ["pipe"]


def test_output_through_a_link_keeps_the_link(tmp_path: Path) -> None:
    (tmp_path / "real").mkdir()
    target, link = tmp_path / "real" / "result.json", tmp_path / "result.json"
    target.write_text("old", encoding="utf-8")
    link.symlink_to(target)
    write_atomically(link, "new")
    assert link.is_symlink()
    assert target.read_text(encoding="utf-8") == "new"
    assert os.listdir(tmp_path / "real") == ["result.json"]


def test_failed_write_names_the_file_that_was_asked_for(tmp_path: Path) -> None:
    path = tmp_path / "no" / "result.json"
    with pytest.raises(FileNotFoundError) as caught:
        write_atomically(path, "new")
    assert caught.value.filename == str(path)


def test_threads_that_write_into_one_folder_do_not_swap_files(tmp_path: Path) -> None:
    names = [f"{k}.json" for k in range(8)] * 12

    def write(name: str) -> None:
        write_atomically(tmp_path / name, name * 5000)

    with ThreadPoolExecutor(8) as pool:
        list(pool.map(write, names))  # raises the exception of a thread
    assert sorted(os.listdir(tmp_path)) == sorted(set(names))
    for name in names:
        assert (tmp_path / name).read_text(encoding="utf-8") == name * 5000


@pytest.mark.parametrize("suffix", [".inp", ".msh", ".vtu"])
def test_threads_that_write_meshes_into_one_folder_do_not_lose_one(
    suffix: str, tmp_path: Path
) -> None:
    cells = (("triangle6", np.arange(6)[None, :]),)

    def write(k: int) -> None:
        write_mesh(tmp_path / f"{k % 4}{suffix}", TRIANGLE, cells, {})

    with ThreadPoolExecutor(4) as pool:
        list(pool.map(write, range(16)))
    assert sorted(os.listdir(tmp_path)) == [f"{k}{suffix}" for k in range(4)]
    assert len({path.read_bytes() for path in tmp_path.iterdir()}) == 1


def test_interrupt_at_any_line_leaves_the_old_or_the_new_file_alone(tmp_path: Path) -> None:
    path = tmp_path / "result.json"
    seen = set()
    for line in range(1, 100):
        path.write_text("old", encoding="utf-8")
        interrupted = _interrupted_at(line, path)
        assert os.listdir(tmp_path) == ["result.json"], line
        seen.add(path.read_text(encoding="utf-8"))
        if not interrupted:
            break
    assert not interrupted
    assert seen == {"old", "new"}


def _interrupted_at(line: int, path: Path) -> bool:
    """Write "new" with a Ctrl-C at a line of `write_atomically`; whether there is such a line."""
    left = [line]

    def at_line(_: Any, event: str, __: Any) -> Any:
        left[0] -= event == "line"
        if event == "line" and left[0] == 0:
            raise KeyboardInterrupt
        return at_line

    def at_call(frame: Any, *_: Any) -> Any:
        return at_line if frame.f_code is write_atomically.__code__ else None

    before = sys.gettrace()
    sys.settrace(at_call)
    try:
        write_atomically(path, "new")
    except KeyboardInterrupt:
        return True
    finally:
        sys.settrace(before)
    return False


@pytest.mark.parametrize("mode", [0o600, 0o664, 0o755])
def test_replaced_file_keeps_its_mode(mode: int, tmp_path: Path) -> None:
    path = tmp_path / "result.json"
    path.write_text("old", encoding="utf-8")
    path.chmod(mode)
    (tmp_path / "link").symlink_to(path)
    for name in ("result.json", "link"):
        write_atomically(tmp_path / name, "new")
        assert stat.S_IMODE(path.stat().st_mode) == mode


def test_new_file_has_the_mode_that_the_umask_leaves(tmp_path: Path) -> None:
    before = os.umask(0o027)
    try:
        write_atomically(tmp_path / "result.json", "new")
    finally:
        os.umask(before)
    assert stat.S_IMODE((tmp_path / "result.json").stat().st_mode) == 0o640


def test_output_through_a_link_to_nothing_makes_the_file(tmp_path: Path) -> None:
    link = tmp_path / "link"
    link.symlink_to(tmp_path / "result.json")
    write_atomically(link, "new")
    assert link.is_symlink()
    assert (tmp_path / "result.json").read_text(encoding="utf-8") == "new"


def test_links_in_a_circle_are_not_replaced(tmp_path: Path) -> None:
    link = tmp_path / "link"
    link.symlink_to(link)
    with pytest.raises(OSError, match="links") as caught:
        write_atomically(link, "new")
    assert caught.value.filename == str(link)
    assert link.is_symlink()
    assert os.listdir(tmp_path) == ["link"]


def test_a_file_on_another_drive_of_windows_is_not_replaced(tmp_path, monkeypatch) -> None:
    def between_drives(path: str, start: str) -> str:
        raise ValueError("path is on mount 'C:', start on mount 'Z:'")

    monkeypatch.setattr(os.path, "relpath", between_drives)
    assert not would_replace(tmp_path, ["*.png", "torque_*/*.vtu"], Path("/elsewhere/scene.toml"))
