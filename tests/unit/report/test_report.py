"""The page of a report: complete, whole in one file, equal to the numbers of the result."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
from datetime import date
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import flankload as fl
from flankload.plot.svg import Panel, panel_of
from flankload.report import pictures, report_html, scene_of_report, write_report
from flankload.report.key_figures import key_rows
from flankload.report.pictures import curve_data
from flankload.report.turning import thinned, turning
from tests.support.gear_scenes import example
from tests.support.made_up_result import made_up_result
from tests.support.paths import SCENES
from tests.support.solving import solve
from tests.support.tolerances import ROUND_OFF

NAME = 'FZG <b>"C"</b> & </script><script>alert(1)</script>'
#: Elements without an end tag.
EMPTY = {"meta", "input", "br", "path", "use", "rect", "line", "image"}
FAST = {"tangents": False, "estimate": False}


class Page(HTMLParser):
    """Elements, texts and references of a page; ends have to match."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.ids: list[str] = []
        self.references: list[str] = []
        self.values: list[str] = []
        self.headings: list[str] = []
        self.texts: list[str] = []
        self.scripts = 0
        self.open: list[str] = []
        self.feed(text)
        self.close()
        assert self.open == []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        found = {key: value or "" for key, value in attrs}
        self.scripts += tag == "script"
        if "id" in found:
            self.ids.append(found["id"])
        if tag == "data":
            self.values.append(found["value"])
        self.references += [found[key] for key in ("href", "src", "action") if key in found]
        for value in found.values():
            self.references += re.findall(r"url\(([^)]*)\)", value)
        if tag not in EMPTY:
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.handle_starttag(tag, attrs)
        if tag not in EMPTY:
            self.open.pop()

    def handle_endtag(self, tag: str) -> None:
        if tag not in EMPTY:
            assert self.open.pop() == tag

    def handle_data(self, text: str) -> None:
        if self.open and self.open[-1] in ("h1", "h2"):
            self.headings.append(text)
        self.texts.append(text)


def keys_with(name: str = "pair", torques: Any = (151.0, 302.0)) -> dict[str, Any]:
    return {**example("external_gear"), "name": name, "load": {"torque_Nm": list(torques)}}


def scene_with(name: str = "pair", torques: Any = (151.0, 302.0)) -> fl.Scene:
    return fl.Scene.from_dict(keys_with(name, torques))


@pytest.fixture(scope="module")
def results() -> tuple[fl.Result, ...]:
    """Two torques, the larger one first, with a violated premise and uncertain positions."""
    status = np.zeros(8, dtype=int)
    status[3:5] = 3
    large = made_up_result(
        count=8,
        name=NAME,
        status=status,
        warnings=("outside the model's limits: load: a <large> torque", "beware"),
    )
    return large, made_up_result(count=8, name=NAME, torque_Nm=151.0)


@pytest.fixture(scope="module")
def text(results: tuple[fl.Result, ...]) -> str:
    return report_html(results, scene_with(NAME), day=date(2026, 1, 2))


@pytest.fixture(scope="module")
def page(text: str) -> Page:
    return Page(text)


def test_sections_come_in_their_order(page: Page) -> None:
    headings = [text for text in page.headings if text != NAME]
    assert page.headings[0] == NAME
    assert headings[:4] == [
        "Premises and warnings", "Key figures", "Drawing data", "Position by position",
    ]  # fmt: skip
    assert headings[-3:] == ["Cost and certificates", "Terms", "Reproduction"]
    assert {"Motion", "Load sharing", "Pressure", "Loaded bodies"} <= set(headings)


def test_ids_are_unique_and_every_reference_has_its_target(page: Page, text: str) -> None:
    assert len(page.ids) == len(set(page.ids))
    outside = [name for name in page.references if not name.startswith(("#", "data:image/png;"))]
    assert outside == []
    addresses = re.findall(r"\w+://[^\"' ]*", text)
    assert addresses == ["http://www.w3.org/2000/svg"]  # the name of SVG in the script
    targets = {name[1:] for name in page.references if name.startswith("#")}
    assert targets
    assert targets <= set(page.ids)


def test_text_of_a_scene_is_escaped(page: Page, text: str) -> None:
    assert page.scripts == 2  # the data and the script of the page
    assert "<b>" not in text
    assert "a <large> torque" in "".join(page.texts)
    assert "alert(1)" in "".join(page.texts)


