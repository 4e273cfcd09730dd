"""The documentation: its generated tables are complete and up to date, and each page has its place.

The site itself is built by `./dev docs`.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

import flankload as fl
from flankload.contact.status import EXCEPTIONS
from flankload.result.drives import BeltDrive, ChainDrive
from flankload.scene.schema import scene_paths
from tests.support.made_up_result import made_up_result
from tests.support.paths import ROOT

DOCS = ROOT / "docs"


@pytest.fixture(autouse=True, scope="module")
def _pages_as_modules() -> Iterator[None]:
    """The scripts of `docs` import each other."""
    sys.path.insert(0, str(DOCS))
    yield
    sys.path.remove(str(DOCS))


def test_the_reference_pages_agree_with_the_code() -> None:
    import make_reference

    pages = {path.name: path.read_text(encoding="utf-8") for path in make_reference.PAGES.glob("*")}
    named = {part["name"] for text in pages.values() for part in make_reference.PART.finditer(text)}
    assert named == set(make_reference.TEXTS)
    differ = [name for name, text in pages.items() if make_reference.completed(text) != text]
    assert differ == [], "`python docs/make_reference.py` writes them anew"


def test_an_unknown_part_of_a_reference_page_is_refused() -> None:
    import make_reference

    with pytest.raises(ValueError, match=r"begin: expected one of .*, found ghosts"):
        make_reference.completed("<!-- begin: ghosts -->\n<!-- end: ghosts -->\n")


def test_every_scene_key_is_in_the_reference() -> None:
    import reference_scene

    kinds = reference_scene.body_tables()
    there = {
        (table, key.name)
        for title, _, keys in reference_scene.scene_sections()
        for table in tables_of(title, kinds)
        for key in keys
    }
    text = reference_scene.scene_keys()
    for path in scene_paths():
        table, _, name = path.path.partition(".")
        if not name or name == "kind":
            continue
        for kind in path.kinds.split(", ") if path.kinds else [table]:
            place = f"{table}: {kind}" if path.kinds else table
            assert (place, name) in there, path.path
        assert f"`{name}`" in text
        assert " ".join(path.meaning.split()) in text
    assert "required" in text


def tables_of(title: str, kinds: dict[str, tuple[object, tuple[str, ...]]]) -> list[str]:
    """Tables of the scene that a section describes."""
    if not title.startswith("Body: "):
        return [title.strip("[]")]
    kind = title.removeprefix("Body: ")
    return [f"{body}: {kind}" for body in kinds[kind][1]]


def test_every_quantity_of_a_result_is_in_the_reference() -> None:
    import make_reference

    text = make_reference.result_quantities()
    rows = dict(re.findall(r"^\| `(\w+)` .*\| (.*) \|$", text, re.M))
    named = set(made_up_result().to_csv().splitlines()[0].split(","))
    named = {re.sub(r"_pair_-?\d+$", "", name) for name in named}
    named |= {"friction_loss_J_per_rad", "follower_angle_rad", "slice_line_load_N_per_mm"}
    for drive in (BeltDrive.units("P"), BeltDrive.units("PS"), ChainDrive.units("PS")):
        named |= set(drive)
    assert named <= set(rows)
    assert all(rows.values()), [name for name, meaning in rows.items() if not meaning]
    described = set(re.findall(r"`(\w+)`", text))
    missing = {name for name in made_up_result().summary if not is_named(name, described)}
    assert missing == set()


def is_named(name: str, described: set[str]) -> bool:
    """Whether the text has the name, or the quantity of which it is a mean, a pair or a place."""
    stem = re.sub(r"_(position_rad|pair)$", "", name)
    quantity = stem.replace("_mean", "")
    return any(other.startswith(stem) or other.startswith(quantity) for other in described)


def test_every_status_is_in_the_reference() -> None:
    import make_reference

    text = make_reference.statuses()
    codes = {int(code) for code in re.findall(r"^\| (-?\d+) \|", text, re.M)}
    source = (ROOT / "fortran" / "base" / "status.f90").read_text(encoding="utf-8")
    assert len(codes) == len(re.findall(r"status_type\(\w+,", source))
    assert set(EXCEPTIONS) <= codes


def test_every_command_and_public_name_is_in_the_reference() -> None:
    import make_reference

    text = make_reference.command_line()
    page = (DOCS / "flankload.1").read_text(encoding="ascii")
    for command in re.findall(r"^\.SS flankload (\w+)", page, re.M):
        assert f"## {command}\n" in text
    for option in re.findall(r"^\.B (\\-\\-[\w\\-]+)", page, re.M):
        if (plain := option.replace("\\", "")) not in ("--version", "--help"):
            assert plain in text
    api = make_reference.python_api()
    for name in fl.__all__:
        if name not in ("__version__", "errors"):
            assert f"### {name}\n" in api
    assert "#### Result.to_json\n" in api
    assert "| `load_share` |" in api


def test_every_page_is_in_a_table_of_contents() -> None:
    import site_pages

    listed = {page for pages in site_pages.pages_of_indexes().values() for page in pages}
    listed |= {page for index in site_pages.INDEXES for page in site_pages.unlisted(index)}
    listed |= set(site_pages.INDEXES)
    pages = {path.relative_to(ROOT).with_suffix("").as_posix() for path in DOCS.rglob("*.md")}
    assert {page for page in pages - listed if not page.endswith(".in")} == set()
    for page in listed:
        assert (ROOT / f"{page}.md").exists(), f"an index lists {page}.md, which does not exist"


def test_links_of_the_examples_lead_to_pages_of_the_site() -> None:
    import site_pages

    listed = {page for pages in site_pages.pages_of_indexes().values() for page in pages}
    for path in (ROOT / "examples").rglob("README.md"):
        assert path.relative_to(ROOT).with_suffix("").as_posix() in listed


def test_a_new_page_appears_in_the_index_of_its_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    import site_pages

    for index in site_pages.INDEXES:
        (tmp_path / f"{index}.md").parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / f"{index}.md").write_text("# Index\n\n* [Old](old.md): text\n")
    (tmp_path / "docs" / "guide" / "old.md").write_text("# Old\n")
    (tmp_path / "docs" / "guide" / "new.md").write_text("# New things\n")
    monkeypatch.setattr(site_pages, "ROOT", tmp_path)
    site_pages.pages_of_indexes.cache_clear()
    text = site_pages.completed("docs/guide/index", "# Index\n\n* [Old](old.md): text\n")
    site_pages.pages_of_indexes.cache_clear()
    assert "## Further pages\n\n* [New things](new.md)\n" in text
    assert "/docs/guide/old\n/docs/guide/new\n```\n" in text


def test_dead_links_and_fetched_files_of_a_site_are_found(tmp_path: Path) -> None:
    import check_site

    (tmp_path / "a.html").write_text(
        '<h1 id="top">A</h1><a href="#top">1</a><a href="b.html#there">2</a><a href="#gone">3</a>'
        '<a href="c.html">4</a><a href="https://example.org">5</a>'
        '<script src="https://example.org/x.js"></script>'
    )
    (tmp_path / "b.html").write_text('<p id="there">B</p>')
    assert check_site.faults(tmp_path) == [
        "a.html: fetched from elsewhere: https://example.org/x.js",
        "a.html: leads nowhere: #gone",
        "a.html: leads nowhere: c.html",
    ]


def test_the_generated_tables_hold_no_raw_values() -> None:
    """A default that cannot be shown would appear as a Python object."""
    import make_reference

    for text in (make_reference.scene_keys(), make_reference.python_api()):
        assert "UNSET" not in text
        assert "object at" not in text
