"""How long a run will take: known before elements are solved, from counted work alone."""

from __future__ import annotations

import tomllib
from typing import Any

import pytest

import flankload as fl
from flankload.mechanisms.duration import Duration
from tests.support.paths import SCENES


@pytest.fixture(autouse=True)
def one_thread(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("OMP_NUM_THREADS", "1")


class Enough(Exception):  # noqa: N818 - ends a run
    """Raised where the estimate is there: nothing behind it runs."""


def told(name: str, **keys: Any) -> Duration:
    tables = tomllib.loads((SCENES / f"{name}.toml").read_text("utf-8"))
    for path, value in keys.items():
        table, key = path.split("__")
        tables.setdefault(table, {})[key] = value
    found: list[Duration] = []

    def stop(duration: Duration) -> None:
        found.append(duration)
        raise Enough

    with pytest.raises(Enough):
        fl.solve(
            fl.Scene.from_dict(tables, file=SCENES / f"{name}.toml"),
            lambda stage, *_: pytest.fail(stage) if "compliance" in stage else None,
            on_duration=stop,
        )
    return found[0]


def test_a_spline_on_an_offset_is_long_and_a_gear_is_not() -> None:
    """Measured on one thread at 3 GHz: 22 CPU seconds and 0.2."""
    spline = told("spline", pair__center_offset_mm=0.01, positions__count=32)
    assert 11.0 < spline.seconds < 44.0
    assert str(spline).startswith(f"about {10 * round(spline.seconds / 10)} s: 32 positions x 24 ")
    assert told("external_gear").seconds < 0.4


def test_states_and_elements_are_counted() -> None:
    one = told("external_gear")
    more = told("external_gear", positions__count=64, load__torque_Nm=[100, 200, 302])
    assert more.states_s == pytest.approx(6 * one.states_s, rel=1e-9)
    assert more.elements_s == pytest.approx(one.elements_s, rel=1e-9)
    assert more.work.startswith("3 torques x 64 positions, elements with ")
    finer = told("external_gear", accuracy__flank_element_mm=0.2, accuracy__estimate=False)
    assert finer.elements_s > 5 * one.elements_s
    assert finer.states_s < one.states_s


def test_effects_are_paid_for() -> None:
    plain = told("internal_gear")
    assert told("internal_gear", effects__influence="finite").states_s > 10 * plain.states_s
    assert told("internal_gear", effects__contact="lumped").states_s < plain.states_s
    assert told("internal_gear", positions__adaptive=True).states_s > 2 * plain.states_s


def test_threads_share_positions(monkeypatch: pytest.MonkeyPatch) -> None:
    one = told("external_gear")
    monkeypatch.setenv("OMP_NUM_THREADS", "4")
    assert told("external_gear").states_s == pytest.approx(one.states_s / 4, rel=1e-9)


def test_belts_and_scenes_with_a_tolerance_know_theirs() -> None:
    assert told("belt", positions__count=8).work == "8 positions, 12 teeth"
    assert told("external_gear", accuracy__tolerance=0.002).elements_s > 0.0
