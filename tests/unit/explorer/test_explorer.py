"""The explorer without a browser: keys, runs, handle, gate, command."""

import http.client
import os
import re
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from types import SimpleNamespace
from typing import Any
from urllib.parse import urlsplit

import numpy as np
import pytest
from bokeh.document import Document
from bokeh.palettes import Inferno256

import flankload as fl
from flankload.explorer.bodies import drawing_of, windows_of
from flankload.explorer.curves import curves_of
from flankload.explorer.keys import keys_of, shown_keys
from flankload.explorer.page import Page
from flankload.explorer.pictures import Picture
from flankload.explorer.worker import Answer, Request, Worker
from tests.support.paths import SCENES
from tests.support.solving import solve

NAME = "external_gear"
RELIEF = {"body_1.tip_relief_um": 20, "body_2.tip_relief_um": 15}
FEW = {"accuracy.estimate": False, "accuracy.tangents": False, "accuracy.flank_element_mm": 4.0,
       "accuracy.strips_per_half_width": 2.5, "accuracy.corner_strips_per_half_width": 2.5,
       "positions.count": 8}  # fmt: skip
NO_KEY = "vary: expected a numeric key of the scene{}, found '{}'"
RANGE = "vary.load.torque_Nm: expected two ascending numbers from 0 to 1e+12, LOW:HIGH, found '{}'"
WHOLE = "vary.body_1.teeth: expected two ascending integers from 3 to 10000, LOW:HIGH, found '{}'"
TORQUE = {"load.torque_Nm": 200.0}


def scene_of() -> fl.Scene:
    """An example at few positions, on coarse elements and cells."""
    return fl.read_scene(SCENES / f"{NAME}.toml").replace(FEW)


@pytest.fixture(scope="module")
def explorer() -> Iterator[Any]:
    with fl.explore(scene_of(), open_browser=False) as found:
        yield found


def answer_of(url: str, path: str | None = None, **headers: str) -> int:
    parts = urlsplit(url)
    connection = http.client.HTTPConnection(parts.netloc, timeout=30)
    connection.request("GET", parts.path if path is None else path, headers=headers)
    status = connection.getresponse().status
    connection.close()
    return status


# --- keys -----------------------------------------------------------------------------------------
@pytest.mark.parametrize("name", sorted(path.stem for path in SCENES.glob("*.toml")))
def test_every_scene_has_sliders_whose_ends_its_schema_allows(name: str) -> None:
    scene = fl.read_scene(SCENES / f"{name}.toml")
    keys = keys_of(scene)
    for key in keys.values():
        assert 0 < key.step <= key.high - key.low, key
    shown = shown_keys(scene, keys, ())
    assert shown[0].path == "load.torque_Nm"
    assert len(shown) >= 2
    for key in shown:
        assert key.low <= key.value <= key.high, key
        assert key.meaning


def test_a_range_that_is_asked_for_is_that_of_the_slider() -> None:
    scene = scene_of()
    (key,) = shown_keys(scene, keys_of(scene), ["pair.center_distance_mm=91:92"])
    assert (key.low, key.high, key.step) == (91.0, 92.0, 0.01)


@pytest.mark.parametrize(
    ("asked", "line"),
    [
        ("body_1.kind", NO_KEY.format("", "body_1.kind")),
        ("load.torque", NO_KEY.format(" (did you mean load.torque_Nm?)", "load.torque")),
        ("", NO_KEY.format("", "")),
        ("load.torque_Nm=3:1", RANGE.format("3:1")),
        ("load.torque_Nm=0:nan", RANGE.format("0:nan")),
        ("load.torque_Nm=-5:5", RANGE.format("-5:5")),
        ("load.torque_Nm=5", RANGE.format("5")),
        ("body_1.teeth=9.5:20", WHOLE.format("9.5:20")),
    ],
)
def test_a_slider_that_is_impossible_is_refused(asked: str, line: str) -> None:
    with pytest.raises(fl.SceneError) as caught:
        fl.explore(scene_of(), [asked], open_browser=False)
    assert str(caught.value) == line


def test_entries_of_lists_are_keys_and_the_largest_torque_has_a_slider() -> None:
    errors = {"body_1.pitch_errors_um": [0, 0, 3, *13 * [0]]}
    scene = scene_of().replace({"load.torque_Nm": [100, 300, 200], **errors})
    keys = keys_of(scene)
    assert shown_keys(scene, keys, ())[0].path == "load.torque_Nm[1]"
    (key,) = shown_keys(scene, keys, ["body_1.pitch_errors_um[2]"])
    assert (key.value, key.low, key.high) == (3, -6, 6)
    assert key.name == "pitch errors of body 1 [2], µm"
    assert scene.replace({key.path: key.at(1.0)}).body_1.pitch_errors_um[2] == 6


