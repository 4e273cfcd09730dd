"""Runs of a study within a budget: finest run, refinements, contact models."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from time import process_time
from typing import TYPE_CHECKING

from flankload.base.arguments import require_names, require_number, require_path
from flankload.scene import Scene, SceneLike, scene_of
from flankload.scene.named_discretization import NamedDiscretization
from flankload.scene.refusal import refuse
from flankload.scene.steps import ELEMENTS, STEPS
from flankload.studies.accuracy.quantities import MEASURES
from flankload.studies.accuracy.reference import Reference, ladder, twin
from flankload.studies.accuracy.refinements import (
    COARSE,
    affordable,
    can_be_nodal,
    can_lump,
    refinements_of,
)
from flankload.studies.accuracy.runs import Run, Runs
from flankload.studies.accuracy.study import AccuracyStudy, Row
from flankload.studies.accuracy.study_text import notes_of
from flankload.studies.plan import choose_effects

if TYPE_CHECKING:
    Progress = Callable[[str, int, int], None]

#: Steps of the progress.
TOLD = 100


class OutOfBudgetError(Exception):
    """Raised instead of a run that exceeds the budget."""


def accuracy(
    scene: SceneLike,
    quantities: Sequence[str] = ("transmission_error", "peak_pressure"),
    budget_s: float = 60.0,
    *,
    progress: Progress | None = None,
    resume: str | Path | None = None,
) -> AccuracyStudy:
    """Accuracy study of a scene: errors, seconds and memory for each discretization parameter.

    The study refines each parameter with the others at their finest and at their default, and tries
    other contact models. All errors are relative to the finest discretization and the extrapolated
    limits; `accuracy.tolerance` in a scene combines the steps for a tolerance. Runs that differ
    only in cells and positions share finite elements, but each is charged as if it were alone.
    Seconds are those of all threads of the process.

    Parameters
    ----------
    scene : Scene, path or mapping
        As for `solve`.
    quantities : sequence of str
        A subset of "transmission_error" (at each position, mean, peak to peak), "load_share",
        "peak_pressure" (off sharp corners) and "stiffness".
    budget_s : float
        CPU seconds after which no further run is started.
    progress : callable, optional
        Called as progress(stage, done, total). An exception from it ends the study.
    resume : path, optional
        File of finished runs: read if it exists, written after each run.

    Returns
    -------
    AccuracyStudy
        After an interruption (Ctrl-C) it contains the finished runs.

    Raises
    ------
    SceneError
        If the scene is impossible or has no torque, or an argument is wrong;
        `PremiseError` if it violates a premise of the model.
    """
    scene = scene_of(scene)
    require_names("quantities", quantities)
    require_number("budget_s", budget_s)
    require_path("resume", resume)
    _check(scene, quantities, budget_s)
    scene, _ = choose_effects(scene)
    run_study = _StudyRuns(
        scene, quantities, budget_s, progress, None if resume is None else Path(resume)
    )
    stopped, interrupted = None, False
    try:
        run_study.all_runs()
    except OutOfBudgetError:
        stopped = f"the budget of {budget_s:g} CPU seconds is used up: further runs are omitted"
    except KeyboardInterrupt:
        if not run_study.groups:
            raise
        stopped, interrupted = "interrupted: further runs are omitted", True
    return run_study.study(stopped, interrupted=interrupted)


def _check(scene: Scene, quantities: Sequence[str], budget_s: float) -> None:
    known = f"some of {', '.join(MEASURES)}"
    if not quantities:
        refuse("quantities", known, "none")
    for quantity in quantities:
        if quantity not in MEASURES:
            refuse("quantities", known, f"'{quantity}'")
    if not budget_s > 0:
        refuse("budget", "CPU seconds > 0", f"{budget_s:g}")
    if not all(torque > 0 for torque in scene.torques_Nm):
        expected = "torques > 0, since without load there is no approximation"
        refuse("load.torque_Nm", expected, "0", scene.file)


class _StudyRuns:
    """Runs of a study in order."""

    def __init__(
        self,
        scene: Scene,
        quantities: Sequence[str],
        budget_s: float,
        progress: Progress | None,
        resume: Path | None,
    ) -> None:
        self.scene, self.quantities = scene, quantities
        self.measures = [name for quantity in quantities for name in MEASURES[quantity]]
        self.refinements = refinements_of(scene)
        self.runs = Runs(scene, resume)
        self.groups: dict[NamedDiscretization, str] = {}
        self._budget_s, self._began, self._progress = budget_s, process_time(), progress

    def all_runs(self) -> None:
        """All runs that the budget allows."""
        self._warm_up()
        base = self.run("default", self.refinements.base)
        self.refinements = affordable(self.scene, self.refinements, base.stages, self._budget_s)
        self.run("as it stands", NamedDiscretization())
        self.run("finest", self.refinements.finest)
        for parameter in sorted(self.refinements.ladders, key="count".__eq__):
            for discretization in ladder(self.refinements, parameter):
                self.run(parameter, discretization)
        for parameter in self.refinements.ladders:
            for step in ladder(self.refinements, parameter):
                self.run("default but for one knob", twin(self.refinements, parameter, step))
        for group, discretization in self._levels():
            self.run(group, discretization)
        if can_be_nodal(self.scene):  # last, since it is the most expensive one
            self.run("nodes", self._nodes(None))

    def run(self, group: str, discretization: NamedDiscretization) -> Run:
        """A run, assigned to the first group that requests it."""
        if discretization not in self.runs.done:
            if self._spent() >= self._budget_s:
                raise OutOfBudgetError
            self._tell(group)
        found = self.runs.at(discretization, lambda *_: self._tell(group))
        self.groups.setdefault(discretization, group)
        return found

    def _warm_up(self) -> None:
        """Load packages whose import would otherwise be charged to the first run."""
        if self.refinements.base not in self.runs.done:
            self._tell("warming up")
            Runs(self.scene).at(self.refinements.base)

    def _spent(self) -> float:
        return process_time() - self._began

    def _tell(self, group: str) -> None:
        if self._progress is not None:
            done = int(TOLD * min(1.0, self._spent() / self._budget_s))
            self._progress(group.replace("_", " "), done, TOLD)

    def _levels(self) -> Iterator[tuple[str, NamedDiscretization]]:
        """Other models at the default, with finer elements, and at more positions."""
        base, ladders = self.refinements.base, self.refinements.ladders
        if self.refinements.spatial:
            if not (self.scene.body_1.brings_compliance or self.scene.body_2.brings_compliance):
                plane = NamedDiscretization("plane", base.flank_element_mm, base.modes)
                yield "plane", replace(plane, count=base.count)
            length = base.flank_element_mm and STEPS[ELEMENTS].coarse * base.flank_element_mm
            yield "coarse", replace(base, flank_element_mm=length, **COARSE)
        if can_lump(self.scene):
            plain = replace(base, level="lumped", strips_per_half_width=None, zone_half_widths=None)
            yield "lumped", plain
            if len(ladders.get("flank_element_mm", ())) > 2:
                yield "lumped", replace(plain, flank_element_mm=ladders["flank_element_mm"][2])
            if len(ladders.get("count", ())) > 1:
                yield "lumped", replace(plain, count=int(ladders["count"][-2]))
        if can_be_nodal(self.scene) and base.flank_element_mm is not None:
            yield "nodes", self._nodes(self.refinements.finest.flank_element_mm)

    def _nodes(self, apart_mm: float | None) -> NamedDiscretization:
        """Nodal forces, which have neither modes nor cells; on their own if None."""
        return NamedDiscretization(
            "nodes", flank_element_mm=apart_mm, count=self.refinements.base.count
        )

    def study(self, stopped: str | None, *, interrupted: bool) -> AccuracyStudy:
        """Study of the runs so far."""
        reference = Reference(self.runs.done, self.refinements)
        done = self.runs.done

        def row(discretization: NamedDiscretization, *parameters: str) -> Row:
            run = done[discretization]
            alone = reference.errors(run, *parameters) if parameters else {}
            return Row(self.groups[discretization], run, reference.errors(run), alone)

        steps = {}
        for parameter in self.refinements.ladders:
            known = (step for step in ladder(self.refinements, parameter) if step in self.groups)
            steps[parameter] = tuple(row(step, parameter) for step in known)
        rows = tuple(
            row(discretization, *({group} & steps.keys()))
            for discretization, group in self.groups.items()
        )
        return AccuracyStudy(
            name=self.scene.name,
            tolerance=self.scene.accuracy.tolerance,
            measures=tuple(self.measures),
            rows=rows,
            steps=steps,
            limits=reference.limits,
            knobs=self.refinements,
            doubts=reference.doubts,
            notes=notes_of(self.scene, rows, steps.get("strips_per_half_width", ())),
            stopped=stopped,
            interrupted=interrupted,
        )
