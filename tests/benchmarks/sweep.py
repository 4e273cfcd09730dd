"""The sweep: where the time of a position goes, how it grows, threads and memory.

Milliseconds per position and torque, the shortest of several runs; ratios hold in one run only. A
machine that others use shows in the seconds, not in the CPU seconds.
FLANKLOAD_SWEEP_POSITIONS=… sets another number of positions for the large run.
"""

from __future__ import annotations

import json
import os
import resource
import subprocess
import sys
import time
from dataclasses import replace

import numpy as np

import flankload as fl
from flankload.contact.body_record import LEVELS
from tests.benchmarks._sweep_core import stage_times
from tests.support.pair_job import Job
from tests.support.paths import SCENES

SCENE = SCENES / "external_gear.toml"
TORQUE = 302e3
STAGES = ("zones", "lumped", "cells", "influence", "loop")
#: Wanted: ms of pairs, influence numbers and loop; s and MB of 1000 x 10; two threads against one.
WANTED = {"position": 0.2, "seconds": 2.0, "memory": 300.0, "threads": 1.7}


def run() -> str:
    """Measure and return the tables."""
    job = Job(fl.read_scene(SCENE))
    return "\n".join([*_stages(job), "", *_growth(job), "", _levels(job), "", *_large_run()])


def _stages(job: Job) -> list[str]:
    """Stages of a position for several numbers of pairs."""
    grid = job.bodies.discretization.grid
    grids = [
        replace(
            grid,
            strips_per_half_width=factor * grid.strips_per_half_width,
            corner_strips_per_half_width=factor * grid.corner_strips_per_half_width,
        )
        for factor in (0.5, 1.0, 1.5)
    ]
    lines = [
        f"{'ms per position':>22}" + "".join(f"{name:>10}" for name in (*STAGES, "rest", "whole"))
    ]
    remarks = []
    for times in stage_times(job, count=256, torque_Nmm=TORQUE, grids=grids):
        stages = [getattr(times, name) for name in STAGES]
        rest = times.whole - sum(stages)
        lines.append(
            f"{times.pairs:6.0f} pairs, {times.active:3.0f} act."
            + "".join(f"{value:10.4f}" for value in (*stages, rest, times.whole))
        )
        remarks.append(
            f"{times.pairs:6.0f} pairs: the loop begun cold takes {times.cold / times.loop:.2f} of"
            f" that, with the very pairs of its state {times.known / times.loop:.2f}, without the"
            f" proof of uniqueness {times.trusted / times.loop:.2f}"
        )
    return [*lines, f"wanted <= {WANTED['position']} ms at 50 to 90 pairs", *remarks]


def _growth(job: Job) -> list[str]:
    """Time of the whole call, arrays of Python included, over positions and torques."""
    lines = []
    for count, n_torques in ((64, 1), (256, 1), (1024, 1), (256, 4), (256, 10)):
        torques = np.linspace(0.2, 1.5, n_torques) * TORQUE if n_torques > 1 else [TORQUE]
        shortest = np.inf
        for _ in range(5):
            start = time.process_time()
            job.sweep(count, list(torques))
            shortest = min(shortest, time.process_time() - start)
        each = 1000 * shortest / count / n_torques
        lines.append(f"{count:5d} positions x {n_torques:2d} torques: {each:.4f} ms CPU each")
    return lines


def _levels(job: Job) -> str:
    """Lumped contact against contact pairs, both in turn so that both meet the same machine."""
    count, shortest = 256, {"pairs": np.inf, "lumped": np.inf}
    for _ in range(7):
        for level in LEVELS:
            start = time.process_time()
            job.sweep(count, [TORQUE], level=level)
            shortest[level] = min(shortest[level], time.process_time() - start)
    pairs, lumped = (1000 * shortest[level] / count for level in LEVELS)
    return (
        f"lumped contact {lumped:.4f} ms CPU a position, {lumped / pairs:.2f} of that of contact"
        f" pairs ({pairs:.4f})"
    )


def _large_run() -> list[str]:
    """1000 positions under ten torques on one and two threads, each a process of its own."""
    found = {}
    for threads in (1, 2):
        command = [sys.executable, "-m", "tests.benchmarks.sweep"]
        surroundings = {**os.environ, "OMP_NUM_THREADS": str(threads)}
        output = subprocess.run(command, env=surroundings, capture_output=True, check=True).stdout
        found[threads] = json.loads(output)
    count = found[1]["positions"]
    ratio = found[1]["short"] / found[2]["short"]
    return [
        *(
            f"{count} positions x 10 torques, {threads} thread(s): {numbers['seconds']:.2f} s,"
            f" {numbers['cpu']:.2f} s CPU, process at most {numbers['memory']:.0f} MB"
            f" (before the sweep {numbers['before']:.0f})"
            for threads, numbers in found.items()
        ),
        f"wanted <= {WANTED['seconds']} s on two threads, <= {WANTED['memory']:.0f} MB",
        f"two threads {ratio:.2f} x as fast as one, wanted >= {WANTED['threads']}",
    ]


def _measure_large_run() -> dict[str, float]:
    """Measured in this process; a tenth of the run, in a quiet moment, shows what threads do."""
    count = int(os.environ.get("FLANKLOAD_SWEEP_POSITIONS", "1000"))
    job = Job(fl.read_scene(SCENE))
    torques = list(np.linspace(0.2, 1.5, 10) * TORQUE)
    job.sweep(8, torques)
    before = _peak_MB()
    shortest, cpu = np.inf, np.inf
    for _ in range(3):
        start, start_cpu = time.perf_counter(), time.process_time()
        job.sweep(count, torques)
        shortest = min(shortest, time.perf_counter() - start)
        cpu = min(cpu, time.process_time() - start_cpu)
    short = np.inf
    for _ in range(30):
        start = time.perf_counter()
        job.sweep(count // 10, torques)
        short = min(short, time.perf_counter() - start)
    return {
        "positions": count,
        "short": short,
        "seconds": shortest,
        "cpu": cpu,
        "before": before,
        "memory": _peak_MB(),
    }


def _peak_MB() -> float:
    """Largest size of this process so far."""
    size = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return size / (1e6 if sys.platform == "darwin" else 1e3)


if __name__ == "__main__":
    print(json.dumps(_measure_large_run()))
