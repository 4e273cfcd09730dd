"""Tutorials: each snippet runs, and prints what the page shows."""

from pathlib import Path

import pytest

from tests.support.paths import ROOT
from tests.support.tutorials import BLOCK, outputs_of

TUTORIALS = ROOT / "docs" / "tutorials"
#: Its program is compiled by tests/legacy.
BY_OTHERS = ("index.md", "fortran77.md")
PAGES = sorted(path.name for path in TUTORIALS.glob("*.md") if path.name not in BY_OTHERS)


@pytest.mark.parametrize("page", PAGES)
def test_a_tutorial_shows_what_its_snippets_print(
    page: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    monkeypatch.chdir(tmp_path)
    outputs = list(outputs_of(TUTORIALS / page))
    assert outputs
    for output in outputs:
        assert output.agrees, f"{output.code}\nprinted\n{output.printed}\nshown\n{output.shown}"


def test_the_page_of_the_mesh_quotes_its_script() -> None:
    text = (TUTORIALS / "own_mesh.md").read_text(encoding="utf-8")
    script = (ROOT / "examples" / "meshes" / "own_pinion.geo").read_text(encoding="utf-8")
    quoted = [code for language, code, _ in BLOCK.findall(text) if language == "geo"]
    assert quoted
    for code in quoted:
        assert code in script
