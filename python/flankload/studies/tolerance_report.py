"""Quantities limited by a tolerance, their estimated errors in the runs, and the report."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from flankload.analysis.error_rules import LARGEST_SMOOTH_CHANGE
from flankload.mechanisms.parameters import OF_ELEMENTS, SOURCES
from flankload.scene.named_discretization import NamedDiscretization

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flankload.mechanisms.parameters import Parameters, Values
    from flankload.result import Result
    from flankload.scene import Scene

    Errors = dict[str, float]
    Table = dict[str, Errors]

#: Quantity limited relative to the largest transmission error, not to itself: the relative error of
#: an almost constant curve's variation is irrelevant.
OF_LARGEST = "transmission_error_peak_to_peak"
#: Quantities that a tolerance limits.
BOUND = (
    "transmission_error",
    "transmission_error_mean",
    OF_LARGEST,
    "load_share",
    "peak_pressure",
    "stiffness_secant",
)
#: Sources that no parameter controls, with what controls them instead.
LEFT_BY = {
    "lumped": "caused by effects.contact = 'lumped'",
    "touch": "the mean gap of a slice closes late: a larger accuracy.slices reduces it",
    "period": "positions.pitches omits teeth with another compliance",
    "one solution": "caused by effects.large_displacement = false",
}


@dataclass(frozen=True)
class Choice:
    """Discretization and positions of a run.

    Attributes
    ----------
    values : dict of str to float
        Values of all parameters.
    positions : NamedDiscretization
        With the keys of the positions only.
    foreseen : dict of str to float
        Predicted errors of limited quantities from the orders of convergence; empty for the first
        run.
    """

    values: Values
    positions: NamedDiscretization
    foreseen: Errors = field(default_factory=dict)

    def discretization(self, parameters: Parameters) -> NamedDiscretization:
        """The keys for the run."""
        named: dict[str, Any] = {
            name: x
            for name, x in self.values.items()
            if name in parameters.explicit or x != parameters.values[name]
        }
        return replace(self.positions, **named)

    def has_elements_of(self, other: Choice) -> bool:
        """Whether compliances of the other choice can be reused."""
        return all(self.values.get(name) == other.values.get(name) for name in OF_ELEMENTS)


@dataclass(frozen=True)
class Attempt:
    """A run, and the estimated errors of the limited quantities, the largest over the torques."""

    choice: Choice
    results: tuple[Result, ...]
    errors: Errors
    by_source: Table

    @classmethod
    def of(cls, choice: Choice, results: tuple[Result, ...]) -> Attempt:
        """Attempt from the results of a run."""
        errors: Errors = {}
        for result in results:
            for quantity, error in _bound(result.estimate or {}, result).items():
                errors[quantity] = max(errors.get(quantity, 0.0), error)
        return cls(choice, results, errors, errors_by_source(results))

    def scaled_by_source(self) -> Table:
        """Errors by source, larger for a quantity whose error exceeds the root of their squares.

        Systematic errors of several sources add up with their signs.
        """
        more = {}
        for quantity in BOUND:
            root = float(np.linalg.norm([errors[quantity] for errors in self.by_source.values()]))
            more[quantity] = max(1.0, self.errors.get(quantity, 0.0) / root) if root else 1.0
        return {
            source: {quantity: more[quantity] * errors[quantity] for quantity in BOUND}
            for source, errors in self.by_source.items()
        }

    def missed(self, tolerance: float) -> list[str]:
        """Quantities whose error exceeds the tolerance."""
        return [quantity for quantity, error in self.errors.items() if error > tolerance]

    @property
    def has_corners(self) -> bool:
        """Whether sharp corners carry load."""
        return any(result.corner_contact.any() for result in self.results)


def errors_by_source(results: Sequence[Result]) -> Table:
    """Largest estimated errors of all torques by source, and by quantity.

    Errors from different sources may cancel: they do not add up to those of an attempt. Elements of
    several bodies have one parameter, so they are one source.
    """
    found: Table = {}
    for result in results:
        table: Table = {}
        for source, errors in (result.estimate or {}).get("by_source", {}).items():
            name = "elements" if source.startswith("elements") else source
            row = table.setdefault(name, dict.fromkeys(BOUND, 0.0))
            for quantity, error in _bound(errors, result).items():
                row[quantity] = float(np.hypot(row[quantity], error))
        for source, errors in table.items():
            row = found.setdefault(source, dict.fromkeys(BOUND, 0.0))
            for quantity, error in errors.items():
                row[quantity] = max(row[quantity], error)
    return found


def _bound(errors: Any, result: Result) -> Errors:
    """Limited quantities of a table of the estimate."""
    found = {quantity: float(errors[quantity]) for quantity in BOUND if quantity in errors}
    if OF_LARGEST in found:
        curve = result.transmission_error_um
        largest = float(np.abs(curve).max())
        found[OF_LARGEST] *= float(np.ptp(curve)) / largest if largest > 0 else 0.0
    return found


def tolerance_report(
    scene: Scene, parameters: Parameters, attempts: Sequence[Attempt]
) -> dict[str, Any]:
    """Choices with their reasons, and missed limits, in the form of `result.accuracy`."""
    tolerance, first, last = scene.accuracy.tolerance, attempts[0], attempts[-1]
    errors, by_source = last.errors, last.by_source
    values: dict[str, Any] = {
        name: last.choice.values[name] for name in SOURCES if name in last.choice.values
    }
    values["positions"] = int(last.results[0].position_rad.size)
    itself = [(result.estimate or {}).get(OF_LARGEST) for result in last.results]
    uncertain = _uncertain(parameters, last) if errors else []
    missed = last.missed(tolerance)
    report: dict[str, Any] = {
        "tolerance": tolerance,
        "met": False if missed else None if uncertain or not errors else True,
        "largest_error": max(errors.values(), default=None),
        "errors": dict(errors),
        "peak_to_peak_of_itself": max((e for e in itself if e is not None), default=None),
        "not_estimated": [one["quantity"] for one in uncertain if one["quantity"] not in errors],
        "uncertain": uncertain,
        "knobs": {
            name: {
                "value": value,
                "source": SOURCES[name],
                "error": max(by_source.get(SOURCES[name], {}).values(), default=None),
                "left_as_it_is": parameters.fixed.get(name),
            }
            for name, value in values.items()
        },
        "keys": last.choice.discretization(parameters).tables(),
        "tightened": _tightened(first.choice, last.choice),
        "errors_before": dict(first.errors) if len(attempts) > 1 else None,
        "missed": [_missed(quantity, tolerance, parameters, attempts) for quantity in missed],
    }
    if not errors:
        loaded = any(result.torque_Nm > 0 for result in last.results)
        default = "default discretization, not checked (accuracy.estimate = false)"
        report["unchecked"] = default if loaded else "without torque there is no approximation"
    return report


def _uncertain(parameters: Parameters, run: Attempt) -> list[dict[str, str]]:
    """Limited quantities that no estimate certifies, with the reason."""
    unknown = dict.fromkeys(set(BOUND) - set(run.errors), "it has no estimate")
    for result in run.results:
        unknown |= (result.estimate or {}).get("uncertain", {})
    if run.results[0].position_rad.size == 1:  # nothing varies
        unknown.pop(OF_LARGEST, None)
    if not parameters.has_pressures:
        unknown.pop("peak_pressure", None)
    return [{"quantity": name, "why": unknown[name]} for name in BOUND if name in unknown]


def _tightened(first: Choice, last: Choice) -> dict[str, list[float | None]]:
    steps: dict[str, list[float | None]] = {
        name: [first.values[name], last.values[name]] for name in SOURCES if name in first.values
    }
    steps["positions.count"] = [first.positions.count, last.positions.count]
    steps["positions.tolerance"] = [first.positions.adaptive, last.positions.adaptive]
    return {name: both for name, both in steps.items() if both[0] != both[1]}


def _missed(
    quantity: str, tolerance: float, parameters: Parameters, attempts: Sequence[Attempt]
) -> dict[str, Any]:
    by_source = attempts[-1].by_source
    source = max(by_source, key=lambda name: by_source[name].get(quantity, 0.0))
    return {
        "quantity": quantity,
        "error": attempts[-1].errors[quantity],
        "source": source,
        "beside": sorted(
            name
            for name, errors in by_source.items()
            if name != source and errors.get(quantity, 0.0) > tolerance
        ),
        "why": _why(source, quantity, tolerance, parameters, attempts),
    }


def _why(
    source: str,
    quantity: str,
    tolerance: float,
    parameters: Parameters,
    attempts: Sequence[Attempt],
) -> str:
    """Reason for the size of an error source."""
    last = attempts[-1]
    name = next((name for name, of in SOURCES.items() if of == source), None)
    if name is None:
        return LEFT_BY.get(source, "no parameter controls it")
    if name in parameters.fixed:
        return parameters.fixed[name]
    if source == "strips" and last.by_source[source][quantity] > LARGEST_SMOOTH_CHANGE:
        return "a rounding, a chamfer or a kink that this number of strips does not resolve"
    if source != "positions" and parameters.finer(last.choice.values, source) is None:
        why = parameters.ends.get(name, "the parameter is at its finest value")
    elif last.choice.foreseen.get(quantity, np.inf) > tolerance:
        why = "no value of the parameter is likely to meet the tolerance"
    else:
        why = "larger than predicted"
    return why + parameters.slow * (parameters.always_slow or last.has_corners)
