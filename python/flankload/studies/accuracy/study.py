"""A finished study: its table, its files, the cheapest discretizations."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields
from math import isfinite
from typing import TYPE_CHECKING, Any

from flankload.base.card import Card
from flankload.base.files import write_atomically
from flankload.result.export import CsvForm
from flankload.scene.named_discretization import NamedDiscretization
from flankload.studies.accuracy.quantities import HEADS, MEANINGS, largest
from flankload.studies.accuracy.reference import twin
from flankload.studies.accuracy.study_text import NAMED, text_of

if TYPE_CHECKING:
    from pathlib import Path

    from flankload.studies.accuracy.ladder import Limit
    from flankload.studies.accuracy.refinements import Refinements
    from flankload.studies.accuracy.runs import Run


@dataclass(frozen=True, eq=False)
class Row:
    """A run of a study and its errors.

    Its group is the parameter of a sequence, "default", "default but for one knob",
    "as it stands", "finest", or a contact model. `errors` are relative to the limit of all
    parameters, by the names of `quantities.HEADS`; `alone`, for a step of a sequence, to the limit
    of this parameter with the others at their finest.
    """

    group: str
    run: Run
    errors: Mapping[str, float] = field(default_factory=dict)
    alone: Mapping[str, float] = field(default_factory=dict)

    @property
    def setting(self) -> NamedDiscretization:
        """Discretization of the run."""
        return self.run.discretization

    def largest(self, measures: Sequence[str]) -> float | None:
        """The largest of some errors; None if none is known."""
        return largest(self.errors, measures)


@dataclass(frozen=True, eq=False, repr=False)
class AccuracyStudy(Card):
    """Errors and costs of the discretizations of a scene.

    Attributes
    ----------
    name : str
        Name of the scene.
    tolerance : float
        Tolerance of the scene.
    measures : tuple of str
        Errors to be limited, by the names of `quantities.HEADS`.
    rows : tuple of Row
        In the order of the runs.
    limits : dict of dict of Limit
        For each parameter, by names of quantities: the limit of its sequence of refinements.
    knobs : Refinements
        Steps of the parameters and the finest discretization.
    steps : dict of tuple of Row
        For each parameter its sequence of refinements, the finest step first; even positions before
        adaptive ones. Their `alone` is known.
    doubts : dict of str to float
        By the names of errors: uncertainty of the limit of all parameters, which is the reference.
    notes : tuple of str
    stopped : str or None
        Reason for omitted runs.
    interrupted : bool
    """

    name: str
    tolerance: float
    measures: tuple[str, ...]
    rows: tuple[Row, ...]
    limits: Mapping[str, Mapping[str, Limit]]
    knobs: Refinements
    steps: Mapping[str, tuple[Row, ...]]
    doubts: Mapping[str, float] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    stopped: str | None = None
    interrupted: bool = False

    @property
    def has_errors(self) -> bool:
        """Whether the finest discretization was run, so that errors are known."""
        return any(row.errors for row in self.rows)

    def seconds_at_default(self, row: Row, parameter: str) -> float | None:
        """CPU seconds of a step with the other parameters at their default."""
        wanted = twin(self.knobs, parameter, row.run.discretization)
        found = (other.run.cpu_s for other in self.rows if other.run.discretization == wanted)
        return next(found, None)

    def candidates(self, *names: str) -> tuple[Row, ...]:
        """Rows with known errors, the cheapest first."""
        measures = names or self.measures
        known = [row for row in self.rows if row.largest(measures) is not None]
        return tuple(sorted(known, key=lambda row: row.run.cpu_s))

    def front(self, *names: str) -> tuple[Row, ...]:
        """Pareto front of CPU seconds and `within`: seconds ascend, error bounds descend.

        The names are those of the errors to be limited; by default those of the study.
        """
        best: list[Row] = []
        for row in self.candidates(*names):
            if not best or self.within(row, *names) < self.within(best[-1], *names):
                best.append(row)
        return tuple(best)

    def within(self, row: Row, *names: str) -> float:
        """Upper bound of some errors of a candidate: the largest plus the uncertainty of the limit.

        The names are as in `front`.
        """
        bound = largest(row.errors, names or self.measures, self.doubts)
        assert bound is not None
        return bound

    def cheapest(self, tolerance: float, *names: str) -> Row | None:
        """The cheapest run that certainly meets a tolerance; None if there is none.

        Its error plus the uncertainty of the reference is below the tolerance: this excludes the
        finest run, and any run whose distance to the limit is not larger than that uncertainty.
        """
        met = (row for row in self.candidates(*names) if self.within(row, *names) <= tolerance)
        return next(met, None)

    def doubt(self, *names: str) -> float | None:
        """Largest uncertainty of the limit among some errors; None if unknown."""
        return largest(self.doubts, names or self.measures)

    def __str__(self) -> str:
        """The table."""
        return text_of(self)

    def to_csv(self, path: str | Path | None = None) -> str:
        """Return a line per run as CSV; write it to `path`."""
        keys = [key.name for key in fields(NamedDiscretization)]
        errors = [name for name in HEADS if any(name in row.errors for row in self.rows)]
        heads = [f"{kind}_{name}" for kind in ("error", "error_of_knob") for name in errors]
        lines = [["group", *keys, "cpu_s", "memory_bytes", *heads, "failure"]]
        for row in self.rows:
            used = row.run.discretization.as_dict()
            found = (of.get(name) for of in (row.errors, row.alone) for name in errors)
            cells = [row.group, *(f"{used.get(key, '')}" for key in keys)]
            cells += [f"{row.run.cpu_s:.6g}", f"{row.run.memory_bytes}"]
            cells += ["" if error is None else f"{error:.4g}" for error in found]
            lines.append([*cells, row.run.failure or ""])
        text = CsvForm().lines(lines)
        if path is not None:
            write_atomically(path, text)
        return text

    def as_dict(self) -> dict[str, Any]:
        """The study in the form of JSON."""
        cheapest = {f"{tolerance:g}": self.cheapest(tolerance) for tolerance in NAMED}
        return {
            "name": self.name,
            "measures": {name: MEANINGS[name] for name in self.measures},
            "finest": self.knobs.finest.as_dict(),
            "runs": [
                {
                    "group": row.group,
                    "setting": row.run.discretization.as_dict(),
                    "cpu_s": row.run.cpu_s,
                    "memory_bytes": row.run.memory_bytes,
                    "errors": dict(row.errors),
                    "errors_of_knob": dict(row.alone),
                    "failure": row.run.failure,
                    "on_front": any(row is other for other in self.front()),
                }
                for row in self.rows
            ],
            "orders": {
                parameter: {name: limit.order for name, limit in limits.items()}
                for parameter, limits in self.limits.items()
            },
            "doubts_of_the_limit": {
                name: doubt if isfinite(doubt) else None for name, doubt in self.doubts.items()
            },
            "cheapest": {
                tolerance: None
                if row is None
                else {"cpu_s": row.run.cpu_s, "keys": row.run.discretization.tables()}
                for tolerance, row in cheapest.items()
            },
            "notes": list(self.notes),
            "stopped": self.stopped,
        }

    def to_json(self, path: str | Path | None = None) -> str:
        """Return the study as JSON; write it to `path`."""
        text = json.dumps(self.as_dict(), indent=2, ensure_ascii=False) + "\n"
        if path is not None:
            write_atomically(path, text)
        return text
