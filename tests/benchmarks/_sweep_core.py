"""Core times of a position by stages, from the compiled bench (tests/fortran/bench_sweep.f90)."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flankload.contact.body_record import records_of
from flankload.scene.discretization import Grid
from tests.benchmarks._core import BUILD
from tests.support.pair_job import Job

TARGET = "tests/fortran/bench_sweep"


@dataclass(frozen=True)
class StageTimes:
    """Shortest times of a position, ms.

    Attributes
    ----------
    pairs, active : float
        Pairs, and how many are in contact, on average.
    zones, lumped, cells, influence, loop, whole : float
        The stages, and all of them in the one call of a sweep.
    cold, known, trusted : float
        The loop begun cold; with the very pairs of its state; without the proof of uniqueness.
    """

    pairs: float
    active: float
    zones: float
    lumped: float
    cells: float
    influence: float
    loop: float
    whole: float
    cold: float
    known: float
    trusted: float


def stage_times(
    job: Job, *, count: int, torque_Nmm: float, grids: Sequence[Grid]
) -> list[StageTimes]:
    """Build the compiled bench and let it take the positions with every grid."""
    ninja = Path(sys.executable).parent / "ninja"
    subprocess.run([ninja, "-C", BUILD, TARGET], check=True, capture_output=True)
    with TemporaryDirectory() as folder:
        paths = [Path(folder) / str(i) for i in range(len(grids))]
        for path, grid in zip(paths, grids, strict=True):
            path.write_bytes(_numbers(job, count, torque_Nmm, grid).tobytes())
        output = subprocess.run(
            [BUILD / TARGET, *paths], check=True, capture_output=True, text=True
        ).stdout
    return [StageTimes(*map(float, line.split())) for line in output.splitlines()]


def _numbers(job: Job, count: int, torque_Nmm: float, grid: Grid) -> NDArray[np.float64]:
    """A sweep as the compiled bench reads it: real numbers alone."""
    pair = job.bodies
    parts: list[Any] = [[count, torque_Nmm], *pair.pairing.turns(job.positions(count))]
    for record in records_of(job.contact(grid)):
        parts += [[record.size], record]
    return np.concatenate([np.ravel(part) for part in parts]).astype(float)
