"""Reference of a study: the finest run, shifted to the limits of its sequences of refinements."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import cached_property
from math import hypot, inf
from typing import TYPE_CHECKING

from flankload.studies.accuracy.knobs import ADAPTIVE, ADAPTIVE_START, KINKS
from flankload.studies.accuracy.observed import errors_of, limits_of, moved, off_by, with_numbers

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flankload.scene.named_discretization import NamedDiscretization
    from flankload.studies.accuracy.knobs import Knobs
    from flankload.studies.accuracy.ladder import Limit
    from flankload.studies.accuracy.observed import Observed
    from flankload.studies.accuracy.runs import Run


def ladder(knobs: Knobs, knob: str) -> Iterator[NamedDiscretization]:
    """Steps of a parameter with the others at their finest, the finest step first.

    Even positions are followed by adaptive ones.
    """
    for value in reversed(knobs.ladders[knob]):
        yield replace(knobs.finest, **{knob: value})  # type: ignore[arg-type]
    if knob == "count":
        for tolerance in ADAPTIVE if _many(knobs) else ():
            yield replace(knobs.finest, count=ADAPTIVE_START, adaptive=tolerance)
        yield from every_kink(knobs)


def at_default(knobs: Knobs, knob: str) -> Iterator[NamedDiscretization]:
    """The same steps with the others at their default: cost of a step in a cheap run."""
    for setting in ladder(knobs, knob):
        yield twin(knobs, knob, setting)


def twin(knobs: Knobs, knob: str, setting: NamedDiscretization) -> NamedDiscretization:
    """A step of a sequence with the other parameters at their default."""
    changed = replace(knobs.base, **{knob: getattr(setting, knob)})
    return replace(changed, adaptive=setting.adaptive)


def every_kink(knobs: Knobs) -> Iterator[NamedDiscretization]:
    """The finest positions and additional ones where the curve bends.

    Sequences of even positions converge erratically for curves with kinks; this is their limit.
    """
    if _many(knobs):
        yield replace(knobs.finest, adaptive=KINKS)


def _many(knobs: Knobs) -> bool:
    """Whether the number of positions is sufficient as a start for adaptive ones."""
    count = knobs.finest.count
    return knobs.can_adapt and count is not None and count >= ADAPTIVE_START


class Truth:
    """Knowledge about the limits at some time of a study.

    Parameters
    ----------
    done : mapping of NamedDiscretization to Run
        Finished runs.
    knobs : Knobs
    """

    def __init__(self, done: Mapping[NamedDiscretization, Run], knobs: Knobs) -> None:
        self._done, self._knobs = done, knobs
        run = done.get(knobs.finest)
        self.finest: Observed | None = None if run is None else run.values
        self.limits: dict[str, dict[str, Limit]] = {}
        for knob in knobs.ladders if self.finest is not None else ():
            if (limits := self._limits(knob)) is not None:
                self.limits[knob] = limits

    def steps(self, knob: str) -> list[Run]:
        """Finished steps of a sequence that have a solution, the finest first."""
        steps = (self._done.get(setting) for setting in ladder(self._knobs, knob))
        return [run for run in steps if run is not None and run.values is not None]

    def _limits(self, knob: str) -> dict[str, Limit] | None:
        """Limits of the even steps of a sequence, from the finest setting on."""
        sizes, runs = [], []
        least = self._size(self._knobs.finest, knob)
        for run in self.steps(knob):
            size = self._size(run.setting, knob)
            if run.setting.adaptive is None and run.values is not None and size >= least:
                sizes.append(size)
                runs.append(run.values)
        if len(runs) < 2:
            return None
        limits = limits_of(sizes, runs)
        for setting in every_kink(self._knobs) if knob == "count" else ():
            best = self._done.get(setting)
            if best is not None and best.values is not None:
                limits = with_numbers(limits, best.values, self._before(best.values))
        return limits

    def _before(self, best: Observed) -> Observed:
        """The finest of the other runs with varied positions: adaptive, or else even."""
        others = [run for run in self.steps("count") if run.values is not best]
        adaptive = [run for run in others if run.setting.adaptive is not None]
        run = min(adaptive, key=lambda run: run.setting.adaptive or inf) if adaptive else others[0]
        assert run.values is not None
        return run.values

    @cached_property
    def doubts(self) -> dict[str, float]:
        """Uncertainty of the limits of all parameters, by the names of errors.

        Each sequence has a remaining error; for a parameter that was not varied, the only
        assumption is that the finest step is nearer to the limit than the default. Squares are
        added.
        """
        truth = self.of()
        if truth is None:
            return {}
        parts = [errors_of(off_by(truth, limits), truth) for limits in self.limits.values()]
        if any(len(steps) > 1 for steps in self._unknown()):
            base = self._done.get(self._knobs.base)
            if base is None or base.values is None:
                return dict.fromkeys(errors_of(truth, truth), inf)
            parts.append(errors_of(base.values, truth))
        found = dict.fromkeys(errors_of(truth, truth), 0.0)
        for part in parts:
            for name, error in part.items():
                found[name] = hypot(found.get(name, 0.0), error)
        return found

    def _unknown(self) -> list[tuple[float, ...]]:
        """Parameters without a known limit."""
        return [steps for knob, steps in self._knobs.ladders.items() if knob not in self.limits]

    @staticmethod
    def _size(setting: NamedDiscretization, knob: str) -> float:
        """Step size, which approaches zero along a sequence."""
        value = float(getattr(setting, knob))
        return value if knob == "flank_element_mm" else 1.0 / value

    def of(self, *knobs: str) -> Observed | None:
        """The finest run with some parameters at their limits; by default all."""
        if self.finest is None:
            return None
        wanted = [self.limits[knob] for knob in (knobs or self.limits) if knob in self.limits]
        return moved(self.finest, wanted, self.finest)

    def errors(self, run: Run, *knobs: str) -> dict[str, float]:
        """Errors of a run against the limits of some parameters; by default all."""
        truth = self.of(*knobs)
        return {} if truth is None or run.values is None else errors_of(run.values, truth)

    def doubt(self, measures: Sequence[str]) -> float:
        """The largest of some uncertainties."""
        return max((self.doubts[name] for name in measures if name in self.doubts), default=inf)

    def within(self, run: Run, measures: Sequence[str]) -> float | None:
        """Upper bound of some errors: the largest plus its uncertainty; None if unknown."""
        errors = self.errors(run)
        return max(
            (errors[name] + self.doubts[name] for name in measures if name in errors), default=None
        )

    def largest(self, run: Run, measures: Sequence[str], *knobs: str) -> float | None:
        """The largest of some errors; None if none is known."""
        errors = self.errors(run, *knobs)
        return max((errors[name] for name in measures if name in errors), default=None)