def test_key_figures_are_those_of_the_summary(page: Page, results: tuple[fl.Result, ...]) -> None:
    large, small = results
    shown = [float(value) for value in page.values if re.fullmatch(r"[-+.\de]+", value)]
    for key in (
        "transmission_error_mean_um",
        "transmission_error_peak_to_peak_um",
        "contact_ratio_under_load",
        "peak_pressure_MPa",
        "peak_line_load_N_per_mm",
        "stiffness_tangent_mean_N_per_um",
    ):
        one, two = small.summary[key], large.summary[key]
        at = shown.index(one)
        assert shown[at : at + 2] == [one, two]  # torques ascend


def test_an_error_is_beside_its_number(results: tuple[fl.Result, ...]) -> None:
    rows = {row.name: row for row in key_rows(results)}
    assert [cell.error for cell in rows["largest pressure"].cells] == [8e-3, 8e-3]
    assert [cell.error for cell in rows["loaded pairs"].cells] == [None, None]


def test_findings_come_first_with_their_reasons(page: Page) -> None:
    whole = "".join(page.texts)
    assert whole.index("Violated premises") < whole.index("beware") < whole.index("Key figures")
    assert "status 3 at 2 of 8 positions under 302 N m (8.44°, 11.25°)" in whole
    assert "Every position is solved" not in whole


def test_drawing_data_are_computed(page: Page) -> None:
    whole = " ".join(part.strip() for part in page.texts if part.strip())
    for words in (
        "67.6579 mm", "101.4868 mm",  # base diameters: 72 and 108 times cos(20 deg)
        "34.7801 mm over k = 3 teeth",
        "1.4375", "2026-01-02", "302 N m",
    ):  # fmt: skip
        assert words in whole


def test_span_measurement_of_a_standard_gear() -> None:
    """W_3 = m cos(a) ((k - 1/2) pi + z inv(a)) + 2 x m sin(a)."""
    from flankload.mechanisms.registry import mechanism_of

    sheet = mechanism_of(scene_with()).data_sheet(scene_with())
    rows = {row.symbol: row.value for row in sheet.bodies[0]}
    angle = np.radians(20)
    involute = np.tan(angle) - angle
    span = 4.5 * np.cos(angle) * (2.5 * np.pi + 16 * involute) + 2 * 0.182 * 4.5 * np.sin(angle)
    assert rows["W_k"] == f"{span:.4f} mm over k = 3 teeth"
    assert (rows["x"], rows["m_n"], rows["α_n"]) == ("0.1820", "4.5 mm", "20.0000°")
    one, *_, five = sheet.path
    assert one.diameters_mm[1] == pytest.approx(118.36, rel=ROUND_OFF)
    assert five.diameters_mm[0] == pytest.approx(82.46, rel=ROUND_OFF)
    assert [point.name for point in sheet.path] == list("ABCDE")


def test_curves_for_the_script_are_those_of_the_plots(
    text: str, results: tuple[fl.Result, ...]
) -> None:
    data = json.loads(re.search(r'id="data">(.*?)</script>', text, re.DOTALL)[1])
    [axes] = data["plots"]["transmission_error"]
    assert axes["position"]
    curves = [np.array(y, dtype=float) for _, _, y in axes["curves"]]
    for result, values in zip(sorted(results, key=lambda one: one.torque_Nm), curves, strict=True):
        np.testing.assert_allclose(values[:8], result.transmission_error_um, rtol=1e-3, atol=0)
    assert data["torques"] == [151.0, 302.0]
    rows = data["states"][1][0]["pairs"]
    loaded = results[0].site_force_N[0] > 0
    np.testing.assert_allclose(
        [row[1] for row in rows], results[0].site_force_N[0][loaded] / 1e3, rtol=1e-3, atol=0
    )


def test_bodies_turn_as_they_mesh(results: tuple[fl.Result, ...]) -> None:
    one, two = turning(results).data["turn"]
    np.testing.assert_allclose(np.diff(two) / np.diff(one), -16 / 24, rtol=1e-3)


def test_thinned_outline_stays_within_its_distance() -> None:
    angle = np.linspace(0, np.pi / 2, 400)
    arc = 50 * np.column_stack([np.cos(angle), np.sin(angle)])
    few = thinned(arc, 0.01)
    assert len(few) < 80
    one, two = few[:-1], few[1:]
    middle = np.hypot(*(0.5 * (one + two)).T)
    assert np.all(50 - middle <= 0.01 * (1 + 1e-9))


