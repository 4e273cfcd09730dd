"""Progress of long computations: the time left, and the line that announces them."""

from __future__ import annotations

import time

import pytest

import flankload as fl
from flankload.cli.progress import Progress, TimeLeft, in_words
from flankload.mechanisms.stage_clock import StageClock, elements_stage, end_of_phase
from tests.support.paths import SCENES


class Clock:
    """Seconds that a test sets."""

    def __init__(self) -> None:
        self.now = 100.0

    def __call__(self) -> float:
        return self.now


def test_the_time_left_is_that_of_the_steps_so_far() -> None:
    clock = Clock()
    left = TimeLeft(now=clock)
    assert left.after("sweep", 0, 40) is None
    clock.now += 2.0
    assert left.after("sweep", 10, 40) == pytest.approx(6.0, rel=1e-12)
    assert left.spent_s == pytest.approx(2.0, rel=1e-12)


def test_states_do_not_take_as_long_as_elements() -> None:
    """Each phase is extrapolated separately: slow elements do not imply slow states."""
    clock = Clock()
    left = TimeLeft(end_of_phase, now=clock)
    total = end_of_phase("compliance body 1", 0) + 100
    left.after("bodies", 0, total)
    left.after("compliance body 1", 1, total)
    clock.now += 5.0
    half = left.after("compliance body 2", 51, total)
    assert half == pytest.approx(5.0, rel=1e-12)
    clock.now += 5.0
    left.after("sweep", total - 100, total)
    clock.now += 1.0
    assert left.after("sweep", total - 50, total) == pytest.approx(1.0, rel=1e-12)


def test_stages_of_three_bodies_follow_each_other() -> None:
    """Regression: only stages of bodies 1 and 2 were counted, not those of a planet."""
    seen: list[tuple[str, int]] = []
    names = ("body_1", "planet", "body_2")
    clock = StageClock(lambda stage, done, total: seen.append((stage, done)), names, 1, {})
    for name in names:
        stage = elements_stage(name)
        clock.stage(stage)
        clock.part_progress(stage)(1.0)
    clock.stage("sweep")
    assert [stage for stage, _ in seen[::2]] == [
        "compliance body 1",
        "compliance planet",
        "compliance body 2",
        "sweep",
    ]
    done = [steps for _, steps in seen]
    assert done[0] == 1
    assert done == sorted(done)
    assert done[-1] == end_of_phase("compliance planet", 0)


def test_a_factorization_is_not_taken_for_each_of_the_loads_behind_it() -> None:
    """Regression: a helical pair of 5 s was announced with minutes after its first, long step."""
    clock = Clock()
    left = TimeLeft(now=clock)
    left.after("compliance body 1", 0, 100)
    for done, seconds in ((1, 0.1), (2, 2.0)):
        clock.now += seconds
        rest = left.after("compliance body 1", done, 100)
    assert rest == pytest.approx(9.8, rel=1e-12)


@pytest.mark.parametrize(
    ("seconds", "words"), [(12.4, "12 s"), (90.0, "90 s"), (600.0, "10 min"), (7200.0, "2.0 h")]
)
def test_durations_in_words(seconds: float, words: str) -> None:
    assert in_words(seconds) == words


def test_a_long_run_is_announced_once(capsys: pytest.CaptureFixture[str]) -> None:
    clock = Clock()
    with Progress(wanted=False, announced=True) as progress:
        progress._left = TimeLeft(now=clock)
        progress.tell("sweep", 0, 100)
        for done in (2, 3):
            clock.now += 0.5
            progress.tell("sweep", done, 100)
    assert capsys.readouterr().err == "flankload: this takes about 20 s or more (now: sweep)\n"


def test_redirected_progress_is_a_line_from_time_to_time(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Regression: with stderr in a file, a study of an hour printed nothing until its end."""
    monkeypatch.setattr("flankload.cli.progress.LINE_S", 0.02)
    with Progress(wanted=True) as progress:
        progress.tell("12 of 600 designs, 2.0/s", 12, 600, 294.0)
        limit = time.monotonic() + 20.0
        err = ""
        while err.count("\n") < 2 and time.monotonic() < limit:
            time.sleep(0.01)
            err += capsys.readouterr().err
    assert set(err.splitlines()) == {"flankload: 12 of 600 designs, 2.0/s, 2 %, 5 min left"}
    assert err.count("\n") >= 2
    with Progress(wanted=False) as progress:
        progress.tell("sweep", 1, 2)
        time.sleep(0.05)
    assert capsys.readouterr().err == ""


def test_elements_in_three_dimensions_show_their_progress() -> None:
    """Their elimination is most of a long run; the remaining time depends on its progress."""
    seen: list[tuple[str, int]] = []
    scene = fl.read_scene(SCENES / "helical_gear.toml").replace(
        {
            "accuracy.flank_element_mm": 5.0,
            "accuracy.axial_degree": 6,
            "accuracy.load_degree_z": 2,
            "accuracy.estimate": False,
            "accuracy.tangents": False,
            "positions.count": 1,
        }
    )
    fl.solve(scene, lambda stage, done, total: seen.append((stage, done)))
    for stage in ("compliance body 1", "compliance body 2"):
        steps = [done for name, done in seen if name == stage]
        assert steps == sorted(steps)
        assert len(steps) > 10
    assert max(done for name, done in seen if "compliance" in name) <= end_of_phase(
        "compliance body 2", 0
    )
