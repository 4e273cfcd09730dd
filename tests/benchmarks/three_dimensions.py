"""Three-dimensional bodies and slices beside the plane run of the same scene.

CPU seconds of one process on one thread, the shortest of several runs; ratios hold in one run only.
"""

from __future__ import annotations

import subprocess
import sys
import time
import tomllib
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

import flankload as fl
from flankload.contact.flank_contact import FlankContact
from flankload.contact.sweep import Sweep, sweep
from flankload.cost import held_bytes
from flankload.elasticity.compliance import BodyCompliance
from flankload.mechanisms.elements import compliance_of
from flankload.mechanisms.flank_pair.assembly import build_bodies
from tests.support.paths import SCENES

#: Positions at which two pairs of the spur scene carry: about half a pitch of 22.5 degrees, deg.
TWO_PAIRS = np.linspace(10.0, 13.0, 32)
#: Runs of which the shortest counts.
RUNS = 3
PLANE = {"effects": {"contact": "lumped"}}
SPATIAL = {"effects": {"dimension": 3}}
#: Elements of half a module, and few modes along the axis.
COARSE: dict[str, dict[str, Any]] = {
    "effects": {"dimension": 3},
    "accuracy": {"flank_element_mm": 2.25, "modes": 3, "axial_degree": 6, "load_degree_z": 2},
}
COARSE_HELICAL = {"accuracy": {**COARSE["accuracy"], "flank_element_mm": 1.5}}
#: Rows: example, changes; ratios refer to the first one.
CASES: dict[str, tuple[str, dict[str, dict[str, Any]]]] = {
    "spur, plane": ("external_gear", PLANE),
    "spur, coarse": ("external_gear", COARSE),
    "spur, default": ("external_gear", SPATIAL),
    "helical, coarse": ("helical_gear", COARSE_HELICAL),
    "helical, default": ("helical_gear", {}),
}


@dataclass(frozen=True)
class Measured:
    """CPU seconds of both bodies and per position, largest number of loaded places, megabytes."""

    bodies_s: float
    position_s: float
    places: int
    held_mb: float
    peak_mb: float


def scene_of(name: str) -> fl.Scene:
    """Scene of a case."""
    example, changes = CASES[name]
    tree = tomllib.loads((SCENES / f"{example}.toml").read_text(encoding="utf-8"))
    for table, keys in changes.items():
        tree[table] = {**tree.get(table, {}), **keys}
    return fl.Scene.from_dict(tree)


def shortest(call: Callable[[], Any]) -> tuple[float, Any]:
    """CPU seconds of the shortest of several calls, and its result."""
    least, found = np.inf, None
    for _ in range(RUNS):
        start = time.process_time()
        found = call()
        least = min(least, time.process_time() - start)
    return float(least), found


def peak_mb(name: str) -> float:
    """Largest memory of a process that solves the scene once, without the estimate, MB."""
    program = (
        "import resource, sys\n"
        "from tests.benchmarks.three_dimensions import scene_of\n"
        "from flankload.mechanisms.flank_pair.assembly import build_bodies\n"
        "from flankload.mechanisms.elements import compliance_of\n"
        "scene = scene_of(sys.argv[1])\n"
        "pair = build_bodies(scene)\n"
        "both = [compliance_of(body, scene) for body in (pair.body_1, pair.body_2)]\n"
        "print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024)\n"
    )
    command = [sys.executable, "-c", program, name]
    return float(subprocess.run(command, capture_output=True, check=True).stdout)


def measured(name: str) -> Measured:
    """Measure a case."""
    scene = scene_of(name)
    pair = build_bodies(scene)

    def bodies() -> tuple[BodyCompliance, BodyCompliance]:
        return compliance_of(pair.body_1, scene), compliance_of(pair.body_2, scene)

    def positions() -> Sweep:
        (found,) = sweep(
            FlankContact(pair, compliances, pair.discretization.grid, "lumped"),
            np.radians(TWO_PAIRS),
            [1000.0 * scene.torques_Nm[0]],
            keep_pairs=False,
            watched=False,
        )
        return found

    of_bodies, compliances = shortest(bodies)
    of_positions, found = shortest(positions)
    force = found.site_force_N if found.slices is None else found.slices.force_N
    return Measured(
        of_bodies,
        of_positions / TWO_PAIRS.size,
        int((force > 0).reshape(TWO_PAIRS.size, -1).sum(axis=1).max()),
        sum(held_bytes(compliance) for compliance in compliances) / 1e6,
        peak_mb(name),
    )


def run() -> str:
    """Measure and return the table."""
    first = f"{'':18}{'both bodies':>20}{'position':>22}{'loaded':>9}{'held':>9}{'peak':>9}"
    units = f"{'CPU s':>12}{'ratio':>8}{'CPU ms':>14}{'ratio':>8}{'places':>9}{'MB':>9}{'MB':>9}"
    lines = [first, f"{'':18}{units}"]
    plane = measured("spur, plane")
    for name in CASES:
        found = plane if name == "spur, plane" else measured(name)
        lines.append(
            f"{name:18}{found.bodies_s:12.2f}{found.bodies_s / plane.bodies_s:8.1f}"
            f"{1000.0 * found.position_s:14.3f}{found.position_s / plane.position_s:8.1f}"
            f"{found.places:9d}{found.held_mb:9.2f}{found.peak_mb:9.0f}"
        )
    lines.append("ratios: to the plane run of the spur scene with lumped contact; one thread")
    return "\n".join(lines)