def test_numbers_that_are_not_finite_leave_strict_json() -> None:
    def draw(axes: Any) -> None:
        axes.plot([0, 1, 2, 3], [1.0, np.nan, np.inf, 4.0], label="a")
        axes.plot([0, 1, 2, 3], [1.0, 2.0, 3.0, 12345.678], label="b")

    plot = pictures.Plot("a", "a", "A", panel_of(draw, "a", (3.0, 2.0)))
    [axes] = curve_data({"A": (plot,)})["a"]
    [named] = axes["curves"]  # two numbers are no curve
    assert named == ["b", [0.0, 1.0, 2.0, 3.0], [1.0, 2.0, 3.0, 12350.0]]


def test_allowance_of_the_thickness_is_a_generating_profile_shift() -> None:
    from flankload.mechanisms.registry import mechanism_of

    tree = example("external_gear")
    tree["body_1"]["tooth_thickness_allowance_um"] = -100
    scene = fl.Scene.from_dict(tree)
    rows = {row.symbol: row.value for row in mechanism_of(scene).data_sheet(scene).bodies[0]}
    shift = 0.182 - 0.1 / (2 * 4.5 * np.tan(np.radians(20)))
    assert (rows["x"], rows["x_E"]) == ("0.1820", f"{shift:.4f}")


# --- kinds ----------------------------------------------------------------------------------------
def kinds() -> dict[str, dict[str, Any]]:
    internal = example("internal_gear")
    belt, chain, cam, spline, helical = map(
        example, ("belt", "chain", "cam", "spline", "helical_gear")
    )
    coarse = {**FAST, "flank_element_mm": 2.0}
    return {
        "internal": {**internal, "positions": {"count": 3}, "accuracy": coarse},
        "spline": {**spline, "accuracy": {**FAST, "flank_element_mm": 1.5}},
        "cam": {**cam, "positions": {"angles_deg": [20, 200]}, "accuracy": coarse},
        "belt": {**belt, "accuracy": {"estimate": False}},
        "chain": {**chain, "positions": {"count": 2}, "accuracy": {"estimate": False}},
        "stage": {
            **example("planetary_stage"),
            "positions": {"count": 2},
            "accuracy": {**FAST, "flank_element_mm": 3.0},
        },
        "train": {
            **example("two_pinions"),
            "positions": {"count": 2},
            "accuracy": {**FAST, "flank_element_mm": 3.0},
        },
        "helical": {
            **helical,
            "positions": {"count": 2},
            "accuracy": {**FAST, "slices": 5, "axial_degree": 6, "flank_element_mm": 2.0},
        },
    }


@pytest.mark.parametrize("kind", ["belt", "chain"])
def test_arrows_and_numbers_are_inside_the_picture_of_the_bodies(kind: str) -> None:
    result = solve(fl.Scene.from_dict(kinds()[kind], file=SCENES / "x.toml"))
    assert isinstance(result, fl.Result)
    picture = turning([result])
    left, top, width, height = map(float, picture.view_box.split())
    for path, *number in (load for state in picture.data["states"][0] for load in state["paths"]):
        corners = [*map(float, re.findall(r"-?\d+\.\d+", path))]
        x, y = np.reshape([*corners, *number], (-1, 2)).T
        assert left < x.min() < x.max() < left + width
        assert top < -y.max() < -y.min() < top + height
    # and the drawing fills it
    size = 2.0 * float(np.hypot(*result.drawing.outline_1.T).max())
    assert max(width, height) < 1.5 * size


@pytest.mark.parametrize("kind", list(kinds()))
def test_every_kind_of_drive_has_a_report(kind: str, monkeypatch: pytest.MonkeyPatch) -> None:
    drawn: list[str] = []

    def draw_only(draw: Any, name: str, size: tuple[float, float]) -> Panel:
        from matplotlib.figure import Figure

        draw(Figure(figsize=size).add_subplot())
        drawn.append(name)
        return Panel(name, "<svg></svg>", ())

    monkeypatch.setattr(pictures, "panel_of", draw_only)
    scene = fl.Scene.from_dict(kinds()[kind])
    page = Page(report_html(solve(scene), scene))
    assert len(page.ids) == len(set(page.ids))
    assert {f"plot-{name}" for name in drawn} <= set(page.ids)
    assert drawn
    sheet = "".join(page.texts)
    words = {
        "internal": "176.2000 mm", "spline": "48.0000 mm", "cam": "length of the profile",
        "belt": "effective tension", "chain": "roller seating radius", "helical": "overlap ratio",
        "stage": "mesh load factor, largest",
        "train": "force on the bearings of body 3, largest",
    }  # fmt: skip
    assert words[kind] in sheet


