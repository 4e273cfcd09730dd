"""Predictions of the plan compared with runs: sizes of effects, seconds, on every example.

A size is measured by two runs of the example as it is, seconds by the shortest of three (of
long ones by the first) in a process that has loaded its packages, extra seconds by the difference
of two such. Ratios are predicted over measured. The part that a plan is of its run is measured in a
process of its own for each example, by medians of three.
"""

from __future__ import annotations

import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from statistics import median

import numpy as np
from msgspec import structs

import flankload as fl
from flankload.errors import FlankloadError
from flankload.mechanisms.effect_size import States, size_of
from flankload.mechanisms.toggles import toggled
from flankload.scene.pair import Positions
from flankload.studies.plan import Plan, PlannedEffect, Size
from flankload.studies.plan.choice import without_choice
from tests.support.paths import SCENES

#: Wanted: factor between predicted and measured, of sizes and of what an effect adds; of the
#: seconds of a run; a plan's part of the run that it predicts, in one process.
FACTOR, RUN_FACTOR, PLAN_PART = 2.0, 1.5, 0.5
#: Sizes below this part of the tolerance are said to be nothing, whatever their factor.
NOTHING = 0.05
#: Extra seconds below this are lost in the noise of two runs.
SHORT_S = 0.05
RUNS, LONG_S = 3, 1.0


def run() -> str:
    """Measure and return the tables."""
    lines = [_head()]
    off: list[str] = []
    for path in sorted(SCENES.glob("*.toml")):
        scene = fl.read_scene(path)
        plan_s, run_s = _plan_and_run(path)
        part = plan_s / run_s
        if part > PLAN_PART:
            off.append(f"off: {path.stem}, the plan: {part:.2f} of the run")
        spent = _plan_seconds(path)
        seconds = f"the plan {plan_s:.3f} s, the run {run_s:.3f} s, ratio {part:.2f}"
        lines += ["", f"{path.stem}: {seconds}, the command {spent:.2f} CPU s"]
        lines += _of(scene, fl.plan(scene, levels=True), off, path.stem)
    wanted = f"wanted: every factor below {FACTOR:g}, of a run below {RUN_FACTOR:g}"
    wanted += f", plans below {PLAN_PART:g} of the run"
    return "\n".join([*lines, "", wanted, *(off or ["all factors are as wanted"])])


def _head() -> str:
    return (
        f"{'':<28}{'rotation at most':>20}{'load share':>22}{'':>8}{'seconds':>18}\n"
        f"{'effect':<28}{'predicted':>10}{'measured':>10}{'predicted':>12}{'measured':>10}"
        f"{'factor':>8}{'predicted':>10}{'measured':>10}{'factor':>8}"
    )


def _of(scene: fl.Scene, plan: Plan, off: list[str], name: str) -> list[str]:
    plain = without_choice(scene)
    base, spent = _solved(plain)
    lines = []
    factor = plan.seconds / spent
    if not 1 / RUN_FACTOR <= factor <= RUN_FACTOR:
        off.append(f"off: {name}, seconds: {factor:.2f}")
    lines.append(f"{'the run':<28}{'':>60}{plan.seconds:10.3f}{spent:10.3f}{factor:8.2f}")
    unloaded, _ = _solved(
        replace(plain, load=structs.replace(plain.load, torque_Nm=0.0)), once=True
    )
    for effect in plan.effects:
        if effect.size is None:
            if effect.unknown is not None:
                lines.append(f"{effect.title:<28} {effect.unknown}"[:150])
            continue
        toggle = toggled(plain, effect.name, on=effect.on)
        assert toggle is not None
        assert toggle.scene is not None
        degrees = tuple(float(angle) for angle in np.degrees(base[0].position_rad))
        positions = Positions(angles_deg=degrees, driver=scene.positions.driver)
        try:
            other, seconds = _solved(replace(toggle.scene, positions=positions))
        except FlankloadError as error:
            lines.append(f"{effect.title:<28} {error}")
            continue
        pair = (_states(base), _states(other))
        measured = size_of(
            *(pair if effect.on else pair[::-1]),
            base=_states(base),
            unloaded_rad=unloaded[0].rotation_rad,
            reference_radius_mm=base[0].reference_radius_mm,
        )
        extra = spent - seconds if effect.on else seconds - spent
        lines.append(_row(effect, measured, extra, scene.accuracy.tolerance, off, name))
    return lines


