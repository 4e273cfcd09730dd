"""The page about design studies: its examples run and print what it shows."""

from __future__ import annotations

import contextlib
import io
import re
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from flankload.studies.design import read_study
from tests.support.paths import EXAMPLES, ROOT, SCENES

TEXT = (ROOT / "docs/guide/studies.md").read_text(encoding="utf-8")


class Client(contextlib.AbstractContextManager["Client"]):
    """Takes the place of a connection to a scheduler."""

    def __init__(self, address: str) -> None:
        assert address == "tcp://node-1:8786"

    def __exit__(self, *_: object) -> None:
        """Nothing is open."""

    def get_executor(self) -> ThreadPoolExecutor:
        return ThreadPoolExecutor(2)


def test_examples_print_what_the_page_shows(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name, content in (("distributed", Client), ("mpi4py.futures", ThreadPoolExecutor)):
        module: Any = ModuleType(name)
        module.Client = module.MPIPoolExecutor = content
        monkeypatch.setitem(sys.modules, name, module)
    (tmp_path / "out").mkdir()
    (tmp_path / "examples").symlink_to(EXAMPLES)
    monkeypatch.chdir(tmp_path)
    examples = re.findall(r"```python\n(.*?)```\n\n```\n(.*?)```", TEXT, re.DOTALL)
    assert len(examples) == TEXT.count("```python")
    names: dict[str, Any] = {"__name__": "__main__"}
    for code, shown in examples:
        out = io.StringIO()
        with contextlib.redirect_stdout(out):
            exec(code, names)
        assert out.getvalue() == shown


def test_study_files_are_read(tmp_path: Path) -> None:
    files = re.findall(r"```toml\n(.*?)```", TEXT, re.DOTALL)
    assert len(files) == 2
    (tmp_path / "scenes").symlink_to(SCENES)
    (tmp_path / "studies").mkdir()
    (tmp_path / "studies" / "pair.toml").symlink_to(SCENES / "external_gear.toml")
    for text, count in zip(files, (10, 1000), strict=True):
        path = tmp_path / "studies" / "study.toml"
        path.write_text(text, encoding="utf-8")
        assert len(read_study(path).designs) == count
