"""The one call of the core: torque lists, packed pairs, stopping, progress, named failures."""

from __future__ import annotations

import os
import subprocess
import sys
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import flankload as fl
from flankload import _core
from flankload.contact import core_call as core_room
from flankload.contact import sweep as sweep_room
from flankload.contact.core_call import call_and_watch
from flankload.contact.pair_table import COLUMNS
from flankload.contact.status import (
    EXCEPTIONS,
    SCENE_TEXTS,
    Status,
    raise_first_failure,
    status_text,
)
from tests.support.sweep_calls import TORQUES, assert_same, job, run


@pytest.mark.parametrize(("kind", "count"), [("gears", 24), ("spline", 2)])
def test_a_torque_of_a_list_is_solved_as_if_it_stood_alone(kind: str, count: int) -> None:
    """Bitwise, after any other torque; conforming flanks search their even gap at each torque."""
    together = run(TORQUES, kind=kind, count=count)
    backwards = run(TORQUES[::-1], kind=kind, count=count)[::-1]
    for torque, found, again in zip(TORQUES, together, backwards, strict=True):
        (alone,) = run([torque], kind=kind, count=count)
        assert found.torque_Nmm == torque
        assert_same(found, alone)
        assert_same(found, again)


def test_torque_lists_are_bitwise_the_same_with_any_number_of_threads() -> None:
    """Threads share positions, and the order of pairs in the packed table depends on who is first.

    Both processes make their compliances themselves: numpy's BLAS keeps one thread.
    """
    program = (
        "import sys\n"
        "from tests.support.sweep_calls import TORQUES, run\n"
        "for s in run(TORQUES, count=60):\n"
        "    numbers = (s.rotation_rad, s.site_force_N, s.certificate, s.counters)\n"
        "    pairs = (table for p in range(60) for table in s.pairs.at(p))\n"
        "    for array in (*numbers, *pairs):\n"
        "        sys.stdout.write(array.tobytes().hex())\n"
    )
    one, several = (
        subprocess.run(
            [sys.executable, "-c", program],
            env={**os.environ, "OMP_NUM_THREADS": threads, "OPENBLAS_NUM_THREADS": "1"},
            capture_output=True,
            check=True,
        ).stdout
        for threads in ("1", "3")
    )
    assert len(one) > 1e6
    assert one == several


def test_pairs_are_packed_without_a_row_to_spare() -> None:
    found = run(TORQUES)
    table = found[0].pairs.table
    assert all(part.pairs.table is table for part in found)
    assert len(table) == len(found[0].pairs.site) == sum(part.n_pairs.sum() for part in found)
    rows = np.concatenate(
        [
            np.arange(first, first + n)
            for part in found
            for first, n in zip(part.pairs.first, part.pairs.count, strict=True)
        ]
    )
    np.testing.assert_array_equal(np.sort(rows), np.arange(len(table)))
    for part in found:
        forces = [part.pairs.at(p)[1][:, COLUMNS.index("force")] for p in range(24)]
        np.testing.assert_array_equal(part.pairs.column("force"), np.concatenate(forces))
        np.testing.assert_allclose(
            [f.sum() for f in forces], part.site_force_N.sum(axis=1), rtol=1e-14
        )