def test_no_key_that_both_bodies_share_has_a_slider_by_default() -> None:
    """Regression: the module of one body of a spline had a slider, but no other value."""
    scene = fl.read_scene(SCENES / "spline.toml")
    paths = [key.path for key in shown_keys(scene, keys_of(scene), ())]
    assert {"body_1.module_mm", "body_1.teeth"}.isdisjoint(paths)


# --- handle ---------------------------------------------------------------------------------------
def test_a_change_has_the_bits_of_a_prepared_scene(explorer: Any) -> None:
    changed = explorer.change(TORQUE)
    expected = fl.prepare(scene_of()).solve(TORQUE)
    assert changed.transmission_error_um.tobytes() == expected.transmission_error_um.tobytes()
    assert changed.peak_pressure_MPa.tobytes() == expected.peak_pressure_MPa.tobytes()
    assert explorer.result is changed
    assert explorer.scene.load.torque_Nm == 200.0


def test_a_relief_that_the_scene_lacks_begins_at_the_end_of_single_contact(explorer: Any) -> None:
    changed = explorer.change(RELIEF)
    assert explorer.scene.body_1.tip_relief_length == "long"
    expected = fl.solve(explorer.scene)
    assert changed.transmission_error_um.tobytes() == expected.transmission_error_um.tobytes()


@pytest.mark.parametrize(
    ("values", "line"),
    [
        ({"body_1.color": 3}, "body_1.color: expected a numeric key of the scene"),
        ({"name": 3}, "name: expected a numeric key of the scene"),
        ({"accuracy.modes": 5}, "accuracy.modes: expected a numeric key of the scene"),
        ({"load.torque_Nm": float("nan")}, "load.torque_Nm: expected a finite number"),
        ({"load.torque_Nm": "5"}, "load.torque_Nm: expected a finite number"),
        ({"load.torque_Nm": -1}, "load.torque_Nm: expected a number from 0 to 1e+12"),
        ({"body_1.teeth": 16.5}, "body_1.teeth: expected an integer from 3 to 10000"),
    ],
)
def test_a_wrong_change_is_refused_and_changes_nothing(
    explorer: Any, values: dict[str, Any], line: str
) -> None:
    before = explorer.scene
    with pytest.raises(fl.SceneError) as caught:
        explorer.change(values)
    assert line in str(caught.value)
    assert explorer.scene is before


def test_a_broken_premise_is_the_error_of_the_change(explorer: Any) -> None:
    with pytest.raises(fl.PremiseError):
        explorer.change({"load.torque_Nm": 3e4})
    assert explorer.change(TORQUE).torque_Nm == 200.0


def test_an_optimisation_goes_to_a_better_design_and_undo_returns() -> None:
    scene = scene_of()
    figure = "transmission_error_peak_to_peak_um"
    with fl.explore(scene, ["body_1.profile_crowning_um"], open_browser=False) as own:
        before = own.result.summary[figure]
        own.optimise(figure).result()
        assert own.scene.body_1.profile_crowning_um > 0
        assert own.result.summary[figure] < 0.9 * before
        own.undo()
        assert own.scene.body_1.profile_crowning_um == scene.body_1.profile_crowning_um


def test_a_notebook_shows_the_page(explorer: Any) -> None:
    assert f'<iframe src="{explorer.url}"' in explorer._repr_html_()


def test_closing_leaves_no_thread_and_no_address() -> None:
    before = set(threading.enumerate())
    one = fl.explore(scene_of(), open_browser=False)
    two = fl.explore(scene_of(), open_browser=False)
    assert one.url != two.url
    assert answer_of(one.url) == answer_of(two.url) == 200
    assert one.change(TORQUE).torque_Nm == 200.0
    one.close()
    assert answer_of(two.url) == 200
    assert two.scene.load.torque_Nm == 302.0
    two.close()
    two.close()
    assert set(threading.enumerate()) <= before
    with pytest.raises(OSError, match="refused"):
        answer_of(two.url)
    with pytest.raises(fl.FlankloadError, match=r"^the explorer is closed$"):
        two.change(TORQUE)


def test_an_answer_to_a_page_that_is_being_closed_does_not_end_the_thread(explorer: Any) -> None:
    """Regression: a document destroyed before its callback ended the runs of other pages."""
    document = Document()
    page = Page(explorer, document)
    document.callbacks.destroy()
    page.progress("optimise", 1, 2)
    explorer.leave(page)


