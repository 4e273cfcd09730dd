"""The recipes in `packaging` name what pyproject.toml requires; the paper cites what it lists."""

from __future__ import annotations

import json
import re
import tomllib

from tests.support.paths import ROOT

PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))
#: Names of conda-forge that are others than those of PyPI.
OF_CONDA = {"matplotlib-base": "matplotlib"}


def required(text: str, pattern: str) -> dict[str, str]:
    """Least version of each package that a recipe names."""
    return {OF_CONDA.get(name, name): least for name, least in re.findall(pattern, text)}


def runs_with() -> dict[str, str]:
    return dict(line.split(">=") for line in PROJECT["project"]["dependencies"])


def builds_with() -> dict[str, str]:
    return dict(line.split(">=") for line in PROJECT["build-system"]["requires"])


def test_conda_requires_what_the_project_requires() -> None:
    text = (ROOT / "packaging/conda/recipe.yaml").read_text("utf-8")
    host, run = text.split("\n  host:")[1].split("\n  run:")
    line = r"- ([\w-]+) >=([\d.]+)\n"
    assert required(host, line) == builds_with()
    assert required(run, line) == runs_with()


def test_spack_requires_what_the_project_requires() -> None:
    text = (ROOT / "packaging/spack/package.py").read_text("utf-8")
    line = r'depends_on\("(?:py-)?([\w-]+)@([\d.]+):", type=\(?"([a-z]+)"(?:, "run"\))?'
    found = re.findall(line, text)
    python = [least for name, least, _ in found if name == "python"]
    assert [f">={least}" for least in python] == [PROJECT["project"]["requires-python"]]
    named = {name: float(least) if name == "numpy" else least for name, least, _ in found}
    wanted = runs_with() | builds_with()
    assert {name: named.pop(name) for name in wanted} == wanted | {"numpy": float(wanted["numpy"])}
    assert set(named) == {"python"}


def test_nix_requires_what_the_project_requires() -> None:
    text = (ROOT / "packaging/nix/package.nix").read_text("utf-8")
    build, run = text.split("  build-system = ")[1].split("  dependencies = ")
    line = r"    ([\w-]+) # >= ([\d.]+)\n"
    assert required(build, line) == builds_with()
    assert required(run, line) == runs_with()
    [least] = re.findall(r'pythonOlder "(.*)"', text)
    assert f">={least}" == PROJECT["project"]["requires-python"]


def test_the_version_is_everywhere_that_of_the_project() -> None:
    [version] = re.findall(r"^ *version: '(.*)'", (ROOT / "meson.build").read_text("utf-8"), re.M)
    assert f'version: "{version}"' in (ROOT / "packaging/conda/recipe.yaml").read_text("utf-8")
    assert f'version("{version}")' in (ROOT / "packaging/spack/package.py").read_text("utf-8")
    assert f'version = "{version}"' in (ROOT / "packaging/nix/package.nix").read_text("utf-8")


def test_zenodo_says_what_the_citation_says() -> None:
    record = json.loads((ROOT / ".zenodo.json").read_text("utf-8"))
    citation = (ROOT / "CITATION.cff").read_text("utf-8")
    assert f'title: "{record["title"]}"' in citation
    [words] = re.findall(r"^keywords:\n((?:  - .*\n)+)", citation, re.M)
    assert record["keywords"] == re.findall(r"  - (.*)\n", words)


def test_the_paper_cites_each_of_its_references() -> None:
    cited = re.findall(r"[\[\s(]@(\w+)", (ROOT / "paper/paper.md").read_text("utf-8"))
    listed = re.findall(r"^@\w+\{(\w+),", (ROOT / "paper/paper.bib").read_text("utf-8"), re.M)
    assert set(cited) == set(listed)
