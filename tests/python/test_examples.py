"""Examples and README: what they print is what they say."""

import contextlib
import io
import re
import runpy
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]


def printed_by(run: object) -> str:
    out = io.StringIO()
    with contextlib.redirect_stdout(out):
        run()  # type: ignore[operator]
    return out.getvalue()


def test_readme_prints_what_it_shows(monkeypatch: pytest.MonkeyPatch) -> None:
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    examples = re.findall(r"```python\n(.*?)```\n\n```\n(.*?)```", text, re.DOTALL)
    assert len(examples) == text.count("```python")
    monkeypatch.chdir(ROOT)
    for code, shown in examples:
        assert printed_by(lambda code=code: exec(code, {})) == shown


def test_files_that_the_readme_names_exist() -> None:
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    names = re.findall(r"\]\(([\w./]+)\)|`((?:[\w]+/)+[\w.]*)`", text)
    paths = [a or b for a, b in names if (a or b) != "out/"]
    assert paths
    for path in paths:
        assert (ROOT / path).exists(), path


@pytest.mark.parametrize("path", sorted((ROOT / "examples").glob("ex*.py")), ids=lambda p: p.stem)
def test_example_runs_and_is_short(path: Path) -> None:
    assert len(path.read_text(encoding="utf-8").splitlines()) <= 60
    module = runpy.run_path(str(path))
    out = printed_by(module["main"])
    assert "FZG type C, 302 N m" in out
    assert "FE jobs              1" in out
