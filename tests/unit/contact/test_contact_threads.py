"""Many calls at once and one after the other: the same bits, a free interpreter, no memory kept."""

from __future__ import annotations

import gc
import multiprocessing
import sys
import threading
import time
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np
import pytest

import flankload as fl
from flankload import _core, errors
from tests.support.contact_problems import flank_problem, random_problem

STATM = Path("/proc/self/statm")
PAGE = 4096


def numbers_of(state: fl.ContactState) -> bytes:
    """Every bit of the numbers of a state."""
    parts = (state.normal_forces, state.final_gap_angles, state.motions, state.tangent)
    return b"".join(part.tobytes() for part in parts)


def test_two_threads_give_the_bits_of_one() -> None:
    rng = np.random.default_rng(21)
    problems = [
        flank_problem(n, rng, friction=friction) for n in (12, 70, 300) for friction in (0, 0.2)
    ]
    methods = ("auto", "single", "load_path")

    def solve_all() -> list[bytes]:
        return [
            numbers_of(
                fl.solve_contact(
                    matrix, row, gaps, torque, normal_lever_arms=np.ones(row.size), method=method
                )
            )
            for matrix, row, gaps, torque in problems
            for method in methods
        ]

    alone = solve_all()
    found: list[list[bytes]] = []
    together = threading.Barrier(2)

    def run() -> None:
        together.wait()
        found.extend(solve_all() for _ in range(5))

    threads = [threading.Thread(target=run) for _ in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(found) == 10
    assert all(answers == alone for answers in found)


@pytest.fixture
def no_forced_switches() -> Iterator[None]:
    """A thread keeps the interpreter until it gives it away by itself."""
    before = sys.getswitchinterval()
    sys.setswitchinterval(1000.0)
    yield
    sys.setswitchinterval(before)


@pytest.mark.usefixtures("no_forced_switches")
def test_other_threads_run_during_a_call_of_the_core() -> None:
    rng = np.random.default_rng(22)
    matrix, row, gaps, torque = flank_problem(900, rng)
    matrix, column = np.asfortranarray(matrix), np.asfortranarray(row[:, np.newaxis])
    nothing, load = np.empty(0, dtype=np.int32), np.array([torque])
    counted = 0
    done = threading.Event()

    def count() -> None:
        nonlocal counted
        while not done.is_set():
            counted += 1
            time.sleep(0)  # gives the interpreter away

    counter = threading.Thread(target=count)
    counter.start()
    try:
        # Without a call of the core the counter does not change.
        before = counted
        sum(range(10000))
        assert counted == before
        # A busy machine may let one call pass without the other thread.
        for _ in range(20):
            _core.flankload_solve_contact(matrix, gaps, column, column, load, 1, 1, nothing)
            during = counted - before
            if during:
                break
    finally:
        done.set()
        counter.join()
    assert during > 0


#: Calls whose memory is counted, after some that fill the memory that is kept.
CALLS, FIRST = 25_000, 5_000


def memory_kept() -> int:
    """Bytes by which this process grows in `CALLS` calls."""
    rng = np.random.default_rng(23)
    matrix, row, levers, gaps, torque = random_problem(rng, unsymmetric=False)

    def call(kind: int) -> None:
        try:
            if kind < 2:
                fl.solve_contact(matrix, row, gaps, torque, normal_lever_arms=levers)
            elif kind == 2:
                fl.solve_contact([[2, 1], [1, 1.5]], [1, -1], [0, 0], 1.0)
            else:
                fl.solve_contact(matrix, row, gaps, -1.0)
        except (errors.NoContactState, errors.InputError):
            assert kind >= 2

    def resident_after(calls: int) -> int:
        for number in range(calls):
            call(number % 4)
        gc.collect()
        return int(STATM.read_text().split()[1]) * PAGE

    warm = resident_after(FIRST)
    return resident_after(CALLS) - warm


@pytest.mark.skipif(not STATM.exists(), reason="resident memory is read from /proc")
def test_many_calls_keep_no_memory() -> None:
    """Solved, without a state, refused; 20 bytes a call. In a process of its own, whose memory no
    other test has filled."""
    with ProcessPoolExecutor(1, multiprocessing.get_context("spawn")) as processes:
        assert processes.submit(memory_kept).result() < 20 * CALLS