# --- worker ---------------------------------------------------------------------------------------
def test_a_burst_ends_with_the_newest_request_and_never_goes_back() -> None:
    scene = scene_of()
    answers: list[Answer] = []
    worker = Worker(scene, keys_of(scene), (), answers.append, lambda *_: None)
    for number in range(1, 101):
        changed = scene.replace({"load.torque_Nm": 200.0 + number})
        worker.ask(Request(number, {"load.torque_Nm": 200.0 + number}, changed, moves=True))
        time.sleep(0.002)
    end = time.monotonic() + 30
    while not any(answer.at_rest for answer in answers) and time.monotonic() < end:
        time.sleep(0.01)
    worker.close()
    answers = [answer for answer in answers if answer.result or answer.error]
    numbers = [answer.request.number for answer in answers]
    assert numbers == sorted(numbers)
    last = answers[-1]
    assert (numbers[-1], last.error, len(numbers) < 100) == (100, "", True)
    expected = fl.prepare(scene).solve({"load.torque_Nm": 300.0})
    assert last.result is not None
    assert last.result.transmission_error_um.tobytes() == expected.transmission_error_um.tobytes()


def test_keys_that_reach_the_elements_are_known() -> None:
    scene = scene_of()
    paths = ["body_1.tip_relief_um", "body_1.bore_diameter_mm", "load.torque_Nm"]
    keys, done = keys_of(scene), threading.Event()

    def tell(answer: Answer) -> None:
        if answer.result is None:
            done.set()

    worker = Worker(scene, keys, shown_keys(scene, keys, paths), tell, lambda *_: None)
    worker.ask(Request(1, {}, scene))
    assert done.wait(30)
    worker.close()
    assert worker.reaching == {"body_1.bore_diameter_mm"}


def test_an_error_of_the_program_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    def fails(*_: Any, **__: Any) -> None:
        raise MemoryError("no room")

    monkeypatch.setattr("flankload.explorer.worker.solve_scene", fails)
    scene, answers = scene_of(), list[Answer]()
    worker = Worker(scene, keys_of(scene), (), answers.append, lambda *_: None)
    with pytest.raises(MemoryError):
        worker.change(Request(1, {}, scene)).result()
    worker.close()
    assert [answer.error for answer in answers if answer.error] == ["MemoryError('no room')"]


# --- pictures -------------------------------------------------------------------------------------
@pytest.mark.parametrize(
    ("name", "labels"),
    [
        ("error", ["Transmission error", "angle of body 1, °"]),
        ("spectrum", ["Spectrum of the transmission error"]),
        ("sites", ["Force of each planet, at the largest one"]),
    ],
)
def test_bars_are_not_over_the_angle_of_a_stage(name: str, labels: list[str]) -> None:
    """Regression: orders of a spectrum and planet numbers had the label of the position."""
    sent: list[dict[str, Any]] = []
    picture = Picture(name, lambda model, **properties: sent.append(properties))
    engagement = SimpleNamespace(
        pairs_advance=False, position_angle="angle of body 1", words_for_sites=("planet", "planets")
    )
    columns = {"x": np.arange(3.0), "y": np.ones(3), "corner": np.ones(3)}
    picture.show(columns, SimpleNamespace(engagement=engagement))  # type: ignore[arg-type]
    words = ("text", "axis_label")
    assert [one[word] for one in sent for word in words if word in one] == labels


def test_pressures_on_corners_alone_are_within_the_picture() -> None:
    """Regression: the picture of a helical internal gear had no range and was empty."""
    sent: list[dict[str, Any]] = []
    picture = Picture("pressure", lambda model, **properties: sent.append(properties))
    engagement = SimpleNamespace(pairs_advance=True, words_for_sites=("pair", "pairs"))
    columns = {"x": np.arange(3.0), "y": np.full(3, np.nan), "corner": np.full(3, 1100.0)}
    picture.show(columns, SimpleNamespace(engagement=engagement))  # type: ignore[arg-type]
    assert max(one["end"] for one in sent if "end" in one) > 1100.0


def test_a_spectrum_has_the_orders_that_few_positions_have() -> None:
    """Regression: orders that few positions cannot resolve left the page without pictures."""
    found = solve(scene_of().replace({"positions.count": 4}))
    assert isinstance(found, fl.Result)
    spectrum = curves_of(found)["spectrum"]
    assert spectrum["x"].tolist() == [1.0]
    assert spectrum["y"][0] > 0


