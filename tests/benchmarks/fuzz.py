"""Trials at random: contact problems, scenes, mesh files, writes and interrupts, a line for each.

`--seed` draws others, `--part` takes so many of them: 0.02 runs about a minute.
"""

from __future__ import annotations

from collections.abc import Iterator

from tests.support.tally import Tally

#: Of a whole run.
CONTACT_PROBLEMS, SCENES, SPATIAL_SCENES, MESHES = 30_000, 3250, 500, 520
WRITES, INTERRUPTS = 600, 100


def run(seed: int = 1, part: float = 1.0) -> str:
    """Tried, wrong, silent and tracebacks of each kind, with the first faults.

    Parameters
    ----------
    seed : int
    part : float
        Of the trials of a whole run, at least one of each kind.
    """
    lines = []
    for tally in _tallies(seed, part):
        print(tally, flush=True)
        lines.append(tally)
    faults = sum(tally.wrong + tally.silent + tally.traceback for tally in lines)
    return f"{sum(tally.tried for tally in lines)} tried, {faults} faults"


def _tallies(seed: int, part: float) -> Iterator[Tally]:
    from tests.benchmarks._fuzz_meshes import fuzz_meshes
    from tests.benchmarks._fuzz_scenes import fuzz_scenes
    from tests.benchmarks._fuzz_spatial import fuzz_spatial
    from tests.benchmarks._fuzz_writes import fuzz_interrupts, fuzz_writes
    from tests.support.contact_fuzz import fuzz_contact

    for fuzz, count in (
        (fuzz_contact, CONTACT_PROBLEMS),
        (fuzz_scenes, SCENES),
        (fuzz_spatial, SPATIAL_SCENES),
        (fuzz_meshes, MESHES),
        (fuzz_writes, WRITES),
        (fuzz_interrupts, INTERRUPTS),
    ):
        yield fuzz(seed, max(1, round(part * count)))
