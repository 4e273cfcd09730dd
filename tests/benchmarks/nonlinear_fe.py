"""Flankload beside nonlinear finite-element contact (CalculiX) on the external pair, in one run.

CPU seconds of both, one thread each: a position where both have the same error of the pressure,
and the whole job of 8 positions, finite elements of flankload included. The pressure is measured
against Hertz where one pair carries all in the pitch point.
"""

from __future__ import annotations

import shutil
import time
from collections.abc import Iterator

import numpy as np

import flankload as fl
from flankload.contact.flank_contact import FlankContact
from flankload.contact.sweep import sweep
from flankload.elasticity.compliance import JobOptions, flank_compliance
from flankload.mechanisms.flank_pair.assembly import build_bodies
from flankload.scene.discretization import Grid
from flankload.scene.gear import Gear
from flankload.studies.verification.calculix import version_of
from tests.support.paths import SCENES

SCENE = SCENES / "external_gear.toml"
POSITIONS = 8
#: Elements on the half-width: decks from coarse to fine; the last one solves all positions.
ELEMENTS = (2.0, 4.0, 6.0)
#: Cells on the half-width: defaults of flankload and coarser.
STRIPS = (10.0, 5.0, 4.0)
#: Wanted: how many times less CPU time, per position and for the job.
WANTED = {"position": 10_000, "job": 200}


def scene_of_positions() -> fl.Scene:
    """The external pair at 8 positions over a pitch."""
    import tomllib

    tree = tomllib.loads(SCENE.read_text(encoding="utf-8"))
    tree["positions"] = {"count": POSITIONS}
    tree["accuracy"] = {"estimate": False}
    return fl.Scene.from_dict(tree)


def hertz_pressure(scene: fl.Scene) -> float:
    """Line contact of two involutes in the pitch point under the whole torque, MPa."""
    assert isinstance(scene.body_1, Gear)
    assert isinstance(scene.body_2, Gear)
    assert scene.body_1.pressure_angle_deg is not None
    assert scene.pair.axes_apart_mm is not None
    z_1, z_2 = scene.body_1.teeth, scene.body_2.teeth
    base = 0.5 * scene.body_1.module_mm * z_1 * np.cos(np.radians(scene.body_1.pressure_angle_deg))
    pitch = scene.pair.axes_apart_mm * z_1 / (z_1 + z_2)
    rolls = np.sqrt(pitch**2 - base**2) * np.array([1.0, z_2 / z_1])
    force = 1000.0 * scene.torques_Nm[0] / base / scene.pair.face_width_mm
    ratio, modulus = scene.body_1.poisson_ratio, scene.body_1.young_modulus_MPa
    give = 4 * (1 - ratio**2) / (np.pi * modulus)
    width = np.sqrt(2 * force * give / (1 / rolls).sum())
    return float(2 * force / (np.pi * width))


def flankload_positions(scene: fl.Scene, strips: float) -> tuple[float, float]:
    """CPU seconds of a position (of 256, warm), and the pressure in the pitch point, MPa."""
    pair = build_bodies(scene)
    compliances = tuple(
        flank_compliance(body, JobOptions(n_modes=5, plane="strain"))
        for body in (pair.body_1, pair.body_2)
    )
    position_rad = np.linspace(0.0, pair.pairing.period_rad, 256, endpoint=False)
    times = []
    for _ in range(4):
        start = time.process_time()
        (found,) = sweep(
            FlankContact(
                pair, (compliances[0], compliances[1]), Grid(strips_per_half_width=strips)
            ),
            position_rad,
            [1000.0 * scene.torques_Nm[0]],
        )
        times.append(time.process_time() - start)
    peak = float(found.site_peak_N_per_mm[0].max()) / scene.pair.face_width_mm
    return min(times) / position_rad.size, peak


def run() -> str:
    """Measure and return the table."""
    if shutil.which("ccx") is None:
        return "CalculiX is not there (apt install calculix-ccx): nothing to compare with"
    return "\n".join(_lines())


def _lines() -> Iterator[str]:
    scene = scene_of_positions()
    hertz = hertz_pressure(scene)
    yield f"CalculiX {version_of('ccx')}; Hertz in the pitch point {hertz:.1f} MPa"
    yield f"{'one position':34s}{'CPU s':>10s}{'MPa':>10s}{'error':>10s}"
    ours = []
    for strips in STRIPS:
        seconds, peak = flankload_positions(scene, strips)
        ours.append((seconds, abs(peak / hertz - 1)))
        yield _row(f"flankload, {strips:g} cells a half-width", seconds, peak, hertz)
    theirs = []
    for elements in ELEMENTS:
        found = fl.verify(scene, elements_per_half_width=elements)
        assert found.calculix is not None
        seconds, peak = found.calculix.cpu_s, float(found.calculix.pressure_MPa.max())
        theirs.append((seconds, abs(peak / hertz - 1)))
        yield _row(f"CalculiX, {elements:g} elements a half-width", seconds, peak, hertz)
    # each deck against the cheapest setting of flankload with no greater error
    ratios = [
        seconds / min((t for t, e in ours if e <= error), default=np.inf)
        for seconds, error in theirs
    ]
    listed = " / ".join(f"{ratio:.0f}" for ratio in ratios)
    yield f"times less CPU time at equal or smaller error {listed}   wanted {WANTED['position']}"
    yield from _job(scene)


def _row(what: str, seconds: float, peak: float, hertz: float) -> str:
    return f"{what:34s}{seconds:10.3g}{peak:10.1f}{100 * (peak / hertz - 1):+9.2f}%"


def _job(scene: fl.Scene) -> Iterator[str]:
    """All positions by both."""
    start = time.process_time()
    fl.solve(scene)
    ours = time.process_time() - start
    heads = zip(
        ("position", "CPU s", "rotation", "share", "pressure"), (8, 8, 11, 10, 22), strict=True
    )
    yield "".join(f"{head:>{width}s}" for head, width in heads)
    theirs = 0.0
    for k in range(POSITIONS):
        found = fl.verify(scene, position=k, elements_per_half_width=ELEMENTS[-1])
        assert found.calculix is not None
        theirs += found.calculix.cpu_s
        share = 100 * float(np.abs(found.share_difference).max())
        smooth = (found.site_force_N > 0) & ~found.corner_contact
        pressure = found.peak_pressure_MPa[smooth] / found.calculix.pressure_MPa[smooth] - 1
        worst = 100 * float(np.abs(pressure).max(initial=0.0))
        corner = "  on a sharp corner" if found.corner_contact.any() else ""
        yield (
            f"{k:8d}{found.calculix.cpu_s:8.1f}{100 * found.rotation_difference:+10.3f}%"
            f"{share:9.3f}%{worst:21.2f}%{corner}"
        )
    yield (
        f"job of {POSITIONS} positions: {ours:.3g} s against {theirs:.0f} s, "
        f"{theirs / ours:.0f} times less   wanted {WANTED['job']}"
    )