# --- bodies ---------------------------------------------------------------------------------------
def test_teeth_over_their_width_carry_the_line_load_of_each_contact() -> None:
    few = {"estimate": False, "tangents": False, "flank_element_mm": 3.0, "modes": 3, "slices": 6}
    scene = fl.read_scene(SCENES / "helical_gear.toml").replace(
        {f"accuracy.{key}": value for key, value in few.items()} | {"positions.count": 2}
    )
    found = solve(scene)
    assert isinstance(found, fl.Result)
    windows = windows_of(found)
    for part, p in ((0.0, 0), (0.9, 1)):
        drawing = drawing_of(found, part, windows)
        assert f"at {found.position_deg[p]:.2f}°" in drawing
        loads = found.slices.line_load_N_per_mm
        fills = re.findall('fill="(#[0-9A-Fa-f]*)"', drawing)
        bands = [fill for fill in fills if fill in Inferno256]
        assert len(bands) == 2 * np.count_nonzero(loads[p])
        brightest = Inferno256[min(int(256 * loads[p].max() / loads.max()), 255)]
        assert max(map(Inferno256.index, bands)) == Inferno256.index(brightest)
        for window, svg in zip(windows, drawing.split("</svg>"), strict=False):
            points = np.array(re.findall("[ML]([-.0-9]+) ([-.0-9]+)", svg), dtype=float)
            assert (window[0] < points.min(axis=0)).all()
            assert (points.max(axis=0) < window[1]).all()


# --- gate -----------------------------------------------------------------------------------------
@pytest.mark.parametrize(
    ("path", "headers", "status"),
    [
        (None, {}, 200),
        ("/", {}, 403),
        ("/wrong-token/", {}, 403),
        ("/static/js/bokeh.min.js", {}, 403),
        (None, {"Host": "evil.example"}, 403),
        (None, {"Host": "127.0.0.1:1"}, 403),
        (None, {"Origin": "http://evil.example"}, 403),
        (None, {"Origin": "null"}, 403),
    ],
)
def test_the_gate_refuses_other_hosts_origins_and_tokens(
    explorer: Any, path: str | None, headers: dict[str, str], status: int
) -> None:
    assert answer_of(explorer.url, path, **headers) == status


@pytest.mark.parametrize(
    ("token", "headers"),
    [
        ("wrong-token", {}),
        (None, {"Origin": "http://evil.example"}),
        (None, {"Host": "evil.example"}),
    ],
)
def test_the_gate_refuses_foreign_websockets(
    explorer: Any, token: str | None, headers: dict[str, str]
) -> None:
    path = urlsplit(explorer.url).path if token is None else f"/{token}/"
    upgrade = {"Connection": "Upgrade", "Upgrade": "websocket", "Sec-WebSocket-Version": "13",
               "Sec-WebSocket-Key": "dGhlIHNhbXBsZSBub25jZQ=="}  # fmt: skip
    assert answer_of(explorer.url, f"{path}ws", **upgrade, **headers) == 403


def test_report_and_scene_of_the_design_are_files_of_the_page(explorer: Any) -> None:
    explorer.change({"load.torque_Nm": 123.0})
    parts = urlsplit(explorer.url)
    connection = http.client.HTTPConnection(parts.netloc, timeout=60)
    connection.request("GET", f"{parts.path}scene.toml")
    assert "torque_Nm = 123.0" in connection.getresponse().read().decode()
    connection.request("GET", f"{parts.path}report")
    assert "123 N m" in connection.getresponse().read().decode()
    connection.close()


# --- command --------------------------------------------------------------------------------------
def test_the_command_prints_its_address_and_ends_with_ctrl_c() -> None:
    path = SCENES / f"{NAME}.toml"
    process = subprocess.Popen(
        [sys.executable, "-m", "flankload", "explore", str(path), "--no-browser"],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    assert process.stdout is not None
    url = process.stdout.readline().strip()
    assert answer_of(url) == 200
    os.kill(process.pid, signal.SIGINT)
    out, errors = process.communicate(timeout=60)
    assert (process.returncode, out, errors) == (0, "", "")
    with pytest.raises(OSError, match="refused"):
        answer_of(url)


def test_a_missing_extra_is_one_line(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "bokeh.server.server", None)
    with pytest.raises(ImportError) as caught:
        fl.explore(scene_of())
    line = "flankload.explore needs the package bokeh: pip install 'flankload[explore]'"
    assert str(caught.value) == line
