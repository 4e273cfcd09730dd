"""Tolerance control: choice of the discretization of a scene with `accuracy.tolerance`.

The first run uses the default discretization. Its error estimate contains the error of each
quantity from each source; if it exceeds the tolerance the parameters are refined according to the
known orders of convergence (`parameters`) and the scene is run again. The verdict is based on the
last run's own estimate.
"""

from __future__ import annotations

from dataclasses import replace
from math import ceil, sqrt
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from flankload.cost import COUNTERS, Account
from flankload.scene.named_discretization import NamedDiscretization, with_discretization
from flankload.studies.parameters import (
    ELEMENTS_WORK,
    OF_ELEMENTS,
    STATES_WORK,
    parameters_of,
    relative,
)
from flankload.studies.tolerance_report import (
    BOUND,
    OF_LARGEST,
    Attempt,
    Choice,
    tolerance_report,
)

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, MutableMapping, Sequence

    from flankload.elasticity.compliance.body_compliance import BodyCompliance
    from flankload.result import Result
    from flankload.scene import Scene
    from flankload.studies.parameters import Parameters, Values

    Progress = Callable[[str, int, int], None]
    Kept = MutableMapping[int, tuple[BodyCompliance, Account]]
    Errors = dict[str, float]
    Table = dict[str, Errors]

#: Largest number of runs.
MOST_RUNS = 3
#: Target of a refinement, as part of the tolerance: orders of convergence are asymptotic.
AIM = 0.9
#: Sources whose error is below this part of the target are not refined.
SMALL_PART = 0.4
#: A quantity that cannot meet the tolerance is refined up to this multiple of the work for all
#: others; a run for that alone must reduce the error from parameters to this part.
PATIENCE, MUCH_NEARER = 4.0, 0.7
#: Number of adaptive positions per pitch in the first round. Their uncertainty of harmonics and
#: peak to peak, as parts of these, may be DOUBT tolerances, since the tolerance applies to parts of
#: the whole; within limits. Refined ones have a target of POSITIONS_AIM tolerances: a smaller one
#: costs more.
POSITIONS, DOUBT, LEAST_DOUBT, MOST_DOUBT = 16, 3.0, 3e-4, 0.03
POSITIONS_AIM, FINEST_DOUBT = 0.4, 1e-5
#: Largest number of adaptive positions per pitch in the first round.
MOST_POSITIONS = 128


class Run(Protocol):
    """A run of a scene with the signature of `run_once`."""

    def __call__(self, scene: Scene, kept: Kept, progress: Progress | None) -> tuple[Result, ...]:
        """Results of a scene; newly solved compliances are stored in `kept`."""


def first_choice(scene: Scene, parameters: Parameters) -> Choice:
    """Initial choice for a scene: the default, and adaptive positions if none are named."""
    positions = NamedDiscretization()
    if "positions" not in parameters.fixed:
        doubt = float(np.clip(DOUBT * scene.accuracy.tolerance, LEAST_DOUBT, MOST_DOUBT))
        positions = NamedDiscretization(count=POSITIONS, adaptive=doubt)
    return Choice(parameters.values, positions)


def first_discretization(scene: Scene) -> NamedDiscretization:
    """Initial discretization for a tolerance, with all open parameters; empty without one."""
    if not scene.names_tolerance:
        return NamedDiscretization()
    parameters = parameters_of(scene)
    default: dict[str, Any] = {
        name: x for name, x in parameters.values.items() if name in parameters.steps
    }
    return replace(first_choice(scene, parameters).positions, **default)


def first_scene(scene: Scene) -> Scene:
    """Scene with the initial discretization of its tolerance; unchanged if it names none."""
    if not scene.names_tolerance:
        return scene
    parameters = parameters_of(scene)
    return _at(scene, first_choice(scene, parameters).discretization(parameters))


def _at(scene: Scene, discretization: NamedDiscretization) -> Scene:
    """The scene with an explicit discretization, which its tolerance no longer changes."""
    scene = with_discretization(scene, discretization)
    return replace(
        scene, named_discretization_keys=scene.named_discretization_keys - {"accuracy.tolerance"}
    )


