"""Planetary stages: time of a state in the core, and of runs around it.

Four planets in the plane, then three helical ones with six meshes in 14 slices.

CPU seconds of one thread, least of several runs, without error estimates.
"""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from time import process_time

import numpy as np
from threadpoolctl import threadpool_limits

import flankload as fl
from flankload.contact.meshes_contact import sweep_meshes
from flankload.mechanisms.stage.assembly import assemble
from flankload.mechanisms.stage.mechanism import MECHANISM
from flankload.mechanisms.stage_clock import StageClock
from tests.support.paths import SCENES

#: Wanted, ms: a state with lumped contact, and with cells; 48 prepared positions; three bodies; a
#: design with other errors of pins in a simulation (10⁴ of them in a minute).
WANTED = {"lumped": 0.2, "pairs": 3.0, "prepared": 15.0, "bodies": 300.0, "design": 6.0}
#: Of the helical stage: a position, and 24 prepared ones.
WANTED_OF_WIDTH, POSITIONS_OF_WIDTH = {"lumped": 5.0, "prepared": 300.0}, 24
DESIGNS = 200
POSITIONS, TIMES, FACTOR = 48, 3, "mesh_load_factor_max"
QUIET = {"accuracy.estimate": False, "positions.count": POSITIONS}


def run() -> str:
    """Measure and return the table."""
    with threadpool_limits(limits=1):
        return "\n".join(_lines())


def _lines() -> list[str]:
    scene = fl.read_scene(SCENES / "planetary_stage.toml").replace(QUIET)
    fl.solve(scene.replace({"effects.contact": "lumped"}))  # imports
    lines = [f"{'':>36}{'ms':>9}{'wanted':>9}"]
    for level in ("lumped", "pairs"):
        own = scene.replace({"effects.contact": level})
        clock = StageClock(None, MECHANISM.body_names, 1, {})
        assembly, compliances = MECHANISM.compliances(own, assemble(own), clock, {})
        contact = assembly.contact(own, compliances)
        for torques in (own.torques_Nmm, tuple(np.linspace(300e3, 600e3, 5))):
            seconds = _least(partial(sweep_meshes, contact, assembly.position_rad, torques))
            words = f"{level}, a state of {len(torques)} torque(s)"
            lines.append(_row(words, seconds / (POSITIONS * len(torques)), WANTED[level]))
    lumped = scene.replace({"effects.contact": "lumped"})
    prepared = fl.prepare(lumped)
    prepared.solve()
    errors = iter(range(1, 100))
    key = "stage.pin_tangential_errors_um"
    changed = _least(lambda: prepared.solve({key: [next(errors), 0, 0, 0]}))
    lines.append(_row(f"{POSITIONS} positions, prepared", changed, WANTED["prepared"]))
    lines.append(_row("a design of 48 positions, other pins", _design_s(lumped), WANTED["design"]))

    def bodies() -> None:
        clock = StageClock(None, MECHANISM.body_names, 1, {})
        MECHANISM.compliances(lumped, assemble(lumped), clock, {})

    lines.append(_row("three bodies", _least(bodies), WANTED["bodies"]))
    return [*lines, *_of_width()]


def _of_width() -> list[str]:
    """Rows of the helical stage."""
    quiet = {"accuracy.estimate": False, "positions.count": POSITIONS_OF_WIDTH}
    scene = fl.read_scene(SCENES / "helical_stage.toml").replace(quiet)
    clock = StageClock(None, MECHANISM.body_names, 1, {})
    assembly, compliances = MECHANISM.compliances(scene, assemble(scene), clock, {})
    contact = assembly.contact(scene, compliances)
    seconds = _least(partial(sweep_meshes, contact, assembly.position_rad, scene.torques_Nmm))
    state = _row("helical, a state", seconds / POSITIONS_OF_WIDTH, WANTED_OF_WIDTH["lumped"])
    prepared = fl.prepare(scene)
    prepared.solve()
    slopes = iter(range(1, 100))
    changed = _least(lambda: prepared.solve({"planet.helix_slope_um": float(next(slopes))}))
    words = f"helical, {POSITIONS_OF_WIDTH} positions, prepared"
    return [state, _row(words, changed, WANTED_OF_WIDTH["prepared"])]


def _design_s(scene: fl.Scene) -> float:
    """CPU seconds of a design of a simulation, beyond those of a shorter one."""
    scatter = {"distribution": "normal", "mean": 0, "standard_deviation": 4}
    pins = {f"stage.pin_tangential_errors_um[{j}]": scatter for j in range(4)}

    def simulate(n: int) -> None:
        with ThreadPoolExecutor(1) as pool:
            fl.study(scene, pins, "random", n=n, quantities=[FACTOR], executor=pool)

    few, many = (_least(partial(simulate, n)) for n in (2, 2 + DESIGNS))
    return (many - few) / DESIGNS


def _row(words: str, seconds: float, wanted_ms: float) -> str:
    return f"{words:>36}{1e3 * seconds:>9.3g}{wanted_ms:>9.3g}"


def _least(work: Callable[[], object]) -> float:
    """Least CPU seconds of several runs."""
    spent = []
    for _ in range(TIMES):
        begin = process_time()
        work()
        spent.append(process_time() - begin)
    return min(spent)
