"""The page of an explorer in a real browser."""

import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import pytest

import flankload as fl
from tests.support.browser import Browser
from tests.support.paths import SCENES

READY = "window.flankload_painted >= 0 && deep('canvas').length > 3"
#: The typed value of a key and its slider, in the order of the sliders.
TYPED, HANDLE = "deep('input.bk-input')", "deep('.noUi-handle')"
#: Types a value, as a user with the keyboard.
TYPE = """(input, value) => { input.value = value;
  input.dispatchEvent(new Event("input")); input.dispatchEvent(new Event("change")); }"""
BROKEN = "document.querySelector('.broken') !== null"
STATUS = "document.querySelector('#status').innerText"
SHOWN = "[...document.querySelectorAll('.picture')].filter(one => one.offsetHeight).length"


@pytest.fixture(scope="module")
def explorer() -> Iterator[Any]:
    scene = fl.read_scene(SCENES / "external_gear.toml").replace({"accuracy.estimate": False})
    vary = ["load.torque_Nm=0:30000", "body_1.profile_crowning_um"]
    with fl.explore(scene, vary, open_browser=False) as found:
        yield found


@pytest.fixture(scope="module")
def browser(explorer: Any, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    with Browser(tmp_path_factory.mktemp("browser")) as found:
        found.open(explorer.url, READY)
        yield found


def model(name: str, code: str) -> str:
    """Expression of a model of the page, by its name."""
    return f"(m => {code})(Bokeh.documents[0].get_model_by_name({name!r}))"


def until(condition: Any, seconds: float = 60.0) -> None:
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.02)


def test_a_broken_premise_is_a_red_frame_without_curves(explorer: Any, browser: Browser) -> None:
    """Regression: the first answer at rest was dropped as outdated."""
    count = "m.renderers[2].data_source.get_length()"
    browser.wait(model("error", f"{count} > 30"))
    pictures = browser.value(SHOWN)
    browser.value(f"({TYPE})({TYPED}[0], 30000)")
    browser.wait(BROKEN)
    assert browser.value(SHOWN) == pictures  # those of other kinds of drive appeared
    assert browser.value(model("error", count)) == 0
    with pytest.raises(fl.PremiseError) as caught:
        explorer.change({})
    browser.wait(f"{STATUS}.trim() === {str(caught.value)!r}")
    browser.value(f"({TYPE})({TYPED}[0], 250)")
    browser.wait(f"!({BROKEN})")
    browser.wait(model("error", f"{count} > 30"))


def test_a_burst_of_slider_events_ends_with_the_bits_of_a_prepared_scene(
    explorer: Any, browser: Browser
) -> None:
    # the keys that the browser sends to a slider in focus; each is an event of its own
    browser.value(f"{TYPED}[0].focus()")
    browser.value(
        f"(async () => {{ for (let k = 1; k <= 100; ++k) {{ ({TYPE})({TYPED}[0], 200 + k); "
        "await new Promise(done => setTimeout(done, 5)); } })()"
    )
    until(lambda: explorer.scene.load.torque_Nm == 300.0)
    shown = "m.renderers[2].data_source.get_column('y')"
    at_rest = explorer.result
    expected = fl.prepare(explorer.scene).solve()
    assert at_rest.transmission_error_um.tobytes() == expected.transmission_error_um.tobytes()
    y = at_rest.transmission_error_um.tolist()
    browser.wait(model("error", f"Array.from({shown})[0] === {y[0]!r}"))
    assert browser.value(model("error", f"Array.from({shown})"))[: len(y)] == y
    assert not browser.value(BROKEN)


def test_arrow_keys_move_a_slider_by_its_step(explorer: Any, browser: Browser) -> None:
    before = explorer.change({"body_1.profile_crowning_um": 4}).peak_pressure_MPa.max()
    browser.wait(f"{TYPED}[1].value == 4")
    browser.value(f"{HANDLE}[1].focus()")
    browser.call("Input.dispatchKeyEvent", type="keyDown", key="ArrowRight", code="ArrowRight",
                 windowsVirtualKeyCode=39)  # fmt: skip
    until(lambda: explorer.scene.body_1.profile_crowning_um == 5.0)
    assert explorer.result.peak_pressure_MPa.max() != before


def test_undo_returns_to_the_design_before(explorer: Any, browser: Browser) -> None:
    explorer.change({"load.torque_Nm": 150.0})
    explorer.change({"load.torque_Nm": 160.0})
    browser.wait(f"{TYPED}[0].value == 160")
    browser.value("deep('.bk-btn').find(b => b.innerText === 'undo').click()")
    browser.wait(f"{TYPED}[0].value == 150")
    assert explorer.scene.load.torque_Nm == 150.0
    browser.value(f"({TYPE})({TYPED}[0], -1)")
    browser.wait(BROKEN)
    browser.value("deep('.bk-btn').find(b => b.innerText === 'undo').click()")
    browser.wait(f"{TYPED}[0].value == 150 && !({BROKEN})")


def test_no_request_leaves_the_machine_and_no_script_fails(explorer: Any, browser: Browser) -> None:
    host = urlsplit(explorer.url).netloc
    requests = browser.requests()
    assert {urlsplit(url).netloc for url in requests} == {host}
    assert any(url.startswith("ws:") for url in requests)
    assert browser.failures() == []


def test_the_page_fits_a_telephone(explorer: Any, browser: Browser) -> None:
    browser.call("Emulation.setDeviceMetricsOverride", width=390, height=844,
                 deviceScaleFactor=1, mobile=True)  # fmt: skip
    browser.wait("document.documentElement.scrollWidth <= 390")
    browser.call("Emulation.clearDeviceMetricsOverride")


def test_the_button_ends_the_explorer(tmp_path: Path, browser: Browser) -> None:
    with fl.explore(SCENES / "chain.toml", open_browser=False) as other:
        browser.open(other.url, READY)
        browser.value("deep('.bk-btn').find(b => b.innerText === 'close').click()")
        until(other._closed.is_set)
        browser.wait(f"{STATUS} === 'The explorer is closed.'")
