"""Interface to CalculiX: find it, run it on a deck, read its output."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
from dataclasses import dataclass
from math import inf, isfinite
from time import monotonic, perf_counter
from typing import TYPE_CHECKING, Any

import numpy as np

from flankload.errors import OtherProgramError, reason_of

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from flankload.base.arrays import Floats
    from flankload.studies.verification.deck import Deck

#: Name of the job: deck.inp, deck.dat, deck.sta.
JOB = "deck"
#: Input and output files of CalculiX, and the log.
SUFFIXES = (".inp", ".dat", ".sta", ".frd", ".cvg", ".12d", ".log")
PACKAGE = "calculix-ccx"
#: Seconds between two readings of its progress.
POLL_S = 0.2
#: Headings of the forces of a contact pair.
TOTAL = "moment about the origin (mx,my,mz)"
NORMAL = "area,  normal force (+ = tension)"
STRESS_TITLE = "contact stress (slave element+face,press,tang1,tang2) for all contact elements"


@dataclass(frozen=True)
class Answer:
    """Solution of CalculiX; S pairs.

    Attributes
    ----------
    version : str
    rotation_rad : float
        Rotation of body 1.
    force_N_per_mm : (S,) array
        Normal force of each pair of the deck.
    moment_N : float
        Sum of their moments about O1 on the undeformed bodies, N mm/mm; equal to the torque except
        for the deformation.
    pressure_MPa : (S,) array
        Largest contact pressure at an integration point, NaN of solid bodies; with friction the
        largest median over a side's points, since single points near the ends of slid sides have
        large errors there.
    iterations : int
    cpu_s, wall_s : float
        NaN without a run.
    line_load_N_per_mm : (S, L) array or None
        Normal force of each pair in each layer of solid bodies, per mm of its width.
    """

    version: str
    rotation_rad: float
    force_N_per_mm: Floats
    moment_N: float
    pressure_MPa: Floats
    iterations: int
    cpu_s: float
    wall_s: float
    line_load_N_per_mm: Floats | None = None


def files_of_deck(folder: Path) -> tuple[Path, ...]:
    """Files that a run writes into a folder."""
    return tuple(folder / f"{JOB}{suffix}" for suffix in SUFFIXES)


def find_program(program: str, folder: Path) -> str:
    """Full path of a program by its name or path.

    Raises OtherProgramError if it is not found; the message names the package that contains it, and
    the folder of the deck.
    """
    found = shutil.which(program)
    if found is None:
        raise OtherProgramError(
            f"the program {program!r} of CalculiX is not there: apt install {PACKAGE} "
            "(Debian, Ubuntu), or see www.calculix.de",
            folder=folder,
        )
    return os.path.abspath(found)  # the program runs in another folder


def version_of(program: str) -> str:
    """Version of CalculiX from its own output; "unknown" if it prints none."""
    try:
        done = subprocess.run(
            [program, "-v"], capture_output=True, text=True, timeout=30.0, check=False
        )
    except (OSError, subprocess.TimeoutExpired):
        return "unknown"
    found = re.search(r"Version\s+(\S+)", done.stdout)
    return found.group(1) if found else "unknown"


def run_deck(
    program: str,
    folder: Path,
    deck: Deck,
    *,
    time_limit_s: float | None,
    on_iteration: Callable[[int], None] | None = None,
) -> Answer:
    """Run CalculiX on folder/deck.inp and read its solution; all its files stay in the folder.

    `on_iteration` is called with the number of finished iterations whenever it has changed.

    Raises OtherProgramError if it does not converge, does not end in time or writes no solution.
    """
    for old in files_of_deck(folder):
        if old.suffix != ".inp":
            old.unlink(missing_ok=True)
    wall, cpu = perf_counter(), _children_cpu_s()
    execute(program, folder, time_limit_s=time_limit_s, on_iteration=on_iteration)
    wall, cpu = perf_counter() - wall, _children_cpu_s() - cpu
    return read_answer(folder, deck, version=version_of(program), cpu_s=cpu, wall_s=wall)


def execute(
    program: str,
    folder: Path,
    *,
    time_limit_s: float | None,
    on_iteration: Callable[[int], None] | None = None,
) -> None:
    """Run CalculiX on folder/deck.inp to its end.

    Raises OtherProgramError if it does not converge or does not end in time.
    """
    log = folder / f"{JOB}.log"
    try:
        code = _run(program, folder, log, time_limit_s, on_iteration)
    except subprocess.TimeoutExpired:
        raise OtherProgramError(
            f"CalculiX did not end within {time_limit_s:g} s and was stopped", folder=folder
        ) from None
    except OSError as error:
        why = f"CalculiX could not be started: {reason_of(error)}"
        raise OtherProgramError(why, folder=folder) from None
    said = log.read_text(encoding="utf-8", errors="replace")
    if code != 0 or "Job finished" not in said:
        raise OtherProgramError(_why(code, said), folder=folder)


def read_answer(
    folder: Path,
    deck: Deck,
    *,
    version: str = "unknown",
    cpu_s: float = float("nan"),
    wall_s: float = float("nan"),
) -> Answer:
    """Read deck.dat and deck.sta of a successful run.

    Raises OtherProgramError if data are missing in them.
    """
    try:
        text = (folder / f"{JOB}.dat").read_text(encoding="utf-8", errors="replace")
        turned = _last_block(text, "displacements (vx,vy,vz) for set AXIS_1")
        rotation = deck.start_rad + float(turned.split()[1])
        if not isfinite(rotation):
            raise ValueError("the rotation is not a number")
        loads = _loads(text, deck)
        iterations = _iterations(folder / f"{JOB}.sta")
    except (OSError, LookupError, ValueError) as error:
        why = f"the output of CalculiX cannot be read: {error}"
        raise OtherProgramError(why, folder=folder) from None
    counted: dict[str, Any] = {"iterations": iterations, "cpu_s": cpu_s, "wall_s": wall_s}
    return Answer(version=version, rotation_rad=rotation, **loads, **counted)


def _run(
    program: str,
    folder: Path,
    log: Path,
    time_limit_s: float | None,
    on_iteration: Callable[[int], None] | None,
) -> int:
    """Exit code of CalculiX, which is stopped if this call ends by an exception."""
    end = inf if time_limit_s is None else monotonic() + time_limit_s
    done = 0
    environment = {"OMP_NUM_THREADS": "1", **os.environ}
    with log.open("w", encoding="utf-8") as out:
        streams: dict[str, Any] = {"stdin": subprocess.DEVNULL, "stdout": out, "stderr": out}
        process = subprocess.Popen([program, "-i", JOB], cwd=folder, env=environment, **streams)
        try:
            while True:
                try:
                    return process.wait(min(POLL_S, max(0.0, end - monotonic())))
                except subprocess.TimeoutExpired:
                    if monotonic() >= end:
                        raise
                if on_iteration is not None and (now := _finished(folder)) > done:
                    on_iteration(done := now)
        finally:
            process.kill()
            process.wait()


def _finished(folder: Path) -> int:
    """Number of finished iterations: lines of deck.cvg after its heads."""
    try:
        text = (folder / f"{JOB}.cvg").read_text(encoding="utf-8", errors="replace")
    except FileNotFoundError:
        return 0
    # step, increment, attempt, iteration, contact elements, ...
    rows = (line.split()[:5] for line in text.splitlines())
    return sum(len(row) == 5 and all(word.isdigit() for word in row) for row in rows)


def _children_cpu_s() -> float:
    times = os.times()
    return times.children_user + times.children_system


def _why(code: int, said: str) -> str:
    """Last error message of a failed run."""
    if "increment size smaller than minimum" in said or "too many cutbacks" in said:
        return "CalculiX did not converge"
    complaints = re.findall(r"\*ERROR[^\n]*(?:\n +[^\s*][^\n]*)?", said)
    last = " ".join(complaints[-1].split()) if complaints else "no message"
    return f"CalculiX ended without an answer (exit code {code}): {last}"


def _last_block(text: str, title: str) -> str:
    """Lines under the last heading of this title, without the empty ones around them."""
    found = list(re.finditer(rf"^ *{re.escape(title)} and time +\S+ *$", text, re.MULTILINE))
    if not found:
        raise LookupError(f"no lines {title!r} in {JOB}.dat")
    return re.split(r"\n\s*\n", text[found[-1].end() :].lstrip("\n "), maxsplit=1)[0]


def _loads(text: str, deck: Deck) -> dict[str, Any]:
    """Loads of `Answer` from the output; those of solid bodies are summed over the layers."""
    forces, moments = np.zeros((2, len(deck.sites), deck.layers))
    for place, (slave, master) in zip(np.ndindex(forces.shape), deck.contacts(), strict=True):
        block = _statistics(text, slave, master)
        total = _numbers_after(block, TOTAL, 6) if block else [0.0] * 6
        if deck.plane:
            force = -_numbers_after(block, NORMAL, 2)[1] if block else 0.0
        else:
            force = float(np.linalg.norm(total[:3]))
        if force > 0:
            forces[place], moments[place] = force, abs(total[5])
    loads = {
        "force_N_per_mm": forces.sum(axis=1) / deck.width_mm,
        "moment_N": float(moments.sum()) / deck.width_mm,
    }
    if deck.edges_mm is None:
        return {**loads, "pressure_MPa": _pressures(_last_block(text, STRESS_TITLE), deck)}
    nothing = np.full(len(deck.sites), np.nan)
    line_load = forces / np.diff(deck.edges_mm)
    return {**loads, "pressure_MPa": nothing, "line_load_N_per_mm": line_load}


def _statistics(text: str, slave: str, master: str) -> str:
    """Last lines on the forces of a contact pair; empty without contact."""
    title = rf"statistics for slave set {slave}, master set {master} and time"
    found = list(re.finditer(title, text))
    return text[found[-1].end() :] if found else ""


def _numbers_after(block: str, heading: str, count: int) -> list[float]:
    """The first numbers under a heading."""
    lines = block[block.index(heading) :].splitlines()[1:]
    return [float(x) for x in next(line for line in lines if line.strip()).split()[:count]]


def _pressures(stress: str, deck: Deck) -> Floats:
    """Largest pressure of each pair."""
    rows = np.array([[float(x) for x in line.split()[:3]] for line in stress.splitlines()])
    of_side = np.max if deck.friction is None else np.median
    found = []
    for faces in deck.parts[0].flanks:
        elements = np.intersect1d(rows[:, 0], faces[:, 0] + 1)
        pressures = (of_side(rows[rows[:, 0] == element, 2]) for element in elements)
        found.append(max(pressures, default=0.0))
    return np.array(found)


def _iterations(path: Path) -> int:
    """Sum of the fourth column of deck.sta."""
    lines = path.read_text(encoding="utf-8", errors="replace").splitlines()[2:]
    return sum(int(line.split()[3]) for line in lines if len(line.split()) >= 4)
