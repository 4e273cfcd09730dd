"""Many that write into one folder, and runs that are interrupted: files are whole, none is left."""

from __future__ import annotations

import multiprocessing
import os
import signal
import subprocess
import sys
import tempfile
import time
from concurrent.futures import Executor, ProcessPoolExecutor, ThreadPoolExecutor, wait
from dataclasses import replace
from pathlib import Path

import numpy as np

import flankload as fl
from tests.support.paths import SCENES
from tests.support.tally import Tally

SCENE = SCENES / "chain.toml"
#: Positions of a run that is interrupted: its files take a while.
POSITIONS = 20
#: Writers at a time, files that they share, writes of a round.
WRITERS, FILES, ROUND = 6, 5, 60
#: The command, which says when it begins: before, Ctrl-C is Python's own.
PROGRAM = """
import sys
from flankload.__main__ import command
print("begun", flush=True)
sys.exit(command())
"""
EARLIEST_S = 0.02
OLD = "old\n"


def fuzz_writes(seed: int, count: int) -> Tally:
    """Write results from threads and processes into one folder, and read them meanwhile.

    Parameters
    ----------
    seed : int
    count : int
        Of writes.

    Returns
    -------
    Tally
        wrong: a file that is not one of those written, whole; a file too many.
    """
    tally = Tally("writes")
    rng = np.random.default_rng(seed)
    result = fl.solve(fl.read_scene(SCENE))
    assert isinstance(result, fl.Result)
    results = [replace(result, name=f"result {k}") for k in range(FILES)]
    spawn = multiprocessing.get_context("spawn")
    with ThreadPoolExecutor(WRITERS) as threads, ProcessPoolExecutor(2, spawn) as processes:
        while tally.tried < count:
            pool = (threads, processes)[tally.tried // ROUND % 2]
            size = min(ROUND, count - tally.tried)
            _round(tally, rng, pool, results, size)
            tally.tried += size
    return tally


def _round(
    tally: Tally, rng: np.random.Generator, pool: Executor, results: list[fl.Result], size: int
) -> None:
    """Some writes at once; all names get several, so that they are replaced, too."""
    place = f"writes {tally.tried} to {tally.tried + size} by {type(pool).__name__}"
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        whole = {f"{k}.{kind}": _text(results[k], kind) for k in range(FILES)
                 for kind in ("json", "csv")}  # fmt: skip
        chosen = [list(whole)[k] for k in rng.integers(0, len(whole), size)]
        jobs = [pool.submit(_write, results[int(file[0])], folder / file) for file in chosen]
        pending = True
        while pending:
            pending = bool(wait(jobs, timeout=0.005).not_done)
            for file, text in whole.items():
                path = folder / file
                if path.exists() and path.read_text(encoding="utf-8") != text:
                    tally.fault("wrong", f"{place}: {file} is another one, or a part")
        for job in jobs:
            error = job.exception()
            if error is not None:
                kind = "wrong" if isinstance(error, OSError) else "traceback"
                tally.fault(kind, f"{place}: {error!r}"[:200])
        left = set(os.listdir(folder)) ^ set(chosen)
        if left:
            tally.fault("wrong", f"{place}: {sorted(left)} missing or too many")


def _text(result: fl.Result, kind: str) -> str:
    return result.to_json() if kind == "json" else result.to_csv()


def _write(result: fl.Result, path: Path) -> None:
    result.to_json(path) if path.suffix == ".json" else result.to_csv(path)


def fuzz_interrupts(seed: int, count: int) -> Tally:
    """Send Ctrl-C to runs that write files, at any moment, half of them near the end.

    Parameters
    ----------
    seed : int
    count : int
        Of interrupts.

    Returns
    -------
    Tally
        wrong: a file that is neither the old nor the new one, a file too many, another exit code
        or more than one line.
    """
    tally = Tally("interrupts")
    rng = np.random.default_rng(seed)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        scene = folder / "scene.toml"
        text = SCENE.read_text(encoding="utf-8")
        assert "[positions]" not in text
        scene.write_text(f"{text}\n[positions]\ncount = {POSITIONS}\n", encoding="utf-8")
        found = fl.solve(fl.read_scene(scene))
        assert isinstance(found, fl.Result)
        _interrupted(scene, 600.0)  # loads what the first one would wait for
        began = time.perf_counter()
        _interrupted(scene, 600.0)
        whole_s = time.perf_counter() - began
        new = (folder / "a.csv").read_text(encoding="utf-8")
        for k in range(count):
            _reset(folder, old=bool(rng.random() < 0.5))
            low, high = (EARLIEST_S, whole_s) if k % 2 else (0.6 * whole_s, 1.05 * whole_s)
            delay = float(rng.uniform(low, high))
            code, said = _interrupted(scene, delay)
            tally.tried += 1
            for fault in _faults(folder, code, said, new):
                tally.fault("wrong", f"seed {seed}, interrupt {k} after {delay:.3f} s: {fault}")
    return tally


def _interrupted(scene: Path, delay_s: float) -> tuple[int, str]:
    """Exit code and what is said of a run that is interrupted after a while."""
    files = ["--json", str(scene.with_name("a.json")), "--csv", str(scene.with_name("a.csv"))]
    with subprocess.Popen(
        [sys.executable, "-c", PROGRAM, "run", str(scene), *files, "--quiet"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as process:
        assert process.stdout is not None
        process.stdout.readline()
        try:
            _, said = process.communicate(timeout=delay_s)
        except subprocess.TimeoutExpired:
            process.send_signal(signal.SIGINT)
            _, said = process.communicate()
    return process.returncode, said


def _reset(folder: Path, *, old: bool) -> None:
    for name in ("a.json", "a.csv"):
        if old:
            (folder / name).write_text(OLD, encoding="utf-8")
        else:
            (folder / name).unlink(missing_ok=True)


def _faults(folder: Path, code: int, said: str, new: str) -> list[str]:
    faults = []
    if (code, said) not in ((0, ""), (130, "flankload: interrupted\n")):
        faults.append(f"exit code {code}, {said[-200:]!r}")
    left = set(os.listdir(folder)) - {"scene.toml", "a.json", "a.csv"}
    if left:
        faults.append(f"{sorted(left)} left")
    for name in ("a.json", "a.csv"):
        path = folder / name
        text = path.read_text(encoding="utf-8") if path.exists() else None
        done = text is not None and (text == new if name == "a.csv" else _is_whole(text))
        if not (done or (text in (None, OLD) and code == 130)):
            faults.append(f"{name} is neither the old nor the new one")
    return faults


def _is_whole(text: str) -> bool:
    """The cost in it differs from run to run."""
    return text.startswith('{"name": ') and text.endswith("}\n") and text.count("\n") == 1
