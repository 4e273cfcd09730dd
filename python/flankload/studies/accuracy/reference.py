"""Reference of a study: the finest run, shifted to the limits of its sequences of refinements."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import cached_property
from math import hypot, inf
from typing import TYPE_CHECKING

from flankload.scene.axial import DEGREES_ABOVE_LOAD
from flankload.studies.accuracy.quantities import (
    Quantities,
    errors_of,
    limits_of,
    shifted,
    with_numbers,
)
from flankload.studies.accuracy.refinements import ADAPTIVE, ADAPTIVE_START, KINKS, Refinements

if TYPE_CHECKING:
    from flankload.scene.named_discretization import NamedDiscretization
    from flankload.studies.accuracy.ladder import Limit
    from flankload.studies.accuracy.runs import Run


def ladder(refinements: Refinements, parameter: str) -> Iterator[NamedDiscretization]:
    """Steps of a parameter with the others at their finest, the finest step first.

    Even positions are followed by adaptive ones.
    """
    for value in reversed(refinements.ladders[parameter]):
        yield replace(refinements.finest, **{parameter: value})  # type: ignore[arg-type]
    if parameter == "count":
        for tolerance in ADAPTIVE if _many(refinements) else ():
            yield replace(refinements.finest, count=ADAPTIVE_START, adaptive=tolerance)
        yield from _every_kink(refinements)


def twin(
    refinements: Refinements, parameter: str, discretization: NamedDiscretization
) -> NamedDiscretization:
    """A step of a sequence with the other parameters at their default."""
    base, degree = refinements.base, discretization.load_degree_z
    if parameter == "load_degree_z" and base.axial_degree is not None and degree is not None:
        base = replace(base, axial_degree=max(base.axial_degree, degree + DEGREES_ABOVE_LOAD))
    changed = replace(base, **{parameter: getattr(discretization, parameter)})
    return replace(changed, adaptive=discretization.adaptive)


def _every_kink(refinements: Refinements) -> Iterator[NamedDiscretization]:
    """The finest positions and additional ones where the curve bends.

    Sequences of even positions converge erratically for curves with kinks; this is their limit.
    """
    if _many(refinements):
        yield replace(refinements.finest, adaptive=KINKS)


def _many(refinements: Refinements) -> bool:
    """Whether the number of positions is sufficient as a start for adaptive ones."""
    count = refinements.finest.count
    return refinements.can_adapt and count is not None and count >= ADAPTIVE_START


class Reference:
    """Knowledge about the limits at some time of a study, from its finished runs."""

    def __init__(self, done: Mapping[NamedDiscretization, Run], refinements: Refinements) -> None:
        self._done, self._refinements = done, refinements
        run = done.get(refinements.finest)
        self.finest: Quantities | None = None if run is None else run.values
        self.limits: dict[str, dict[str, Limit]] = {}
        for parameter in refinements.ladders if self.finest is not None else ():
            if (limits := self._limits(parameter)) is not None:
                self.limits[parameter] = limits

    def steps(self, parameter: str) -> list[Run]:
        """Finished steps of a sequence that have a solution, the finest first."""
        steps = (self._done.get(step) for step in ladder(self._refinements, parameter))
        return [run for run in steps if run is not None and run.values is not None]

    def _limits(self, parameter: str) -> dict[str, Limit] | None:
        """Limits of the even steps of a sequence, from the finest discretization on."""
        sizes, runs = [], []
        least = self._size(self._refinements.finest, parameter)
        for run in self.steps(parameter):
            size = self._size(run.discretization, parameter)
            if run.discretization.adaptive is None and run.values is not None and size >= least:
                sizes.append(size)
                runs.append(run.values)
        if len(runs) < 2:
            return None
        limits = limits_of(sizes, runs)
        for discretization in _every_kink(self._refinements) if parameter == "count" else ():
            best = self._done.get(discretization)
            if best is not None and best.values is not None:
                limits = with_numbers(limits, best.values, self._before(best.values))
        return limits

    def _before(self, best: Quantities) -> Quantities:
        """The finest of the other runs with varied positions: adaptive, or else even."""
        others = [run for run in self.steps("count") if run.values is not best]
        adaptive = [run for run in others if run.discretization.adaptive is not None]
        adaptive.sort(key=lambda run: run.discretization.adaptive or inf)
        values = (adaptive or others)[0].values
        assert values is not None
        return values

    @cached_property
    def doubts(self) -> dict[str, float]:
        """Uncertainty of the limits of all parameters, by the names of errors.

        Each sequence has a remaining error; for a parameter that was not varied, the only
        assumption is that the finest step is nearer to the limit than the default. Squares are
        added.
        """
        reference = self.of()
        if reference is None:
            return {}
        left = [{name: x.left for name, x in limits.items()} for limits in self.limits.values()]
        parts = [errors_of(shifted(reference, shift), reference) for shift in left]
        ladders = self._refinements.ladders
        if any(len(steps) > 1 for name, steps in ladders.items() if name not in self.limits):
            base = self._done.get(self._refinements.base)
            if base is None or base.values is None:
                return dict.fromkeys(errors_of(reference, reference), inf)
            parts.append(errors_of(base.values, reference))
        found = dict.fromkeys(errors_of(reference, reference), 0.0)
        for part in parts:
            for name, error in part.items():
                found[name] = hypot(found.get(name, 0.0), error)
        return found

    @staticmethod
    def _size(discretization: NamedDiscretization, parameter: str) -> float:
        """Step size, which approaches zero along a sequence."""
        value = float(getattr(discretization, parameter))
        if parameter in ("axial_degree", "load_degree_z"):
            value += 1.0  # the number of functions
        return value if parameter == "flank_element_mm" else 1.0 / value

    def of(self, *parameters: str) -> Quantities | None:
        """The finest run with some parameters at their limits; by default all."""
        if (finest := self.finest) is None:
            return None
        shifts = (
            {
                name: limit.value - finest[name]
                for name, limit in self.limits[parameter].items()
                if limit.value.shape == finest[name].shape
            }
            for parameter in (parameters or self.limits)
            if parameter in self.limits
        )
        return shifted(finest, *shifts)

    def errors(self, run: Run, *parameters: str) -> dict[str, float]:
        """Errors of a run against the limits of some parameters; by default all."""
        reference = self.of(*parameters)
        return {} if reference is None or run.values is None else errors_of(run.values, reference)