def solve_to_tolerance(
    scene: Scene, run: Run, progress: Progress | None = None
) -> tuple[Result, ...]:
    """Results of a scene whose discretization meets its tolerance as far as possible.

    Parameters
    ----------
    scene : Scene
        It names a tolerance.
    run : callable
        Solves a scene.
    progress : callable, optional
        As in `solve`.

    Returns
    -------
    tuple of Result
        One per torque, with `accuracy`.
    """
    with Account() as control:
        parameters = parameters_of(scene)
        choice = first_choice(scene, parameters)
    tell, kept, spent = _Parts(progress), {}, Account()  # type: tuple[_Parts, Kept, Account]
    attempts: list[Attempt] = []
    while True:
        at = _at(scene, choice.discretization(parameters))
        found = run(at, kept, tell.part(len(attempts)))
        attempts.append(Attempt.of(choice, found))
        with control:
            finer = choose_discretization(parameters, attempts, scene.accuracy.tolerance)
        if finer is None:
            break
        same = finer.has_elements_of(choice)
        _add_spent(spent, attempts[-1].results, without=set(kept) if same else set())
        choice, kept = finer, kept if same else {}
    extra = {"steering": control} | ({"first run": spent} if len(attempts) > 1 else {})
    report = tolerance_report(scene, parameters, attempts)
    results = tuple(
        replace(result, accuracy=report, cost=_with_extra(result.cost, extra))
        for result in attempts[-1].results
    )
    tell.finish()
    return results


def choose_discretization(
    parameters: Parameters, attempts: Sequence[Attempt], tolerance: float
) -> Choice | None:
    """Discretization that will probably meet the tolerance, from the estimate of the last run.

    None if the tolerance is met, or if no further run is worth its cost.
    """
    last = attempts[-1]
    missed = [quantity for quantity, error in last.errors.items() if error > tolerance]
    if not missed or len(attempts) == MOST_RUNS:
        return None
    by_source, positions = dict(last.by_source), last.choice.positions
    if positions.adaptive is not None and "positions" in by_source:
        positions, by_source["positions"] = finer_positions(
            positions, by_source["positions"], POSITIONS_AIM * tolerance
        )
    if len(attempts) > 1:  # elements are not solved a third time
        steps = {n: ahead for n, ahead in parameters.steps.items() if n not in OF_ELEMENTS}
        parameters = replace(parameters, steps=steps)
    refining = _Refining(parameters, last, by_source, AIM * tolerance)
    values = refining.values()
    choice = Choice(values, positions, refining.foreseen(values))
    meets = any(choice.foreseen[quantity] <= tolerance for quantity in missed)
    before = max(_norm(last.by_source, quantity, parameters) for quantity in missed)
    after = max(_norm(refining.left(values), quantity, parameters) for quantity in missed)
    return choice if meets or (before > tolerance and after <= MUCH_NEARER * before) else None


def finer_positions(
    positions: NamedDiscretization, errors: Errors, wanted: float
) -> tuple[NamedDiscretization, Errors]:
    """Adaptive positions whose errors are likely to be small enough, and these errors by quantity.

    That of the peak to peak is proportional to the tolerance of the positions; the others belong to
    kinks that the rotation does not have, and go with the square of the distance of the positions
    with which the rounds begin.
    """
    left, count, adaptive = dict(errors), positions.count, positions.adaptive
    assert count is not None
    assert adaptive is not None
    if left.get(OF_LARGEST, 0.0) > wanted:
        part = wanted / left[OF_LARGEST]
        left[OF_LARGEST] *= part
        doubt = float(f"{max(FINEST_DOUBT, part * adaptive):.2g}")
        positions = replace(positions, adaptive=doubt)
    others = max((error for name, error in left.items() if name != OF_LARGEST), default=0.0)
    if others > wanted:
        more = min(MOST_POSITIONS, ceil(count * sqrt(others / wanted)))
        part = (count / more) ** 2
        left = {name: e if name == OF_LARGEST else part * e for name, e in left.items()}
        positions = replace(positions, count=more)
    return positions, left


def _norm(table: Table, quantity: str, only_open: Parameters | None = None) -> float:
    """Combined errors of a quantity from all sources, or from those with open parameters."""
    among = table if only_open is None else only_open.open_sources
    return float(np.linalg.norm([table[source][quantity] for source in table if source in among]))


