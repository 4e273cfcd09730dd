"""Comparison of the answers of a program with the reference values of the benchmark set."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from flankload.base.text_table import text_table

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flankload.studies.benchmark.answers import Answers
    from flankload.studies.benchmark.case import Case, Quantity

#: Cell of a value that the program does not give.
MISSING = "-"


@dataclass(frozen=True)
class Row:
    """A quantity with the answer of the program; None if it gives no value."""

    identifier: str
    reference: Quantity
    found: float | None

    @property
    def ratio(self) -> float | None:
        """Difference divided by the uncertainty of the reference."""
        if self.found is None:
            return None
        return abs(self.found - self.reference.value) / self.reference.uncertainty


@dataclass(frozen=True)
class Comparison:
    """Answers of a program beside the reference values, and its seconds if known, by case."""

    program: str
    rows: dict[str, tuple[Row, ...]]
    seconds: dict[str, float]

    def to_text(self) -> str:
        """A row per case: the largest difference in uncertainties of the reference."""
        table: list[Sequence[str]] = [
            ("case", "given", "within", "largest difference", "%", "uncertainty %", "ratio", "s")
        ]
        for name, rows in self.rows.items():
            given = [row for row in rows if row.ratio is not None]
            within = sum(row.ratio <= 1.0 for row in given if row.ratio is not None)
            worst = max(given, key=lambda row: row.ratio or 0.0, default=None)
            seconds = self.seconds.get(name)
            table.append(
                (
                    name,
                    f"{len(given)}/{len(rows)}",
                    str(within),
                    *(("", "", "", "") if worst is None else _worst_cells(worst)),
                    MISSING if seconds is None else f"{seconds:.2f}",
                )
            )
        title = f"{self.program}: quantities within the uncertainty of the reference, "
        title += "and the largest difference as a multiple of it"
        return "\n".join([title, "", *text_table(table, left=1)])

    def case_text(self, name: str) -> str:
        """A row per quantity of a case."""
        table = [(name, "unit", "reference", "uncertainty", self.program, "ratio")]
        for row in self.rows[name]:
            found = MISSING if row.found is None else f"{row.found:.6g}"
            ratio = MISSING if row.ratio is None else f"{row.ratio:.2f}"
            value, uncertainty = row.reference.value, row.reference.uncertainty
            numbers = (f"{value:.6g}", f"{uncertainty:.2g}", found, ratio)
            table.append((row.identifier, row.reference.unit, *numbers))
        return "\n".join(text_table(table, left=2))

    def as_dict(self) -> dict[str, Any]:
        """Cases with reference, uncertainty, value and ratio of each quantity."""
        return {
            "program": self.program,
            "cases": {
                name: {
                    row.identifier: {
                        "unit": row.reference.unit,
                        "reference": row.reference.value,
                        "uncertainty": row.reference.uncertainty,
                        "value": row.found,
                        "ratio": row.ratio,
                    }
                    for row in rows
                }
                for name, rows in self.rows.items()
            },
            "seconds": self.seconds,
        }


def _worst_cells(row: Row) -> tuple[str, str, str, str]:
    """Identifier, difference and uncertainty as parts of the reference, ratio."""
    assert row.found is not None
    assert row.ratio is not None
    reference = row.reference
    if reference.value == 0.0:
        return row.identifier, MISSING, MISSING, f"{row.ratio:.2g}"
    difference = 100 * (row.found - reference.value) / abs(reference.value)
    uncertainty = 100 * reference.uncertainty / abs(reference.value)
    return row.identifier, f"{difference:+.2g}", f"{uncertainty:.2g}", f"{row.ratio:.2g}"


def compare(cases: Sequence[Case], answers: Answers) -> Comparison:
    """Compare answers with the reference values."""
    rows = {
        case.name: tuple(
            Row(identifier, quantity, answers.values.get(case.name, {}).get(identifier))
            for identifier, quantity in case.quantities.items()
        )
        for case in cases
    }
    return Comparison(answers.program, rows, answers.seconds)
