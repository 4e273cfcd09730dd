"""A finished study: its table, its files, the cheapest settings."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from math import isfinite
from typing import TYPE_CHECKING, Any

from flankload.base.files import write_atomically
from flankload.studies.accuracy.observed import HEADS, MEANINGS
from flankload.studies.accuracy.study_text import NAMED, text_of
from flankload.studies.accuracy.truth import twin

if TYPE_CHECKING:
    from pathlib import Path

    from flankload.scene.named_discretization import NamedDiscretization
    from flankload.studies.accuracy.knobs import Knobs
    from flankload.studies.accuracy.ladder import Limit
    from flankload.studies.accuracy.runs import Run


@dataclass(frozen=True, eq=False)
class Row:
    """A run of a study and its errors.

    Attributes
    ----------
    group : str
        Knob of a ladder, "combination", "default", "default but for one knob", "as it stands",
        "finest", or a level.
    run : Run
    errors : dict
        Relative errors against the limit of all knobs, by the names of `observed.HEADS`.
    alone : dict
        Of a step of a ladder: against the limit of this knob, the others at their finest.
    """

    group: str
    run: Run
    errors: Mapping[str, float] = field(default_factory=dict)
    alone: Mapping[str, float] = field(default_factory=dict)

    @property
    def setting(self) -> NamedDiscretization:
        """Knobs of the run."""
        return self.run.setting

    def largest(self, measures: Sequence[str]) -> float | None:
        """The largest of some errors; None where none is known."""
        errors = [self.errors[name] for name in measures if name in self.errors]
        return max(errors, default=None)


@dataclass(frozen=True, eq=False)
class Study:
    """What accuracy costs in a scene.

    Attributes
    ----------
    name : str
        Of the scene.
    tolerance : float
        Of the scene.
    measures : tuple of str
        Errors that count, by the names of `observed.HEADS`.
    rows : tuple of Row
        In the order in which they were run.
    limits : dict of dict of Limit
        Of each knob, by names of quantities: where its ladder leads to.
    knobs : Knobs
        Ladders and the finest setting.
    steps : dict of tuple of Row
        Of each knob its ladder, the finest step first; even positions before adaptive ones. Their
        `alone` is known.
    doubts : dict of str to float
        By the names of errors: what the limit of all knobs, against which they are measured, may be
        off itself.
    notes : tuple of str
    stopped : str or None
        Why runs are left out.
    interrupted : bool
    """

    name: str
    tolerance: float
    measures: tuple[str, ...]
    rows: tuple[Row, ...]
    limits: Mapping[str, Mapping[str, Limit]]
    knobs: Knobs
    steps: Mapping[str, tuple[Row, ...]]
    doubts: Mapping[str, float] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    stopped: str | None = None
    interrupted: bool = False

    @property
    def has_errors(self) -> bool:
        """Whether the finest setting was run, so that errors are known."""
        return any(row.errors for row in self.rows)

    def seconds_at_default(self, row: Row, knob: str) -> float | None:
        """CPU seconds of a step of a ladder with the other knobs at their default."""
        wanted = twin(self.knobs, knob, row.setting)
        found = (other.run.cpu_s for other in self.rows if other.setting == wanted)
        return next(found, None)

    def candidates(self, *names: str) -> tuple[Row, ...]:
        """Rows whose errors are known, the cheapest first."""
        measures = names or self.measures
        known = [row for row in self.rows if row.largest(measures) is not None]
        return tuple(sorted(known, key=lambda row: row.run.cpu_s))

    def front(self, *names: str) -> tuple[Row, ...]:
        """Rows that no other beats both in seconds and in `within`, the cheapest first.

        Parameters
        ----------
        *names : str
            Errors that count; those of the study without any.

        Returns
        -------
        tuple of Row
            Seconds ascend, what errors are within descends.
        """
        best: list[Row] = []
        for row in self.candidates(*names):
            if not best or self.within(row, *names) < self.within(best[-1], *names):
                best.append(row)
        return tuple(best)

    def within(self, row: Row, *names: str) -> float:
        """What some errors of a row are below: the largest with the doubt of the limit added.

        Parameters
        ----------
        row : Row
            One of the candidates.
        *names : str
            As of `front`.

        Returns
        -------
        float
        """
        known = [name for name in names or self.measures if name in row.errors]
        return max(row.errors[name] + self.doubts.get(name, 0.0) for name in known)

    def cheapest(self, tolerance: float, *names: str) -> Row | None:
        """The run of fewest CPU seconds that meets a tolerance for certain; None where none does.

        Its errors and the doubt of what they are measured against are below the tolerance together:
        the finest run, and whatever comes as near to the limit as that is known, is not named.
        """
        met = (row for row in self.candidates(*names) if self.within(row, *names) <= tolerance)
        return next(met, None)

    def doubt(self, *names: str) -> float | None:
        """What the limit is in doubt by, in the worst of some errors; None where none is known."""
        known = [self.doubts[name] for name in names or self.measures if name in self.doubts]
        return max(known, default=None)

    def __str__(self) -> str:
        """The table."""
        return text_of(self)

    def to_csv(self, path: str | Path | None = None) -> str:
        """Return a line per run as CSV; write it to `path`."""
        stream = io.StringIO()
        writer = csv.writer(stream, lineterminator="\n")
        keys = ("level", *_SETTING)
        errors = tuple(name for name in HEADS if any(name in row.errors for row in self.rows))
        writer.writerow(
            [
                "group",
                *keys,
                "cpu_s",
                "memory_bytes",
                *(f"error_{name}" for name in errors),
                *(f"error_of_knob_{name}" for name in errors),
                "failure",
            ]
        )
        for row in self.rows:
            knobs = row.setting.as_dict()
            writer.writerow(
                [
                    row.group,
                    *(knobs.get(key, "") for key in keys),
                    f"{row.run.cpu_s:.6g}",
                    row.run.memory_bytes,
                    *(_cell(row.errors.get(name)) for name in errors),
                    *(_cell(row.alone.get(name)) for name in errors),
                    row.run.failure or "",
                ]
            )
        if path is not None:
            write_atomically(path, stream.getvalue())
        return stream.getvalue()

    def as_dict(self) -> dict[str, Any]:
        """As JSON has it."""
        cheapest = {f"{tolerance:g}": self.cheapest(tolerance) for tolerance in NAMED}
        return {
            "name": self.name,
            "measures": {name: MEANINGS[name] for name in self.measures},
            "finest": self.knobs.finest.as_dict(),
            "runs": [
                {
                    "group": row.group,
                    "setting": row.setting.as_dict(),
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
                knob: {name: limit.order for name, limit in limits.items()}
                for knob, limits in self.limits.items()
            },
            "doubts_of_the_limit": {
                name: doubt if isfinite(doubt) else None for name, doubt in self.doubts.items()
            },
            "cheapest": {
                tolerance: None
                if row is None
                else {"cpu_s": row.run.cpu_s, "keys": row.setting.tables()}
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


_SETTING = (
    "flank_element_mm",
    "modes",
    "strips_per_half_width",
    "zone_half_widths",
    "count",
    "adaptive",
)


def _cell(error: float | None) -> str:
    return "" if error is None else f"{error:.4g}"