def test_positions_without_room_for_their_pairs_are_asked_for_again(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    plenty = run(TORQUES)
    monkeypatch.setattr(sweep_room, "INITIAL_PAIRS", 7)
    for ample, scarce in zip(plenty, run(TORQUES), strict=True):
        assert_same(ample, scarce)


def test_pairs_that_are_not_wanted_take_no_room() -> None:
    with_pairs, without = run([302e3])[0], run([302e3], keep_pairs=False)[0]
    assert without.pairs.nbytes == without.pairs.table.nbytes == 0
    np.testing.assert_array_equal(without.n_pairs, with_pairs.n_pairs)
    np.testing.assert_array_equal(without.site_force_N, with_pairs.site_force_N)


def test_a_failure_names_position_and_torque() -> None:
    """A single state without a solution ends the sweep with an error."""
    pair, _ = job("gears", 24)
    apart = replace(pair.pairing, center_distance_mm=200.0)
    with pytest.raises(
        fl.errors.NoContactState,
        match=r"position 0 \(0\.0000 deg\), torque 40 N m: no circle .* \(96 of 96 states failed\)",
    ):
        run(TORQUES, pairing=apart)
    status = np.zeros((3, 2), dtype=int)
    status[2, 1] = -1
    certificate = np.full((3, 3, 2), np.nan)
    certificate[:2, 2, 1] = [0.25, 1.0]  # a quarter can be held, more cannot for certain
    with pytest.raises(
        fl.errors.NoContactState,
        match=r"position 2 \(11.* torque 0\.5 N m: no contact st.* about 0\.125 N m can be held",
    ) as caught:
        raise_first_failure(
            status,
            np.array([0.0, 0.1, 0.2]),
            np.array([0.0, 500.0]),
            certificate,
            has_friction=False,
        )
    assert caught.value.largest_torque == pytest.approx(125.0)
    assert caught.value.proven


def test_the_core_stops_when_it_is_asked_to(monkeypatch: pytest.MonkeyPatch) -> None:
    """A request before the first position: no position is begun, and all statuses show it."""
    stopped, calls = [], []
    original = _core.flankload_sweep_mesh

    def asked_to_stop(*arguments: np.ndarray) -> object:
        control = arguments[-6]
        control[0] = 1
        found = original(*arguments)
        stopped.append((found[0], control.copy()))
        return found

    monkeypatch.setattr(_core, "flankload_sweep_mesh", asked_to_stop)
    with pytest.raises(fl.errors.ContactError, match="stopped"):
        run([302e3, 0.0], progress=lambda done, total: calls.append((done, total)))
    ((status, control),) = stopped
    assert (status == -16).all()
    assert control[1] == 0
    assert calls == [(0, 24)]


def test_progress_is_reported_while_the_core_runs_and_ends_at_the_end() -> None:
    calls: list[tuple[int, int]] = []
    run([302e3], count=24, progress=lambda done, total: calls.append((done, total)))
    assert calls[-1] == (24, 24)
    assert sorted(calls) == calls


def test_an_exception_of_progress_stops_the_core_and_reaches_the_caller() -> None:
    control = np.zeros(2, dtype=np.intc)

    def core() -> str:
        while not control[0]:  # as the core: positions until it is asked to stop
            control[1] += 1
        return "stopped"

    def report(done: int) -> None:
        raise RuntimeError(f"enough after {done > 0}")

    with pytest.raises(RuntimeError, match="enough after True"):
        call_and_watch(core, control, report=report)
    assert control[0] == 1


def test_an_exception_of_the_core_call_reaches_the_caller() -> None:
    def core() -> None:
        raise MemoryError("too many pairs")

    with pytest.raises(MemoryError, match="too many pairs"):
        call_and_watch(core, np.zeros(2, dtype=np.intc))


def test_every_status_of_a_position_has_an_exception_and_words() -> None:
    """Except tension, which only the paper's loop leaves, and errors that no sweep has."""
    left_out = {Status.NEGATIVE_FORCE, Status.NO_ROOM, Status.UNSTEADY_POINTS}
    of_position = {status for status in Status if status < 0} - left_out
    assert {*EXCEPTIONS} == of_position
    for code in of_position:
        with pytest.raises(EXCEPTIONS[code], match="position 0") as caught:
            raise_first_failure(
                np.array([[code]]), np.zeros(1), np.ones(1), np.zeros((3, 1, 1)), has_friction=False
            )
        assert (SCENE_TEXTS.get(code) or status_text(code)) in str(caught.value)
    assert status_text(-18) == "the half-widths of the lumped contacts do not converge"


def test_a_short_call_needs_no_thread(monkeypatch: pytest.MonkeyPatch) -> None:
    calls: list[object] = []

    def counted(call: Any, *arguments: Any, **options: Any) -> Any:
        calls.append(call)
        return call_and_watch(call, *arguments, **options)

    monkeypatch.setattr(core_room, "call_and_watch", counted)
    done: list[tuple[int, int]] = []
    run([TORQUES[0]], count=4, level="lumped", progress=lambda *now: done.append(now))
    assert (calls, done) == ([], [(4, 4)])
    monkeypatch.setattr(core_room, "SHORT_CALL", 3)
    run([TORQUES[0]], count=4, level="lumped")
    monkeypatch.undo()
    monkeypatch.setattr(core_room, "call_and_watch", counted)
    run([TORQUES[0]], count=4)
    assert len(calls) == 1
    run([TORQUES[0]], count=32)
    assert len(calls) == 2
