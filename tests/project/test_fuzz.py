"""The fuzz of the benches runs, and its oracles find faults."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import flankload as fl
from tests.benchmarks import __main__ as benches
from tests.benchmarks import _fuzz_meshes, _fuzz_scenes, _fuzz_spatial, _fuzz_writes, fuzz
from tests.support.balance import imbalance
from tests.support.made_up_result import made_up_result
from tests.support.random_spatial_scenes import spatial_scene
from tests.support.solving import solve
from tests.support.spoiled_scenes import bases, spoiled
from tests.support.tally import Tally


def test_tally_is_a_line_with_the_first_examples() -> None:
    tally = Tally("scenes", tried=20)
    for k in range(12):
        tally.fault("silent", f"seed {k}")
    tally.fault("traceback", "seed 99")
    lines = str(tally).splitlines()
    assert lines[0] == "scenes: 20 tried, 0 wrong, 12 silent, 1 tracebacks"
    assert lines[1:] == [f"  silent: seed {k}" for k in range(10)]


def test_little_fuzz_finds_nothing() -> None:
    assert str(_fuzz_scenes.fuzz_scenes(1, 3)).endswith(" 0 wrong, 0 silent, 0 tracebacks")
    assert str(_fuzz_spatial.fuzz_spatial(7, 1)).endswith(" 0 wrong, 0 silent, 0 tracebacks")
    assert str(_fuzz_meshes.fuzz_meshes(1, 6)).endswith(" 0 wrong, 0 silent, 0 tracebacks")
    assert str(_fuzz_writes.fuzz_writes(1, 10)).endswith(" 0 wrong, 0 silent, 0 tracebacks")


def test_same_seed_spoils_the_same_scene() -> None:
    one, other = (spoiled(np.random.default_rng([3, k])) for k in (7, 7))
    assert repr(one) == repr(other)


def test_scene_that_is_taken_without_a_word_is_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(_fuzz_scenes, "spoiled", lambda _: (bases()[0], "teeth = nan"))
    assert _fuzz_scenes.fuzz_scenes(1, 1).examples == ["silent: seed [1, 0]: teeth = nan"]


def test_exception_that_is_not_ours_is_a_traceback(monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(_: object) -> None:
        raise ZeroDivisionError("float division by zero")

    monkeypatch.setattr(_fuzz_scenes, "spoiled", lambda _: (bases()[0], None))
    monkeypatch.setattr(fl, "solve", fail)
    tally = _fuzz_scenes.fuzz_scenes(4, 1)
    assert tally.traceback == 1
    assert "seed [4, 0]: ZeroDivisionError" in tally.examples[0]


def test_result_that_pulls_or_does_not_balance_is_wrong() -> None:
    result = made_up_result()
    force = result.site_force_N.copy()
    force[0, 0] = np.nan
    assert "site_force_N is not finite" in _fuzz_scenes.faults_of(
        replace(result, site_force_N=force)
    )
    force[0, 0] = -1.0
    assert "a force of -1 N" in _fuzz_scenes.faults_of(replace(result, site_force_N=force))
    # the forces of this result come from springs, not from its torque
    assert imbalance(replace(result, torque_Nm=2 * result.torque_Nm)) > 1e-3


def test_contacts_that_pull_over_a_gap_or_penetrate_are_wrong() -> None:
    (result,) = spatial_answer()
    assert _fuzz_spatial.contact_faults(result) == []
    table = result.pairs(0)
    assert (table.force_N > 0).any()
    for gap_um, fault in ((1e-3, "force over a gap"), (-1e-3, "penetration")):
        tables = [replace(table, gap_um=np.full(len(table), gap_um))]
        found = _fuzz_spatial.contact_faults(replace(result, pair_tables=tables))
        assert any(fault in each for each in found)
    assert result.slices is not None
    half = replace(result, site_force_N=0.5 * result.site_force_N)
    assert "forces of slices do not add up" in _fuzz_spatial.contact_faults(half)


def test_image_with_another_answer_is_wrong() -> None:
    answer = spatial_answer()
    (result,) = answer
    assert result.slices is not None
    assert _fuzz_spatial.image_faults(answer, answer, 1.0) == []
    turned = replace(result, rotation_rad=result.rotation_rad * (1 + 1e-8))
    (fault,) = _fuzz_spatial.image_faults(answer, (turned,), 1.0)
    assert fault.startswith("another rotation under")
    force = result.slices.force_N.copy()
    force[..., 0] += 1e-6 * force.max()
    loaded = replace(result, slices=replace(result.slices, force_N=force))
    (fault,) = _fuzz_spatial.image_faults(answer, (loaded,), 1.0)
    assert fault.startswith("other line loads under")
    refused = fl.SceneError(key="pair", expected="one", found="none")
    (fault,) = _fuzz_spatial.image_faults(answer, refused, None)
    assert fault.endswith("in place of a result")


def spatial_answer() -> tuple[fl.Result, ...]:
    """A single position of a random scene in three dimensions."""
    scene = spatial_scene(np.random.default_rng(7))
    scene["positions"] = {"count": 1}
    scene["load"]["torque_Nm"] = np.max(scene["load"]["torque_Nm"])
    found = solve(fl.Scene.from_dict(scene))
    assert isinstance(found, fl.Result)
    return (found,)


def test_seed_and_part_reach_the_fuzz(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    asked: list[tuple[int, float]] = []

    def run(seed: int = 1, part: float = 1.0) -> str:
        asked.append((seed, part))
        return "done"

    monkeypatch.setattr(fuzz, "run", run)
    assert benches.main(["fuzz", "--seed", "5", "--part", "0.1"]) == 0
    assert asked == [(5, 0.1)]
    assert capsys.readouterr().out == "== fuzz\ndone\n"
    assert benches.main(["stress", "--part", "0.1"]) == 2
    assert "stress knows no --part" in capsys.readouterr().err
