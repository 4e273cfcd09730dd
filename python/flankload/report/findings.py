"""Findings that precede the numbers: violated premises, warnings, certificates."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flankload.contact.status import Status
from flankload.report.key_figures import percent
from flankload.result.notes import OUTSIDE, accuracy_lines, warning_lines
from flankload.result.table import STATUS_WORDS, unestimated_pressure

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from flankload.result import Result

#: Status of a position: what its certificate proves.
SOLVED = "solved; the certificate proves the state and that no other exists"
#: Most positions that are named one by one.
MOST_NAMED = 8


@dataclass(frozen=True)
class Findings:
    """Remarks on a run: violated premises of the model, and other warnings.

    `uncertain` are positions with another status than solved, and quantities without an error
    estimate; `tolerance` are lines on the tolerance of the scene, if it names one.
    """

    violated: tuple[str, ...]
    warnings: tuple[str, ...]
    uncertain: tuple[str, ...]
    tolerance: tuple[str, ...]


def findings_of(results: Sequence[Result]) -> Findings:
    """Remarks on the results of a scene, one per torque."""
    lines = warning_lines(results)
    accuracy = results[-1].accuracy
    return Findings(
        violated=tuple(line for line in lines if line.startswith(OUTSIDE)),
        warnings=tuple(line for line in lines if not line.startswith(OUTSIDE)),
        uncertain=(*_statuses(results), *_without_estimate(results)),
        tolerance=() if accuracy is None else tuple(accuracy_lines(accuracy)),
    )


def _statuses(results: Sequence[Result]) -> Iterator[str]:
    for result in results:
        for status, words in STATUS_WORDS.items():
            at = np.flatnonzero(result.status == status)
            if at.size:
                angles = np.degrees(result.position_rad[at[:MOST_NAMED]])
                listed = ", ".join(f"{angle:.2f}°" for angle in angles)
                more = ", …" if at.size > MOST_NAMED else ""
                yield (
                    f"status {status} at {at.size} of {result.status.size} positions under "
                    f"{result.torque_Nm:g} N m ({listed}{more}): {words}"
                )


def _without_estimate(results: Sequence[Result]) -> Iterator[str]:
    missing = [f"{one.torque_Nm:g}" for one in results if one.estimate is None and one.torque_Nm]
    if missing:
        yield (
            f"no error estimate under {', '.join(missing)} N m: the scene switches it off "
            "(accuracy.estimate = false)"
        )
    hidden = {f"{one.torque_Nm:g}": why for one in results if (why := unestimated_pressure(one))}
    if hidden:
        yield (
            f"no error estimate of the largest pressure under {', '.join(hidden)} N m: it is "
            f"{next(iter(hidden.values()))}"
        )
    if any(one.summary["corner_pressure_pair"] is not None for one in results):
        yield (
            "no finite pressure exists at sharp corners: pressures there are left out of the key "
            "figures and drawn dashed"
        )


def certificate_rows(results: Sequence[Result]) -> tuple[tuple[str, tuple[str, ...]], ...]:
    """Counts of the statuses and numbers of the solution: name, and a text per torque."""
    words = {Status.SOLVED: SOLVED, **STATUS_WORDS}
    rows = [
        (
            f"status {status}: {text}",
            tuple(str(int((one.status == status).sum())) for one in results),
        )
        for status, text in words.items()
        if status == Status.SOLVED or any((one.status == status).any() for one in results)
    ]
    for name, key in (
        ("largest backward error of the equations", "largest_backward_error"),
        ("largest condition of a system", "largest_condition"),
    ):
        if all(key in one.cost for one in results):
            rows.append((name, tuple(f"{one.cost[key]:.2g}" for one in results)))
    pivots = tuple(str(one.cost.get("of_this_torque", {}).get("pivots", "–")) for one in results)
    return (*rows, ("pivots of the contact loop", pivots))


def source_rows(result: Result) -> tuple[tuple[str, ...], tuple[tuple[str, ...], ...]]:
    """Estimated errors by source: names of the quantities, and a row per source.

    A row has the source, then the error of each quantity in per cent; the last row is the whole.
    """
    if result.estimate is None:
        return (), ()
    whole = {key: value for key, value in result.estimate.items() if isinstance(value, int | float)}
    by_source = result.estimate.get("by_source", {})
    # harmonics have errors by single sources only
    keys = dict.fromkeys([*whole, *(key for errors in by_source.values() for key in errors)])
    rows = [
        (source, *(percent(errors.get(key)) for key in keys))
        for source, errors in by_source.items()
    ]
    rows.append(("whole", *(percent(whole.get(key)) for key in keys)))
    return tuple(key.replace("_", " ") for key in keys), tuple(rows)
