"""Notes of a study: errors that no discretization reduces, and runs without a solution."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flankload.result.notes import outside_words
from flankload.studies.accuracy.quantities import CORNER

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flankload.scene import Scene
    from flankload.scene.named_discretization import NamedDiscretization
    from flankload.studies.accuracy.study import Row

#: Data that kinds of bodies import.
FROM_FILES = {"mesh": "elements", "compliance": "influence numbers"}


def limit_notes(rows: Sequence[Row]) -> tuple[str, ...]:
    """Note on errors that are not included: violated premises of the model."""
    names = sorted({name for row in rows for name in row.run.outside})
    return (f"errors {outside_words(names).removeprefix('; ')}",) if names else ()


def corner_notes(rows: Sequence[Row]) -> tuple[str, ...]:
    """Note on an error that no discretization reduces: the pressure on sharp corners."""
    pressures = [
        (
            row.run.discretization.strips_per_half_width,
            float(np.max(row.run.values[CORNER], initial=0.0)),
        )
        for row in rows
        if row.run.values is not None
    ]
    carrying = sorted((n, pressure) for n, pressure in pressures if n and pressure > 0)
    if not carrying:
        return ()
    (few, low), (many, high) = carrying[0], carrying[-1]
    note = (
        f"a sharp corner carries load: its pressure, {low:.0f} MPa with {few:g} strips "
        f"and {high:.0f} MPa with {many:g}, has no limit; no discretization changes that, "
        "but a tip radius (tip_radius_mm) or a parabolic relief does"
    )
    return (note,)


def file_notes(scene: Scene) -> tuple[str, ...]:
    """Note on data in files, which a study cannot vary."""
    return tuple(
        f"{key}: its {what} come from a file, whose own error is not part of this"
        for key, body in (("body_1", scene.body_1), ("body_2", scene.body_2))
        if (what := FROM_FILES.get(body.kind)) is not None
    )


def failure_notes(rows: Sequence[Row]) -> tuple[str, ...]:
    """Runs without a solution, with the reason."""
    return tuple(
        f"{row.group.replace('_', ' ')} ({_short(row.run.discretization)}): {row.run.failure}"
        for row in rows
        if row.run.failure is not None
    )


def _short(discretization: NamedDiscretization) -> str:
    return ", ".join(f"{key} {value}" for key, value in discretization.as_dict().items())
