"""Examples and README: their output is the one that they show."""

import contextlib
import io
import json
import re
import runpy
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import flankload as fl
from flankload.mechanisms.flank_pair.assembly import build_bodies
from tests.support.paths import ROOT, SCENES
from tests.support.solving import solve
from tests.support.tolerances import SOLVER


def printed_by(run: object) -> str:
    out = io.StringIO()
    with contextlib.redirect_stdout(out):
        run()  # type: ignore[operator]
    return out.getvalue()


@pytest.mark.parametrize(
    "page",
    [
        "README.md",
        "docs/guide/contact_problems.md",
        "docs/guide/derivatives.md",
        "docs/guide/explorer.md",
        "docs/guide/notebooks.md",
        "docs/guide/optimisation.md",
        "docs/guide/pictures.md",
        "docs/guide/python.md",
        "docs/guide/robust_design.md",
        "docs/guide/variations.md",
    ],
)
def test_a_page_shows_what_its_examples_print(page: str, monkeypatch: pytest.MonkeyPatch) -> None:
    text = (ROOT / page).read_text(encoding="utf-8")
    examples = re.findall(r"```python\n(.*?)```\n\n```\n(.*?)```", text, re.DOTALL)
    assert len(examples) == text.count("```python")
    monkeypatch.chdir(ROOT)
    for code, shown in examples:
        assert printed_by(lambda code=code: exec(code, {})) == shown


def test_the_notebook_of_the_explorer_runs(monkeypatch: pytest.MonkeyPatch) -> None:
    path = ROOT / "examples/notebooks/explore_relief.ipynb"
    cells = json.loads(path.read_text(encoding="utf-8"))["cells"]
    code = ["".join(cell["source"]) for cell in cells if cell["cell_type"] == "code"]
    assert all(not cell.get("outputs") for cell in cells)
    monkeypatch.chdir(path.parent)
    names: dict[str, Any] = {}
    printed = printed_by(lambda: [exec(cell, names) for cell in code])
    assert "tip_relief_um = 45" in printed
    assert tomllib.loads(printed)["body_2"]["tip_relief_um"] == 45


def test_the_scene_of_the_readme_is_complete(tmp_path: Path) -> None:
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    (scene,) = re.findall(r"```toml\n(.*?)```", text, re.DOTALL)
    file = tmp_path / "pair.toml"
    file.write_text(scene, encoding="utf-8")
    assert fl.read_scene(file).torques_Nm == (302.0,)
    build_bodies(fl.read_scene(file))


def test_links_between_pages_lead_to_files() -> None:
    pages = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *(ROOT / "docs").rglob("*.md")]
    for page in pages:
        for link in re.findall(r"\]\(([\w./]+)\)", page.read_text(encoding="utf-8")):
            assert (page.parent / link).exists(), f"{page}: {link}"


def test_files_that_the_readme_names_exist() -> None:
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    names = re.findall(r"\]\(([\w./]+)\)|`((?:[\w]+/)+[\w.]*)`", text)
    paths = [a or b for a, b in names if (a or b) not in ("out/", "dist/")]
    assert paths
    for path in paths:
        assert (ROOT / path).exists(), path


def test_the_page_of_examples_has_all_scenes_and_its_pictures() -> None:
    folder = ROOT / "examples"
    text = (folder / "README.md").read_text(encoding="utf-8")
    named = set(re.findall(r"`([\w]+\.toml)`", text))
    assert named == {path.name for path in (folder / "scenes").glob("*.toml")}
    pictures = re.findall(r"!\[[^\]]+\]\(([^)]+)\)", text)
    assert pictures
    for picture in pictures:
        assert (folder / picture).exists(), picture


def test_compliance_files_of_the_example_are_those_of_its_gears() -> None:
    """`flankload compliance` wrote them; if this fails, write them again."""
    scenes = SCENES
    computed = solve(fl.read_scene(scenes / "external_gear.toml"))
    read = solve(fl.read_scene(scenes / "external_gear_compliance.toml"))
    assert read.cost["fe_factorisations"] == 0
    np.testing.assert_allclose(read.rotation_rad, computed.rotation_rad, rtol=SOLVER, atol=0)
    np.testing.assert_allclose(
        read.site_force_N, computed.site_force_N, rtol=0, atol=SOLVER * computed.site_force_N.max()
    )


@pytest.mark.parametrize("path", sorted((ROOT / "examples").glob("ex*.py")), ids=lambda p: p.stem)
def test_example_runs_and_is_short(path: Path) -> None:
    assert len(path.read_text(encoding="utf-8").splitlines()) <= 60
    module = runpy.run_path(str(path))
    out = printed_by(module["main"])
    assert "FZG type C, 302 N m" in out
    assert "FE jobs              1" in out
