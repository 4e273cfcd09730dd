"""The main job: finite elements of both gears, milliseconds per position, import, the whole demo.

Best of several runs in CPU seconds of one process, one thread; the wanted numbers stand beside.
"""

from __future__ import annotations

import os
import resource
import subprocess
import sys
import time
from collections.abc import Callable

import numpy as np

import flankload as fl
from flankload.contact.flank_contact import FlankContact
from flankload.contact.sweep import Sweep, sweep
from flankload.elasticity.compliance import JobOptions, flank_compliance
from flankload.mechanisms.flank_pair.assembly import build_bodies
from tests.support.paths import SCENES

SCENE = SCENES / "external_gear.toml"
#: Wanted, seconds: both gears' elements, a position, the import over numpy, the demo.
WANTED = {"elements": 1.0, "position": 1e-3, "import": 0.3, "demo": 20.0}


def best(call: Callable[[], object], runs: int, clock: Callable[[], float]) -> float:
    """Shortest of several runs, s."""
    shortest = np.inf
    for _ in range(runs):
        start = clock()
        call()
        shortest = min(shortest, clock() - start)
    return shortest


def import_seconds() -> float:
    """Shortest time of `import flankload` where numpy is there already, fresh interpreters, s."""
    program = (
        "import numpy, time\n"
        "t = time.perf_counter()\n"
        "import flankload\n"
        "flankload.solve_contact\n"
        "print(time.perf_counter() - t)"
    )
    command = [sys.executable, "-c", program]
    return min(
        float(subprocess.run(command, capture_output=True, check=True).stdout) for _ in range(5)
    )


def cpu_of_children() -> float:
    """CPU seconds of the processes that have ended."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def run() -> str:
    """Measure and return the table."""
    scene = fl.read_scene(SCENE)
    pair = build_bodies(scene)
    bodies = (pair.body_1, pair.body_2)

    def elements() -> list:
        return [flank_compliance(body, JobOptions(n_modes=5, plane="strain")) for body in bodies]

    first = time.process_time()
    compliances = elements()
    first = time.process_time() - first
    again = best(elements, 5, time.process_time)
    position_rad = np.linspace(0.0, pair.pairing.pitch_rad, 256, endpoint=False)

    def positions() -> Sweep:
        (found,) = sweep(
            FlankContact(pair, (compliances[0], compliances[1]), pair.discretization.grid),
            position_rad,
            [302e3],
        )
        return found

    found = positions()
    each = best(positions, 5, time.process_time) / position_rad.size
    demo = best(
        lambda: subprocess.run(
            [sys.executable, "-m", "flankload", "run", str(SCENE), "--quiet"],
            stdout=subprocess.DEVNULL,
            check=True,
        ),
        3,
        cpu_of_children,
    )
    threads = os.environ.get("OMP_NUM_THREADS", "as many as there are cores,")
    rows = (
        ("elements of both gears, first time", first, "elements"),
        ("elements of both gears, again", again, "elements"),
        (f"a position of {found.n_pairs.mean():.0f} pairs, {threads} thread(s)", each, "position"),
        ("import flankload and its contact loop, over numpy", import_seconds(), "import"),
        ("flankload run on the example, CPU of the process", demo, "demo"),
    )
    return "\n".join(
        f"{what:70s} {1000 * seconds:9.2f} ms   wanted <= {1000 * WANTED[key]:7.0f} ms"
        for what, seconds, key in rows
    )