class _Refining:
    """Refinement of the parameters from a run, each source with its order of convergence."""

    def __init__(
        self, parameters: Parameters, done: Attempt, by_source: Table, wanted: float
    ) -> None:
        self._parameters, self._start, self._wanted = parameters, done.choice.values, wanted
        self._by_source = by_source
        stages = {name: one["cpu_s"] for name, one in done.results[0].cost["stages"].items()}
        self._elements_s = sum(s for name, s in stages.items() if name.startswith("compliance"))
        self._states_s = sum(stages.get(name, 0.0) for name in ("sweep", "tangent", "estimate"))

    def left(self, values: Values) -> Table:
        """Predicted error of each quantity from each source."""
        powers = self._parameters.powers
        found: Table = {}
        for source, errors in self._by_source.items():
            factor = relative(powers.get(source, {}), values, self._start)
            found[source] = {quantity: factor * error for quantity, error in errors.items()}
        return found

    def foreseen(self, values: Values) -> Errors:
        """Predicted error of each quantity from all sources: they are independent."""
        left = self.left(values)
        return {quantity: _norm(left, quantity) for quantity in BOUND}

    def _work(self, values: Values) -> float:
        """CPU seconds of a run, as far as they depend on the parameters."""
        elements = self._elements_s * relative(ELEMENTS_WORK, values, self._start)
        return elements + self._states_s * relative(STATES_WORK, values, self._start)

    def values(self) -> Values:
        """Parameters that meet the attainable limits and approach the others if cheap."""
        finest = self._refined(self._start, set(BOUND), np.inf)
        can = {q for q, error in self.foreseen(finest).items() if error <= self._wanted}
        values = self._refined(self._start, can, np.inf)
        most = PATIENCE * max(self._work(self._start), self._work(values))
        return self._refined(values, set(BOUND) - can, most)

    def _refined(self, values: Values, quantities: set[str], most_work: float) -> Values:
        """Refine step by step the largest contribution to the largest error."""
        left = set(quantities)
        while left:
            errors = self.foreseen(values)
            worst = max(left, key=lambda quantity: errors[quantity])
            if errors[worst] <= self._wanted:
                break
            sources = {source: one[worst] for source, one in self.left(values).items()}
            finer = None
            for source in sorted(sources, key=lambda name: -sources[name]):
                if sources[source] < SMALL_PART * self._wanted:
                    break
                finer = self._parameters.finer(values, source)
                if finer is not None:
                    break
            if finer is None or self._work(finer) > most_work:
                left.remove(worst)
            else:
                values = finer
        return values


def _add_spent(spent: Account, results: Sequence[Result], *, without: set[int]) -> None:
    """Count the cost of a run that the next one cannot reuse."""
    kept = {f"compliance body {z + 1}" for z in without}
    for name, stage in results[0].cost["stages"].items():
        if name not in kept:
            spent.wall_s += stage["wall_s"]
            spent.cpu_s += stage["cpu_s"]
            spent.count(**stage["counters"])


def _with_extra(cost: Mapping[str, Any], extra: Mapping[str, Account]) -> dict[str, Any]:
    """Cost of a run including the additional cost."""
    stages = {name: account.as_dict() | {"predicted": {}} for name, account in extra.items()}
    more = {
        name: cost.get(name, 0) + sum(account.counters.get(name, 0) for account in extra.values())
        for name in COUNTERS
        if name in cost
    }
    return {**cost, **more, "stages": {**stages, **cost["stages"]}}


class _Parts:
    """Progress of several runs as that of one: later runs are not certain."""

    def __init__(self, progress: Progress | None) -> None:
        self._progress = progress
        self._total = 1

    def part(self, number: int) -> Progress | None:
        """Progress of a run; each may take half of what the previous ones have left."""
        if self._progress is None:
            return None

        def tell(stage: str, done: int, total: int) -> None:
            assert self._progress is not None
            self._total = max(total, self._total)
            if done < total:
                at = number * self._total + done * self._total // total
                self._progress(stage, at, MOST_RUNS * self._total)

        return tell

    def finish(self) -> None:
        """Report that all runs are complete."""
        if self._progress is not None:
            self._progress("done", MOST_RUNS * self._total, MOST_RUNS * self._total)
