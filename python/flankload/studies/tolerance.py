"""Tolerance control: choice of the discretization of a scene with `accuracy.tolerance`.

The first run is coarse. Its error estimate contains the error of each quantity from each source; if
it exceeds the tolerance the parameters are refined according to the known orders of convergence
(`parameters`) and the scene is run again. The verdict is based on the last run's own estimate.
"""

from __future__ import annotations

from dataclasses import replace
from math import ceil, sqrt
from typing import TYPE_CHECKING, Any

import numpy as np

from flankload.cost import COUNTERS, Account
from flankload.mechanisms.parameters import ELEMENTS_WORK, STATES_WORK, relative
from flankload.mechanisms.registry import mechanism_of
from flankload.mechanisms.stage_clock import elements_stage
from flankload.scene.named_discretization import NamedDiscretization, with_discretization
from flankload.studies.tolerance_report import (
    BOUND,
    OF_LARGEST,
    Attempt,
    Choice,
    tolerance_report,
)

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Mapping, Sequence

    from flankload.mechanisms.parameters import Parameters, Values
    from flankload.mechanisms.stage_clock import Kept, Progress
    from flankload.result import Result
    from flankload.scene import Scene

    Run = Callable[[Scene, Kept, Progress | None], tuple[Result, ...]]
    Errors = dict[str, float]
    Table = dict[str, Errors]

#: Largest number of runs: coarse, refined, and refined by the estimate of the second one.
MOST_RUNS = 3
#: Target of a refinement, as part of the tolerance: orders of convergence are asymptotic.
AIM = 0.9
#: A quantity that cannot meet the tolerance is refined up to this multiple of the work for all
#: others, or of the default: half the length of the elements.
PATIENCE = 4.0
#: Number of adaptive positions per pitch in the first round, and the largest one.
POSITIONS, MOST_POSITIONS = 16, 128
#: Relative uncertainty that they may leave in harmonics and peak to peak, over the tolerance, which
#: refers to the whole transmission error; and its limits.
DOUBT, LEAST_DOUBT, MOST_DOUBT = 3.0, 1e-5, 0.03


def first_choice(scene: Scene, parameters: Parameters) -> Choice:
    """Initial choice for a scene: coarse, with adaptive positions if none are named.

    Without an error estimate no run can follow, so the choice is the default.
    """
    positions = NamedDiscretization()
    if "positions" not in parameters.fixed:
        doubt = float(np.clip(DOUBT * scene.accuracy.tolerance, LEAST_DOUBT, MOST_DOUBT))
        positions = NamedDiscretization(count=POSITIONS, adaptive=doubt)
    coarse = parameters.first if scene.accuracy.estimate else {}
    return Choice({**parameters.values, **coarse}, positions)


def first_discretization(scene: Scene) -> NamedDiscretization:
    """Initial discretization for a tolerance, with all open parameters; empty without one."""
    if not scene.names_tolerance:
        return NamedDiscretization()
    parameters = mechanism_of(scene).parameters(scene)
    choice = first_choice(scene, parameters)
    named: dict[str, Any] = {n: x for n, x in choice.values.items() if n in parameters.steps}
    return replace(choice.positions, **named)


