"""One run of a study, in any thread or process: the numbers that its row holds."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, field, replace
from math import isfinite
from threading import Event, Lock
from time import perf_counter
from typing import TYPE_CHECKING, Any

from flankload.base.blas_threads import one_blas_thread
from flankload.base.plain import plain
from flankload.errors import FlankloadError
from flankload.mechanisms import Parts
from flankload.mechanisms.displaced import run_displaced
from flankload.result.quantities import curves_of
from flankload.studies.prepared import solve_scene

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flankload.result import Result
    from flankload.scene import Scene

#: States of a row: solved; no solution or a scene that is refused; stopped by an error that has
#: nothing to do with the design, such as memory, and solved again when the study is resumed.
SOLVED, FAILED, ABORTED = "solved", "failed", "aborted"
#: Studies whose bodies and compliances a process holds.
MOST_HELD = 2

_held: OrderedDict[bytes, Parts] = OrderedDict()
_lock = Lock()


class StoppedError(Exception):
    """Raised in the middle of a run when the study is interrupted."""


@dataclass(frozen=True)
class Task:
    """A run to be done; small, since it is sent to the worker.

    `study` is the digest of the scene that all designs change: parts are shared within it. The
    scene has an absolute path of its file, `names` are the wanted quantities, and `whole` says
    whether the whole summary is kept beside them, since others may be wanted later.
    """

    study: bytes
    scene: Scene
    names: tuple[str, ...]
    whole: bool = True


@dataclass(frozen=True)
class Outcome:
    """Stored outcome of a run: "solved", "failed" or "aborted", its seconds, reason of a failure.

    `results` has for each torque `torque_Nm`, `quantities` (the summary, and curves that were
    wanted) and `estimate` (estimated relative errors); `unknown` are wanted quantities that the
    result lacks.
    """

    status: str
    seconds: float = 0.0
    error: str | None = None
    results: tuple[dict[str, Any], ...] = ()
    unknown: tuple[str, ...] = field(default=(), compare=False)


def run_tasks(tasks: Sequence[Task], stopped: Event | None = None) -> list[Outcome]:
    """Solve designs, several of them together if they differ by known displacements only."""
    if len(tasks) > 1 and not (stopped is not None and stopped.is_set()):
        began = perf_counter()
        with suppress(FlankloadError), one_blas_thread():  # with an error, one by one
            found = run_displaced([task.scene for task in tasks], _parts_of(tasks[0].study))
            together = zip(found, tasks, strict=True)
            outcomes = [_outcome_of(results, task) for results, task in together]
            seconds = (perf_counter() - began) / len(tasks)
            return [replace(one, seconds=seconds) for one in outcomes]
    return [run_task(task, stopped) for task in tasks]


def run_task(task: Task, stopped: Event | None = None) -> Outcome:
    """Solve a design; an error of any kind is an outcome. The event ends the run soon after."""

    def watch(*_: object) -> None:
        if stopped is not None and stopped.is_set():
            raise StoppedError

    began = perf_counter()
    try:
        watch()
        with one_blas_thread():  # its number of threads changes bits, and workers share processors
            found = solve_scene(task.scene, watch, _parts_of(task.study))
        outcome = _outcome_of(found.by_torque, task)
    except StoppedError:
        raise
    except FlankloadError as error:
        return Outcome(FAILED, perf_counter() - began, str(error))
    except Exception as error:
        text = f"{type(error).__name__}: {error}"
        return Outcome(ABORTED, perf_counter() - began, text)
    return replace(outcome, seconds=perf_counter() - began)


def _outcome_of(results: Sequence[Result], task: Task) -> Outcome:
    """Stored part of the results of a design, one per torque."""
    rows = tuple(row_of(one, task.names, whole=task.whole) for one in results)
    known = {name for row in rows for name in row["quantities"]}
    for row in rows:  # a missing quantity is stored as such, so that it is not searched for again
        row["quantities"] |= {n: None for n in task.names if n not in row["quantities"]}
    unknown = tuple(name for name in task.names if name not in known)
    return Outcome(SOLVED, results=rows, unknown=unknown)


def release(study: bytes) -> None:
    """Drop the parts that this process holds for a study."""
    with _lock:
        _held.pop(study, None)


def _parts_of(study: bytes) -> Parts:
    """Bodies and compliances that the runs of a study share in this process."""
    with _lock:
        parts = _held.setdefault(study, Parts())
        _held.move_to_end(study)
        while len(_held) > MOST_HELD:
            _held.popitem(last=False)
    return parts


def row_of(result: Result, names: tuple[str, ...], *, whole: bool = True) -> dict[str, Any]:
    """Plain numbers of a result: an entry of `Outcome.results`.

    The names are those of curves that are wanted in addition to the summary; `whole` is False if
    its key figures suffice, unless a name is none of them.
    """
    curves = curves_of(result)
    known = result.key_figures.keys() | curves.keys()
    quantities = _flat(result.summary if whole or set(names) - known else result.key_figures)
    found = {name: getattr(*curves[name][:2]) for name in names if name in curves}
    found = {name: values for name, values in found.items() if values is not None}
    if found:
        found["position_rad"] = result.position_rad
    quantities |= {name: plain(values) for name, values in found.items()}
    errors = {
        name: value
        for name, value in (result.estimate or {}).items()
        if isinstance(value, float) and isfinite(value)
    }
    return {"torque_Nm": result.torque_Nm, "quantities": quantities, "estimate": errors}


def _flat(tree: Mapping[str, Any], before: str = "") -> dict[str, Any]:
    """Entries of a summary by dotted name."""
    found: dict[str, Any] = {}
    for name, value in tree.items():
        if isinstance(value, Mapping):
            found |= _flat(value, f"{before}{name}.")
        else:
            found[f"{before}{name}"] = plain(value)
    return found