# --- positions ------------------------------------------------------------------------------------
def test_positions_are_adaptive_where_a_scene_names_none() -> None:
    tree = example("external_gear")
    del tree["positions"]
    free = fl.Scene.from_dict(tree)
    assert scene_of_report(free).positions.adaptive
    assert "adaptive = true" in scene_of_report(free).to_toml()
    for positions in ({"count": 32}, {"adaptive": False}):
        named = fl.Scene.from_dict({**tree, "positions": positions})
        assert scene_of_report(named) is named
    for name in ("belt", "chain", "spline"):
        other = fl.Scene.from_dict(
            {key: v for key, v in example(name).items() if key != "positions"}
        )
        assert scene_of_report(other) is other


# --- files ----------------------------------------------------------------------------------------
def test_missing_jinja_is_one_line(
    results: tuple[fl.Result, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(__import__("sys").modules, "jinja2", None)
    with pytest.raises(fl.FlankloadError, match=r"^a report needs the package jinja2, which is"):
        write_report(results, scene_with(), tmp_path / "a.html")
    assert list(tmp_path.iterdir()) == []


# --- browser --------------------------------------------------------------------------------------
def chromium(page: Path, *options: str) -> subprocess.CompletedProcess[str]:
    program = shutil.which("chromium") or shutil.which("chromium-browser")
    if program is None:
        pytest.skip("no Chromium")
    return subprocess.run(
        [program, "--headless", "--no-sandbox", "--disable-gpu", "--enable-logging=stderr",
         f"--user-data-dir={page.parent / 'profile'}", *options, page.as_uri()],
        capture_output=True, text=True, check=True, timeout=120,
    )  # fmt: skip


def console(done: subprocess.CompletedProcess[str]) -> list[str]:
    return [line for line in done.stderr.splitlines() if "CONSOLE" in line]


#: A browser that runs no scripts.
NO_SCRIPT = """<head><meta http-equiv="Content-Security-Policy" content="script-src 'none'">"""

#: Actions of a reader: another position, another torque, a look at a curve.
READER = """<script>
const slider = document.getElementById("place"), torque = document.getElementById("torque");
torque.value = 0; torque.dispatchEvent(new Event("change"));
document.body.dataset.first = document.getElementById("load").textContent;
slider.value = 0; slider.dispatchEvent(new Event("input"));
const svg = document.querySelector("#plot-transmission_error svg");
const box = svg.getBoundingClientRect();
svg.dispatchEvent(new PointerEvent("pointermove", {
  clientX: box.left + box.width / 2, clientY: box.top + box.height / 2}));
// on a telephone: elements wider than the page that do not scroll by themselves
document.body.style.maxWidth = "390px"; document.body.style.margin = "0";
document.body.dataset.wide = [...document.querySelectorAll("main *")].filter(part =>
  part.getBoundingClientRect().right > 390 && !part.closest(".scroll, svg, .tip")).length;
</script></body>"""


def test_browser_shows_the_page_with_and_without_script(
    text: str, results: tuple[fl.Result, ...], tmp_path: Path
) -> None:
    path = tmp_path / "report.html"
    path.write_text(text.replace("</body>", READER), encoding="utf-8")
    done = chromium(path, "--dump-dom", "--window-size=500,900")
    assert console(done) == []
    assert 'data-wide="0"' in done.stdout
    shown = Page(done.stdout)
    small = results[1]
    words = "".join(shown.texts)
    error = f"{small.transmission_error_um[0]:.4g}".rstrip("0")
    assert f"0°, 151 N m: transmission error {error} µm" in words
    assert 'data-first="151 N m"' in done.stdout
    assert '<div class="controls">' in done.stdout
    assert re.search(r'class="tip" style="[^"]*"><div>[\d.]+°</div><div>', done.stdout)

    path.write_text(text.replace("<head>", NO_SCRIPT), encoding="utf-8")
    done = chromium(path, "--dump-dom")
    assert {"Content Security Policy" in line for line in console(done)} == {True}
    still = Page(done.stdout)
    assert '<div class="controls" hidden="">' in done.stdout
    largest = results[0].summary["peak_pressure_MPa"]
    assert f"{largest:.4g}" in "".join(still.texts)


def test_a_report_takes_a_scene_in_each_form(text: str, results: tuple[fl.Result, ...]) -> None:
    keys, result = keys_with(NAME), results[0]
    assert report_html(results, keys, day=date(2026, 1, 2)) == text
    with pytest.raises(fl.InputError, match=r"^scene: expected a Scene, a GearPair"):
        report_html(result, 3)  # type: ignore[arg-type]
    with pytest.raises(fl.InputError, match=r"^results: expected a Result or a sequence"):
        report_html(3, keys)  # type: ignore[arg-type]