def first_scene(scene: Scene) -> Scene:
    """Scene with the initial discretization of its tolerance; unchanged if it names none."""
    if not scene.names_tolerance:
        return scene
    parameters = mechanism_of(scene).parameters(scene)
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
        run(scene, kept, progress) returns results, and stores newly solved compliances in `kept`.
    progress : callable, optional
        As in `solve`.

    Returns
    -------
    tuple of Result
        One per torque, with `accuracy`.
    """
    with Account() as control:
        parameters = mechanism_of(scene).parameters(scene)
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
    missed = last.missed(tolerance)
    if not missed or len(attempts) == MOST_RUNS:
        return None
    by_source, positions = last.scaled_by_source(), last.choice.positions
    if positions.adaptive is not None and "positions" in by_source:
        positions, by_source["positions"] = finer_positions(
            positions, by_source["positions"], AIM * tolerance * equal_part(by_source)
        )
    refining = _Refining(parameters, last.choice.values, by_source, AIM * tolerance)
    values = refining.values(set(missed))
    choice = Choice(values, positions, refining.foreseen(values))
    if (values, positions) == (last.choice.values, last.choice.positions):
        return None
    meets = any(choice.foreseen[quantity] <= tolerance for quantity in missed)
    return choice if meets or values != last.choice.values else None


def equal_part(sources: Collection[str]) -> float:
    """Part of an error that each of several independent sources may have."""
    return 1.0 / sqrt(len(sources))


def finer_positions(
    positions: NamedDiscretization, errors: Errors, wanted: float
) -> tuple[NamedDiscretization, Errors]:
    """Adaptive positions whose errors are likely to be small enough, and these errors by quantity.

    The error of the peak to peak is proportional to the tolerance of the positions. The others are
    caused by kinks that the rotation does not have; they are proportional to the square of the
    distance of the initial positions.
    """
    left, count, adaptive = dict(errors), positions.count, positions.adaptive
    assert count is not None
    assert adaptive is not None
    if left.get(OF_LARGEST, 0.0) > wanted:
        part = wanted / left[OF_LARGEST]
        left[OF_LARGEST] *= part
        doubt = float(f"{max(LEAST_DOUBT, part * adaptive):.2g}")
        positions = replace(positions, adaptive=doubt)
    others = max((error for name, error in left.items() if name != OF_LARGEST), default=0.0)
    if others > wanted:
        more = min(MOST_POSITIONS, ceil(count * sqrt(others / wanted)))
        part = (count / more) ** 2
        left = {name: e if name == OF_LARGEST else part * e for name, e in left.items()}
        positions = replace(positions, count=more)
    return positions, left


class _Refining:
    """Refinement of the parameters from a run, each source with its order of convergence."""

    def __init__(
        self, parameters: Parameters, start: Values, by_source: Table, wanted: float
    ) -> None:
        self._parameters, self._start, self._by_source = parameters, start, by_source
        self._wanted = wanted

    def _left(self, values: Values, quantity: str) -> Errors:
        """Predicted error of a quantity from each source."""
        powers = self._parameters.powers
        return {
            source: relative(powers.get(source, {}), values, self._start) * errors[quantity]
            for source, errors in self._by_source.items()
        }

    def foreseen(self, values: Values) -> Errors:
        """Predicted error of each quantity from all sources: they are independent."""
        return {
            quantity: float(np.linalg.norm(list(self._left(values, quantity).values())))
            for quantity in BOUND
        }

    def _is_long(self, values: Values, cheap: Collection[Values]) -> bool:
        """Whether elements or states take more than `PATIENCE` times those of all cheap values."""
        works = [
            max(relative(powers, values, others) for powers in (ELEMENTS_WORK, STATES_WORK))
            for others in cheap
        ]
        return min(works, default=0.0) > PATIENCE

    def values(self, missed: set[str]) -> Values:
        """Parameters with which missed quantities meet the tolerance, or approach it if cheap."""
        finest = self._refined(self._start, missed)
        errors = self.foreseen(finest)
        can = {name for name in missed if errors[name] <= self._wanted}
        values = self._refined(self._start, can)
        return self._refined(values, missed - can, (values, self._parameters.values))

    def _refined(self, values: Values, missed: set[str], cheap: Collection[Values] = ()) -> Values:
        """Refine step by step the largest contribution to the largest error.

        With `cheap`, the work is at most `PATIENCE` times that at one of these values.
        """
        left = set(missed)
        while left:
            errors = self.foreseen(values)
            worst = max(sorted(left), key=lambda name: errors[name])
            sources = self._left(values, worst)
            least = self._wanted * equal_part(sources)
            large = sorted((s for s in sources if sources[s] >= least), key=lambda s: -sources[s])
            steps = (self._parameters.finer(values, source) for source in large)
            finer = next((step for step in steps if step and not self._is_long(step, cheap)), None)
            if finer is None or errors[worst] <= self._wanted:
                left.remove(worst)
            else:
                values = finer
        return values


def _add_spent(spent: Account, results: Sequence[Result], *, without: set[str]) -> None:
    """Count the cost of a run that the next one cannot reuse."""
    kept = set(map(elements_stage, without))
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