def _row(
    effect: PlannedEffect, measured: Size, extra: float, tolerance: float, off: list[str], name: str
) -> str:
    predicted = effect.size
    assert predicted is not None
    factor = predicted.largest / measured.largest if measured.largest > 0 else np.nan
    small = max(predicted.largest, measured.largest) < NOTHING * tolerance
    if not small and not 1 / FACTOR <= factor <= FACTOR:
        off.append(f"off: {name}, {effect.title}: {factor:.2f}")
    parts = [
        f"{effect.title:<28}",
        f"{100 * (predicted.rotation_largest or 0):9.3f}%",
        f"{100 * (measured.rotation_largest or 0):9.3f}%",
        f"{100 * predicted.load_share:11.3f}%{100 * measured.load_share:9.3f}%",
        f"{'nothing' if small else f'{factor:.2f}':>8}",
        f"{effect.extra_s or 0.0:10.3f}{extra:10.3f}{_factor_of_seconds(effect, extra, off, name)}",
    ]
    return "".join(parts)


def _factor_of_seconds(effect: PlannedEffect, extra: float, off: list[str], name: str) -> str:
    """Predicted over measured extra seconds; nothing where both are short."""
    predicted = effect.extra_s or 0.0
    if max(abs(predicted), abs(extra)) < SHORT_S:
        return f"{'short':>8}"
    factor = predicted / extra
    if not 1 / FACTOR <= factor <= FACTOR:
        off.append(f"off: {name}, {effect.title}, extra seconds: {factor:.2f}")
    return f"{factor:8.2f}"


def _solved(scene: fl.Scene, *, once: bool = False) -> tuple[tuple[fl.Result, ...], float]:
    """Results and CPU seconds of the stages."""
    shortest = np.inf
    for _ in range(1 if once else RUNS):
        start = time.process_time()
        found = fl.solve(scene)
        shortest = min(shortest, time.process_time() - start)
        if shortest > LONG_S:
            break
    return found.by_torque, shortest


def _states(results: tuple[fl.Result, ...]) -> list[States]:
    """States of the smallest and the largest torque, as the plan uses them."""
    loaded = [result for result in results if result.torque_Nm > 0]
    ends = {id(result): result for result in (loaded[0], loaded[-1])}
    return [
        States.of(result.torque_Nm, result.sites, result.rotation_rad, result.site_force_N)
        for result in ends.values()
    ]


def print_seconds(path: str) -> None:
    """Print CPU seconds of the plan and of the run: medians of several in turns, after one each."""
    scene = fl.read_scene(path)
    spent: dict[Callable[[fl.Scene], object], list[float]] = {fl.plan: [], fl.solve: []}
    for number in range(1 + RUNS):
        for work, seconds in spent.items():
            start = time.process_time()
            work(scene)
            if number:
                seconds.append(time.process_time() - start)
    print(*map(median, spent.values()))


def _plan_and_run(path: Path) -> tuple[float, float]:
    """CPU seconds of the plan and of the run in a process of their own."""
    code = f"from tests.benchmarks.plan import print_seconds; print_seconds({str(path)!r})"
    ran = subprocess.run([sys.executable, "-c", code], capture_output=True, check=True, text=True)
    plan_s, run_s = map(float, ran.stdout.split())
    return plan_s, run_s


def _plan_seconds(path: Path) -> float:
    """CPU seconds of the command, packages and all."""
    code = (
        "import sys, time, flankload.cli as cli\n"
        f"cli.main(['plan', {str(path)!r}])\n"
        "print(time.process_time(), file=sys.stderr)"
    )
    ran = subprocess.run([sys.executable, "-c", code], capture_output=True, check=True, text=True)
    return float(ran.stderr.split()[-1])
