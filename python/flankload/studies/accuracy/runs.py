"""Runs of a study: each is solved once, charged as if it were alone, and stored."""

from __future__ import annotations

import json
from dataclasses import dataclass, field, replace
from hashlib import sha256
from importlib.metadata import version
from os.path import isfile
from pathlib import Path
from typing import TYPE_CHECKING, Any

from flankload.base.digest import digest_of
from flankload.base.files import read_file, write_atomically
from flankload.cost import Account
from flankload.errors import FlankloadError, PremiseError
from flankload.mechanisms import Progress, run_once
from flankload.scene.named_discretization import NamedDiscretization, scene_at
from flankload.scene.refusal import refuse
from flankload.studies.accuracy.quantities import Quantities, from_tree, quantities_of, to_tree
from flankload.studies.tolerance import first_scene

if TYPE_CHECKING:
    from flankload.elasticity.compliance import BodyCompliance
    from flankload.scene import Scene

    Kept = dict[str, tuple[BodyCompliance, Account]]

#: Runs below this duration are measured twice.
REPEATED_BELOW_S = 0.5
#: Elements with a longer duration are solved once for all numbers of modes: fewer modes are a
#: submatrix of more, and the cost is equal to a few percent.
SHARED_ABOVE_S = 0.4


@dataclass(frozen=True, eq=False)
class Run:
    """A finished run.

    `cpu_s` are the CPU seconds of all its stages, elements included, and `stages` those of each;
    `memory_bytes` are the arrays of all stages and the largest workspace. `values` is None for a
    run without a solution, whose reason is `failure`. `outside` names the premises of the model
    that it violates.
    """

    discretization: NamedDiscretization
    cpu_s: float
    memory_bytes: int
    values: Quantities | None
    failure: str | None = None
    stages: dict[str, float] = field(default_factory=dict)
    outside: tuple[str, ...] = ()


def fingerprint(scene: Scene) -> str:
    """Identification of a scene: bodies, requested quantities, and contents of its files."""
    parts = [repr(scene.tables)]
    parts += [
        sha256(path.read_bytes()).hexdigest() for path in scene.files.values() if isfile(path)
    ]
    return sha256("\n".join(parts).encode()).hexdigest()[:16]


class Runs:
    """Finished runs of a scene, in memory and in a file if there is one."""

    def __init__(self, scene: Scene, file: Path | None = None) -> None:
        self.scene = scene
        self._file = file
        self._head = {"runs_of_flankload": version("flankload"), "scene": fingerprint(scene)}
        self._lines: list[str] = []
        self._kept: dict[tuple[object, int | None, int | None], Kept] = {}
        self.done: dict[NamedDiscretization, Run] = {}
        if file is not None and file.exists():
            self._read(file)

    def _read(self, file: Path) -> None:
        try:
            lines = read_file(file).decode().splitlines()
            head = json.loads(lines[0]) if lines else self._head
            runs = [_from_line(line) for line in lines[1:]]
        except (ValueError, KeyError, TypeError, AttributeError, RecursionError):
            head, runs, lines = {}, [], []
        if head != self._head:
            expected = "a file of finished runs of this very scene and version, or none yet"
            refuse("--resume", expected, f"{file}, which is another one or damaged")
        self._lines = lines[1:]
        self.done = {run.discretization: run for run in runs}

    def at(self, discretization: NamedDiscretization, progress: Progress | None = None) -> Run:
        """The run at a discretization, solved if it is not available."""
        if discretization not in self.done:
            run = self._solved(discretization, progress)
            self.done[discretization] = run
            if self._file is not None:
                self._lines.append(_line_of(run))
                text = "\n".join([json.dumps(self._head), *self._lines]) + "\n"
                write_atomically(self._file, text)
        return self.done[discretization]

    def _solved(self, discretization: NamedDiscretization, progress: Progress | None) -> Run:
        as_it_is = first_scene(self.scene) if discretization.is_empty else self.scene
        scene = scene_at(as_it_is, discretization)
        try:
            run = _measured(discretization, scene, self._compliances(discretization), progress)
            if run.cpu_s < REPEATED_BELOW_S:
                again = _measured(discretization, scene, {}, progress)
                stages = {key: min(run.stages[key], again.stages[key]) for key in run.stages}
                run = replace(run, stages=stages, cpu_s=sum(stages.values()))
        except PremiseError:  # independent of the discretization
            raise
        except FlankloadError as error:
            return Run(discretization, 0.0, 0, None, failure=str(error))
        return run

    def _compliances(self, discretization: NamedDiscretization) -> Kept:
        """Compliances for the same elements and modes; or for more modes, if that saves time."""
        if discretization.is_empty:
            return {}
        elements = (
            discretization.level if discretization.level in ("nodes", "plane") else "",
            discretization.flank_element_mm,
            discretization.axial_degree,
        )
        modes, load_degree = discretization.modes, discretization.load_degree_z
        kept = self._kept.setdefault((elements, modes, load_degree), {})
        if kept or modes is None:
            return kept
        wanted = (modes, load_degree or 0)
        for (of_elements, more, degree), other in self._kept.items():
            has = (more or 0, degree or 0)
            enough = has != wanted and has[0] >= wanted[0] and has[1] >= wanted[1]
            if of_elements == elements and enough:
                fewer = {
                    name: _with_modes(*body, modes, load_degree) for name, body in other.items()
                }
                if all(body is not None for body in fewer.values()):
                    kept.update({name: body for name, body in fewer.items() if body is not None})
                    break
        return kept


def _with_modes(
    compliance: BodyCompliance, account: Account, modes: int, load_degree: int | None
) -> tuple[BodyCompliance, Account] | None:
    """The submatrix of the lower modes; None if a separate solution is cheap."""
    if compliance.modes.closed or account.cpu_s < SHARED_ABOVE_S:
        return None
    if load_degree is not None:
        compliance = compliance.fewer_axial_modes(compliance.modes.axial.degree - load_degree)
    return compliance.fewer_modes(compliance.flank_modes - modes), account


def _measured(
    discretization: NamedDiscretization, scene: Scene, kept: Kept, progress: Progress | None
) -> Run:
    results = run_once(scene, kept, progress)
    cost = results[0].cost
    stages = {name: stage["cpu_s"] for name, stage in cost["stages"].items()}
    largest = max(stage["workspace_bytes"] for stage in cost["stages"].values())
    return Run(
        discretization=discretization,
        cpu_s=sum(stages.values()),
        memory_bytes=int(cost["bytes"] + largest),
        values=quantities_of(results),
        stages=stages,
        outside=tuple(sorted({name for result in results for name in result.outside_limits})),
    )


def _line_of(run: Run) -> str:
    """Line of a run: its digest, and the run as JSON."""
    text = json.dumps(_to_tree(run), separators=(",", ":"))
    return f"{digest_of(text).hex()} {text}"


def _from_line(line: str) -> Run:
    """The run of a line; ValueError if it is damaged."""
    digest, _, text = line.partition(" ")
    if digest != digest_of(text).hex():
        raise ValueError
    return _from_tree(json.loads(text))


def _to_tree(run: Run) -> dict[str, Any]:
    values = None if run.values is None else to_tree(run.values)
    tree = {**vars(run), "setting": run.discretization.as_dict(), "values": values}
    del tree["discretization"]
    return tree


def _from_tree(tree: dict[str, Any]) -> Run:
    values, setting = tree["values"], NamedDiscretization.from_dict(tree["setting"])
    known = {key: tree[key] for key in ("cpu_s", "memory_bytes", "failure", "stages")}
    outside = tuple(tree.get("outside", ()))
    return Run(setting, values=values and from_tree(values), outside=outside, **known)
